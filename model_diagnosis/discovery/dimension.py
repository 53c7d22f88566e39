"""Dimensions of coefficients: a term that needs a constant with a made-up dimension is no law of physics."""

from collections.abc import Mapping

from model_diagnosis.discovery.candidates import Candidate
from model_diagnosis.discovery.variables import Variable
from model_diagnosis.replay.terms import FACTORS
from signals.units import parse_unit

_BASE = ("m", "kg", "s", "A", "rad", "degC")
_ANGLE = _BASE.index("rad")
MOST_EXPONENTS = 2
_UNITS = {"body_longitudinal_force": "N", "body_lateral_force": "N", "yaw_moment": "N m"}
"""Of what is added; a factor is a ratio."""


def _exponents(unit: str) -> list[float]:
    known = parse_unit(unit)
    if known is None:
        raise ValueError(f"found the unit {unit!r}, allowed: one that files may use")
    result = [float(exponent) for exponent in known[1]]
    result[_ANGLE] = 0.0  # radians are a ratio here
    return result


def _of_factors(candidate: Candidate, variables: Mapping[str, Variable]) -> list[float]:
    total = [0.0] * len(_BASE)
    for shape in candidate.shapes:
        if shape.function in ("step", "excess_share", "limited", "direction", "sine"):
            continue
        for k, exponent in enumerate(_exponents(variables[shape.variable].unit)):
            total[k] += exponent * shape.exponent
    return total


def coefficient_exponents(candidate: Candidate, target: str, variables: Mapping[str, Variable]) -> list[float]:
    """Exponents of m, kg, s, A, rad, °C in the coefficient's unit; ``target`` is one of `replay.terms`."""
    unit = [0.0] * len(_BASE) if target in FACTORS else _exponents(_UNITS[target])
    return [wanted - given for wanted, given in zip(unit, _of_factors(candidate, variables), strict=True)]


def is_physical(candidate: Candidate, target: str, variables: Mapping[str, Variable]) -> bool:
    """True unless the coefficient needs more than two base units beyond those of the target itself."""
    made_up = sum(exponent != 0.0 for exponent in _of_factors(candidate, variables))
    in_all = sum(exponent != 0.0 for exponent in coefficient_exponents(candidate, target, variables))
    return min(made_up, in_all) <= MOST_EXPONENTS


def unit_text(exponents: list[float]) -> str:
    """``kg/m``, ``s^2/m^2`` or ``1``."""
    above = [_with_power(name, power) for name, power in zip(_BASE, exponents, strict=True) if power > 0.0]
    below = [_with_power(name, -power) for name, power in zip(_BASE, exponents, strict=True) if power < 0.0]
    text = " ".join(above) or "1"
    return text + "".join(f"/{one}" for one in below)


def _with_power(name: str, power: float) -> str:
    return name if power == 1.0 else f"{name}^{power:g}"
