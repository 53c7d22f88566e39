"""How far estimates move when something is other than assumed: one table and one chart for each perturbation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.estimation.comparison import Score, quantity_labels, score_estimate
from bench.estimation.groups import Case
from bench.estimation.made_runs import make_run
from bench.estimation.offline import Request, run_offline
from bench.estimation.perturbations import WITHOUT_TRUTH, Level, Perturbation, RobustnessPlan
from bench.estimation.source import Source
from bench.recording.arrays import RunArrays
from bench.scenario.estimator_names import kind_of
from estimators import describe
from signals.catalogue import catalogue

_LOSS_SEED = 7


@dataclass(frozen=True)
class PerturbationResult:
    """Scores of every estimator at every level, by level label."""

    perturbation: Perturbation
    scores: Mapping[str, Sequence[Score]]


def try_all(
    plan: RobustnessPlan, only: Sequence[str] = (), progress: Callable[[str], None] | None = None
) -> list[PerturbationResult]:
    """Make the runs of a plan, or of the perturbations named in ``only``, and score the estimators."""
    say = progress or (lambda text: None)
    made: dict[str, Source] = {}
    results = []
    for perturbation in plan.perturbations:
        if only and perturbation.name not in only:
            continue
        scores = {}
        for level in perturbation.levels:
            say(f"{perturbation.name}: {level.label}")
            scores[level.label] = _scores(plan, level, _run(plan, level, made))
        results.append(PerturbationResult(perturbation, scores))
    return results


def _run(plan: RobustnessPlan, level: Level, made: dict[str, Source]) -> Source:
    """The level's run; levels that change nothing of it share one."""
    sets = {**plan.set, **level.set}
    key = repr((level.scenario, level.plant, sorted(sets.items(), key=lambda entry: entry[0])))
    if key not in made:
        made[key] = make_run(level.scenario or plan.scenario, sets, plant=level.plant or None)
    return made[key]


def _scores(plan: RobustnessPlan, level: Level, source: Source) -> list[Score]:
    from vehicle_model.vehicle_file import load_vehicle

    requests = [
        Request(name, kind_of(name), {**settings, **_known(kind_of(name), level.settings)})
        for name, settings in plan.variants.items()
    ]
    labels = quantity_labels([request.kind for request in requests])
    heard = replace(source, data=disturb(source.data, level.latency_ticks, level.lost_frames))
    estimates = run_offline(heard, load_vehicle(source.vehicle).numbers(), requests)
    case = Case(level.label, plan.scenario)
    also = {name for name, figure in plan.quantities.items() if figure in WITHOUT_TRUTH}
    return [score for estimate in estimates for score in score_estimate(case, source, estimate, labels, also)]


def _known(kind: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    fields = describe(kind).settings.model_fields
    return {key: value for key, value in settings.items() if key in fields}


def disturb(data: RunArrays, latency_ticks: int, lost_frames: float) -> RunArrays:
    """Signals as an estimator would see them behind a slow or lossy line; the truth is left alone.

    Parameters
    ----------
    latency_ticks : int
        Rows by which decoded signals come later. What is late from the first frame on nobody can tell: ages stay.
    lost_frames : float
        Share of the frames of each kind that does not arrive: the value before is held, its age goes on.
    """
    if latency_ticks == 0 and lost_frames == 0.0:
        return data
    columns = {name: data.array(name) for name in data.names}
    groups = _signals_by_age()
    for age, signals in groups.items():
        present = [name for name in signals if name in columns]
        if age not in columns:
            continue
        ages, rows = columns[age], np.arange(len(data))
        if lost_frames > 0.0:
            rows, ages = _lose(ages, lost_frames, sorted(groups).index(age))
        if latency_ticks:
            rows = np.concatenate((np.zeros(latency_ticks, np.int64), rows[:-latency_ticks]))
            ages = np.concatenate((np.full(latency_ticks, np.inf), ages[:-latency_ticks]))
        columns[age] = ages
        for name in present:
            columns[name] = columns[name][rows]
    return RunArrays(
        data.time, columns, data.units, phase_names=data.phase_names, timing=data.timing, information=data.information
    )


def _signals_by_age() -> dict[str, list[str]]:
    from estimators.channels import CHANNELS

    found: dict[str, list[str]] = {}
    for signal in catalogue():
        if signal.block == "bus" and signal.name in CHANNELS:
            found.setdefault(CHANNELS[signal.name].age, []).append(signal.name)
    return found


def _lose(ages: np.ndarray, share: float, stream: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows whose values are seen, and ages, with a share of the arrivals left out."""
    random = np.random.default_rng([_LOSS_SEED, stream])
    arrives = np.concatenate(([True], ages[1:] < ages[:-1] + 0.5e-3))
    kept = arrives & ~((random.random(len(ages)) < share) & np.isfinite(ages))
    last = np.maximum.accumulate(np.where(kept, np.arange(len(ages)), 0))
    return last, ages[last] + 1e-3 * (np.arange(len(ages)) - last)
