"""Tyres from ``.tir`` files: reading, signs, limits, symmetry, versions, faults."""

import math
from pathlib import Path

import numpy as np
import pytest

from signals.errors import InputError
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.magic_formula_tyre import MagicFormula52, MagicFormula61, MagicFormula62, MagicFormulaTyre

HEADER = """$-------------------- a tyre made for these tests
[MDI_HEADER]
FILE_TYPE   = 'tir'     ! of no program
[UNITS]
LENGTH = 'meter'
FORCE = 'newton'
ANGLE = '{angle}'
MASS = 'kg'
TIME = 'second'
[MODEL]
FITTYP\t= {fittyp}\t$ version
TYRESIDE = 'LEFT'
LONGVL = 16.7
[DIMENSION]
UNLOADED_RADIUS = 0.317
[SHAPE]
{{radial width}}
 1.0    0.0
 0.9    1.0
[OPERATING_CONDITIONS]
INFLPRES =
NOMPRES = 2.2e5
[VERTICAL]
FNOMIN = 4000
[VERTICAL_FORCE_RANGE]
FZMIN = 200
FZMAX = 9000
[SLIP_ANGLE_RANGE]
ALPMIN = {low}
ALPMAX = {high}
"""

COEFFICIENTS = """[LONGITUDINAL_COEFFICIENTS]
PCX1 = 1.6
PDX1 = 1.1      $ peak
PDX2 = -0.1
PEX1 = 0.3
PKX1 = 22.0
PKX3 = 0.2
RBX1 = 12.0
RBX2 = 10.0
RCX1 = 1.05
[LATERAL_COEFFICIENTS]
PCY1 = 1.3
PDY1 = 1.0D+00
PDY2 = -0.12
PEY1 = -0.8
PKY1 = -20.0
PKY2 = 1.9
PKY6 = -0.9
RBY1 = 10.0
RBY2 = 8.0
RCY1 = 1.05
[ALIGNING_COEFFICIENTS]
QBZ1 = 9.0
QCZ1 = 1.2
QDZ1 = 0.11
QEZ1 = -2.0
[ROLLING_COEFFICIENTS]
QSY1 = 0.01
[OVERTURNING_COEFFICIENTS]
QSX2 = 0.8
QSX3 = 0.05
"""


def write(folder: Path, fittyp: str = "61", coefficients: str = COEFFICIENTS, **header: str) -> Path:
    values = {"angle": "radian", "low": "-0.5", "high": "0.5"} | header
    file = folder / "tyre.tir"
    file.write_bytes((HEADER.format(fittyp=fittyp, **values) + coefficients + "$ µ-Messung\n").encode("latin-1"))
    return file


@pytest.fixture
def tyre(tmp_path: Path) -> MagicFormulaTyre:
    return read_tir(write(tmp_path))


@pytest.mark.parametrize(
    ("fittyp", "kind"), [("52", MagicFormula52), ("6", MagicFormula52), ("61", MagicFormula61), ("62", MagicFormula62)]
)
def test_the_file_says_which_formula(tmp_path: Path, fittyp: str, kind: type) -> None:
    read = read_tir(write(tmp_path, fittyp))
    assert type(read) is kind
    assert read.record["PDY1"][0] == 1.0
    assert read.record["INFLPRES"][0] == 2.2e5  # blank: the nominal pressure


def test_signs_are_those_of_iso(tyre: MagicFormulaTyre) -> None:
    driving = tyre.forces(0.05, 0.0, 0.0, 4000.0)
    assert driving.fx > 0.0
    turned = tyre.forces(0.0, 0.05, 0.0, 4000.0)
    assert turned.fy < 0.0
    assert turned.mz > 0.0  # turns the wheel back towards its path
    assert turned.my < 0.0
    assert tyre.forces(0.0, 0.0, 0.0, 4000.0, speed=-10.0).my > 0.0
    assert isinstance(driving.fx, float)


def test_arrays_broadcast(tyre: MagicFormulaTyre) -> None:
    forces = tyre.forces(np.linspace(-0.2, 0.2, 5)[:, None], 0.02, 0.0, np.array([2000.0, 4000.0, 6000.0]))
    assert forces.fx.shape == (5, 3)
    assert forces.fx[1, 2] == tyre.forces(-0.1, 0.02, 0.0, 6000.0).fx


def test_pure_slip_is_the_formula(tyre: MagicFormulaTyre) -> None:
    load, slip = 5000.0, -0.08
    dfz = (load - 4000.0) / 4000.0
    peak = (1.1 - 0.1 * dfz) * load
    stiffness = load * 22.0 * math.exp(0.2 * dfz)
    x = stiffness / (1.6 * peak) * slip
    expected = peak * math.sin(1.6 * math.atan(x - 0.3 * (x - math.atan(x))))
    assert tyre.forces(slip, 0.0, 0.0, load).fx == pytest.approx(expected, rel=1e-12)
    assert tyre.stiffnesses(load)[0] == pytest.approx(stiffness)
    slopes = tyre.slopes(0.0, 0.0, 0.0, load)
    assert slopes.fx_by_slip_ratio == pytest.approx(stiffness, rel=1e-6)
    assert slopes.fy_by_slip_angle == pytest.approx(tyre.stiffnesses(load)[1], rel=1e-6)


def test_a_tyre_without_shifts_is_symmetric_and_mirrors(tyre: MagicFormulaTyre) -> None:
    points = (np.array([-0.1, 0.2]), np.array([0.05, -0.1]), np.array([0.02, -0.03]), 4000.0)
    here = tyre.forces(*points)
    there = tyre.forces(points[0], -points[1], -points[2], 4000.0)
    np.testing.assert_allclose([there.fx, there.fy, there.mz, there.mx], [here.fx, -here.fy, -here.mz, -here.mx])
    other_side = tyre.forces(points[0], -points[1], -points[2], 4000.0, mirrored=True)
    np.testing.assert_allclose([other_side.fy, other_side.mz], [-here.fy, -here.mz])


def test_combined_slip_takes_from_each_force(tyre: MagicFormulaTyre) -> None:
    pure = tyre.forces(-0.08, 0.0, 0.0, 4000.0).fx, tyre.forces(0.0, 0.08, 0.0, 4000.0).fy
    both = tyre.forces(-0.08, 0.08, 0.0, 4000.0)
    assert abs(both.fx) < abs(pure[0])
    assert abs(both.fy) < abs(pure[1])


def test_a_file_without_weights_gets_an_ellipse(tmp_path: Path) -> None:
    lines = [line for line in COEFFICIENTS.splitlines() if not line.startswith("R")]
    tyre = read_tir(write(tmp_path, coefficients="\n".join(lines) + "\n"))
    assert tyre.uses_ellipse
    slips, angles = np.meshgrid(np.linspace(-0.5, 0.5, 41), np.linspace(-0.4, 0.4, 41))
    forces = tyre.forces(slips, angles, 0.0, 4000.0)
    used = np.hypot(forces.fx / (1.1 * 4000.0), forces.fy / 4000.0)
    assert used.max() <= 1.0 + 1e-9
    assert used.max() > 0.99
    without = read_tir(write(tmp_path, coefficients="\n".join(lines) + "\n"), combined_slip="weights")
    assert without.forces(-0.1, 0.1, 0.0, 4000.0).fx == without.forces(-0.1, 0.0, 0.0, 4000.0).fx


def test_pressure_and_friction_and_scale_act(tmp_path: Path) -> None:
    text = COEFFICIENTS.replace("PKX3 = 0.2", "PKX3 = 0.2\nPPX1 = -0.3\nPPX3 = -0.1")
    tyre = read_tir(write(tmp_path, coefficients=text))
    soft = tyre.forces(-0.01, 0.0, 0.0, 4000.0, inflation_pressure=1.76e5)
    assert soft.fx / tyre.forces(-0.01, 0.0, 0.0, 4000.0).fx == pytest.approx(1.0 + 0.3 * 0.2, rel=1e-2)
    wet = tyre.forces(-1.0, 0.0, 0.0, 4000.0, friction=0.5)
    assert wet.fx / tyre.forces(-1.0, 0.0, 0.0, 4000.0).fx == pytest.approx(0.5, rel=0.1)
    # friction leaves the slope at zero slip, as scale factor LMUX does
    small = [tyre.forces(-1e-4, 0.0, 0.0, 4000.0, friction=f).fx for f in (1.0, 0.5)]
    assert small[1] == pytest.approx(small[0], rel=1e-2)
    scaled = read_tir(write(tmp_path), scale={"LKY": 0.5})
    assert scaled.stiffnesses(4000.0)[1] == pytest.approx(0.5 * read_tir(write(tmp_path)).stiffnesses(4000.0)[1])


def test_a_lifted_tyre_has_no_force(tyre: MagicFormulaTyre) -> None:
    assert list(tyre.forces(-0.1, 0.1, 0.0, -50.0)) == [0.0] * 5


def test_limits_are_checked_with_a_clear_message(tmp_path: Path) -> None:
    tyre = read_tir(write(tmp_path))
    with pytest.raises(InputError) as caught:
        tyre.forces(0.0, 0.6, 0.0, 4000.0)
    assert "slip_angle" in str(caught.value)
    assert "-0.5…0.5 rad" in str(caught.value)
    with pytest.raises(InputError, match="vertical_load"):
        tyre.forces(0.0, 0.0, 0.0, [4000.0, 10000.0])
    with pytest.raises(InputError, match="slip_ratio"):
        tyre.forces(float("nan"), 0.0, 0.0, 4000.0)
    tyre.forces(0.0, 0.6, 0.0, 4000.0, check=False)
    in_degrees = read_tir(write(tmp_path, angle="deg", low="-15", high="15"))
    assert in_degrees.limits.ranges["slip_angle"][1] == pytest.approx(math.radians(15.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("FITTYP\t= 61", "FITTYP\t= 70"), "unknown formula"),
        (("FITTYP\t= 61", ""), "does not say which formula"),
        (("PKY1 = -20.0", ""), "PKY1"),
        (("FNOMIN = 4000", "FNOMIN = -4"), "absurd value"),
        (("PDX1 = 1.1 ", "PDX1 = 1100"), "absurd value"),
        (("PKX1 = 22.0", "PKX1 = twenty"), "PKX1"),
        (("FORCE = 'newton'", "FORCE = 'pound_force'"), "not an SI unit"),
        (("[VERTICAL]", "what is this"), "no line of a .tir file"),
        (("UNLOADED_RADIUS = 0.317", "UNLOADED_RADIUS = 317"), "0.02…3"),
        (("NOMPRES = 2.2e5", "NOMPRES = 32"), "pressures are in Pa"),
        (("ALPMAX = 0.5", "ALPMAX = 15"), "-1.6…1.6"),
        (("FZMAX = 9000", "FZMAX = 100"), "more than FZMIN = 200"),
        (("PKX3 = 0.2", "PKX3 = 0.2\nPCX1 = 1.2"), "given twice with different values, first in line 32"),
        (("PDX2 = -0.1", "PDX2 = 1e9"), "absurd value"),
    ],
)
def test_faults_name_the_line(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    file = write(tmp_path)
    text = file.read_bytes().decode("latin-1")
    assert change[0] in text
    file.write_bytes(text.replace(*change).encode("latin-1"))
    with pytest.raises(InputError) as caught:
        read_tir(file)
    assert message in str(caught.value)
    assert "tyre.tir" in str(caught.value)


def test_a_missing_section_is_one_fault(tmp_path: Path) -> None:
    head, _, rest = COEFFICIENTS.partition("[LATERAL_COEFFICIENTS]")
    with pytest.raises(InputError) as caught:
        read_tir(write(tmp_path, coefficients=head + rest[rest.index("[ALIGNING") :]))
    message = str(caught.value)
    assert "[LATERAL_COEFFICIENTS]: section is missing" in message
    assert "PCY1, PDY1, PKY1, PKY2" in message
    assert "PKX1" not in message


def test_a_missing_coefficient_is_put_into_its_section(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_tir(write(tmp_path, coefficients=COEFFICIENTS.replace("PKY1 = -20.0", "PKYY1 = -20.0")))
    assert "tyre.tir:41:1  PKY1: is missing in [LATERAL_COEFFICIENTS]" in str(caught.value)
    assert "did you mean PKYY1?" in str(caught.value)


def test_exceeded_limits_tell_the_line_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"tyre.tir: ALPMIN in line 29, ALPMAX in line 30"):
        read_tir(write(tmp_path)).forces(0.0, 0.6, 0.0, 4000.0)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_tir(tmp_path / "none.tir")
    (tmp_path / "text.tir").write_text("a = 1\n")
    with pytest.raises(InputError, match="no section"):
        read_tir(tmp_path / "text.tir")
    (tmp_path / "binary.tir").write_bytes(b"\x00\x01\x02")
    with pytest.raises(InputError, match="not a text file"):
        read_tir(tmp_path / "binary.tir")
    with pytest.raises(InputError, match="did you mean LMU"):
        read_tir(write(tmp_path), scale={"LMUZ": 1.0})
