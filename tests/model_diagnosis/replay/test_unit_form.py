"""Whether a hydraulic unit flows or moves by steps is told by its pressures, not by what their sensors add."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "data"))

from hidden_car import hidden_logs

from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.replay.prepared import PRESSURES
from vehicle_model.vehicle_file import VehicleFile

HELD_BEFORE, HELD_BEHIND = slice(200, 350), slice(560, 720)
"""Samples of the same pedal's force before the pulses of the braking in a turn and behind them."""
NAMES = ("gentle_stops", "abs_stop", "brake_in_turn")


@pytest.fixture(scope="module", params=[882, 1027])
def stops(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[VehicleFile, list]:
    """Vehicle file and logs of a healthy car whose valves flow."""
    return hidden_logs(tmp_path_factory.mktemp("stops"), request.param, NAMES)


def read_by(log: Manoeuvre, scale: float, offset_pa: float) -> Manoeuvre:
    changed = {name: scale * log.channels[name] + offset_pa for name in PRESSURES}
    return replace(log, channels={**log.channels, **changed})


@pytest.mark.parametrize(("scale", "offset_pa"), [(1.0, 0.0), (0.95, 0.0), (0.9, 0.0), (1.06, 0.0), (1.0, -1.5e5)])
def test_sensors_that_differ_from_the_masters_do_not_change_the_form(
    scale: float, offset_pa: float, stops: tuple[VehicleFile, list]
) -> None:
    """Wheels that seem to rest below their supply all the time are no valves that move by steps."""
    vehicle, logs = stops
    assert Replay(vehicle, [read_by(log, scale, offset_pa) for log in logs]).pressures.unit.flows


def test_pressures_that_nobody_measured_flow(stops: tuple[VehicleFile, list]) -> None:
    """A unit that moves by steps rests below a rising supply and above a fallen one: 4 % of what brakes in a turn with
    pulses, which would be a wind that blows in that manoeuvre."""
    vehicle, logs = stops
    told = [replace(log, channels={n: v for n, v in log.channels.items() if n not in PRESSURES}) for log in logs]
    replay = Replay(vehicle, told)
    turn = NAMES.index("brake_in_turn")
    pressures, _ = replay.driving_pressures(np.zeros(len(replay.columns)), turn)
    measured = np.stack([logs[turn].on_one_raster().channels[name] for name in PRESSURES], axis=1)
    held = [np.median((pressures / np.maximum(measured, 1e5))[part], axis=0) for part in (HELD_BEFORE, HELD_BEHIND)]
    assert replay.pressures.unit.flows
    assert held[0] == pytest.approx(held[1], abs=0.02)
