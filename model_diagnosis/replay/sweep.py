"""Sensitivities of one manoeuvre: finite differences by cars that run side by side, or without a run at all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.sensor_chain import measured_signals, sensor_columns
from model_diagnosis.replay.deviations import RECORD_COLUMNS
from model_diagnosis.replay.hydraulic import acts_by_valves
from model_diagnosis.replay.parts import Parts
from model_diagnosis.replay.side_by_side_cars import MANY, CarRun, run_eight

if TYPE_CHECKING:
    from model_diagnosis.replay.replay import Replay

FloatArray = NDArray[np.float64]

_OF_THE_CAR_ONLY = RECORD_COLUMNS | {"tyre_peak_shape.sliding_loss"}
"""Columns that change numbers or tables of the car, and neither pressures nor sensors."""

_OBSERVED_SENSORS = ("gyro_offset", "gyro_scale", "tone_ring_error")
"""Effects of sensors that the observer corrects on, so that their columns need a replay."""


@dataclass(frozen=True)
class _Step:
    """Step of a finite difference: place and name of its column, its size, and the deviations with it."""

    place: int
    name: str
    size: float
    deviations: Mapping[str, float]


def sweep(replay: "Replay", theta: FloatArray, m: int, columns: Sequence[int]) -> FloatArray:
    """Derivatives (n, c, len(columns)) of the prediction of manoeuvre ``m`` at theta.

    A column that does what others do together has the sum of theirs: near the limit a run is rough, and differences of
    their own would seem to tell it from those.
    """
    summed = {column: replay.sum_of(column, theta, m) for column in columns}
    asked = list(dict.fromkeys(part for parts in summed.values() for part in parts))
    found = _Sweep(replay, theta, m, asked).run()
    if asked == list(columns):
        return found
    place = {part: index for index, part in enumerate(asked)}
    return np.stack(
        [
            np.sum([share * found[:, :, place[part]] for part, share in summed[column].items()], axis=0)
            for column in columns
        ],
        axis=2,
    )


class _Sweep:
    def __init__(self, replay: "Replay", theta: FloatArray, m: int, columns: Sequence[int]) -> None:
        self.replay, self.prepared = replay, replay.prepared[m]
        self.deviations = replay.deviations_at(theta, m)
        self.base = replay.parts_of(self.deviations, self.prepared, replay.gains)
        self.reported = replay.reported(self.deviations, self.prepared, self.base)
        self.steps = self._steps(theta, m, columns)
        self.result = np.zeros((*self.reported.shape, len(columns)))

    def run(self) -> FloatArray:
        """Each column in the cheapest way that there is for it."""
        prepared, count = self.prepared, len(self.prepared.chosen)
        signals = prepared.signals[:count]
        analytic = sensor_columns(self.deviations, signals, self.base.car, prepared.carriers)
        terms = {f"{term.name}.{part}" for term in self.replay.terms for part in term.parts}
        of_car, of_run, others = [], [], []
        for step in self.steps:
            drives = prepared.drives(step.name)
            if step.name in analytic and not drives and not step.name.startswith(_OBSERVED_SENSORS):
                self.result[:, :count, step.place] = analytic[step.name]
            elif step.name in _OF_THE_CAR_ONLY and not drives:
                of_car.append(step)
            elif step.name in terms or self.replay.car_key(step.deviations, prepared) == self.base.car_key:
                others.append(step)
            else:
                of_run.append(step)
        if of_car or of_run:
            self._by_eights(of_car, of_run)
        list(self.replay.mapped(self._alone, others))
        return self.result

    def _steps(self, theta: FloatArray, m: int, columns: Sequence[int]) -> list[_Step]:
        """Steps by those of the columns that act in the manoeuvre."""
        hydraulics, steps = self.prepared.hydraulics, []
        at_rest = hydraulics is not None and not hydraulics.switched
        for place, column in enumerate(columns):
            name = self.replay.acts_as(column, m)
            if name is not None and not (at_rest and acts_by_valves(name)):
                size = self.replay.step_of(theta, column)
                changed = {**self.deviations, name: self.deviations.get(name, 0.0) + size}
                steps.append(_Step(place, name, size, changed))
        return steps

    def _by_eights(self, of_car: Sequence[_Step], of_run: Sequence[_Step]) -> None:
        """Columns that change the car alone, and those that change what drives it or what its observer sees."""
        replay, prepared = self.replay, self.prepared
        usual = replay.run_of(self.deviations, prepared, self.base.pressures)

        def begun(step: _Step) -> tuple[Parts, CarRun]:
            key, pressures = replay.pressures_by(step.deviations, prepared, False, (self.base,))
            parts = replace(self.base, pressure_key=key, pressures=pressures)
            return parts, replay.run_of(step.deviations, prepared, pressures)

        made = list(replay.mapped(begun, of_run))
        # with the car as it is among the eights a column that does nothing is exactly 0
        runs = [usual, *(replay.with_car(usual, step.deviations) for step in of_car), *(run for _, run in made)]
        eights = [runs[k : k + MANY] for k in range(0, len(runs), MANY)]
        cars = np.concatenate(list(replay.mapped(lambda eight: run_eight(eight, replay.gains), eights)), axis=2)
        if of_car:
            self._take_cars(of_car, cars[:, :, : 1 + len(of_car)])
        if of_run:
            reported = replay.reported(self.deviations, prepared, replace(self.base, car=cars[:, :, 0]))
        for lane, (step, (parts, _)) in enumerate(zip(of_run, made, strict=True), 1 + len(of_car)):
            moved = replay.reported(step.deviations, prepared, replace(parts, car=cars[:, :, lane]))
            self.result[:, :, step.place] = (moved - reported) / step.size

    def _take_cars(self, steps: Sequence[_Step], cars: FloatArray) -> None:
        """Columns from the outputs (n, c, 1 + k) of the usual car and of k others with the same sensors."""
        count = cars.shape[1]
        signals = measured_signals(self.deviations, self.prepared.signals[:count], cars, self.prepared.carriers)
        change = signals[:, :, 1:] - signals[:, :, :1]
        self.result[:, :count, [step.place for step in steps]] = change / [step.size for step in steps]

    def _alone(self, step: _Step) -> None:
        """A column of the hydraulic unit, whose car is the usual one, or of a term, whose inputs are wider."""
        parts = self.replay.parts_of(step.deviations, self.prepared, self.replay.gains, known=(self.base,))
        moved = self.replay.reported(step.deviations, self.prepared, parts)
        self.result[:, :, step.place] = (moved - self.reported) / step.size
