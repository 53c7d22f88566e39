"""Another logger's clock by correlation and by innovations together, and commands among short brake applications.

Logs are those of the challenge's generator; those of the look at seed 1000004 came out wrong there.
"""

import json
from pathlib import Path
from typing import Any

import pytest
from hidden_car import drawn_logs

from model_diagnosis.data import check_data
from model_diagnosis.replay import Replay

SEED = 1000004


def _hidden(folder: Path) -> dict[str, Any]:
    label: dict[str, Any] = json.loads((folder / "label.json").read_text())["label"]
    return label


@pytest.mark.parametrize(
    ("seed", "index", "family"),
    [
        pytest.param(SEED, 39, None, id="without the acceleration"),
        pytest.param(1000015, 20, "clean", id="without the acceleration, told half", marks=pytest.mark.nightly),
        pytest.param(1000019, 36, "clean", id="without the acceleration, not told"),
        pytest.param(SEED, 26, None, id="clean car"),
    ],
)
def test_a_large_clock_offset_is_told_to_half_a_sample(
    seed: int, index: int, family: str | None, tmp_path: Path
) -> None:
    """Correlation alone is 8 ms late in the clean car, which is 0.06 m/s in a stop: many times a speed's noise.

    Without the acceleration the wheels' slip says 297 ms for 255, and two sensors' scales and a mass were named. Two
    healthy cars had a scale of the gyroscope and the name of a wrong vehicle: correlation said 151 ms for 194, and
    340 ± 130 for 292, which was not enough to be a lag.
    """
    vehicle, manoeuvres = drawn_logs(tmp_path, seed, index, family)
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    (fault,) = [one for one in faults if one.unit == "s"]
    assert (fault.kind, fault.channel) == ("clock_offset", "speed")
    assert fault.value == pytest.approx(_hidden(tmp_path)["clock_offset_s"], abs=0.005)


def test_another_late_channel_does_not_draw_the_clock_away(tmp_path: Path) -> None:
    """Wheel speeds 49 ms late (tuning seed 68): innovations asked before they are shifted say 25 ms too little."""
    vehicle, manoeuvres = drawn_logs(tmp_path, 68, 1, "data_fault")
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    late = {one.kind: one.value for one in faults if one.unit == "s"}
    assert set(late) == {"clock_offset", "wheel_speed_delay"}
    assert late["clock_offset"] == pytest.approx(_hidden(tmp_path)["clock_offset_s"], abs=0.01)


def test_pressures_that_are_commands_are_known_in_spite_of_a_short_brake_application(tmp_path: Path) -> None:
    """67 moving samples of one manoeuvre look like noise of 7 kPa: the command passed for early measurements."""
    vehicle, manoeuvres = drawn_logs(tmp_path, SEED, 11)
    faults, repaired = check_data(manoeuvres, vehicle, Replay)
    (command,) = [one for one in faults if one.kind == "command_not_measurement"]
    assert command.channel.startswith("brake_pressure_fl")
    assert command.value == pytest.approx(_hidden(tmp_path)["data_fault"]["value"], abs=0.015)
    # the pedal's force was measured: what the valves made of the command is the hydraulic unit's to tell
    assert all("pedal_force" in m.channels and "brake_pressure_fl" not in m.channels for m in repaired)
