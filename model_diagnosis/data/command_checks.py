"""Commands logged as measurements: no noise where a sensor has some, and a lead over the car's answer."""

from collections.abc import Sequence

import numpy as np

from model_diagnosis.data.delay_checks import LagRelation, Late, shifted
from model_diagnosis.data.faults import joined
from model_diagnosis.data.level_checks import without
from model_diagnosis.data.sample_values import noise_of
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import members
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.result import DataFault
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

COMMANDED = ("brake_pressure", "steering")
_SUPPLY = frozenset(("master_pressure", "pedal_force"))
"""One of them is enough for the hydraulic unit to tell the pressures of the brakes by its valves."""
_LEAD_S = 0.02
_SURELY = {"brake_pressure": 1.2, "steering": 2.5}
"""Spreads of a lead that it has to be. A pressure without noise is suspect by that alone; a good angle sensor's noise
is hidden by its steps, and one turn tells its lead to 17 ms."""
_QUIET = 0.15
_LEAST_SAMPLES = 100
"""Moving ones: a ramp and the first pulses of an ABS look like noise of 7 kPa in 67 samples."""
_USUAL_NOISE = {"brake_pressure": 1e4, "steering": 2e-3}


def is_quiet(manoeuvres: Sequence[Manoeuvre], group: str, vehicle: VehicleFile) -> bool:
    """True where a group's channels move without noise although the car's other sensors have some."""
    expected = max(_sensor_noise(vehicle, group), 0.1 * _USUAL_NOISE[group])
    samples = [_measured(m, n) for m in manoeuvres for n in members(group, list(m.channels))]
    levels = [noise_of(values) for values in samples if len(values) >= _LEAST_SAMPLES]
    return bool(levels) and max(levels) < _QUIET * expected and _others_are_noisy(manoeuvres)


def _measured(manoeuvre: Manoeuvre, name: str) -> FloatArray:
    """The channel's own samples from its first change to its last; those between them on the time base have no noise
    of their own."""
    values = manoeuvre.channels[name][manoeuvre.weight(name) > 0.0]
    return values[_moving(values)]


def _moving(values: FloatArray) -> slice:
    """From the first to the last change."""
    change = np.flatnonzero(np.diff(values) != 0.0)
    return slice(int(change[0]), int(change[-1]) + 2) if len(change) else slice(0, 0)


def _sensor_noise(vehicle: VehicleFile, group: str) -> float:
    if group == "brake_pressure":
        return float(vehicle.sensors.brake_pressure.noise)
    return float(vehicle.sensors.steering_wheel_angle.noise)


def _others_are_noisy(manoeuvres: Sequence[Manoeuvre]) -> bool:
    names = ("longitudinal_acceleration", "yaw_rate", *(f"wheel_speed_{w}" for w in WHEELS))
    levels = {n: noise_of(m.channels[n]) for m in manoeuvres for n in names if n in m.channels}
    scales = {n: 0.01 if n == "yaw_rate" else 1.0 for n in names}
    return any(level > 0.005 * scales[n] for n, level in levels.items())


def lead_of(relations: Sequence[LagRelation], group: str) -> tuple[float, float]:
    """How much the car answers later than it should to a group [s], and the spread; (0, inf) where nothing says."""
    lags = [r for r in relations if r.early == group]
    if not lags:
        return 0.0, float("inf")
    weights = np.array([r.std_s**-2 for r in lags])
    lead = float(np.sum(weights * np.array([r.lag_s for r in lags])) / weights.sum())
    return lead, float(weights.sum() ** -0.5)


def find_command(manoeuvres: Sequence[Manoeuvre], relations: Sequence[LagRelation], vehicle: VehicleFile) -> list[Late]:
    """Groups without noise that the car answers at least 20 ms late: commands, early by that lead."""
    found = []
    for group in COMMANDED:
        lead, spread = lead_of(relations, group)
        if lead < max(_LEAD_S, _SURELY[group] * spread) or not is_quiet(manoeuvres, group, vehicle):
            continue
        channels = list(dict.fromkeys(n for m in manoeuvres for n in members(group, list(m.channels))))
        found.append(Late("command_not_measurement", frozenset({group}), tuple(channels), -lead, spread))
    return found


def without_command(manoeuvres: Sequence[Manoeuvre], command: Late) -> tuple[DataFault, list[Manoeuvre]]:
    """The fault of a command that stands where a measurement should, and the manoeuvres repaired.

    Pressures that were asked for say nothing of what the valves made of them. Where the master pressure or the pedal's
    force was measured the hydraulic unit tells the brakes' pressures, and they are left out; else their lead is all
    that is known.
    """
    lead = -command.delay_s
    is_supplied = all(m.channels.keys() & _SUPPLY for m in manoeuvres)
    if command.groups == {"brake_pressure"} and is_supplied:
        repaired = [without(m, command.channels) for m in manoeuvres]
        repair = "Left out: the brakes' pressures are the hydraulic unit's by what supplies it and by its valves"
    else:
        repaired = [shifted(m, command.channels, command.delay_s) for m in manoeuvres]
        repair = "Shifted by that lead; the lag of what carries it out stays unknown"
    fault = DataFault(
        kind="command_not_measurement",
        channel=joined(command.channels),
        value=lead,
        unit="s",
        evidence=0.5 * (lead / command.std_s) ** 2 if 0.0 < command.std_s < np.inf else None,
        repaired=True,
        message=f"{joined(command.channels)} has no sensor noise and leads the car's answer by {1e3 * lead:.0f} ms "
        f"more than a measured value would: a command. {repair}",
    )
    return fault, repaired
