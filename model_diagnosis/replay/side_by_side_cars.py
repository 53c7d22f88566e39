"""Cars run side by side: those of a sweep over deviations, which has one for each, or those of several manoeuvres."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.compiled_replay import replay_car, replay_several
from model_diagnosis.replay.disturb_step import NOWHERE
from model_diagnosis.replay.lane_memory import LANE_AXES
from model_diagnosis.replay.prepared import Prepared
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

FEW, MANY = sorted(LANE_AXES)
"""Cars that one register of 256 or 512 bits holds a number of each of."""

_QUIET = np.zeros(0)


@dataclass(frozen=True)
class CarRun:
    """A car, and what drives it through a manoeuvre.

    Attributes
    ----------
    prepared : the manoeuvre
    cars : (1,) of ``REPLAY_RECORD``
    tables : (4 (CELLS + 1), 2) of its tyres
    inputs : (n, INPUTS), or (n, INPUTS_WITH_TERMS)
    corrected : (n, 6) what its observer corrects on
    """

    prepared: Prepared
    cars: NDArray[np.void]
    tables: FloatArray
    inputs: FloatArray
    corrected: FloatArray

    def goes_with(self, other: "CarRun") -> bool:
        """True if both may run side by side: all of a step is done for both."""
        own, others = self.prepared.phases, other.prepared.phases
        return (
            self.inputs.shape[1] == other.inputs.shape[1]
            and np.array_equal(self.prepared.chosen, other.prepared.chosen)
            and np.array_equal(own.inputs, others.inputs)
            and np.array_equal(own.corrected, others.corrected)
            and np.array_equal(own.outputs, others.outputs)
        )


def run_one(
    run: CarRun,
    gains: FloatArray,
    horizon: int,
    chosen: NDArray[np.int64],
    place: int = NOWHERE,
    disturbance: FloatArray = _QUIET,
) -> FloatArray:
    """Outputs (n, len(chosen)) of one car before the sensors; arguments as in ``run_through``."""
    prepared, phases = run.prepared, run.prepared.phases
    out = np.empty((len(run.inputs), len(chosen)))
    taken = phases.outputs if chosen is prepared.chosen else np.zeros(len(chosen))
    replay_car(
        run.cars,
        run.tables,
        run.inputs,
        prepared.between.reshape(-1, len(WHEELS)),
        run.corrected,
        prepared.valid,
        prepared.start[None],
        gains,
        prepared.least if gains.any() else np.zeros_like(prepared.least),
        horizon,
        SAMPLE_TIME_S,
        chosen,
        phases.inputs,
        phases.corrected,
        taken,
        place,
        disturbance,
        out,
    )
    return out


def together(runs: Sequence[CarRun]) -> list[list[int]]:
    """Numbers of the runs of several manoeuvres that go side by side, as many as four each."""
    alike: list[list[int]] = []
    for number, run in enumerate(runs):
        into = next((one for one in alike if runs[one[0]].goes_with(run)), None)
        if into is None:
            alike.append([number])
        else:
            into.append(number)
    return [[int(k) for k in part] for one in alike for part in np.array_split(one, -(-len(one) // FEW))]


def run_four(runs: Sequence[CarRun], gains: FloatArray) -> list[FloatArray]:
    """Outputs (n, c) of up to four cars in manoeuvres of their own under the observer, before the sensors."""
    lanes = _side_by_side(runs, gains, FEW)
    return [np.ascontiguousarray(lanes[: len(run.inputs), :, lane]) for lane, run in enumerate(runs)]


def run_eight(runs: Sequence[CarRun], gains: FloatArray) -> FloatArray:
    """Outputs (n, c, k) of up to eight cars in one manoeuvre under the observer, before the sensors."""
    return np.ascontiguousarray(_side_by_side(runs, gains, MANY)[:, :, : len(runs)])


def _side_by_side(runs: Sequence[CarRun], gains: FloatArray, count: int) -> FloatArray:
    first = runs[0].prepared
    out = np.empty((max(len(run.inputs) for run in runs), len(first.chosen), *LANE_AXES[count]))

    def shared(values: Sequence[FloatArray]) -> FloatArray:
        # as few ways as possible to compile: what is one manoeuvre's is shared by eight, what are several's by nobody
        return values[0] if count == MANY else _in_lanes(values, count)

    replay_several[count](
        _in_lanes([run.cars.view(np.float64).reshape(-1) for run in runs], count).reshape(-1, count),
        _in_lanes([run.tables for run in runs], count),
        _in_lanes([run.inputs for run in runs], count),
        shared([run.prepared.between.reshape(-1, len(WHEELS)) for run in runs]),
        _in_lanes([run.corrected for run in runs], count),
        shared([run.prepared.valid for run in runs]),
        shared([run.prepared.start[None] for run in runs]),
        gains,
        shared([run.prepared.least for run in runs]),
        0,
        SAMPLE_TIME_S,
        first.chosen,
        first.phases.inputs,
        first.phases.corrected,
        first.phases.outputs,
        NOWHERE,
        _QUIET,
        out,
    )
    return out.reshape(*out.shape[:2], count)


def _in_lanes(values: Sequence[FloatArray], count: int) -> FloatArray:
    """Arrays (n, …) of several cars as one with the axes of lanes behind its own.

    Where there are fewer the first one fills up, and shorter ones go on with their last row.
    """
    lanes = np.empty((max(len(one) for one in values), *values[0].shape[1:], count))
    for lane in range(count):
        one = values[lane if lane < len(values) else 0]
        lanes[: len(one), ..., lane] = one
        lanes[len(one) :, ..., lane] = one[-1]
    return lanes.reshape(*lanes.shape[:-1], *LANE_AXES[count])
