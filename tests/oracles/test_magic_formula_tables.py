"""Magic Formula against the value tables of two independent programs, to 1e-9 of each column's full scale."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from vehicle_model.tyres import read_tir
from vehicle_model.tyres.relaxation import fill_in
from vehicle_model.tyres.tir_writer import write_tir
from vehicle_model.tyres.tyre_file import TirTyre

DATA = Path(os.environ.get("BENCH_SHARED_DATA", Path(__file__).parents[2].parent / "shared" / "data"))
pytestmark = pytest.mark.skipif(not (DATA / "mf61-oracle").is_dir(), reason=f"no reference tables in {DATA}")

FULL_SCALE = 1e-9

# what the two programs do differently from the book, read in their sources
OCTAVE_LIBRARY = (
    "angle_in_side_force",
    "curvature_sign_of_angle",
    "curvature_unlimited",
    "residual_without_camber",
    "residual_cosine_twice",
)
PAC2002_ROUTINE = ("denominator_plus_0_1", "camber_raises_side_friction", "trail_sign_of_slip_ratio")


def table(name: str) -> dict[str, NDArray[np.float64]]:
    with (DATA / "mf61-oracle" / name).open(newline="") as file:
        header, *rows = csv.reader(file)
    return dict(zip(header, np.array(rows, np.float64).T, strict=True))


def share_of_full_scale(value: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    return float(np.abs(value - reference).max() / np.abs(reference).max())


def test_version_6_1_meets_the_octave_library() -> None:
    points = table("mf61_obfuscated.csv")
    tyre = read_tir(DATA / "tyre-rig-ttc-deid" / "obfuscated.tir", deviations=OCTAVE_LIBRARY)
    forces = tyre.forces(
        points["SX"], points["SA_rad"], points["IA_rad"], points["FZ_N"], points["IP_Pa"], points["VX_mps"]
    )
    columns = {"fx": "FX_N", "fy": "FY_N", "mx": "MX_Nm", "my": "MY_Nm", "mz": "MZ_Nm"}
    for name, column in columns.items():
        assert share_of_full_scale(getattr(forces, name), points[column]) < FULL_SCALE, column


def test_the_book_and_the_octave_library_differ_as_known() -> None:
    points = table("mf61_obfuscated.csv")
    forces = read_tir(DATA / "tyre-rig-ttc-deid" / "obfuscated.tir").forces(
        points["SX"], points["SA_rad"], points["IA_rad"], points["FZ_N"], points["IP_Pa"], points["VX_mps"]
    )
    assert share_of_full_scale(forces.fx, points["FX_N"]) < FULL_SCALE
    assert share_of_full_scale(forces.fy, points["FY_N"]) == pytest.approx(1.1e-3, rel=0.1)
    assert share_of_full_scale(forces.mz, points["MZ_Nm"]) < 0.02


@pytest.mark.parametrize(("suffix", "clamp"), [("unclamped", ()), ("clamped", ("argument_clamped",))])
def test_pac2002_meets_the_routine(suffix: str, clamp: tuple[str, ...]) -> None:
    points = table("pac02_sedan.csv")
    file = DATA / "tir-chrono" / "Sedan_Pac02Tire.tir"
    tyre = read_tir(file, combined_slip="weights", deviations=(*PAC2002_ROUTINE, *clamp))
    forces = tyre.forces(points["kappa"], points["alpha_rad"], points["gamma_rad"], points["FZ_N"])
    for name, column in {"fx": "FX", "fy": "FY", "mz": "MZ"}.items():
        assert share_of_full_scale(getattr(forces, name), points[f"{column}_{suffix}"]) < FULL_SCALE, column


def test_a_locked_wheel_brakes_less_than_the_peak_and_the_clamp_hides_it() -> None:
    file = DATA / "tir-chrono" / "Sedan_Pac02Tire.tir"
    slips = np.linspace(-1.0, 0.0, 1001)
    load = 4850.0 * 0.81  # nominal load: FNOMIN times LFZO
    formula = -read_tir(file).forces(slips, 0.0, 0.0, load).fx / load
    clamped = -read_tir(file, deviations=("argument_clamped", "denominator_plus_0_1")).forces(slips, 0.0, 0.0, load).fx
    assert formula[0] < 0.8 * formula.max()
    assert clamped[0] == pytest.approx(clamped.max(), rel=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        "tir-chrono/Sedan_Pac02Tire",
        "tir-chrono/Generic_Pac02Tire",
        "tir-chrono/mf_185_80R14",
        "tyre-rig-ttc-deid/obfuscated",
        "tyre-rig-ttc-deid/obfuscated_v52",
    ],
)
def test_public_tyres_have_a_falling_branch(name: str) -> None:
    tyre = read_tir(DATA / f"{name}.tir")
    load = float(tyre.record["FNOMIN"][0] * tyre.record["LFZO"][0])
    braking = -tyre.forces(np.linspace(-1.0, 0.0, 1001), 0.0, 0.0, load, check=False).fx
    assert braking[0] < 0.97 * braking.max()
    assert 0.03 < (1000 - int(braking.argmax())) / 1000 < 0.4


@pytest.mark.parametrize(
    "name", ["tir-chrono/Sedan_Pac02Tire", "tir-chrono/Generic_Pac02Tire", "tyre-rig-ttc-deid/obfuscated"]
)
def test_public_tyres_written_again_are_the_same(name: str, tmp_path: Path) -> None:
    tyre = read_tir(DATA / f"{name}.tir")
    again = read_tir(write_tir(tmp_path / "again.tir", tyre))
    assert again.record.tobytes() == tyre.record.tobytes()
    assert dict(again.limits.ranges) == dict(tyre.limits.ranges)


def test_relaxation_lengths_of_a_public_tyre() -> None:
    tyre = read_tir(DATA / "tir-chrono" / "Sedan_Pac02Tire.tir")
    along, across = tyre.relaxation_lengths(4000.0)
    assert 0.1 < across < 1.5
    assert 0.1 < along < 1.5
    entry = TirTyre(tir=str(DATA / "tir-chrono" / "Sedan_Pac02Tire.tir"))
    fill_in(entry)
    assert entry.relaxation_length_lateral == pytest.approx(tyre.relaxation_lengths(4850.0 * 0.81)[1])
    assert entry.relaxation_length_longitudinal == pytest.approx(tyre.relaxation_lengths(4850.0 * 0.81)[0])
