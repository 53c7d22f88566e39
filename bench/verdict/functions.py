"""Functions of the expression language on arrays of shape (rows, wheels).

Functions along time keep the wheels apart and return shape (1, wheels); the others reduce everything to one number. A
row stands for the time until the next row, the last one for as long as the one before it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import FloatArray
from bench.verdict.assessment import NoValueError, intervals

Array = NDArray[Any]


@dataclass(frozen=True)
class Rows:
    """Time of each row of the window and the time it stands for, in s."""

    time: FloatArray
    weight: FloatArray

    @classmethod
    def of(cls, time: FloatArray, window: slice) -> "Rows":
        """Rows of a window of a run."""
        inside = time[window]
        weight = np.diff(time[window.start : min(window.stop + 1, len(time))])
        if len(weight) < len(inside):
            weight = np.append(weight, weight[-1] if len(weight) else 0.0)
        return cls(inside, weight)


def _series(rows: Rows, value: Any) -> Array:
    """Value per row; a number is the same in every row."""
    array = np.atleast_2d(np.asarray(value))
    if array.shape[0] == len(rows.time):
        return array
    if array.shape[0] == 1:
        return np.broadcast_to(array, (len(rows.time), array.shape[1]))
    raise ValueError("needs a value for every row of the phase (select leaves rows out)")


def _condition(rows: Rows, value: Any) -> NDArray[np.bool_]:
    array = _series(rows, value)
    return array if array.dtype == np.bool_ else array != 0


def _numbers(value: Any) -> FloatArray:
    array = np.asarray(value, np.float64)
    if array.size == 0:
        raise NoValueError("no sample is left to take a value from")
    return array


def _clip(_: Rows, x: Any, low: Any, high: Any) -> Any:
    return np.clip(x, low, high)


def _where(_: Rows, condition: Any, x: Any, y: Any) -> Any:
    return np.where(np.asarray(condition, np.bool_), x, y)


def _select(rows: Rows, x: Any, condition: Any) -> Any:
    values, chosen = np.broadcast_arrays(_series(rows, x), _condition(rows, condition))
    return values[chosen][:, None]


def _extreme(reduce: Callable[[Any], Any], pairwise: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    def extreme(_: Rows, *values: Any) -> Any:
        if len(values) == 1:
            return reduce(_numbers(values[0]))
        result = values[0]
        for value in values[1:]:
            result = pairwise(result, value)
        return result

    return extreme


def _percentile(_: Rows, x: Any, percent: Any) -> Any:
    if not 0 <= float(percent) <= 100:
        raise ValueError(f"found {float(percent):g}; allowed: 0 to 100 %")
    return np.percentile(_numbers(x), float(percent))


def _integral(rows: Rows, x: Any) -> Any:
    return np.atleast_2d(np.trapezoid(np.asarray(_series(rows, x), np.float64), rows.time, axis=0))


def _derivative(rows: Rows, x: Any) -> Any:
    if len(rows.time) < 2:
        raise NoValueError("a derivative needs two rows")
    return np.gradient(np.asarray(_series(rows, x), np.float64), rows.time, axis=0)


def _moving_mean(rows: Rows, x: Any, span: Any) -> Any:
    values = np.asarray(_series(rows, x), np.float64)
    first = np.searchsorted(rows.time, rows.time - float(span) + 1e-9)
    total = np.concatenate((np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)))
    end = np.arange(1, len(rows.time) + 1)
    first = np.minimum(first, end - 1)
    return (total[end] - total[first]) / (end - first)[:, None]


def _at(rows: Rows, x: Any, time: Any) -> Any:
    values, instant = np.asarray(_series(rows, x), np.float64), float(np.asarray(time).item())
    if not rows.time[0] <= instant <= rows.time[-1]:
        raise NoValueError(f"the time {instant:g} s is outside the phase")
    return np.array([[np.interp(instant, rows.time, column) for column in values.T]])


def _first_time(rows: Rows, condition: Any) -> Any:
    holds = _condition(rows, condition)
    return np.where(holds.any(axis=0), rows.time[np.argmax(holds, axis=0)], np.inf)[None, :]


def _last_time(rows: Rows, condition: Any) -> Any:
    holds = _condition(rows, condition)
    last = len(rows.time) - 1 - np.argmax(holds[::-1], axis=0)
    return np.where(holds.any(axis=0), rows.time[last], -np.inf)[None, :]


def _duration(rows: Rows, condition: Any) -> Any:
    return (rows.weight @ _condition(rows, condition).astype(np.float64))[None, :]


def _share(rows: Rows, condition: Any) -> Any:
    total = rows.weight.sum()
    return _duration(rows, condition) / total if total > 0 else _condition(rows, condition).mean(axis=0)[None, :]


def longest(rows: Rows, condition: Any) -> FloatArray:
    """Longest unbroken time during which each column of a condition holds, shape (1, columns), in s."""
    holds = _condition(rows, condition)
    elapsed = np.concatenate(([0.0], np.cumsum(rows.weight)))
    result = np.zeros((1, holds.shape[1]))
    for column in range(holds.shape[1]):
        begins, ends = intervals(holds[:, column])
        if len(begins):
            result[0, column] = np.max(elapsed[ends] - elapsed[begins])
    return result


def _count_rising(rows: Rows, condition: Any) -> Any:
    holds = _condition(rows, condition)
    return np.atleast_2d(np.sum(holds[1:] & ~holds[:-1], axis=0, dtype=np.float64))


IMPLEMENTATIONS: dict[str, Callable[..., Any]] = {
    "abs": lambda _, x: np.abs(x),
    "sign": lambda _, x: np.sign(x),
    "sqrt": lambda _, x: np.sqrt(x),
    "hypot": lambda _, x, y: np.hypot(x, y),
    "sin": lambda _, x: np.sin(x),
    "cos": lambda _, x: np.cos(x),
    "tan": lambda _, x: np.tan(x),
    "clip": _clip,
    "where": _where,
    "select": _select,
    "max": _extreme(np.max, np.maximum),
    "min": _extreme(np.min, np.minimum),
    "mean": lambda _, x: np.mean(_numbers(x)),
    "std": lambda _, x: np.std(_numbers(x)),
    "rms": lambda _, x: np.sqrt(np.mean(_numbers(x) ** 2)),
    "rmse": lambda _, x, y: np.sqrt(np.mean(_numbers(np.subtract(x, y)) ** 2)),
    "percentile": _percentile,
    "integral": _integral,
    "derivative": _derivative,
    "moving_mean": _moving_mean,
    "first": lambda rows, x: _series(rows, x)[:1],
    "last": lambda rows, x: _series(rows, x)[-1:],
    "at": _at,
    "first_time": _first_time,
    "last_time": _last_time,
    "duration": _duration,
    "longest": longest,
    "share": _share,
    "count_rising": _count_rising,
    "any": lambda rows, x: _condition(rows, x).any(),
    "all": lambda rows, x: _condition(rows, x).all(),
}
