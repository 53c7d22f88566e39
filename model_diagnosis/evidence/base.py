"""The two fits everything rests on: "nothing is wrong" and "everything may be", and the whitening between them.

Source: model discrepancy anchor, section 3.4.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.catalogue import IMPOSTORS
from model_diagnosis.effects.form import OTHER_FORMS
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.priors import NUISANCE_FLOOR, Priors
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.whitening import Whitener, fit_whitener, sensor_whitener, temperature

FloatArray = NDArray[np.float64]
Progress = Callable[[str, float], None]

CRUDE_STEPS = 5
"""Steps of the first fit of "nothing", by the sensitivities at the vehicle file."""

FORM_STEPS, FORM_SWEEPS = 8, 8
"""Steps of the fits that two forms are compared by, and how often sensitivities are taken for them at most: as long as
both still gain and neither is surely lower, the slowest known needs six."""

FORM_GAIN = 0.1
"""Share of a crude fit's cost that steps by new sensitivities have to gain for others to be taken."""

WHITENING_ROUNDS = 2
WORTH_WHITENING = 0.02
"""Share by which sigma of the whitened rows must fall for the saturated fit's residual to be whitened by once more. On
most cars of the challenge's generator its last sensitivities gain 0 to 1.8 % (ten of them); 2.9 to 8 % (four) are the
end of a fit that had stayed in a wrong valley, and whitened by that an effect of that valley seems real."""

CONVERGING_SWEEPS = 3
CONVERGED = 1.0
"""Cost by which fresh sensitivities must lower a fit for others to be taken."""

SURELY_LOWER, CLEARLY_LOWER = 0.5, 0.97
"""Shares of a crude fit's cost below which another form's is lower whatever more steps do, and lower in the end.

In a stop with ABS the right one is a fifth to two fifths of the other at once; with calipers that lag by 60 ms it is
1.23 first and 0.36 after three more sensitivities on one car, on another 1.09, 1.01 after three, 0.66 after four. On
drives that show neither they differ by less than 0.01.
"""

LEAST_TOLD = 0.02
"""Cost per row that the lower form must save: the sensors' own noise costs 1, and on drives of the bench's plant that
show neither form the two differ by 0.001 (measured)."""

LEAST_LOWER = 10.0
"""Cost by which "nothing" must fit better in a form than in the vehicle file's own. Half of it is log evidence that an
effect can get by standing in for the right form, less than any threshold asks for. A single drive that shows the other
form gains 25; on drives of the bench's plant, which has the file's own, it is -4 to 6 (measured)."""


@dataclass(frozen=True)
class Base:
    """Where the search starts.

    Attributes
    ----------
    problem : with the whitening that stays fixed for all hypotheses
    nothing : fit of the nominal parameters within their scatter
    saturated : fit with every effect allowed
    at_nothing, at_saturated : sensitivities at the two
    """

    problem: Problem
    nothing: Fit
    saturated: Fit
    at_nothing: Linearisation
    at_saturated: Linearisation


def fit_base(replay: ReplayModel, priors: Priors, progress: Progress | None = None) -> Base:
    """Fit base and saturated model, the latter from two starts, and whiten by what the saturated one leaves.

    Five to seven sweeps of sensitivities: at neutral for each form (up to three more of each where both come near), at
    the base fit, at the saturated fit, and at the base fit again until it has converged. Where that tells no form, two
    to four more in the other one. Another where the saturated fit has left its whitening far behind.
    """
    tell = progress or (lambda _step, _share: None)
    tell("sensitivities at the vehicle file", 0.0)
    every_form = forms(replay, priors)
    crude, at_file, chord, nothing, is_told = nearer_form(replay, every_form)
    priors, neutral = crude.priors, chord.theta
    saturated, whitener = _saturated_from_two_starts(crude, chord, (nothing.theta, neutral))
    tell("sensitivities at the base fit", 0.4)
    problem = Problem(replay, priors, whitener)
    chord = problem.linearise(neutral, at_file)
    nothing = problem.fit(chord, priors.nuisance, nothing.theta)
    raw = replay.sensitivities(nothing.theta)
    chord = problem.linearise(nothing.theta, raw)
    saturated, whitener = _saturated_from_two_starts(problem, chord, (nothing.theta, saturated.theta))
    tell("sensitivities at the saturated fit", 0.7)
    base = _whitened_by(whitener, crude, nothing, saturated, raw)
    for _ in range(WHITENING_ROUNDS):
        whitener = fit_whitener(replay, replay.residuals(base.saturated.theta))
        gained = base.problem.whitener.log_sigma() - whitener.log_sigma()
        if gained < WORTH_WHITENING * sum(len(weights) for weights in base.at_nothing.weights):
            break
        base = _whitened_by(whitener, crude, base.nothing, base.saturated, raw)
    base = _heated(base)
    # wheels that follow an inferred force tell nothing of how their tyres do
    for other in every_form if not is_told and replay.forces_measured else ():
        base = _in_form(base, other)
    tell("base", 1.0)
    return base


def _whitened_by(
    whitener: Whitener, crude: Problem, nothing: Fit, saturated: Fit, at_base: Sequence[FloatArray]
) -> Base:
    """Both fits behind a whitening, from where they ended behind the one before; ``at_base`` are the base fit's slopes.

    What this whitening still finds in them is no form error.
    """
    problem = replace(crude, whitener=whitener)
    at_saturated = problem.linearise(saturated.theta)
    at_nothing = problem.linearise(nothing.theta, at_base)
    nothing = problem.fit(at_nothing, problem.priors.nuisance, nothing.theta)
    saturated = problem.fit(at_saturated, problem.priors.saturated(), saturated.theta)
    return Base(problem, nothing, saturated, at_nothing, at_saturated)


def _heated(base: Base) -> Base:
    """The base at the temperature of its residuals, "nothing" converged there.

    A form error that garbage collectors took out of the saturated residual is still there without them; one true effect
    raises the scores of few columns, and the temperature is their median.
    """
    problem, at_saturated, at_nothing = base.problem, base.at_saturated, base.at_nothing
    heat = max(_temperature(problem, at_saturated, base.saturated), _temperature(problem, at_nothing, base.nothing))
    problem = replace(problem, whitener=replace(problem.whitener, temperature=heat))
    at_saturated = _cooled(at_saturated, problem)
    nothing, at_nothing = _converged(problem, _cooled(at_nothing, problem), base.nothing)
    saturated = problem.fit(at_saturated, problem.priors.saturated(), base.saturated.theta)
    return Base(problem, nothing, saturated, at_nothing, at_saturated)


def _in_form(base: Base, priors: Priors) -> Base:
    """The base in another form where "nothing" fits better in it; else as it is.

    A form that crude fits do not tell apart can still be told by a few units of cost, as in a single manoeuvre; in the
    wrong one they are evidence for whatever effect stands in for the right one.
    """
    if np.array_equal(priors.centre, base.problem.priors.centre):
        return base
    problem = replace(base.problem, priors=priors)
    held = priors.low == priors.high
    start = np.where(held, priors.centre, base.nothing.theta)
    chord = problem.linearise(start)
    nothing, at_nothing = _converged(problem, chord, problem.fit(chord, priors.nuisance, start))
    if nothing.cost > base.nothing.cost - LEAST_LOWER:
        return base
    start = np.where(held, priors.centre, base.saturated.theta)
    at_saturated = problem.linearise(start)
    saturated = problem.fit(at_saturated, priors.saturated(), start)
    return Base(problem, nothing, saturated, at_nothing, at_saturated)


def forms(replay: ReplayModel, priors: Priors) -> list[Priors]:
    """Priors that hold one of two forms without a way between them, for each of the two."""
    found = [priors]
    for name, value in OTHER_FORMS.items():
        if name in replay.columns:
            column = replay.columns.index(name)
            found = [_held(one, column, at) for one in found for at in dict.fromkeys((one.centre[column], value))]
    return found


def _held(priors: Priors, column: int, value: float) -> Priors:
    centre, low, high, nuisance = (of.copy() for of in (priors.centre, priors.low, priors.high, priors.nuisance))
    centre[column] = low[column] = high[column] = value
    nuisance[column] = NUISANCE_FLOOR * priors.effect[column]
    return replace(priors, centre=centre, nuisance=nuisance, low=low, high=high)


def nearer_form(
    replay: ReplayModel, every_form: Sequence[Priors]
) -> tuple[Problem, list[FloatArray], Linearisation, Fit, bool]:
    """Problem with the form whose crude fit comes nearer, sensitivities at the vehicle file, and a fit of "nothing".

    The vehicle file's own form stays where no other one comes clearly nearer, as on drives that show neither. What
    shifts phases is allowed meanwhile, or whatever is late makes the wrong form look nearer; nothing else is, for a fit
    with every effect free ends in valleys that are no car's.

    Returns
    -------
    problem with the sensors' own whitening, sensitivities and linearisation at the vehicle file, fit of "nothing", and
    True where the form is beyond doubt
    """
    found, fits = [], []
    for one in every_form:
        neutral = np.clip(one.centre, one.low, one.high)
        crude = Problem(replay, one, sensor_whitener(replay))
        at_file = replay.sensitivities(neutral)
        found.append((crude, at_file, crude.linearise(neutral, at_file)))
        fits.append(_form_fit(crude, found[-1][-1]))
    for _ in range(1, FORM_SWEEPS):
        if not any(SURELY_LOWER < fit.cost / fits[0].cost < 1.0 / SURELY_LOWER for fit in fits[1:]):
            break
        before = fits
        fits = [_form_fit(crude, crude.linearise(fit.theta)) for (crude, _, _), fit in zip(found, fits, strict=True)]
        if all(fit.cost > (1.0 - FORM_GAIN) * one.cost for fit, one in zip(fits, before, strict=True)):
            break
    nearest = int(np.argmin([fit.cost for fit in fits]))
    rows = sum(len(weights) for weights in found[0][-1].weights)
    saved = fits[0].cost - fits[nearest].cost
    is_told = saved > max((1.0 - CLEARLY_LOWER) * fits[0].cost, LEAST_TOLD * rows)
    second = min((fit.cost for fit in fits[1:]), default=np.inf)
    is_own = CLEARLY_LOWER * second > fits[0].cost and second - fits[0].cost > LEAST_TOLD * rows
    crude, at_file, chord = found[nearest if is_told else 0]
    return (
        crude,
        at_file,
        chord,
        crude.fit(chord, crude.priors.nuisance, chord.theta, steps=CRUDE_STEPS, is_rough=True),
        is_told or is_own,
    )


def _form_fit(crude: Problem, chord: Linearisation) -> Fit:
    """Crude fit with the effects that shift phases allowed, from where the sensitivities were taken."""
    replay, priors = crude.replay, crude.priors
    shifting = [replay.effects[int(owner)].name in IMPOSTORS for owner in replay.owner]
    widths = np.where(shifting, priors.saturated(), priors.nuisance)
    return crude.fit(chord, widths, chord.theta, steps=FORM_STEPS, is_rough=True)


def _converged(problem: Problem, chord: Linearisation, start: Fit) -> tuple[Fit, Linearisation]:
    """Fit of "nothing" with sensitivities taken anew until they gain no more, and the last ones.

    Every effect is weighed against it: what it is short of its minimum would be evidence for the first that goes on.
    """
    fit = problem.fit(chord, start.widths, start.theta)
    for _ in range(CONVERGING_SWEEPS):
        chord = problem.linearise(fit.theta)
        better = problem.fit(chord, start.widths, fit.theta)
        gained, fit = fit.cost - better.cost, better
        if gained < CONVERGED:
            break
    return fit, chord


def _saturated_from_two_starts(
    problem: Problem, chord: Linearisation, starts: tuple[FloatArray, FloatArray]
) -> tuple[Fit, Whitener]:
    """Saturated fit and its whitening from the start that leaves the smaller sum of log sigma."""
    fits = [problem.fit(chord, problem.priors.saturated(), start) for start in starts]
    whiteners = [fit_whitener(problem.replay, problem.replay.residuals(fit.theta)) for fit in fits]
    best = int(np.argmin([whitener.log_sigma() for whitener in whiteners]))
    return fits[best], whiteners[best]


def _temperature(problem: Problem, linearisation: Linearisation, fit: Fit) -> float:
    return temperature(problem.rows(fit.theta), linearisation.matrices, problem.whitener.blocks())


def _cooled(linearisation: Linearisation, problem: Problem) -> Linearisation:
    """The linearisation, made at temperature 1, at the problem's."""
    scale = 1.0 / problem.whitener.temperature
    return replace(linearisation, informations=tuple(scale * part for part in linearisation.informations))
