"""Numbers with units in files: ``80 km/h`` becomes 22.2 m/s, a wrong dimension is refused.

A pydantic model whose fields are declared with :func:`parameter` accepts for each of them a plain number in SI units or
a text with a unit. The declaration keeps unit, range and neutral value, so that the same table serves validation, the
editors' schema and ``bench vehicle list``.
"""

import re
from tokenize import TokenError
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from signals.units import parse_unit, si_name

_TEXT = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")


class QuantityError(ValueError):
    """A text that is no number with a unit of the wanted dimension.

    Attributes
    ----------
    problem, allowed
        What is wrong, and what may stand there.
    """

    def __init__(self, problem: str, text: str, unit: str) -> None:
        self.problem = problem
        self.allowed = (
            f"a number in {unit} or a text such as '{_example(unit)}'" if unit != "1" else "a number or '5 %'"
        )
        super().__init__(f"{problem}: found {text!r}, allowed: {self.allowed}")


def to_si(value: str | float, unit: str) -> float:
    """Value in ``unit`` (an SI unit as the catalogue writes it) of a number or a text such as ``"80 km/h"``.

    Raises
    ------
    QuantityError
        If the text is no number, the unit is unknown, or its dimension is another one.
    """
    if isinstance(value, (int, float)):
        return float(value)
    match = _TEXT.match(value)
    if match is None:
        raise QuantityError("not a number with a unit", value, unit)
    number, written = float(match[1]), match[2]
    if written in ("", unit):
        return number
    known, wanted = parse_unit(written), parse_unit(unit)
    if known is None or wanted is None:
        return _with_pint(number, written, unit, value)
    if known[1] != wanted[1]:
        name = si_name(known[1])
        raise QuantityError("wrong dimension" + (f", a quantity in {name}" if name else ""), value, unit)
    return number * known[0] / wanted[0]


# what pint's parser raises on a text that is no unit; its own errors are AttributeError, ValueError and TypeError too
_NO_UNIT_OF_PINT = (
    AttributeError,
    ValueError,
    TypeError,
    SyntaxError,
    LookupError,
    ArithmeticError,
    AssertionError,
    TokenError,
)


def _with_pint(number: float, written: str, unit: str, text: str) -> float:
    """The rare unit that `signals.units` does not know; importing pint costs 0.2 s."""
    import pint

    registry: Any = pint.get_application_registry()  # type: ignore[no-untyped-call]
    try:
        target = registry.Unit("dimensionless" if unit == "1" else unit)
        return float(registry.Quantity(number, written).to(target).magnitude)
    except pint.DimensionalityError:
        raise QuantityError("wrong dimension", text, unit) from None
    except _NO_UNIT_OF_PINT:
        raise QuantityError(f"unknown unit {written!r}", text, unit) from None


_EXAMPLES = {
    "m": "25 cm",
    "m^3": "4 cm^3",
    "m/s^2": "0.3 g",
    "N": "400 N",
    "m/s": "80 km/h",
    "Pa": "120 bar",
    "Pa/s": "400 bar/s",
    "rad": "30 deg",
    "rad/s": "10 deg/s",
    "s": "50 ms",
}


def _example(unit: str) -> str:
    return _EXAMPLES.get(unit, f"1 {unit}")


def parameter(
    unit: str,
    default: Any = ...,
    *,
    low: float | None = None,
    high: float | None = None,
    description: str = "",
    neutral: float | None = None,
    source: str = "",
) -> Any:
    """Declare a field with a unit (pydantic ``Field``).

    Parameters
    ----------
    unit : str
        SI unit as in the signal catalogue, "1" for a pure number.
    default
        Default in SI units; leave out for a required field.
    low, high : float, optional
        Closed range in SI units.
    neutral : float, optional
        Value at which an optional effect changes nothing.
    source : str
        Where the default comes from (document and line, or "assumed").
    """
    extra: dict[str, Any] = {"unit": unit}
    if neutral is not None:
        extra["neutral"] = neutral
    if source:
        extra["source"] = source
    return Field(default, ge=low, le=high, description=description, json_schema_extra=extra)


def unit_of(field: FieldInfo) -> str | None:
    """Unit that a field was declared with, or None."""
    extra = field.json_schema_extra
    unit = extra.get("unit") if isinstance(extra, dict) else None
    return unit if isinstance(unit, str) else None


def limits_of(field: FieldInfo) -> tuple[float | None, float | None]:
    """Closed range of a field in SI units, None where it is open."""
    low = next((item.ge for item in field.metadata if getattr(item, "ge", None) is not None), None)
    high = next((item.le for item in field.metadata if getattr(item, "le", None) is not None), None)
    return low, high


def range_text(unit: str, low: float | None, high: float | None) -> str:
    """``0…1500 N``, ``at least 0 N`` or ``a number in N``."""
    behind = "" if unit in ("1", "") else f" {unit}"
    if low is not None and high is not None:
        return f"{low:g}…{high:g}{behind}"
    if low is not None:
        return f"at least {low:g}{behind}"
    if high is not None:
        return f"at most {high:g}{behind}"
    return f"a number in {unit}" if behind else "a number"


def _convert(value: Any, unit: str) -> Any:
    if isinstance(value, str):
        return to_si(value, unit)
    if isinstance(value, (list, tuple)):
        return [_convert(item, unit) for item in value]
    return value


class FileModel(BaseModel):
    """Base of everything that is read from a file: unknown fields are errors, quantities may carry units."""

    # most parts of a file are only ever read as part of the whole: they need no validator of their own
    model_config = ConfigDict(extra="forbid", validate_default=False, allow_inf_nan=False, defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _units(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields.get(info.field_name or "")
        unit = unit_of(field) if field is not None else None
        return value if unit is None else _convert(value, unit)
