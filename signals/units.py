"""Units as files write them, without a unit library: ``km/h``, ``N s/m``, ``bar/N``, ``cm^2``.

A unit is a factor to SI and a dimension. An angle has a dimension of its own here, so that a frequency in Hz is no
angular speed and a slope in degrees is no ratio.
"""

import math
import re
from functools import cache

# exponents of m, kg, s, A, rad, degC
Dimension = tuple[int, int, int, int, int, int]

_NONE: Dimension = (0, 0, 0, 0, 0, 0)
_BASE: dict[str, tuple[float, Dimension]] = {
    "1": (1.0, _NONE),
    "%": (0.01, _NONE),
    "m": (1.0, (1, 0, 0, 0, 0, 0)),
    "kg": (1.0, (0, 1, 0, 0, 0, 0)),
    "t": (1000.0, (0, 1, 0, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0, 0)),
    "min": (60.0, (0, 0, 1, 0, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0, 0)),
    "rad": (1.0, (0, 0, 0, 0, 1, 0)),
    "deg": (math.pi / 180, (0, 0, 0, 0, 1, 0)),
    "rev": (2 * math.pi, (0, 0, 0, 0, 1, 0)),
    "rpm": (math.pi / 30, (0, 0, -1, 0, 1, 0)),
    "degC": (1.0, (0, 0, 0, 0, 0, 1)),
    "Hz": (1.0, (0, 0, -1, 0, 0, 0)),
    "N": (1.0, (1, 1, -2, 0, 0, 0)),
    "Pa": (1.0, (-1, 1, -2, 0, 0, 0)),
    "bar": (1e5, (-1, 1, -2, 0, 0, 0)),
    "J": (1.0, (2, 1, -2, 0, 0, 0)),
    "W": (1.0, (2, 1, -3, 0, 0, 0)),
    "V": (1.0, (2, 1, -3, -1, 0, 0)),
    "l": (1e-3, (3, 0, 0, 0, 0, 0)),
    "g": (9.81, (1, 0, -2, 0, 0, 0)),  # standard gravity, the unit of accelerations; masses are in kg
}
_PREFIXES = {"k": 1e3, "M": 1e6, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "c": 1e-2, "d": 1e-1}
_WITH_PREFIX = {"m", "s", "N", "Pa", "J", "W", "V", "A", "Hz", "bar", "rad", "l"}
_FACTOR = re.compile(r"^([A-Za-zµ%1]+)(?:\^(-?\d+))?$")
_NAMES = ("m/s", "m/s^2", "Pa", "N", "N m", "kg", "m", "s", "rad", "rad/s", "Hz", "m^2", "m^3", "W", "V", "A", "1")


@cache
def parse_unit(text: str) -> tuple[float, Dimension] | None:
    """Factor to SI and dimension of a unit, None if it is unknown. Factors are separated by a space, ``*`` or ``/``."""
    factor, exponents = 1.0, list(_NONE)
    for number, part in enumerate(text.replace("²", "^2").replace("³", "^3").split("/")):
        for piece in re.split(r"[ *·]+", part.strip()):
            match = _FACTOR.match(piece)
            unit = _single(match[1]) if match else None
            if match is None or unit is None:
                return None
            power = int(match[2] or 1) * (-1 if number else 1)
            factor *= unit[0] ** power
            exponents = [old + power * new for old, new in zip(exponents, unit[1], strict=True)]
    a, b, c, d, e, f = exponents
    return factor, (a, b, c, d, e, f)


def _single(name: str) -> tuple[float, Dimension] | None:
    if name in _BASE:
        return _BASE[name]
    prefix, rest = name[:1], name[1:]
    if prefix in _PREFIXES and rest in _WITH_PREFIX:
        factor, dimension = _BASE[rest]
        return _PREFIXES[prefix] * factor, dimension
    return None


def si_name(dimension: Dimension) -> str:
    """Usual SI unit of a dimension, or an empty text."""
    for name in _NAMES:
        known = parse_unit(name)
        if known is not None and known[1] == dimension:
            return name
    return ""
