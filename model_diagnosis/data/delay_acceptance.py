"""A small delay is accepted only where the innovations of a refitted replay shrink by it.

Low friction, a long relaxation length or brake drag shift phases too (by up to 30 ms); refitting the replay to the data
before and after the shift tells them apart: what physics can explain, the refit explains without a shift.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_diagnosis.data.delay_checks import PLAIN_GAIN, Late, shifted
from model_diagnosis.data.innovations import total_log_innovation
from model_diagnosis.data.replayed import FloatArray, ReplayFactory, ReplayModel
from model_diagnosis.effects.catalogue import IMPOSTORS
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from vehicle_model.vehicle_file import VehicleFile

_BEND_PHASES = (*IMPOSTORS, "pressure_sensor_lag")
"""Effects of the refit; the last passes for late pressures, as a caliper's lag does for early ones."""
_MARGIN = 200.0
_MARGIN_SAMPLES = 43_200
_FARTHEST = 2
_AGREEMENT_S = 0.006
"""Difference between what innovations and correlation say above which neither is believed: physics bends phases more
than it shifts them. Correlation that is less sure than that, over gaps, is given two of its standard deviations."""
_AGREEMENT_SHARE = 0.2
"""The same as a share of the delay: no physics shifts phases by 30 ms and more, and the two ways weigh frequencies
differently."""
_KINEMATIC, _SLOPE = frozenset({"speed"}), "longitudinal_acceleration"
"""Group whose lag correlation tells for itself, and the channel that is its slope with no tyre or brake between them.
Innovations put 35 ms at 18 and 62 at 51 (tuning seed 64) where numbers that were refitted to the late data have taken
a part of the delay upon them, more than one step takes back. Refitted afresh at the correlation's delay they decide, by
as little as a step of the refit has to gain: the margin is there for what physics can do to phases."""
_MOST_STEPS = 10
"""Of the refit before the shifts; with a friction that is off by a third it takes eight."""
_CONVERGED_SHARE = 0.1
"""Share of a delay's margin that a further step of the refit has to gain."""
_UNSURE_S = 0.01
"""Standard deviation of what correlation says from which an accepted delay is settled once more at where it then is."""
_AGREEMENT_STDS = 2.5
"""By how many standard deviations of their difference correlation and innovations may disagree on a large delay."""
_INNOVATION_STD_S = 0.005
"""Standard deviation of the delay that innovations tell: half a sample, since only whole samples are tried."""


def accepted_delays(
    delays: Sequence[Late], manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory
) -> tuple[list[Late], list[Manoeuvre]]:
    """Delays whose whole-sample shift shrinks Σ N log σ of the innovations enough, and the manoeuvres so shifted.

    The margin is 200 for six manoeuvres of nine seconds with eight signals, in proportion to the samples.
    """
    accepted: list[Late] = []
    current = list(manoeuvres)
    last: Step | None = None
    waiting = sorted(delays, key=lambda one: -one.gain)
    while waiting:
        refused = []
        for late in waiting:
            if last is None:  # what is not shifted yet, the numbers take a part of upon them
                model = replay(vehicle, current)
                margin = _margin(model)
                last, _, score = _refitted_phases(model)
            trials = _Trials(late, current, {0: score}, vehicle, replay, last)
            told = _by_chords(trials, score - margin) or _afresh(trials, score - _CONVERGED_SHARE * margin)
            if told is None:
                refused.append(late)
                continue
            named, current = told
            if late.std_s > _UNSURE_S:
                named, current = _settled(replace(named, std_s=late.std_s), current, vehicle, replay)
            accepted.append(named)
            last = None
        if len(refused) == len(waiting):
            break
        waiting = refused  # beside another late set, innovations draw a delay towards it
    return accepted, current


def fitted_car(vehicle: VehicleFile, manoeuvres: Sequence[Manoeuvre], replay: ReplayFactory) -> FloatArray:
    """Deviations (p,) of the car that fits the manoeuvres best, by the effects that shift phases."""
    return _refitted_phases(replay(vehicle, manoeuvres))[1]


def settled_delays(
    large: Sequence[Late], manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory
) -> tuple[list[Late], list[Manoeuvre]]:
    """Late sets that were shifted already, with what the innovations of a refitted replay say beside correlation.

    Correlation tells 6 to 10 ms (clocks of 0.2 s and more came out 7 to 9 ms late in a look at seed 1000004), and
    30 ms where a speed without its slope is compared with the wheels' slip. What else is late has to be
    shifted before. Where both disagree, something else is wrong, which innovations would make up for.
    """
    settled, current = [], list(manoeuvres)
    for late in large:
        told, current = _settled(late, current, vehicle, replay)
        settled.append(told)
    return settled, current


def _settled(
    late: Late, manoeuvres: list[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory
) -> tuple[Late, list[Manoeuvre]]:
    """A late set by both values, weighted, and manoeuvres so shifted; both as they were where the values disagree."""
    last, _, score = _refitted_phases(replay(vehicle, manoeuvres))
    trials = _Trials(late, manoeuvres, {0: score}, vehicle, replay, last)
    allowed_s = _AGREEMENT_STDS * float(np.hypot(late.std_s, _INNOVATION_STD_S))
    rest_s = SAMPLE_TIME_S * _vertex(trials.score, _best_shift(trials.score, 0, round(allowed_s / SAMPLE_TIME_S)))
    shifted_s = SAMPLE_TIME_S * round(late.delay_s / SAMPLE_TIME_S)
    if abs(shifted_s + rest_s - late.delay_s) > allowed_s:
        return late, manoeuvres
    told = _combined(late, shifted_s + rest_s)
    return told, trials.manoeuvres(round((told.delay_s - shifted_s) / SAMPLE_TIME_S))


def _refitted_phases(model: ReplayModel) -> tuple["Step", FloatArray, float]:
    """Refit of the effects that bend phases: its last step, deviations (p,) and Σ N log σ after it."""
    chosen = [k for k, column in enumerate(model.columns) if column.partition(".")[0] in _BEND_PHASES]
    return refitted(model, chosen, _CONVERGED_SHARE * _margin(model))


def _margin(model: ReplayModel) -> float:
    samples = int(sum(np.sum(weight > 0.0) for weight in model.weights()))
    return _MARGIN * min(1.0, samples / _MARGIN_SAMPLES)


_Told = tuple[Late, list[Manoeuvre]]
"""An accepted late set and the manoeuvres shifted by it."""


def _by_chords(trials: "_Trials", needed: float) -> _Told | None:
    """The late set as correlation and innovations tell it; None where they disagree or leave ``needed`` and more."""
    late = trials.late
    farthest = max(_FARTHEST, round(2.0 * late.std_s / SAMPLE_TIME_S))
    best = _best_shift(trials.score, round(late.delay_s / SAMPLE_TIME_S), farthest)
    delay_s = SAMPLE_TIME_S * _vertex(trials.score, best)
    allowed_s = max(_AGREEMENT_S, 2.0 * late.std_s, _AGREEMENT_SHARE * abs(late.delay_s))
    if abs(delay_s - late.delay_s) >= allowed_s or trials.score(best) >= needed:
        return None
    told = _combined(late, delay_s)
    return told, trials.manoeuvres(round(told.delay_s / SAMPLE_TIME_S))


def _afresh(trials: "_Trials", needed: float) -> _Told | None:
    """A late set that correlation is sure of without a model, where a refit from the vehicle file on leaves less than
    ``needed``."""
    late = trials.late
    has_slope = all(_SLOPE in one.channels for one in trials.base)
    if late.groups != _KINEMATIC or late.gain <= PLAIN_GAIN or not has_slope:
        return None
    moved = trials.manoeuvres(round(late.delay_s / SAMPLE_TIME_S))
    _, _, score = _refitted_phases(trials.replay(trials.vehicle, moved))
    return (late, moved) if score < needed else None


def _combined(late: Late, delay_s: float) -> Late:
    """The late set with the mean of what correlation and innovations say, weighted by their variances."""
    weights = late.std_s**-2.0, _INNOVATION_STD_S**-2.0
    mean = (weights[0] * late.delay_s + weights[1] * delay_s) / sum(weights)
    return replace(late, delay_s=mean, std_s=sum(weights) ** -0.5)


@dataclass(frozen=True)
class _Trials:
    """Manoeuvres with the channels of a late set shifted by whole samples, and the scores of those tried."""

    late: Late
    base: Sequence[Manoeuvre]
    tried: dict[int, float]
    vehicle: VehicleFile
    replay: ReplayFactory
    last: "Step"

    def manoeuvres(self, shift: int) -> list[Manoeuvre]:
        return [shifted(m, self.late.channels, shift * SAMPLE_TIME_S) for m in self.base]

    def score(self, shift: int) -> float:
        if shift not in self.tried:
            model = self.replay(self.vehicle, self.manoeuvres(shift))
            self.tried[shift] = innovations_after(model, self.last)[1]
        return self.tried[shift]


def _best_shift(score_of: Callable[[int], float], start: int, farthest: int) -> int:
    """Whole samples of the smallest score, downhill from a first guess."""
    best = start
    for _ in range(farthest):
        lower = min((best - 1, best, best + 1), key=score_of)
        if lower == best:
            break
        best = lower
    return best


def _vertex(score_of: Callable[[int], float], best: int) -> float:
    """Place of the least score between samples, by the parabola through three."""
    before, least, after = (score_of(best + step) for step in (-1, 0, 1))
    bend = before - 2.0 * least + after
    return best + (0.5 * (before - after) / bend if bend > 0.0 else 0.0)


@dataclass(frozen=True)
class Step:
    """A damped Gauss-Newton step of some columns: where it begins and what they change there.

    Attributes
    ----------
    theta : (p,) deviations of all columns
    slopes : (n, c, len(chosen)) sensitivities of the chosen columns, by manoeuvre
    """

    theta: FloatArray
    slopes: Sequence[FloatArray]
    chosen: Sequence[int]


def refitted(model: ReplayModel, chosen: Sequence[int], worth_a_step: float) -> tuple[Step, FloatArray, float]:
    """The last step of a refit of the chosen columns, deviations (p,) and Σ N log σ after it.

    Steps go on while they gain as much as one is worth.

    A friction that is off by a third bends the phases of a stop in ways that one step from the vehicle file leaves.
    """
    theta = np.zeros(len(model.columns))
    score = total_log_innovation(model.residuals(theta), model.weights())
    for _ in range(_MOST_STEPS):
        step = Step(theta, model.sensitivities(theta, chosen), chosen)
        theta, better = innovations_after(model, step)
        gained, score = score - better, better
        if gained < worth_a_step:
            break
    return step, theta, score


def innovations_after(model: ReplayModel, step: Step) -> tuple[FloatArray, float]:
    """Deviations (p,) after a step, none where it would not gain, and Σ N log σ of the innovations there.

    The step's slopes may come from slightly shifted data: a chord step.
    """
    chosen, weights = list(step.chosen), model.weights()
    residuals = model.residuals(step.theta)
    stds = [_spread(r, w) for r, w in zip(residuals, weights, strict=True)]
    best, taken = total_log_innovation(residuals, weights), step.theta
    widths = np.array([max(model.parameters[k].nuisance_std, model.parameters[k].effect_std) for k in chosen])
    precision = widths**-2.0
    normal, gradient = np.diag(precision), -precision * step.theta[chosen]
    for residual, weight, slope, std in zip(residuals, weights, step.slopes, stds, strict=True):
        scaled = (slope * (weight / std)[:, :, None]).reshape(-1, len(chosen))
        normal = normal + scaled.T @ scaled
        gradient = gradient + scaled.T @ (residual * weight / std).ravel()
    change = np.linalg.solve(normal, gradient)
    for share in (1.0, 0.5):
        theta = step.theta.copy()
        theta[chosen] = np.clip(
            theta[chosen] + share * change,
            [model.parameters[k].low for k in chosen],
            [model.parameters[k].high for k in chosen],
        )
        score = total_log_innovation(model.residuals(theta), weights)
        if score < best:
            best, taken = score, theta
    return taken, best


def _spread(residual: FloatArray, weight: FloatArray) -> FloatArray:
    """Root mean square of each signal (c,), never zero."""
    counts = np.maximum(weight.sum(axis=0), 1.0)
    rms: FloatArray = np.sqrt((weight * residual**2).sum(axis=0) / counts)
    return np.maximum(rms, 1e-9)
