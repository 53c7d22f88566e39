"""A term that says what the only named cause does is that cause, and is not built in beside or instead of it."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "data"))

from hidden_car import hidden_logs
from hidden_effects.manoeuvres import SIX

from model_diagnosis.diagnosis import diagnose

WIND_M_S = 10.0


@pytest.mark.nightly
def test_a_side_wind_stays_a_side_wind_where_the_file_knows_no_side_force(tmp_path: Path) -> None:
    """The file's car feels the wind by its drag only: the size is wrong, and a force over speed fits better."""
    vehicle, drives = hidden_logs(tmp_path, 43, [one.name for one in SIX], ("side_wind", WIND_M_S, 0))
    vehicle.aerodynamics.side_force_coefficient = 0.0
    answer = diagnose(drives, vehicle).diagnosis
    assert [cause.effect for cause in answer.causes] == ["side_wind"]
    assert not answer.discovered_terms
    assert any("side_wind in other words" in remark for remark in answer.remarks)
