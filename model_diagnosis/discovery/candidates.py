"""Candidate terms: functions of variables as the plant's added terms know them, evaluated on measured data."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.discovery.quantities import Balance, Series, Variable, stacked

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """A function of one variable, with the names of `vehicle_model.extension_terms_file`."""

    variable: str
    function: str = "power"
    symmetry: str = "none"
    exponent: float = 1.0
    at: float = 0.0
    width: float = 1.0
    wave_number: float = 1.0

    def of(self, x: FloatArray) -> FloatArray:
        """Values for one manoeuvre, (n,) or (n, 4); a sine has its cosine beside it (see `Candidate`)."""
        if self.symmetry == "none":
            return self._plain(x)
        even = self._plain(np.abs(x))
        return np.sign(x) * even if self.symmetry == "odd" else even

    def _plain(self, x: FloatArray) -> FloatArray:
        if self.function == "power":
            result: FloatArray = np.sign(x) * np.abs(x) ** self.exponent
            return result
        if self.function == "above":
            return np.where(x > self.at, np.maximum(x - self.at, 0.0) ** self.exponent, 0.0)
        if self.function == "below":
            return np.where(x < self.at, np.maximum(self.at - x, 0.0) ** self.exponent, 0.0)
        if self.function == "step":
            return (x > self.at).astype(np.float64)
        if self.function == "limited":
            return np.clip((x - self.at) / self.width, -1.0, 1.0)
        if self.function == "relay":
            return _by_column(x, lambda column: _relay(column, self.at, self.width))
        if self.function == "direction":
            return _by_column(x, lambda column: _direction(column, self.width))
        raise ValueError(f"found the function {self.function!r}, allowed: one without a phase")

    @property
    def text(self) -> str:
        """As a formula has it."""
        x = f"|{self.variable}|" if self.symmetry == "even" else self.variable
        power = "" if self.exponent == 1.0 else f"^{self.exponent:g}"
        if self.function == "power":
            return f"{x}{power}"
        if self.function == "above":
            return f"max({x} - {self.at:.4g}, 0){power}"
        if self.function == "below":
            return f"max({self.at:.4g} - {x}, 0){power}"
        if self.function == "step":
            return f"[{x} > {self.at:.4g}]"
        if self.function == "limited":
            return f"limited({x} / {self.width:.4g})"
        if self.function == "relay":
            return f"relay({x}; {self.at - self.width:.4g}, {self.at + self.width:.4g})"
        if self.function == "direction":
            return f"direction({x}; {self.width:.4g})"
        return f"sin({self.wave_number:.4g} {x})"


def _by_column(x: FloatArray, function: Callable[[FloatArray], FloatArray]) -> FloatArray:
    if x.ndim == 1:
        return function(x)
    return np.stack([function(np.ascontiguousarray(x[:, i])) for i in range(x.shape[1])], axis=1)


@njit(cache=True)
def _relay(x: FloatArray, at: float, width: float) -> FloatArray:
    result = np.empty_like(x)
    held = -1.0
    for k in range(len(x)):
        if x[k] > at + width:
            held = 1.0
        elif x[k] < at - width:
            held = -1.0
        result[k] = held
    return result


@njit(cache=True)
def _direction(x: FloatArray, width: float) -> FloatArray:
    result = np.empty_like(x)
    held = 0.0
    for k in range(len(x)):
        held = min(max(held, x[k] - width), x[k] + width)
        result[k] = (x[k] - held) / width
    return result


@dataclass(frozen=True)
class Candidate:
    """A product of shapes, alone or times a force of the balance.

    Attributes
    ----------
    force : name of the force that it multiplies; empty for an additive term
    wheel : the one wheel on which it acts; -1 for all
    """

    shapes: tuple[Shape, ...]
    force: str = ""
    wheel: int = -1

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of its variables, sorted."""
        return tuple(sorted(shape.variable for shape in self.shapes))

    @property
    def kind(self) -> str:
        """product, power, threshold, hysteresis or periodic."""
        functions = {shape.function for shape in self.shapes}
        if "sine" in functions:
            return "periodic"
        if functions & {"relay", "direction"}:
            return "hysteresis"
        if functions & {"above", "below", "step", "limited"}:
            return "threshold"
        return "product" if len({shape.variable for shape in self.shapes}) > 1 else "power"

    @property
    def family(self) -> tuple[str, ...]:
        """Candidates of a family differ in the numbers of their shapes only."""
        functions = "·".join(sorted(f"{shape.variable}:{shape.function}:{shape.symmetry}" for shape in self.shapes))
        exponents = "" if self.kind != "product" else str(sorted(shape.exponent for shape in self.shapes))
        return self.force, str(self.wheel), functions, exponents

    @property
    def numbers(self) -> int:
        """Numbers inside its shapes that are fitted to data."""
        kinds = {"above": 1, "below": 1, "step": 1, "limited": 1, "relay": 2, "direction": 1, "sine": 1}
        single = len(self.shapes) == 1 and self.shapes[0].function == "power" and self.shapes[0].exponent != 1.0
        return sum(kinds.get(shape.function, 0) for shape in self.shapes) + int(single)

    @property
    def complexity(self) -> float:
        """For choosing the simplest of equals: factors, odd exponents, numbers inside."""
        odd = sum(_oddness(shape.exponent) for shape in self.shapes)
        powers = sum(0.25 * abs(shape.exponent - 1.0) for shape in self.shapes)
        return len(self.shapes) + self.numbers + odd + powers + (0.5 if self.wheel >= 0 else 0.0)

    def with_shape(self, **changes: Any) -> "Candidate":
        """The same with other numbers in its one shape."""
        return replace(self, shapes=(replace(self.shapes[0], **changes), *self.shapes[1:]))

    @property
    def text(self) -> str:
        """As a formula has it, without coefficient."""
        parts = ([self.force] if self.force else []) + [shape.text for shape in self.shapes]
        return " · ".join(parts) or "1"


def _oddness(exponent: float) -> float:
    if exponent == round(exponent):
        return 0.0
    return 0.25 if 2.0 * exponent == round(2.0 * exponent) else 0.75


Variables = Mapping[str, Variable]


def columns_of(candidate: Candidate, balance: Balance, variables: Variables) -> FloatArray:
    """Columns (N, d) of a candidate: one, or sine and cosine of a periodic one (for each manoeuvre where the variable's
    zero has no meaning)."""
    periodic = [shape for shape in candidate.shapes if shape.function == "sine"]
    plain = [_product(candidate, balance, variables, m) for m in range(len(balance.error))]
    if not periodic:
        return stacked([_summed(one, candidate.wheel) for one in plain])[:, None]
    shape = periodic[0]
    variable = variables[shape.variable]
    parts = []
    for m, values in enumerate(variable.values):
        angle = shape.wave_number * values
        rest = plain[m]
        if angle.ndim == 2 and rest.ndim == 1:
            rest = rest[:, None] / 4.0 if candidate.force else rest[:, None]
        elif angle.ndim == 1 and rest.ndim == 2:
            rest = rest.sum(axis=1)
        waves = [_summed(rest * np.sin(angle), candidate.wheel), _summed(rest * np.cos(angle), candidate.wheel)]
        parts.append(np.stack(waves, axis=1))
    if not variable.cumulative:
        return np.concatenate(parts)
    blocks = np.zeros((balance.samples, 2 * len(parts)))
    start = 0
    for m, part in enumerate(parts):
        blocks[start : start + len(part), 2 * m : 2 * m + 2] = part
        start += len(part)
    return blocks


def _product(candidate: Candidate, balance: Balance, variables: Variables, m: int) -> FloatArray:
    """Force times all shapes but a sine, (n,) or (n, 4)."""
    force: Series = balance.forces[candidate.force].values if candidate.force else ()
    value = force[m] if candidate.force else np.ones(len(balance.error[m]))
    for shape in candidate.shapes:
        if shape.function == "sine":
            continue
        factor = shape.of(variables[shape.variable].values[m])
        if factor.ndim == 2 and value.ndim == 1:
            # the force of the car is taken as the wheels' in equal parts; what is additive acts on each wheel
            value = value[:, None] / 4.0 if candidate.force else value[:, None]
        elif factor.ndim == 1 and value.ndim == 2:
            factor = factor[:, None]
        value = value * factor
    return value


def _summed(values: FloatArray, wheel: int) -> FloatArray:
    """Sum over the wheels, or one wheel's."""
    if values.ndim == 1:
        return values
    return values[:, wheel] if wheel >= 0 else values.sum(axis=1)
