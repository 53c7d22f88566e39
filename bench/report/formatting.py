"""Numbers as people read them: display units, significant digits, limits and margins."""

import math
from typing import Any

_DISPLAY: dict[str, tuple[str, float]] = {
    "Pa": ("bar", 1e-5),
    "Pa/s": ("bar/s", 1e-5),
    "rad": ("°", 180 / math.pi),
    "rad/s": ("°/s", 180 / math.pi),
    "m/s^2": ("m/s²", 1.0),
    "m^3": ("cm³", 1e6),
    "1": ("", 1.0),
    "us": ("µs", 1.0),
}

# endings of metric names in verdict.json and the unit each stands for, longest first
_ENDINGS = (
    ("_m_s2", "m/s^2"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_pa", "Pa"),
    ("_us", "us"),
    ("_m", "m"),
    ("_s", "s"),
)

VERDICT_SYMBOLS = {"pass": "✓", "fail": "✗", "inconclusive": "?", "error": "!"}
VERDICT_ORDER = ("pass", "inconclusive", "fail", "error")


def display(value: float, unit: str) -> tuple[float, str]:
    """Value and unit as shown: bar instead of Pa, degrees instead of rad."""
    shown, factor = _DISPLAY.get(unit, (unit, 1.0))
    return value * factor, shown


def number(value: Any, digits: int = 4) -> str:
    """A number with ``digits`` significant digits, without exponents where a person would write none."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, (int, float)):
        return str(value)
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == int(value) and abs(value) < 1e7:
        text = str(int(value))
    elif 1e-3 <= abs(value) < 1e7:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        text = f"{value:.{decimals}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        text = f"{value:.{digits - 1}g}"
    return text.replace("-", "−")


def quantity(value: Any, unit: str) -> str:
    """Number with its display unit; a list gives its entries separated by spaced dots."""
    if isinstance(value, (list, tuple)):
        return " · ".join(quantity(item, "") for item in value) + (f" {display(0.0, unit)[1]}" if unit else "")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return number(value)
    shown, shown_unit = display(float(value), unit)
    text = number(shown)
    return f"{text} {shown_unit}".rstrip() if not shown_unit.startswith("°") else f"{text}{shown_unit}"


def limits_text(limits: Any, unit: str) -> str:
    """``≤ 75 m``, ``≥ 8 m/s²`` or ``2 … 5 m``; empty where there is no limit."""
    if not isinstance(limits, (list, tuple)) or len(limits) != 2:
        return ""
    low, high = (None if limit is None or math.isinf(limit) else float(limit) for limit in limits)
    if low is None and high is None:
        return ""
    if low is None:
        return f"≤ {quantity(high, unit)}"
    if high is None:
        return f"≥ {quantity(low, unit)}"
    if low == high:
        return f"= {quantity(low, unit)}"
    return f"{number(display(low, unit)[0])} … {quantity(high, unit)}"


def metric_label(name: str) -> tuple[str, str]:
    """Words and SI unit of a metric of ``verdict.json``: ``mean_deceleration_m_s2`` → mean deceleration, m/s^2."""
    unit = "1"
    for ending, meant in _ENDINGS:
        if name.endswith(ending) and len(name) > len(ending):
            name, unit = name[: -len(ending)], meant
            break
    words = name.replace("_", " ").strip()
    return words.replace("mfdd", "MFDD").replace("abs cycles", "ABS cycles").replace("max abs ", "largest "), unit


def seconds(value: float) -> str:
    """Duration with a sensible number of decimals."""
    return f"{value:.3f} s" if value < 10 else f"{value:.2f} s"


def size_text(size: int) -> str:
    """Size of a file in B, kB or MB."""
    if size < 1000:
        return f"{size} B"
    return f"{size / 1e3:.0f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"
