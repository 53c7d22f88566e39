"""All estimators of a group on the same runs: error, time to ±10 %, jumps and cost of a step.

Outputs of different estimators are the same quantity where the simulated car has one truth for them. Figures are taken
over the braking phase (0.4 s after the brake start until 5 m/s), or over the whole run where nobody brakes, and there
over the rows in which the estimator ran.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bench.estimation.groups import Case, Group
from bench.estimation.made_runs import make_run
from bench.estimation.offline import OfflineEstimate, Request, run_offline, with_estimates
from bench.estimation.source import Source
from bench.scenario.estimator_names import kind_of
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.metrics import settling_time, truth
from bench.verdict.truth import Truth, truth_of
from estimators import describe
from signals.catalogue import Signal

BAND = 0.1


@dataclass(frozen=True)
class Score:
    """How well an estimator told a quantity in a run.

    Attributes
    ----------
    rmse, mean_error : float
        Over the phase, in the unit of the quantity.
    relative_error : float
        Mean of the estimate over mean of the truth, less one.
    settling_s : float
        Time from the brake start, or from a jump of the truth, until the estimate stays within ±10 %; infinite: never.
    spread : float
        Largest less smallest estimate in the phase.
    mean, smallest_sure : float
        Mean of the estimate in the phase, which of a flag is its share; smallest while it is to be trusted, NaN where
        it never was.
    """

    case: str
    estimator: str
    quantity: str
    output: str
    unit: str
    rmse: float
    mean_error: float
    relative_error: float
    settling_s: float
    spread: float
    mean: float
    smallest_sure: float

    def as_json(self) -> dict[str, Any]:
        """Plain data; what is never reached is null."""
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(self).items()
        }


@dataclass(frozen=True)
class GroupComparison:
    """Scores of a group, and the processor time of a step of each estimator [us]."""

    name: str
    group: Group
    scores: Sequence[Score]
    step_time_us: Mapping[str, float]
    skipped: Mapping[str, str]

    def quantities(self) -> list[str]:
        """Quantities in the order in which they first appear."""
        return list(dict.fromkeys(score.quantity for score in self.scores))

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "group": self.name,
            "scores": [score.as_json() for score in self.scores],
            "step_time_us": dict(self.step_time_us),
            "documents": [asdict(figure) for figure in self.group.figures],
            "skipped": dict(self.skipped),
        }


def compare_group(
    name: str, group: Group, *, plant: str | None = None, progress: Callable[[str], None] | None = None
) -> GroupComparison:
    """Make the runs of a group and score its estimators on them.

    Parameters
    ----------
    plant : str, optional
        In place of the plants that the scenarios name.
    progress : callable, optional
        Receives a line per run.
    """
    say = progress or (lambda text: None)
    requests = [Request(label, kind_of(label), settings) for label, settings in group.variants.items()]
    labels = quantity_labels([request.kind for request in requests])
    scores: list[Score] = []
    times: dict[str, list[float]] = {}
    for case in group.cases:
        say(f"{case.name}: {case.scenario}")
        source = make_run(case.scenario, case.set, plant=plant)
        for estimate in _estimates(source, requests):
            times.setdefault(estimate.name, []).append(estimate.step_time_us)
            scores += score_estimate(case, source, estimate, labels)
    members = {request.kind for request in requests}
    skipped = {
        kind: "needs other runs than these stops"
        for kind, entry in ((kind, describe(kind)) for kind in _names())
        if entry.group == name and kind not in members
    }
    return GroupComparison(
        name, group, scores, {label: float(np.median(values)) for label, values in times.items()}, skipped
    )


def _names() -> tuple[str, ...]:
    from estimators import names

    return names()


def _estimates(source: Source, requests: Sequence[Request]) -> list[OfflineEstimate]:
    from vehicle_model.vehicle_file import load_vehicle

    return run_offline(source, load_vehicle(source.vehicle).numbers(), requests)


def quantity_labels(kinds: Sequence[str]) -> dict[Truth, str]:
    """Name of each quantity by its truth: that of the first estimator that tells it.

    Where another quantity already has that name, the estimator's own is added.
    """
    labels: dict[Truth, str] = {}
    for kind in kinds:
        for output in describe(kind).compared():
            expected = truth_of(f"{kind}.{output.name}")
            if expected is not None and expected not in labels:
                taken = output.name in labels.values()
                labels[expected] = f"{output.name}_{kind}" if taken else output.name
    return labels


def score_estimate(
    case: Case, source: Source, estimate: OfflineEstimate, labels: Mapping[Truth, str], also: Collection[str] = ()
) -> list[Score]:
    """Scores of every output that the source has a truth of, and of outputs in ``also`` without one: errors NaN."""
    assessment = Assessment(with_estimates(source.data, [estimate]))
    rows = _phase(assessment)
    found = []
    for signal in estimate.outputs:
        expected = truth_of(signal.name)
        name = signal.name.partition(".")[2]
        if expected is not None:
            found.append(_score(case, estimate, labels[expected], signal, assessment, rows))
        elif name in also:
            found.append(_score(case, estimate, name, signal, assessment, rows, has_truth=False))
    return found


def _phase(assessment: Assessment) -> slice:
    try:
        return assessment.window("braking")
    except NoValueError:
        return assessment.window("run")


def _score(
    case: Case, estimate: OfflineEstimate, label: str, signal: Signal, assessment: Assessment, rows: slice,
    *, has_truth: bool = True,
) -> Score:  # fmt: skip
    output = signal.name
    ran = estimate.running()[rows]
    kept = ran if ran.any() else np.ones_like(ran)
    values = assessment.signal(output)[rows][kept]
    expected = truth(assessment, output)[rows][kept] if has_truth else np.full_like(values, np.nan)
    sure = estimate.confident(output.partition(".")[2])[rows][kept]
    error = values - expected
    level = float(np.mean(expected))
    return Score(
        case.name,
        estimate.name,
        label,
        output.partition(".")[2],
        signal.unit,
        float(np.sqrt(np.mean(error**2))),
        float(np.mean(error)),
        float(np.mean(error)) / level if level else math.nan,
        _settling(assessment, output, rows) if has_truth else math.nan,
        float(np.ptp(values)),
        float(np.mean(values)),
        float(np.min(values[sure])) if sure.any() else math.nan,
    )


def _settling(assessment: Assessment, output: str, rows: slice) -> float:
    """Time to ±10 % after a jump of the truth, else after the brake start."""
    try:
        return settling_time(assessment, output, rows)
    except NoValueError:
        pass
    try:
        start = assessment.brake_row
    except NoValueError:
        start = rows.start
    values, expected = assessment.signal(output)[start : rows.stop], truth(assessment, output)[start : rows.stop]
    outside = ~(np.abs(values - expected) <= BAND * np.abs(expected))
    if not outside.any():
        return 0.0
    last = len(outside) - 1 - int(np.argmax(outside[::-1]))
    if last == len(outside) - 1:
        return math.inf
    return float(assessment.time[start + last + 1] - assessment.time[start])
