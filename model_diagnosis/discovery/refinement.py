"""Numbers inside a candidate's shapes (exponent, threshold, width, wave number), fitted and then rounded."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar

from model_diagnosis.discovery.candidates import Candidate, Variables
from model_diagnosis.discovery.quantities import Variable

FloatArray = NDArray[np.float64]
Explained = Callable[[Candidate], float]

_EDGE = 0.05
"""Share of a range at its ends in which no threshold is looked for: too few samples lie beyond it."""
_ROUND_EXPONENTS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0)


def refine(candidate: Candidate, variables: Variables, explained: Explained) -> Candidate:
    """The candidate of the same form that explains most.

    Parameters
    ----------
    explained : drop of the squared residual by a candidate
    """
    if len(candidate.shapes) != 1:
        return candidate
    shape = candidate.shapes[0]
    variable = variables[shape.variable]
    if shape.function == "power" and shape.exponent != 1.0:
        return _along(candidate, "exponent", 0.3, 4.0, explained)
    if shape.function in ("above", "below", "step"):
        low, high = _span(variable, shape.symmetry)
        reach = 0.12 * (high - low)
        refined = _along(candidate, "at", max(shape.at - reach, low), min(shape.at + reach, high), explained)
        if shape.function == "step":
            return refined
        square = _along(refined.with_shape(exponent=2.0), "at", low, high, explained)
        return square if explained(square) > explained(refined) else refined
    if shape.function in ("direction", "limited"):
        return _along(candidate, "width", 0.7 * shape.width, 2.5 * shape.width, explained)
    if shape.function == "relay":
        return _relay(candidate, explained)
    if shape.function == "sine":
        reach = max(float(np.ptp(one[:, 0] if one.ndim == 2 else one)) for one in variable.values)
        step = np.pi / reach
        return _along(
            candidate, "wave_number", max(shape.wave_number - step, 0.2 * step), shape.wave_number + step, explained
        )
    return candidate


def _span(variable: Variable, symmetry: str) -> tuple[float, float]:
    low, high = variable.span
    if symmetry != "none":
        low, high = 0.0, max(abs(low), abs(high))
    edge = _EDGE * (high - low)
    return low + edge, high - edge


def _along(candidate: Candidate, name: str, low: float, high: float, explained: Explained) -> Candidate:
    """Best value of one number between two bounds; the candidate's own if nothing is better."""
    if not high > low:
        return candidate
    found = minimize_scalar(
        lambda value: -explained(candidate.with_shape(**{name: float(value)})),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 2e-3 * (high - low), "maxiter": 30},
    )
    better = candidate.with_shape(**{name: float(found.x)})
    return better if explained(better) > explained(candidate) else candidate


def _relay(candidate: Candidate, explained: Explained) -> Candidate:
    shape = candidate.shapes[0]

    def at(values: FloatArray) -> Candidate:
        return candidate.with_shape(at=float(values[0]), width=max(float(abs(values[1])), 1e-3 * shape.width))

    start = np.array([shape.at, shape.width])
    simplex = start + np.array([[0.0, 0.0], [shape.width, 0.0], [0.0, 0.6 * shape.width]])
    found = minimize(
        lambda values: -explained(at(values)),
        start,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": 60, "xatol": 1e-3 * shape.width, "fatol": 0.0},
    )
    better = at(found.x)
    return better if explained(better) > explained(candidate) else candidate


def rounded_forms(candidate: Candidate) -> list[Candidate]:
    """The candidate with its exponents at whole and half numbers, the nearest first."""
    if len(candidate.shapes) != 1 or candidate.shapes[0].function != "power":
        return []
    exponent = candidate.shapes[0].exponent
    nearest = sorted(_ROUND_EXPONENTS, key=lambda value: abs(value - exponent))[:2]
    return [replace(candidate, shapes=(replace(candidate.shapes[0], exponent=value),)) for value in nearest]
