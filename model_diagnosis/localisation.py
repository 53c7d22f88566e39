"""Where the model breaks: both views of the violated equations for one diagnosis, and whether a cause acts there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Effect, Group
from model_diagnosis.evidence.base import Base
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.localise import EquationErrors, violated_by_innovations, violated_equations
from model_diagnosis.evidence.priors import NUISANCE_FLOOR, Priors
from model_diagnosis.evidence.whitening import fit_whitener
from model_diagnosis.replay import Replay
from model_diagnosis.replay.disturbances import ALIKE, UNITS, disturbance_answers, possible_errors
from model_diagnosis.replay.equations import errors_of
from model_diagnosis.result import LIT_RATIO, ViolatedEquation
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

_LIT_SHARE = 0.1
"""Of the largest ratio: what a violated equation spills into others is not lit."""
_SCATTER_STD = 2.0
"""Ordinary scatter of a number, in its standard deviations, that may explain an equation's error."""
_NEAR_STD = 3.0
"""The same for the innovations, which let the scatter explain what it can: only their slopes are taken there. From one
scatter on what is not linear lit a wheel's sensor of three healthy cars in three."""
_DRAWS = 4

_FORCES = ("longitudinal force", "lateral force", "yaw moment")
_WHEELS = (*(f"wheel torque {wheel}" for wheel in WHEELS), ALIKE)
_HYDRAULICS = tuple(f"hydraulics {wheel}" for wheel in WHEELS)
_LOADS = ("load transfer",)

ACTS_ON: Mapping[Group, tuple[str, ...]] = {
    Group.TYRE: (*_FORCES, *_WHEELS, "sensor"),  # the rolling radius stands between a wheel's speed and the car's
    Group.BRAKE: _WHEELS,
    Group.HYDRAULICS: (*_WHEELS, *_HYDRAULICS),
    Group.SUSPENSION: (*_LOADS, "lateral force", "yaw moment"),
    Group.BODY: (*_FORCES, *_LOADS),
    Group.AERODYNAMICS: (*_FORCES, *_LOADS),
    Group.ROAD: (*_FORCES, *_WHEELS),
    Group.DRIVELINE: _WHEELS,
    Group.STEERING: ("lateral force", "yaw moment"),
    Group.SENSOR: ("sensor",),
    Group.CLOCK: ("sensor",),
    Group.CAN: ("sensor",),
    Group.CONTROLLER: _HYDRAULICS,
}
"""Equations in which the effects of a group stand, by the begin of their names."""


@dataclass(frozen=True)
class Localisation:
    """Likelihood ratios by equation error, and violations by innovations; the most violated equation first."""

    by_equation_error: Mapping[str, float]
    by_innovations: Mapping[str, ViolatedEquation]


def localise(replay: Replay, base: Base, theta: FloatArray, seed: int = 0) -> Localisation:
    """Violated equations at the numbers that an ordinary car has: theta (p,), the fit of "nothing", within its scatter.

    The fit of "nothing" itself has shared the guilt already, a wheel's weak brake with its neighbour's strong one; the
    vehicle file is so far off that what is not linear about it looks like violations too.
    """
    temperature, manoeuvres = base.problem.whitener.temperature, range(len(replay.manoeuvres))
    priors = base.problem.priors
    near = _within(priors, theta, _NEAR_STD)
    problem = _with_final_whitening(base)
    innovations = violated_by_innovations(
        problem, problem.linearise(near), near, partial(disturbance_answers, replay, near)
    )
    ordinary = _within(priors, theta, _SCATTER_STD)
    draws = _scattered(priors, np.random.default_rng(seed))
    errors = [_errors(replay, ordinary, base.saturated.theta, draws, m) for m in manoeuvres]
    return Localisation(
        {name: one.likelihood_ratio for name, one in violated_equations(errors, temperature).items()},
        {
            name: ViolatedEquation(likelihood_ratio=one.likelihood_ratio, error=one.std, unit=UNITS[name])
            for name, one in innovations.items()
        },
    )


def _with_final_whitening(base: Base) -> Problem:
    """The problem with the whitening of what the saturated fit leaves in the end.

    The search's is from before its last sensitivities: broader by what they gained, which keeps form errors from being
    effects there, but hides which equation is violated.
    """
    problem = base.problem
    whitener = fit_whitener(problem.replay, problem.replay.residuals(base.saturated.theta))
    return replace(problem, whitener=replace(whitener, temperature=problem.whitener.temperature))


def _within(priors: Priors, theta: FloatArray, std: float) -> FloatArray:
    """Theta with no number off by more than so many standard deviations of its scatter."""
    reach = std * priors.nuisance
    return np.asarray(priors.centre + np.clip(theta - priors.centre, -reach, reach))


def _scattered(priors: Priors, random: np.random.Generator) -> list[FloatArray]:
    """Draws of the ordinary scatter, what an ordinary car does not have left out; the first is the centre."""
    width = np.where(priors.nuisance > 2.0 * NUISANCE_FLOOR * priors.effect, priors.nuisance, 0.0)
    draws = [priors.centre + width * random.standard_normal(len(width)) for _ in range(_DRAWS)]
    return [np.clip(draw, priors.low, priors.high) for draw in (priors.centre, *draws)]


def _errors(
    replay: Replay, ordinary: FloatArray, saturated: FloatArray, draws: Sequence[FloatArray], m: int
) -> EquationErrors:
    centre, *others = (errors_of(replay, draw, m) for draw in draws)
    # a force that an accelerometer feels and one that it does not have one course
    courses = {
        name: list({of.values.tobytes(): of.values for of in possible if np.any(of.values)}.values())
        for name, possible in possible_errors(replay, ordinary, m).items()
    }
    return EquationErrors(
        nothing=errors_of(replay, ordinary, m),
        saturated=errors_of(replay, saturated, m),
        scattered=[{name: one[name] - centre[name] for name in centre} for one in others],
        courses=courses,
    )


def acts_on(effect: Effect, equation: str) -> bool:
    """True where an effect stands in an equation."""
    places = ACTS_ON[effect.group]
    if effect.name.startswith("pressure_sensor_"):
        places = (*_WHEELS, *_HYDRAULICS)
    return any(equation.startswith(place) for place in places)


def lit(violations: Mapping[str, ViolatedEquation]) -> list[str]:
    """Violated equations, less those into which a much more violated one spills."""
    highest = max((one.likelihood_ratio for one in violations.values()), default=0.0)
    least = max(LIT_RATIO, _LIT_SHARE * highest)
    return [name for name, one in violations.items() if one.likelihood_ratio >= least]


def place_remarks(causes: Sequence[Effect], violations: Mapping[str, ViolatedEquation]) -> list[str]:
    """What is to be said where a cause stands in none of the violated equations."""
    violated = lit(violations)
    if not violated:
        return []
    return [
        f"{effect.name} acts on no equation that the innovations show as violated ({', '.join(violated)}): "
        "look at the equation before you believe the cause"
        for effect in causes
        if not any(acts_on(effect, equation) for equation in violated)
    ]
