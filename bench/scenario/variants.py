"""Variants of a scenario: lists, grids, ranges and random draws of values.

    variants:
      list:
        - {name: twin, set: {plant: single_track}}
      grid:
        road.friction: [0.3, 0.6, 0.9]
        ecu.calibration: [sensitive, coarse]
      range: {parameter: initial_speed, from: 60 km/h, to: 120 km/h, steps: 4}
      random:
        count: 20
        seed: 7
        parameters:
          body.mass: {uniform: [1200 kg, 1500 kg]}
          brakes.front.pad_friction: {normal: [0.4, 0.04]}
          ecu.calibration: {choice: [sensitive, coarse]}

Given together they are combined, each with each. A path is one that ``--set`` takes.
"""

import math
import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from pydantic import ConfigDict, Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel

_NUMBER = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")
MOST_VARIANTS = 100_000


class NamedVariant(FileModel):
    """One variant by name."""

    name: str = Field(pattern=r"^[\w.+-]+$", description="appended to the scenario's id")
    set: dict[str, Any] = Field(description="path: value, as for --set")


class Range(FileModel):
    """Evenly spaced values of one parameter."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True, serialize_by_alias=True)

    parameter: str = Field(description="path, as for --set")
    start: float | str = Field(alias="from", description="first value")
    to: float | str = Field(description="last value, with the unit of the first")
    steps: int = Field(ge=2, le=10_000, description="number of values")

    @model_validator(mode="after")
    def _same_unit(self) -> "Range":
        if _split(self.start)[1] != _split(self.to)[1]:
            raise FieldError(
                "another unit than the first value", at=("to",), allowed=_split(self.start)[1] or "no unit"
            )
        return self


class Draw(FileModel):
    """How a value is drawn; exactly one of the fields."""

    uniform: list[float | str] | None = Field(
        default=None, min_length=2, max_length=2, description="lowest and highest value"
    )
    normal: list[float | str] | None = Field(
        default=None, min_length=2, max_length=2, description="mean, standard deviation"
    )
    choice: list[Any] | None = Field(default=None, min_length=1, description="one of these")

    @model_validator(mode="after")
    def _one(self) -> "Draw":
        given = [name for name in ("uniform", "normal", "choice") if getattr(self, name) is not None]
        if len(given) != 1:
            raise FieldError(
                "one way to draw", found=" and ".join(given) or "none", allowed="uniform, normal or choice"
            )
        for name in ("uniform", "normal"):
            pair = getattr(self, name)
            if pair is not None and _split(pair[0])[1] != _split(pair[1])[1]:
                raise FieldError("two different units", at=(name, 1), allowed=_split(pair[0])[1] or "no unit")
        return self

    def value(self, generator: random.Random) -> Any:
        """A drawn value, a text with its unit where the file gives one."""
        if self.choice is not None:
            return generator.choice(self.choice)
        pair = self.uniform or self.normal or []
        (first, unit), (second, _) = _split(pair[0]), _split(pair[1])
        number = generator.uniform(first, second) if self.uniform else generator.gauss(first, second)
        return _joined(number, unit)


class Random(FileModel):
    """Random draws, the same for the same seed."""

    count: int = Field(ge=1, le=MOST_VARIANTS, description="number of draws")
    seed: int = Field(default=1, ge=0, description="of the draws; the runs' own seeds count up from the scenario's")
    parameters: dict[str, Draw] = Field(min_length=1, description="path: how it is drawn")


class Variants(FileModel):
    """Further runs of a scenario; what is given together is combined, each with each."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True, serialize_by_alias=True)

    named: list[NamedVariant] | None = Field(default=None, alias="list", min_length=1, description="variants by name")
    grid: dict[str, Any] | None = Field(
        default=None, description="path: list of values; every combination is a variant"
    )
    range: Range | None = Field(default=None, description="evenly spaced values of one parameter")
    random: Random | None = Field(default=None, description="random draws")

    @model_validator(mode="after")
    def _checked(self) -> "Variants":
        if self.named is None and self.grid is None and self.range is None and self.random is None:
            raise FieldError("no variants", allowed="list, grid, range or random")
        for path, values in (self.grid or {}).items():
            if not isinstance(values, (list, tuple)) or not values:
                raise FieldError("not a list of values", at=("grid", path))
        names = [variant.name for variant in self.named or ()]
        for number, name in enumerate(names):
            if name in names[:number]:
                raise FieldError("two variants of one name", at=("list", number, "name"))
        total = math.prod(len(part) for part in _parts(self))
        if total > MOST_VARIANTS:
            raise FieldError(f"{total} variants", allowed=f"at most {MOST_VARIANTS}")
        return self


@dataclass(frozen=True)
class Variant:
    """One variant: its name and what it sets (path: value)."""

    name: str
    sets: Mapping[str, Any]


def expand(variants: Variants) -> list[Variant]:
    """All variants, in the order of the file; the last part varies fastest."""
    result = []
    for combination in product(*_parts(variants)):
        sets: dict[str, Any] = {}
        for part in combination:
            sets |= part.sets
        result.append(Variant(",".join(part.name for part in combination), sets))
    return result


def _parts(variants: Variants) -> Sequence[Sequence[Variant]]:
    parts: Sequence[Sequence[Variant]] = [
        [Variant(entry.name, entry.set) for entry in variants.named or ()],
        *([_one(path, value) for value in values] for path, values in (variants.grid or {}).items()),
        _of_range(variants.range) if variants.range is not None else [],
        _of_random(variants.random) if variants.random is not None else [],
    ]
    return [part for part in parts if part]


def _one(path: str, value: Any) -> Variant:
    return Variant(f"{path}={value}", {path: value})


def _of_range(entry: Range) -> list[Variant]:
    (first, unit), (last, _) = _split(entry.start), _split(entry.to)
    step = (last - first) / (entry.steps - 1)
    return [_one(entry.parameter, _joined(first + step * number, unit)) for number in range(entry.steps)]


def _of_random(entry: Random) -> list[Variant]:
    generator = random.Random(entry.seed)
    draws = []
    for number in range(entry.count):
        values = {path: draw.value(generator) for path, draw in entry.parameters.items()}
        draws.append(Variant(f"draw{number + 1}", values))
    return draws


def _split(value: float | str) -> tuple[float, str]:
    """Number and unit of a value."""
    if not isinstance(value, str):
        return float(value), ""
    match = _NUMBER.match(value)
    if match is None:
        raise FieldError("not a number with a unit", found=repr(value))
    return float(match[1]), match[2]


def _joined(number: float, unit: str) -> float | str:
    rounded = float(f"{number:.12g}")
    return f"{rounded:.12g} {unit}" if unit else rounded
