"""Units as other people's logs write them: ``kmph``, ``°/s``, ``m/s2``, ``U/min``."""

import re
from functools import cache

from signals.quantities import QuantityError, to_si

_WRITTEN = {
    "kmph": "km/h", "kmh": "km/h", "kph": "km/h", "km/hr": "km/h",
    "mps": "m/s", "m/sec": "m/s", "meters/second": "m/s", "metres/second": "m/s",
    "m/s2": "m/s^2", "m/s/s": "m/s^2", "m/s**2": "m/s^2", "m/sec2": "m/s^2", "m/sec^2": "m/s^2", "mps2": "m/s^2",
    "g": "g", "gs": "g",
    "°": "deg", "degree": "deg", "degrees": "deg", "grad": "deg",
    "°/s": "deg/s", "°/sec": "deg/s", "deg/sec": "deg/s", "degree/s": "deg/s", "degrees/s": "deg/s",
    "degree/second": "deg/s", "degrees/second": "deg/s", "grad/s": "deg/s", "dps": "deg/s",
    "radian": "rad", "radians": "rad", "rad/sec": "rad/s", "radians/second": "rad/s", "1/s": "rad/s",
    "u/min": "rpm", "1/min": "rpm", "/min": "rpm", "min-1": "rpm", "min^-1": "rpm", "r/min": "rpm",
    "nm": "N m", "n.m": "N m", "n*m": "N m", "newton meter": "N m", "ft.lbs": "ft*lbf", "lb-ft": "ft*lbf",
    "kpa": "kPa", "mpa": "MPa", "pa": "Pa", "newton": "N", "kn": "kN",
}  # fmt: skip
"""In small letters. Other than in a unit library a g is of gravity, a kmph no thousand miles, an Nm no nautical one."""


_SAYS_SOMETHING = re.compile("[A-Za-z%1]")
"""Other than an empty text or a dash, which a number without a unit stands for in any quantity."""


@cache
def unit_in(text: str, quantity: str) -> str | None:
    """A unit text of a log as our files write it; None where it is no unit of the quantity.

    Parameters
    ----------
    quantity : SI unit of the quantity, as the signal catalogue writes it
    """
    plain = text.strip().strip("[]()").strip().replace("²", "^2").replace("·", "*")
    for unit in dict.fromkeys((_WRITTEN.get(plain.lower(), plain), plain.lower())):
        if _SAYS_SOMETHING.search(unit) and _measures(unit, quantity):
            return unit
    return None


def _measures(unit: str, quantity: str) -> bool:
    try:
        return to_si(f"1 {unit}", quantity) > 0.0
    except QuantityError:
        return False
