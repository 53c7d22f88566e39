"""Rig tables: units and signs judged from the numbers, traps of real rigs, faults."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from rig_tables import write_tables

from bench.tyre_bench.rig_data import read_rig_data
from signals.errors import InputError


def changed(file: Path, column: str, change: object, rename: str = "") -> None:
    """Replace a column of a table by ``change(values)``."""
    header = file.read_text().splitlines()[0].split(",")
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    place = header.index(column)
    rows[:, place] = change(rows[:, place])  # type: ignore[operator]
    header[place] = rename or column
    np.savetxt(file, rows, delimiter=",", header=",".join(header), comments="", fmt="%.8g")


def test_units_and_signs_become_si_and_iso(tmp_path: Path) -> None:
    data = read_rig_data(write_tables(tmp_path))
    assert data.inputs.shape == (2 * 3 * 90 * 4, 6)
    assert np.abs(data.inputs[:, 1]).max() == pytest.approx(0.2, rel=1e-4)
    assert data.inputs[:, 2].max() == pytest.approx(0.06, rel=1e-4)
    assert set(np.round(data.inputs[:, 3])) == {1000.0, 2000.0, 3000.0, 4500.0}
    assert data.inputs[0, 4] == pytest.approx(2e5)
    assert data.inputs[0, 5] == pytest.approx(60.0 / 3.6, rel=1e-3)
    assert data.driven.sum() == 3 * 90 * 4
    assert any("FZ is negative" in note for note in data.notes)
    assert any("SA up to" in note and "deg" in note for note in data.notes)


def test_the_same_tables_in_other_units_are_the_same(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    expected = read_rig_data(write_tables(tmp_path))
    files = write_tables(tmp_path / "other")
    for file in files:
        changed(file, "SA", np.radians)
        changed(file, "P", lambda kpa: kpa / 100.0)  # bar
        changed(file, "V", lambda kmh: kmh / 3.6)
        changed(file, "FZ", np.negative)
    changed(files[0], "SL", lambda share: 100.0 * share)
    other = read_rig_data(files)
    np.testing.assert_allclose(other.inputs, expected.inputs, rtol=1e-5, atol=1e-6)


def test_a_unit_may_be_told(tmp_path: Path) -> None:
    files = write_tables(tmp_path)
    for file in files:
        changed(file, "P", lambda kpa: kpa / 6.894757)  # psi, 29
    assert read_rig_data(files).inputs[0, 4] == pytest.approx(2e5, rel=1e-5)  # 15 to 60: judged as psi
    for file in files:
        changed(file, "P", lambda psi: psi * 3.0)
    assert read_rig_data(files, {"P": "psi"}).inputs[0, 4] == pytest.approx(6e5, rel=1e-5)
    with pytest.raises(InputError, match="unit of P"):
        read_rig_data(files, {"P": "furlong"})


def test_minus_one_stands_for_free_rolling(tmp_path: Path) -> None:
    """Seen at a rig: slip column SR is -1.000 while the wheel rolls freely."""
    _, cornering = write_tables(tmp_path)
    changed(cornering, "SL", lambda slip: slip - 0.9998, rename="SR")
    data = read_rig_data([cornering])
    assert not data.driven.any()
    assert not data.inputs[:, 0].any()
    assert any("freely rolling" in note for note in data.notes)


def test_a_slip_that_refers_to_another_radius_is_noticed(tmp_path: Path) -> None:
    driven, _ = write_tables(tmp_path)
    changed(driven, "SL", lambda slip: slip - 0.02, rename="SR")
    assert any("refers to another radius" in note for note in read_rig_data([driven]).notes)


def test_turned_signs_are_turned_back(tmp_path: Path) -> None:
    files = write_tables(tmp_path)
    before = read_rig_data(files)
    changed(files[0], "SL", np.negative)
    changed(files[1], "SA", np.negative)
    after = read_rig_data(files)
    np.testing.assert_allclose(after.inputs[:, :2], before.inputs[:, :2], atol=1e-6)
    assert sum("turned round" in note for note in after.notes) == 2


def test_sae_signs_turn_slip_angle_side_force_and_moment(tmp_path: Path) -> None:
    files = write_tables(tmp_path)
    iso, sae = read_rig_data(files), read_rig_data(files, sae=True)
    np.testing.assert_allclose(sae.inputs[:, 1], -iso.inputs[:, 1])
    np.testing.assert_allclose(sae.measured["fy"], -iso.measured["fy"])
    np.testing.assert_allclose(sae.measured["mz"], -iso.measured["mz"])
    np.testing.assert_allclose(sae.measured["fx"], iso.measured["fx"])


def test_gzip_folders_and_unit_rows(tmp_path: Path) -> None:
    """Files of the tyre test consortium have a title row, names, units, and tabs."""
    folder = tmp_path / "rig"
    folder.mkdir()
    driven, cornering = write_tables(tmp_path)
    header, *rows = driven.read_text().splitlines()
    text = "\n".join(["round 9, run 38", header, "sec,-,deg,deg,kPa,kph,N,N,N,Nm,Nm", *rows]).replace(",", "\t")
    (folder / "drivebrake.dat").write_text(text + "\n")
    with gzip.open(folder / "cornering.csv.gz", "wt") as file:
        file.write(cornering.read_text())
    (folder / "README.md").write_text("none")
    data = read_rig_data([folder])
    assert data.inputs.shape == read_rig_data([driven, cornering]).inputs.shape


def test_faults_name_file_and_column(tmp_path: Path) -> None:
    driven, _ = write_tables(tmp_path)
    changed(driven, "FZ", np.asarray, rename="FN")
    with pytest.raises(InputError, match=r"drivebrake.csv: no channel 'FZ'"):
        read_rig_data([driven])
    with pytest.raises(InputError, match="no such file"):
        read_rig_data([tmp_path / "none.csv"])
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no table of a rig"):
        read_rig_data([tmp_path / "empty"])
