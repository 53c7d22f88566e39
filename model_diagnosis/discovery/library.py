"""Library of candidate terms: monomials up to degree 3, magnitudes, powers, thresholds, hysteresis, periodic functions.

Each stands alone (additive) or times a force of the balance (multiplicative); a term whose coefficient would need a
made-up dimension is left out.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.candidates import Candidate, Shape, Variables
from model_diagnosis.discovery.dimension import is_physical
from model_diagnosis.discovery.quantities import Balance, Variable
from model_diagnosis.gain import noise_std_of

FloatArray = NDArray[np.float64]

_POWERS = (0.5, 1.5, 2.0, 3.0)
_THRESHOLDS = (0.1, 0.25, 0.4, 0.55, 0.7, 0.85)
_STEPS = (0.2, 0.35, 0.5, 0.65, 0.8)
_WIDTHS = (0.03, 0.08, 0.2)
_RELAYS = ((0.25, 0.05), (0.5, 0.05), (0.75, 0.05), (0.4, 0.15), (0.6, 0.15), (0.5, 0.25))
_LIMITS = (0.02, 0.06, 0.2)
_NOISES = 6.0
"""Half widths of a hysteresis are larger than this many standard deviations of noise, which else is its input."""
_MOST_PERIODS = 200
_FEWEST_PERIODS = 2
_MOST_OF_A_STATE = 20.25
_PEAKS = 4
_WHOLE_TURNS = (1.0, 2.0, 3.0, 4.0)


def _base(variable: Variable) -> list[Shape]:
    """The variable itself and, where it changes sign, its magnitude."""
    shapes = [Shape(variable.name)]
    if variable.signed:
        shapes.append(Shape(variable.name, symmetry="even"))
    return shapes


def _powers(variable: Variable) -> Iterator[Shape]:
    yield from _base(variable)
    for exponent in _POWERS:
        yield Shape(variable.name, exponent=exponent, symmetry="even")
        if variable.signed:
            yield Shape(variable.name, exponent=exponent, symmetry="odd")


def _thresholds(variable: Variable) -> Iterator[Shape]:
    values = np.concatenate([one.ravel() for one in variable.values])
    cases = [("none", values)]
    if variable.signed:
        cases = [("even", np.abs(values)), ("odd", np.abs(values)), ("none", values)]
    for symmetry, x in cases:
        low, high = np.quantile(x, [0.005, 0.995])
        if not high > low:
            continue
        for at in (float(low + share * (high - low)) for share in _THRESHOLDS):
            yield Shape(variable.name, "above", symmetry, at=at)
            if symmetry != "odd":
                yield Shape(variable.name, "below", symmetry, at=at)
        for share in _STEPS:
            yield Shape(variable.name, "step", symmetry, at=float(low + share * (high - low)))


def _hysteresis(variable: Variable) -> Iterator[Shape]:
    low, high = variable.span
    if variable.cumulative or not high > low:
        return
    least = _NOISES * max(noise_std_of(one[:, 0] if one.ndim == 2 else one) for one in variable.values)
    for share in _WIDTHS:
        if share * (high - low) > least:
            yield Shape(variable.name, "direction", width=share * (high - low))
    for place, share in _RELAYS:
        if share * (high - low) > least:
            yield Shape(variable.name, "relay", at=low + place * (high - low), width=share * (high - low))


def _limited(variable: Variable) -> Iterator[Shape]:
    """Which way a variable goes, level from a size on: what follows the sign of a rate or a slip."""
    if not variable.signed or variable.cumulative:
        return
    largest = max(abs(end) for end in variable.span)
    for share in _LIMITS:
        yield Shape(variable.name, "limited", width=share * largest)


def _products(variables: Variables) -> Iterator[tuple[Shape, ...]]:
    """Products of two variables, and of the square of one with another."""
    usable = [variable for variable in variables.values() if not variable.cumulative]
    for first, second in combinations(usable, 2):
        for one in _base(first):
            for other in _base(second):
                yield one, other
        for squared, plain in ((first, second), (second, first)):
            for base in _base(plain):
                yield Shape(squared.name, exponent=2.0, symmetry="even"), base
    for trio in combinations(usable, 3):
        yield tuple(Shape(variable.name) for variable in trio)


def library(balance: Balance, variables: Variables) -> list[Candidate]:
    """All candidates but the periodic ones, which need the residual (see `periodic`)."""
    shapes: list[tuple[Shape, ...]] = []
    for variable in variables.values():
        if not variable.cumulative:
            single = (*_powers(variable), *_thresholds(variable), *_hysteresis(variable), *_limited(variable))
            shapes += [(shape,) for shape in single]
    shapes += list(_products(variables))
    forces = ["", *balance.forces] if balance.target else list(balance.forces)
    candidates = [Candidate(one, force) for force in forces for one in shapes]
    return [candidate for candidate in candidates if is_physical(candidate, balance, variables)]


def periodic(balance: Balance, variables: Variables, residual: FloatArray, root_weights: FloatArray) -> list[Candidate]:
    """Periodic candidates at the highest peaks of the residual's periodogram over each variable.

    Parameters
    ----------
    residual, root_weights : (N,) weighted residual, square roots of the weights
    """
    found = []
    forces = ["", *balance.forces] if balance.target else list(balance.forces)
    for force in forces:
        for variable in variables.values():
            wheels = range(4) if variable.of_wheels and variable.cumulative else (-1,)
            for wheel in wheels:
                template = Candidate((Shape(variable.name, "sine"),), force, wheel)
                if is_physical(template, balance, variables):
                    found += _peaks(template, balance, variables, residual, root_weights)
    return found


def _peaks(
    template: Candidate, balance: Balance, variables: Variables, residual: FloatArray, root_weights: FloatArray
) -> list[Candidate]:
    variable = variables[template.shapes[0].variable]
    reach = max(float(np.ptp(one[:, 0] if one.ndim == 2 else one)) for one in variable.values)
    if not reach > 0.0:
        return []
    grid: FloatArray = np.arange(float(_FEWEST_PERIODS), float(_MOST_PERIODS)) * (2.0 * np.pi / reach)
    if not variable.cumulative:
        # a state passes through its range a few times only: more periods than that are noise
        grid = 2.0 * np.pi / reach * np.arange(1.0, _MOST_OF_A_STATE, 0.25)
    power = _powers_over(template, grid, balance, variables, residual, root_weights)
    inner = np.flatnonzero((power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])) + 1
    best = inner[np.argsort(power[inner])[::-1][:_PEAKS]]
    wave_numbers = [float(grid[k]) for k in best]
    if variable.name == "wheel_angle":
        wave_numbers += list(_WHOLE_TURNS)
    return [template.with_shape(wave_number=k) for k in wave_numbers]


def _powers_over(
    template: Candidate,
    wave_numbers: FloatArray,
    balance: Balance,
    variables: Variables,
    residual: FloatArray,
    root_weights: FloatArray,
) -> FloatArray:
    """Squared residual that a sine and a cosine of each wave number (k,) would take, nearly."""
    variable, start = variables[template.shapes[0].variable], 0
    total = np.zeros(len(wave_numbers))
    sums, squares = np.zeros(len(wave_numbers), complex), 0.0
    for m, values in enumerate(variable.values):
        rows = slice(start, start + len(values))
        start += len(values)
        force = balance.forces[template.force].values[m] if template.force else np.ones(len(values))
        if values.ndim == 2:
            wheel = max(template.wheel, 0)
            values = values[:, wheel]
            force = force[:, wheel] if force.ndim == 2 else force
        elif force.ndim == 2:
            force = force.sum(axis=1)
        weighted = force * root_weights[rows]
        part = (residual[rows] * weighted) @ np.exp(1j * values[:, None] * wave_numbers)
        energy = 0.5 * float(weighted @ weighted)
        if variable.cumulative:
            total += np.abs(part) ** 2 / max(energy, 1e-300)
        else:
            sums, squares = sums + part, squares + energy
    return total if variable.cumulative else np.abs(sums) ** 2 / max(squares, 1e-300)
