"""Written ``.tir`` files read back as the same tyre."""

from pathlib import Path

import numpy as np
import pytest
from test_tir_tyres import write

from signals.errors import InputError
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.tir_writer import write_tir


@pytest.mark.parametrize("fittyp", ["52", "61", "62"])
def test_what_is_written_reads_back_identically(tmp_path: Path, fittyp: str) -> None:
    tyre = read_tir(write(tmp_path, fittyp), scale={"LMUX": 0.1 + 0.2})
    tyre.record["PDX2"] = -1.0 / 3.0
    again = read_tir(write_tir(tmp_path / "again.tir", tyre, ["by a test, µ"]))
    assert again.record.tobytes() == tyre.record.tobytes()
    assert dict(again.limits.ranges) == dict(tyre.limits.ranges)
    assert (again.version, again.uses_ellipse, again.measured_side) == (tyre.version, tyre.uses_ellipse, "LEFT")
    twice = write_tir(tmp_path / "twice.tir", again, ["by a test, µ"])
    assert twice.read_bytes() == (tmp_path / "again.tir").read_bytes()
    points = (np.linspace(-0.3, 0.3, 7), 0.05, 0.02, 3000.0)
    np.testing.assert_array_equal(again.forces(*points), tyre.forces(*points))


def test_what_no_file_can_tell_is_refused(tmp_path: Path) -> None:
    tyre = read_tir(write(tmp_path), deviations=("argument_clamped",))
    with pytest.raises(InputError, match="departures from the book"):
        write_tir(tmp_path / "out.tir", tyre)
    with pytest.raises(InputError, match="no such file or directory"):
        write_tir(tmp_path / "none" / "out.tir", read_tir(write(tmp_path)))
