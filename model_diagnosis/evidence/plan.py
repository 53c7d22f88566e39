"""The next manoeuvre: the one that separates best what the data at hand cannot.

Source: model discrepancy anchor, section 3.7 (T-optimal design, Atkinson and Fedorov 1975). Every manoeuvre of the
library is simulated at the answer; the plan maximises the smallest expected log evidence over the pairs to be told
apart. Where none separates, the sensor is named that would.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from statistics import median_low

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.groups import SEPARATION_NEEDED, separation
from model_diagnosis.evidence.manoeuvre_library import LIBRARY, PlannedManoeuvre
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.structure import are_forced_together, separating_sensor
from model_diagnosis.evidence.whitening import Memory, SignalFilter, Whitener
from model_diagnosis.result import NextManoeuvre

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Pair:
    """Two effects to be told apart: columns of the one taken as true, its size, and columns of the other."""

    first: str
    second: str
    columns: tuple[int, ...]
    size: FloatArray
    other: tuple[int, ...]


Simulate = Callable[[PlannedManoeuvre, FloatArray], ReplayModel | None]
"""Simulates a planned manoeuvre at theta and returns a replay of it with the channels of the log at hand."""


def plan(
    problem: Problem,
    known: FloatArray,
    theta: FloatArray,
    pairs: Sequence[Pair],
    ratios: FloatArray,
    channels: Collection[str],
    simulate: Simulate,
    columns: Sequence[int],
    library: Sequence[PlannedManoeuvre] = LIBRARY,
) -> NextManoeuvre | None:
    """Manoeuvre of the library with the largest smallest separation, or the sensor to add; None without pairs.

    Parameters
    ----------
    known : (p, p) information of the data at hand
    theta : (p,) answer
    ratios : (p,) prior widths of the other deviations over their effect widths
    channels : measured at present
    columns : whose sensitivities are computed on the planned manoeuvre, the pairs' own and what looks like them
    """
    if not pairs:
        return None
    names = list(dict.fromkeys(name for pair in pairs for name in (pair.first, pair.second)))
    if any(are_forced_together(channels, pair.first, pair.second) for pair in pairs):
        return _sensor(pairs, names, channels, None)
    best: tuple[float, PlannedManoeuvre] | None = None
    for planned in library:
        made = simulate(planned, theta)
        if made is None:
            continue
        information = known + _information(problem, made, theta, columns)
        _, projected = Quadratic(information, np.zeros(len(ratios))).projected(ratios)
        expected = min(separation(projected, pair.size, pair.columns, pair.other) for pair in pairs)
        if best is None or expected > best[0]:
            best = (expected, planned)
    if best is not None and best[0] >= SEPARATION_NEEDED:
        return NextManoeuvre(
            name=best[1].name, description=best[1].description, separates=names, expected_evidence=best[0]
        )
    return _sensor(pairs, names, channels, best)


def _sensor(
    pairs: Sequence[Pair], names: list[str], channels: Collection[str], best: tuple[float, PlannedManoeuvre] | None
) -> NextManoeuvre:
    """The sensor that separates the pairs, or the plain word that nothing known does."""
    sensors = [separating_sensor(channels, pair.first, pair.second) for pair in pairs]
    wanted = next((sensor for sensor in sensors if sensor is not None), None)
    expected = 0.0 if best is None else best[0]
    reached = "" if best is None else f"; the best of the library, {best[1].name}, is expected to give {expected:.1f}"
    if wanted is None:
        text = f"no manoeuvre of the library separates these{reached}"
        return NextManoeuvre(name="none", description=text, separates=names, expected_evidence=expected)
    text = f"no manoeuvre separates these, a further sensor does: {wanted.replace('_', ' ')}{reached}"
    return NextManoeuvre(name=f"sensor:{wanted}", description=text, separates=names, expected_evidence=expected)


def _information(problem: Problem, replay: ReplayModel, theta: FloatArray, columns: Sequence[int]) -> FloatArray:
    """J'J / T (p, p) of a planned manoeuvre in some columns, whitened as the data at hand was in the same signals.

    Columns of single manoeuvres and of terms stand behind those that the planned replay has: they do not act there.
    """
    chosen = np.array([column for column in columns if column < len(replay.columns)], dtype=np.int64)
    raw = replay.sensitivities(theta, chosen.tolist())
    matrices = typical_whitener(problem.whitener, replay).sensitivities(
        [values * problem.scale[chosen] for values in raw]
    )
    information = np.zeros((len(theta), len(theta)))
    information[np.ix_(chosen, chosen)] = np.sum([matrix.T @ matrix for matrix in matrices], axis=0)
    return information / problem.whitener.temperature


def typical_whitener(known: Whitener, replay: ReplayModel) -> Whitener:
    """For each signal the filter of median sigma among the manoeuvres at hand; the sensor's own noise without one."""
    by_signal: dict[str, list[SignalFilter]] = {}
    for filters in known.filters:
        for one in filters:
            by_signal.setdefault(one.signal, []).append(one)
    made = []
    for number, weights in enumerate(replay.weights()):
        row = []
        for column, signal in enumerate(replay.signals(number)):
            samples = np.flatnonzero(weights[:, column] > 0.0)
            if len(samples) < 20:
                continue
            candidates = by_signal.get(signal)
            if candidates is None:
                row.append(SignalFilter(signal, column, samples, np.zeros(4), replay.sensor_std(signal), 1.0))
                continue
            level = median_low([one.sigma for one in candidates])
            typical = next(one for one in candidates if one.sigma == level)
            row.append(replace(typical, column=column, samples=samples))
        made.append(tuple(row))
    leak = known.memories[0].leak if known.memories else 1.0
    memories = tuple(Memory(replay.corrections(number), leak) for number in range(len(made)))
    return Whitener(tuple(made), known.temperature, memories)
