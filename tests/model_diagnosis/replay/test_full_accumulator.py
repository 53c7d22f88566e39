"""Fluid that a wheel brake loses until its circuit's accumulator is full: where each part of it is booked."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from plant_log import hydraulic_log

from model_diagnosis.replay import Replay
from model_diagnosis.replay.hydraulic import HydraulicLog, HydraulicReplay
from vehicle_model.vehicle_file import VehicleFile, set_parameter

CAPACITY_M3 = 4e-7
"""Small: a front brake loses some 30 bar until it is full."""
STIFFNESS_PA_M3 = 7e12
SUPPLY_PA = 1.5e7
BUILT_UP = 6
"""Samples of build-up before the release."""


@pytest.fixture
def small(car: VehicleFile) -> VehicleFile:
    changed = car.model_copy(deep=True)
    set_parameter(changed, "hydraulics.accumulator_volume", CAPACITY_M3)
    set_parameter(changed, "hydraulics.accumulator_pressure", 0.0)
    set_parameter(changed, "hydraulics.caliper_stiffness_front", STIFFNESS_PA_M3)
    return changed


def _release(car: VehicleFile) -> tuple[HydraulicReplay, HydraulicLog]:
    """Pressure built up in the front left brake alone, and released with the pump at rest for as long as it falls."""
    n, wheel = 60, 0
    inlet, outlet = np.ones((n, 4)), np.zeros((n, 4))
    inlet[:BUILT_UP, wheel] = 0.0
    outlet[BUILT_UP:, wheel] = 1.0
    model = Replay(car, [hydraulic_log(car)])
    given = model.prepared[0].hydraulics
    assert given is not None
    unit = model.pressures.unit
    unit.flows = True
    log = replace(
        given,
        master=np.full(n, SUPPLY_PA), inlet=inlet, outlet=outlet, pump=np.zeros(n),
        cornering=np.zeros(n, dtype=np.bool_), behind_commands=0.0, behind_master=0.0,
    )  # fmt: skip
    return unit, log


def _pressures(unit: HydraulicReplay, log: HydraulicLog, **deviations: float) -> NDArray[np.float64]:
    """Of the front left brake, from rest, without a correction."""
    named = {name.replace("__", "."): value for name, value in deviations.items()}
    rest = np.zeros((len(log.pump), 4))
    first = np.zeros_like(rest)
    first[0] = 1.0
    return unit.wheels(named, log, rest, first, gain=0.0)[1][:, 0]


def test_what_passes_both_valves_is_not_in_the_accumulator(small: VehicleFile) -> None:
    """Conservation: the brake loses the capacity, and with an overlap the flow through the inlet valve times it too."""
    unit, log = _release(small)
    overlap_s = 1e-3
    without, beside = _pressures(unit, log), _pressures(unit, log, form_valve_overlap__time=overlap_s)
    highest = without[-1] + CAPACITY_M3 * STIFFNESS_PA_M3  # within a sample
    assert without.max() < highest < SUPPLY_PA
    rate_pa_s = (SUPPLY_PA - highest) / small.hydraulics.increase_time_constant
    assert without[-1] - beside[-1] == pytest.approx(rate_pa_s * overlap_s, rel=0.02)
