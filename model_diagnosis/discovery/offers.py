"""Candidates that the replay itself weighs: what may change the brake torque, the grip, or push at the body.

A few of each variable first, that show which target lacks something; then all of that target.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from model_diagnosis.discovery.candidates import Candidate, Shape, Variables
from model_diagnosis.discovery.variables import Variable
from model_diagnosis.replay.terms import FACTORS

_VARIABLES = {
    "brake_torque_factor": (
        *("speed", "yaw_rate", "lateral_acceleration", "steering_wheel_angle"),
        *("brake_pressure", "brake_pressure_rate", "brake_disc_temperature", "vertical_load"),
    ),
    "tyre_friction_factor": (
        *("speed", "steering_wheel_angle"),
        *("vertical_load", "slip_angle", "slip_ratio", "brake_disc_temperature"),
    ),
    "body_longitudinal_force": ("speed", "yaw_rate", "lateral_acceleration", "steering_wheel_angle"),
    "body_lateral_force": ("speed", "yaw_rate", "longitudinal_acceleration", "steering_wheel_angle"),
    "yaw_moment": ("speed", "lateral_acceleration", "longitudinal_acceleration", "steering_wheel_angle"),
}
"""What each target may depend on: no acceleration or rate that it causes itself, as the noise of that would stand on
both sides."""
_WAVES_OF = ("speed", "brake_pressure", "steering_wheel_angle", "brake_disc_temperature")
"""Variables that a periodic term may go over: what passes through its range smoothly."""
_MOST_PERIODS = 20
_PLACES = (0.3, 0.6)
"""Thresholds, over a variable's span; like the next three only where a search begins."""
_LIMITS = (0.04, 0.15)
"""Half widths of a limited slope, over the largest magnitude."""
_WIDTHS = (0.04, 0.12)
"""Half widths within which a direction turns round, over the span."""
_SHARES_FROM = (0.1, 0.25, 0.5)
"""Thresholds of what lies above as a share, over the largest value."""
_PLACE_STEP, _WIDTH_FACTOR, _PERIOD_STEP = 0.07, 1.5, 0.2
"""Distance of neighbours at reach 1: of a place over the span, of widths by a factor, of the periods in the span."""


def _variables_for(target: str, variables: Variables) -> list[Variable]:
    return [variables[name] for name in _VARIABLES[target] if name in variables]


def _bases(variable: Variable) -> list[Shape]:
    plain = [Shape(variable.name)]
    return [*plain, Shape(variable.name, symmetry="even")] if variable.signed else plain


def _limited(variable: Variable) -> Iterator[Shape]:
    if variable.signed:
        largest = max(abs(end) for end in variable.span)
        for share in _LIMITS:
            yield Shape(variable.name, "limited", width=share * largest)


def _bent(variable: Variable) -> Iterator[Shape]:
    """Powers, thresholds, steps and hystereses; their numbers are refined later."""
    yield Shape(variable.name, exponent=2.0, symmetry="even")
    if variable.signed:
        yield Shape(variable.name, exponent=2.0, symmetry="odd")
    else:
        yield Shape(variable.name, exponent=0.5, symmetry="even")
    low, high = variable.span
    cases = [("none", low, high)]
    if variable.signed:
        cases.append(("even", 0.0, max(abs(low), abs(high))))
    for symmetry, begin, end in cases:
        for share in _PLACES:
            at = begin + share * (end - begin)
            yield Shape(variable.name, "above", symmetry, at=at)
            yield Shape(variable.name, "below", symmetry, at=at)
        yield Shape(variable.name, "step", symmetry, at=0.5 * (begin + end))
    if not variable.signed:
        yield from _shares(variable)
    for share in _WIDTHS:
        yield Shape(variable.name, "direction", width=share * (high - low))


def _shares(variable: Variable) -> Iterator[Shape]:
    """What lies above a threshold as a share: a factor that is a threshold of what it multiplies."""
    if variable.span[0] > -0.05 * variable.span[1]:
        for share in _SHARES_FROM:
            yield Shape(variable.name, "excess_share", at=share * variable.span[1])


def _waves(variable: Variable) -> Iterator[Shape]:
    if variable.name in _WAVES_OF:
        low, high = variable.span
        for periods in range(1, _MOST_PERIODS + 1):
            yield Shape(variable.name, "sine", wave_number=2.0 * np.pi * periods / (high - low))


def first_offers(target: str, variables: Variables) -> list[Candidate]:
    """A few candidates of each variable; the phase of a speed's wave goes over all of its range."""
    shapes: list[Shape] = []
    for variable in _variables_for(target, variables):
        shapes += [*_bases(variable), *_limited(variable)]
        if target in FACTORS and variable.name == "speed":
            shapes += _waves(variable)
        if target == "brake_torque_factor" and variable.name == "brake_pressure":
            shapes += _shares(variable)
    return [Candidate((shape,)) for shape in shapes]


def further_offers(target: str, variables: Variables) -> list[Candidate]:
    """All other candidates of a target: bent functions, waves, and products of two variables."""
    usable = _variables_for(target, variables)
    singles = [Candidate((shape,)) for variable in usable for shape in (*_bent(variable), *_waves(variable))]
    products = [
        Candidate((one, other))
        for first, second in combinations(usable, 2)
        for one in _bases(first)
        for other in _bases(second)
    ]
    known = set(first_offers(target, variables))
    return [candidate for candidate in (*singles, *products) if candidate not in known]


def neighbours(candidate: Candidate, variables: Variables, reach: float) -> list[Candidate]:
    """The candidate with other numbers in its one shape, as far off as ``reach`` (1 at first, less when it zooms)."""
    if len(candidate.shapes) != 1:
        return []
    shape = candidate.shapes[0]
    variable = variables[shape.variable]
    low, high = variable.span
    if shape.function == "power" and (shape.symmetry != "none" or not variable.signed):
        symmetry = "even" if shape.symmetry == "none" else shape.symmetry
        return [
            candidate.with_shape(exponent=one, symmetry=symmetry)
            for one in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
            if reach == 1.0 and one != shape.exponent
        ]
    if shape.function in ("above", "below", "step", "excess_share"):
        if shape.symmetry != "none":
            low, high = 0.0, max(abs(low), abs(high))
        step = _PLACE_STEP * reach * (high - low)
        places = (shape.at + k * step for k in (-3, -2, -1, 1, 2, 3))
        return [candidate.with_shape(at=at) for at in places if low + 0.02 * (high - low) < at < high]
    if shape.function in ("limited", "direction"):
        return [candidate.with_shape(width=shape.width * _WIDTH_FACTOR ** (k * reach)) for k in (-3, -2, -1, 1, 2, 3)]
    if shape.function == "sine":
        once = 2.0 * np.pi / (high - low)
        numbers = (shape.wave_number + _PERIOD_STEP * reach * once * k for k in (-3, -2, -1, 1, 2, 3))
        # less than one period is no periodic term
        return [candidate.with_shape(wave_number=one) for one in numbers if one >= once]
    return []
