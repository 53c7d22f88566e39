"""Fits: a known tyre is found again through noise and outliers; measured data beat the file that comes with them."""

import os
from pathlib import Path

import numpy as np
import pytest
from rig_tables import LOADS, true_tyre, write_tables

from bench.tyre_bench.fit_command import run_fit
from bench.tyre_bench.fitting import errors_of, fit_tyre
from bench.tyre_bench.rig_data import read_rig_data
from bench.tyre_bench.stages import STAGES, bounds_of
from signals.errors import InputError
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.magic_formula_record import COEFFICIENTS

DATA = Path(os.environ.get("BENCH_SHARED_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
RIG = DATA / "tyre-rig-ttc-deid"
NOISE = {"fx": 15.0, "fy": 15.0, "mx": 1.0, "mz": 1.0}


def silent(line: str) -> None:
    """No progress."""


def test_every_coefficient_of_a_stage_is_one_of_a_tir_file() -> None:
    names = [name for stage in STAGES for name in stage.coefficients]
    assert set(names) <= COEFFICIENTS
    assert len(names) == len(set(names))
    for name in names:
        start, low, high = bounds_of(name)
        assert low < start < high or low == start < high


def test_a_known_tyre_is_found_again(tmp_path: Path) -> None:
    """Noise of 15 N and 1 N m, and 1 % of rows 4 kN off: what remains is the noise."""
    data = read_rig_data(write_tables(tmp_path, outliers=10))
    fit = fit_tyre(data, "again", nominal_load=3000.0, nominal_pressure=2e5, radius=0.3, rows_per_stage=500)
    truth = true_tyre()
    slips, angles = np.linspace(-0.25, 0.2, 46), np.linspace(-0.2, 0.2, 41)
    for load in LOADS:
        for camber in (0.0, 0.05):
            for mine, theirs in (
                (fit.tyre.forces(slips, 0.0, 0.0, load, check=False).fx, truth.forces(slips, 0.0, 0.0, load).fx),
                (
                    fit.tyre.forces(0.0, angles, camber, load, check=False).fy,
                    truth.forces(0.0, angles, camber, load).fy,
                ),
                (
                    fit.tyre.forces(slips, -0.06, 0.0, load, check=False).fy,
                    truth.forces(slips, -0.06, 0.0, load).fy,
                ),
            ):
                assert np.abs(mine - theirs).max() < 0.02 * load
    errors = errors_of(fit.tyre, data)
    for force in ("fy", "mz"):
        assert errors["cornering"][force] < 1.15 * NOISE[force]
    record = fit.tyre.record[0]
    assert record["PDX1"] == pytest.approx(1.15, rel=0.03)
    assert record["PKX1"] == pytest.approx(24.0, rel=0.03)
    assert record["PKY1"] == pytest.approx(-19.0, rel=0.05)
    assert fit.missing == []


def test_a_fit_repeats_bit_for_bit(tmp_path: Path) -> None:
    data = read_rig_data(write_tables(tmp_path)[1:])
    first, second = (fit_tyre(data, "a", radius=0.3, rows_per_stage=300).tyre.record.tobytes() for _ in range(2))
    assert first == second


def test_cornering_alone_leaves_the_longitudinal_curve_usual(tmp_path: Path) -> None:
    _, cornering = write_tables(tmp_path)
    lines: list[str] = []
    result = run_fit([cornering], tmp_path / "out", "half", radius=0.3, say=lines.append)
    assert "longitudinal" in result["missing"]
    assert "lateral at slip ratios" in result["missing"]
    tyre = read_tir(tmp_path / "out" / "half.tir")
    assert tyre.record["PCX1"][0] == bounds_of("PCX1")[0]
    assert "usual values kept: longitudinal" in (tmp_path / "out" / "half.tir").read_text("latin-1")
    assert tyre.limits.ranges["slip_angle"][1] == pytest.approx(0.2, rel=1e-4)
    for picture in ("fit.png", "residuals.png"):
        assert (tmp_path / "out" / picture).stat().st_size > 20_000


def test_too_little_to_fit(tmp_path: Path) -> None:
    driven, _ = write_tables(tmp_path)
    with pytest.raises(InputError, match="radius"):
        fit_tyre(read_rig_data([driven]), "a")
    head = driven.read_text().splitlines()[:100]
    driven.write_text("\n".join(head) + "\n")
    with pytest.raises(InputError, match="too few measurements"):
        fit_tyre(read_rig_data([driven]), "a", radius=0.3)


@pytest.mark.skipif(not RIG.is_dir(), reason=f"no measurements of a rig in {DATA}")
def test_measured_rig_data_are_met_as_well_as_by_the_file_that_comes_with_them() -> None:
    """Issue: at most 1.1 times its error; here for each force, in drive/brake and in cornering tests."""
    data = read_rig_data([RIG])
    assert data.radius == pytest.approx(0.2025, rel=0.05)
    fit = fit_tyre(data, "rig", rows_per_stage=700)
    mine, theirs = errors_of(fit.tyre, data), errors_of(read_tir(RIG / "obfuscated.tir"), data)
    for kind, by_force in mine.items():
        for force, error in by_force.items():
            assert error <= 1.1 * theirs[kind][force], (kind, force)
    braking = -fit.tyre.forces(np.linspace(-1.0, 0.0, 101), 0.0, 0.0, 2500.0, check=False).fx / 2500.0
    assert 0.6 < braking[0] <= braking.max() < 1.8  # beyond the measured slip the curve stays that of a tyre
