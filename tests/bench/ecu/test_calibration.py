"""Calibration files: the shipped ones are valid, bad ones are refused with their place."""

from pathlib import Path

import numpy as np
import pytest

from bench.ecu.calibration import CALIBRATIONS, calibration_path, load_calibration
from bench.ecu.faults import FAULTS
from bench.ecu.records import CALIBRATION_RECORD, calibration_record
from signals.errors import InputError

DOCUMENT = Path(__file__).parents[3] / "docs" / "ecu.md"


@pytest.mark.parametrize("name", CALIBRATIONS)
def test_shipped_calibration_fills_every_entry_of_the_record(name: str) -> None:
    loaded = load_calibration(name)
    assert loaded.name == name
    record = calibration_record(loaded)[0]
    assert record["slip_release"][0] == loaded.slip.front.release
    assert record["slip_release"][1] == loaded.slip.rear.release
    assert record["wheel_radius"][3] == loaded.car.rear_wheel_radius
    may_be_zero = {"monitoring_inertial_required"}
    zeros = {field for field in CALIBRATION_RECORD.names or () if not np.all(record[field])} - may_be_zero
    assert zeros == set()


def test_faults_of_a_file_come_with_their_place(tmp_path: Path) -> None:
    text = calibration_path("sensitive").read_text().replace("release: 0.15", "release: 15")
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("hold_tasks:", "hold_task:"))
    with pytest.raises(InputError) as caught:
        load_calibration(path)
    message = str(caught.value)
    assert "mine.yaml:" in message
    assert "slip.front.release" in message
    assert "hold_task" in message


def test_unknown_name_tells_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean sensitive"):
        load_calibration("sensitiv")


def test_every_fault_code_is_in_the_documentation() -> None:
    text = DOCUMENT.read_text()
    for fault in FAULTS.values():
        assert f"| {fault.code} | `{fault.name}` |" in text
