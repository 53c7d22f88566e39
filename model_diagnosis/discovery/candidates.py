"""Candidate terms: functions of variables as the plant's added terms know them, evaluated on measured data."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.discovery.variables import Variable

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
        """Values for one manoeuvre, (n,) or (n, 4); a sine has its cosine beside it (see `courses`)."""
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
        if self.function == "excess_share":
            return np.maximum(1.0 - self.at / np.maximum(x, 1e-3 * self.at), 0.0)
        if self.function == "limited":
            return np.clip((x - self.at) / self.width, -1.0, 1.0)
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
        if self.function == "excess_share":
            return f"max(1 - {self.at:.4g} / {x}, 0)"
        if self.function == "limited":
            return f"limited({x} / {self.width:.4g})"
        if self.function == "direction":
            return f"direction({x}; {self.width:.4g})"
        return f"sin({self.wave_number:.4g} {x})"


def _by_column(x: FloatArray, function: Callable[[FloatArray], FloatArray]) -> FloatArray:
    if x.ndim == 1:
        return function(x)
    return np.stack([function(np.ascontiguousarray(x[:, i])) for i in range(x.shape[1])], axis=1)


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
    """A product of shapes."""

    shapes: tuple[Shape, ...]

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
        if "direction" in functions:
            return "hysteresis"
        if functions & {"above", "below", "step", "excess_share", "limited"}:
            return "threshold"
        return "product" if len({shape.variable for shape in self.shapes}) > 1 else "power"

    @property
    def family(self) -> tuple[str, ...]:
        """Candidates of a family differ in the numbers of their shapes only."""
        functions = "·".join(sorted(f"{shape.variable}:{shape.function}:{shape.symmetry}" for shape in self.shapes))
        exponents = "" if self.kind != "product" else str(sorted(shape.exponent for shape in self.shapes))
        return functions, exponents

    @property
    def numbers(self) -> int:
        """Numbers inside its shapes that are fitted to data."""
        kinds = {
            "above": 1,
            "below": 1,
            "step": 1,
            "excess_share": 1,
            "limited": 1,
            "direction": 1,
            "sine": 1,
        }
        single = len(self.shapes) == 1 and self.shapes[0].function == "power" and self.shapes[0].exponent != 1.0
        return sum(kinds.get(shape.function, 0) for shape in self.shapes) + int(single)

    @property
    def complexity(self) -> float:
        """For choosing the simplest of equals: factors, odd exponents, numbers inside."""
        odd = sum(_oddness(shape.exponent) for shape in self.shapes)
        powers = sum(0.25 * abs(shape.exponent - 1.0) for shape in self.shapes)
        return len(self.shapes) + self.numbers + odd + powers

    def with_shape(self, **changes: Any) -> "Candidate":
        """The same with other numbers in its one shape."""
        return replace(self, shapes=(replace(self.shapes[0], **changes), *self.shapes[1:]))

    @property
    def text(self) -> str:
        """As a formula has it, without coefficient."""
        return " · ".join(shape.text for shape in self.shapes)


def _oddness(exponent: float) -> float:
    if exponent == round(exponent):
        return 0.0
    return 0.25 if 2.0 * exponent == round(2.0 * exponent) else 0.75


Variables = Mapping[str, Variable]
