"""Units against closed forms, and against pint as a second opinion."""

import math
import subprocess
import sys

import pint
import pytest

from signals.quantities import QuantityError, to_si
from signals.units import parse_unit


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("80 km/h", "m/s", 80 / 3.6),
        ("120 bar", "Pa", 1.2e7),
        ("400 bar/s", "Pa/s", 4e7),
        ("0.3 bar/N", "Pa/N", 3e4),
        ("30 deg", "rad", math.pi / 6),
        ("13.5 deg/s", "rad/s", 13.5 * math.pi / 180),
        ("6500 rpm", "rad/s", 6500 * 2 * math.pi / 60),
        ("16.25 cm^2", "m^2", 1.625e-3),
        ("4 cm^3", "m^3", 4e-6),
        ("1300 N s/m", "N s/m", 1300.0),
        ("20 kN/m", "N/m", 2e4),
        ("0.8 kg m^2", "kg m^2", 0.8),
        ("10 %", "1", 0.1),
        ("0.5 g", "m/s^2", 4.905),
        ("1.4 t", "kg", 1400.0),
        ("2 ms", "s", 2e-3),
        ("3 m^3/h", "m^3/s", 3 / 3600),
        (" -1.5e1 m ", "m", -15.0),
        ("7", "m", 7.0),
        (7, "m", 7.0),
        ("1 atm", "Pa", 101325.0),  # only pint knows it
    ],
)
def test_values(text: str | float, unit: str, expected: float) -> None:
    assert to_si(text, unit) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "unit", ["km/h", "bar/s", "N s/m", "cm^2", "kN/m", "kg m^2", "N m/rad", "W", "mV", "kHz", "m^3/s", "m/s^2", "Pa/N"]
)
def test_factors_agree_with_pint(unit: str) -> None:
    known = parse_unit(unit)
    assert known is not None
    assert known[0] == pytest.approx(pint.get_application_registry().Quantity(1.0, unit).to_base_units().magnitude)


@pytest.mark.parametrize(
    ("text", "unit", "problem"),
    [
        ("80 bar", "m/s", "wrong dimension, a quantity in Pa"),
        ("5 deg", "1", "wrong dimension, a quantity in rad"),
        ("10 Hz", "rad/s", "wrong dimension, a quantity in Hz"),
        ("5 furlongz", "m", "unknown unit 'furlongz'"),
        ("fast", "m/s", "not a number with a unit"),
        ("1,5 m", "m", "unknown unit ',5 m'"),
        ("1 atm", "m", "wrong dimension"),
    ],
)
def test_refused(text: str, unit: str, problem: str) -> None:
    with pytest.raises(QuantityError) as caught:
        to_si(text, unit)
    assert caught.value.problem == problem


def test_shipped_vehicles_need_no_unit_library() -> None:
    code = (
        "import sys; from vehicle_model.vehicle_file import load_vehicle, vehicle_names\n"
        "on_tir_tyres = ['commonroad_bmw_320i']  # a .tir file is checked with numpy\n"
        "for name in set(vehicle_names()) - set(on_tir_tyres): load_vehicle(name)\n"
        "assert 'pint' not in sys.modules and 'numpy' not in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
