"""Replay of manoeuvres: what the vehicle file predicts, with any deviations of the catalogue's effects.

replay = Replay(load_vehicle("asphalt_car"), manoeuvres)
theta = np.zeros(len(replay.columns))
replay.residuals(theta)[0]        # (n, c) measured minus predicted of the first manoeuvre
"""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.conditions import everywhere
from model_diagnosis.effects.effect import Application, Effect
from model_diagnosis.effects.form import REPLAYED
from model_diagnosis.effects.sensor_chain import measured_signals, true_inputs
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.base import STEP_SHARE, ReplayBase
from model_diagnosis.replay.columns import Columns
from model_diagnosis.replay.hydraulic import (
    HYDRAULIC_COLUMNS,
    acts_on_pressures,
    reported_pressure,
    without_steps,
)
from model_diagnosis.replay.inputs import read_inputs, with_pressures
from model_diagnosis.replay.nominal import nominal_car
from model_diagnosis.replay.parameters import values_of
from model_diagnosis.replay.parts import Key, Parts, selected, without
from model_diagnosis.replay.prepared import PRESSURES, Prepared, prepare
from model_diagnosis.replay.record import INPUT_PRESSURE, OUTPUTS, SHOWN_STATES
from model_diagnosis.replay.sensors import own_noise
from model_diagnosis.replay.side_by_side_cars import CarRun, run_four, run_one, together
from model_diagnosis.replay.state import SUBSTEPS
from model_diagnosis.replay.sums import BrakeGains, sums_of
from model_diagnosis.replay.sweep import sweep
from model_diagnosis.replay.terms import TermCourse, with_terms
from model_diagnosis.replay.wheel_pressures import WheelPressures
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

_GAINS = (0.3, 0.05, 0.1, 0.05)
"""Gains of the observer per 10 ms: wheel speeds, speed, yaw rate, and speed by the wheels where it is not measured."""

_DEAD_BAND = 2.0
"""Standard deviations of a wheel speed's own noise that correct nothing; what is beyond has 1 % of its variance.

A wheel that is corrected by noise forgets it the sooner, the lighter it is and the closer it is coupled to the other
one: the prediction would gain by a wrong inertia, a wrong differential, a wrong lag.
"""

_FREE = np.zeros(len(_GAINS) + 1)

_PARTS_KEPT = 6

_COARSE_STEP_SHARE = 0.05
"""Step of a finite difference over the effect's width for what acts by jumps: a hydraulic unit that moves by steps,
roads that change at once."""

_ACT_BY_JUMPS = ("mu_step.place",)

_REPLAYED = (Application.PLANT, Application.INPUT, Application.SENSOR)


class Replay(ReplayBase):
    """The vehicle driven by the measured inputs of each manoeuvre.

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; its ``scatter`` section replaces the catalogue's nuisance widths.
    manoeuvres : sequence of Manoeuvre
        With wheel speeds or a speed; which other channels are there decides what is compared and what is excited.
    effects : sequence of Effect
        Those that the replay carries as columns; effects of clock, CAN and controller are left out.
    threads : int, optional
        For sweeps; the machine's processors if left out.
    conditions : bool
        True where road and wind of each manoeuvre are columns too, behind all others. Without them what another
        replay's theta has behind the catalogue's columns is passed over.

    Attributes
    ----------
    pressures : the vehicle's hydraulic unit, without deviations
    gains : (5,) of the observer, and the dead band of the wheel speeds [rad/s]

    Raises
    ------
    InputError
        If a manoeuvre has neither wheel speeds nor a speed.
    """

    def __init__(
        self,
        vehicle: VehicleFile,
        manoeuvres: Sequence[Manoeuvre],
        effects: Sequence[Effect] = REPLAYED,
        *,
        threads: int | None = None,
        conditions: bool = False,
    ) -> None:
        carried = tuple(effect for effect in effects if effect.application in _REPLAYED)
        columns = Columns.of(carried, values_of(vehicle), vehicle.scatter, len(manoeuvres) if conditions else 0)
        super().__init__(vehicle, manoeuvres, columns, nominal_car(vehicle), threads)
        self._of_pressures = frozenset(filter(acts_on_pressures, columns.names))
        self._sums = sums_of(columns.names, self.car.record[0])
        self._brake_gains = BrakeGains(columns.names, self.car.record[0])
        self.pressures = WheelPressures(vehicle)
        self.gains = np.array([*_GAINS, _DEAD_BAND * own_noise(vehicle, "wheel_speed_fl")])
        nominal = self._record_at({})[0]
        self.prepared: Sequence[Prepared] = self.pressures.settled(
            [prepare(one, vehicle, nominal, m) for m, one in enumerate(self.manoeuvres)]
        )
        if self.pressures.unit.flows:
            self.parameters = without_steps(self.parameters, self.columns)
        # fits change what acts on the pressures and what does not in turn
        self._known = [deque[Parts](maxlen=_PARTS_KEPT) for _ in self.prepared]
        self._inputs = [deque[tuple[Key, FloatArray]](maxlen=_PARTS_KEPT) for _ in self.prepared]

    @property
    def forces_measured(self) -> bool:
        """True where what drives and brakes the wheels was measured in every manoeuvre."""
        return all(prepared.inputs.forces_measured for prepared in self.prepared)

    @property
    def torque_measured(self) -> bool:
        """True where a torque of brakes or drive was measured at any time."""
        return not all(prepared.inputs.inferred.all() for prepared in self.prepared)

    def with_terms(self, terms: Sequence[TermCourse]) -> "Replay":
        """The same with columns of these terms behind all others."""
        other = copy(self)
        other._set_columns(self._columns.with_terms(terms))
        other._known = [deque[Parts](maxlen=_PARTS_KEPT) for _ in self.prepared]
        return other

    def predict(self, theta: FloatArray, m: int) -> FloatArray:
        """Observer replay (n, c): each sample predicted from those before it, with the same gains for every theta."""
        prepared, deviations, known = self.prepared[m], self.deviations_at(theta, m), self._known[m]
        parts = self.parts_of(deviations, prepared, self.gains, known=tuple(known))
        known.append(parts)
        return self.reported(deviations, prepared, parts)

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        """Measured minus predicted (n, c) of each manoeuvre, 0 where the weight is 0; all manoeuvres side by side."""
        asked = [(self.deviations_at(theta, m), prepared) for m, prepared in enumerate(self.prepared)]

        def begun(m: int) -> tuple[Key, FloatArray | CarRun, Key, FloatArray | None]:
            (deviations, prepared), known = asked[m], tuple(self._known[m])
            car_key = self.car_key(deviations, prepared)
            key, pressures = self.pressures_by(deviations, prepared, False, known)
            same = next((one.car for one in known if one.car_key == car_key), None)
            return car_key, self.run_of(deviations, prepared, pressures) if same is None else same, key, pressures

        made = list(self.mapped(begun, range(len(asked))))
        runs = {m: car for m, (_, car, _, _) in enumerate(made) if isinstance(car, CarRun)}
        cars = {m: car for m, (_, car, _, _) in enumerate(made) if not isinstance(car, CarRun)}
        groups = [[list(runs)[k] for k in one] for one in together(list(runs.values()))]
        outputs = self.mapped(lambda group: run_four([runs[m] for m in group], self.gains), groups)
        for group, found in zip(groups, outputs, strict=True):
            cars |= zip(group, found, strict=True)

        def of(m: int) -> FloatArray:
            (deviations, prepared), (car_key, _, pressure_key, pressures) = asked[m], made[m]
            parts = Parts(car_key, cars[m], pressure_key, pressures)
            self._known[m].append(parts)
            return self.residual(m, self.reported(deviations, prepared, parts))

        return list(self.mapped(of, range(len(asked))))

    def free_run(self, theta: FloatArray, m: int, horizon_s: float | None = None) -> FloatArray:
        """Free run (n, c); with ``horizon_s`` it restarts so often at the measured wheel speeds, speed and yaw rate."""
        horizon = 0 if horizon_s is None else max(round(horizon_s / SAMPLE_TIME_S), 1)
        prepared, deviations = self.prepared[m], self.deviations_at(theta, m)
        return self.reported(deviations, prepared, self.parts_of(deviations, prepared, _FREE, horizon))

    def states(self, theta: FloatArray, m: int) -> dict[str, FloatArray]:
        """States of the observer replay over which residuals are looked at, name -> (n,): speed, slips, loads, …"""
        prepared = self.prepared[m]
        chosen = np.array([OUTPUTS.index(name) for name in SHOWN_STATES])
        deviations = self.deviations_at(theta, m)
        pressures = self.pressures.at(deviations, prepared)
        values = self.car_outputs(deviations, prepared, pressures, self.gains, 0, chosen)
        return {name: values[:, k] for k, name in enumerate(SHOWN_STATES)}

    def driving_pressures(self, theta: FloatArray, m: int) -> tuple[FloatArray, FloatArray]:
        """Wheel pressures [Pa] that drive the car, less their sensors' noise.

        (n, 4) at the samples, and (n, SUBSTEPS, 4) in the middle of the car's steps before each of them. Measured ones
        are taken as read: freed of a lag of their sensors they would slope where valves hold them.
        """
        prepared = self.prepared[m]
        inputs = prepared.inputs.values
        if not prepared.pressure_known:
            deviations = self.deviations_at(theta, m)
            inputs = self.inputs_at(deviations, prepared, self.pressures.at(deviations, prepared))
        pressures = inputs[:, INPUT_PRESSURE : INPUT_PRESSURE + len(WHEELS)]
        before = np.concatenate([pressures[:1], pressures[:-1]])[:, None]
        share = ((np.arange(SUBSTEPS) + 0.5) / SUBSTEPS)[:, None]
        line = before + share * (pressures[:, None] - before)
        return pressures, np.maximum(line + prepared.between, 0.0)

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        """Derivatives of the prediction by the deviations, (n, c, len(columns)) of each manoeuvre.

        Finite differences of one side, towards the inside of the bounds; columns of accelerometers are analytic where
        they drive nothing.
        """
        chosen = list(range(len(self.columns))) if columns is None else [int(column) for column in columns]
        at = np.asarray(theta, dtype=np.float64)
        return [sweep(self, at, m, chosen) for m in range(len(self.prepared))]

    def corrections(self, m: int) -> FloatArray:
        """(c, 1) change of the observer's speed by one unit of each compared signal's residual."""
        signals, wheels = self.prepared[m].signals, self.vehicle.wheels
        moved = np.zeros((len(signals), 1))
        by_wheels = {f"wheel_speed_{wheel}": _GAINS[3] * getattr(wheels, wheel).radius / 4.0 for wheel in WHEELS}
        gains = {"speed": _GAINS[1]} if "speed" in signals else by_wheels
        for name, gain in gains.items():
            if name in signals:
                moved[signals.index(name), 0] = gain
        return moved

    def inputs_at(
        self, deviations: Mapping[str, float], prepared: Prepared, pressures: FloatArray | None
    ) -> FloatArray:
        """Inputs of the car: as measured, freed of their sensors' effects, or the pressures of the hydraulic unit."""
        if pressures is not None and not prepared.pressure_known:
            return self._inputs_by(deviations, prepared, dict(zip(PRESSURES, pressures.T, strict=True)))
        key = selected(deviations, prepared.driving_columns)
        if not key:
            return prepared.inputs.values
        known = self._inputs[prepared.number]
        values = next((values for made_with, values in tuple(known) if made_with == key), None)
        if values is None:
            values = self._inputs_by(deviations, prepared, {})
            known.append((key, values))
        return values

    def _inputs_by(
        self, deviations: Mapping[str, float], prepared: Prepared, by_unit: Mapping[str, FloatArray]
    ) -> FloatArray:
        manoeuvre = prepared.manoeuvre
        channels = {**true_inputs(deviations, manoeuvre.time, prepared.driving, prepared.leads), **by_unit}
        if prepared.inputs.forces_measured:
            return with_pressures(prepared.inputs, channels)
        return read_inputs(manoeuvre, channels, self.vehicle, self._record_at(deviations)[0]).values

    def car_outputs(
        self,
        deviations: Mapping[str, float],
        prepared: Prepared,
        pressures: FloatArray | None,
        gains: FloatArray,
        horizon: int,
        chosen: NDArray[np.int64],
    ) -> FloatArray:
        """Outputs of the car before the sensors, (n, len(chosen))."""
        return run_one(self.run_of(deviations, prepared, pressures), gains, horizon, chosen)

    def run_of(self, deviations: Mapping[str, float], prepared: Prepared, pressures: FloatArray | None) -> CarRun:
        """Car and what drives it."""
        inputs = self.inputs_at(deviations, prepared, pressures)
        return CarRun(
            prepared,
            self._record_at(deviations),
            self.tables_at(deviations),
            with_terms(inputs, self._columns.terms, deviations, prepared.number),
            prepared.corrected_at(deviations),
        )

    def with_car(self, run: CarRun, deviations: Mapping[str, float]) -> CarRun:
        """The same with another car, whose deviations change nothing else."""
        return replace(run, cars=self._record_at(deviations), tables=self.tables_at(deviations))

    def acts_as(self, column: int, m: int) -> str | None:
        """Column of the catalogue or a term that a column acts as in a manoeuvre; None where it does not act there."""
        return self._columns.acts_as(column, m)

    def sum_of(self, column: int, theta: FloatArray, m: int) -> Mapping[int, float]:
        """Columns that together do at theta what a column does in a manoeuvre, and how much of each.

        Itself, those of the axles or those of each wheel's brake, where these drive nothing.
        """
        if column in self._brake_gains.columns and not self.prepared[m].drives(self.columns[column]):
            return self._brake_gains.shares(column, theta)
        return self._sums.get(column, {column: 1.0})

    @property
    def terms(self) -> Sequence[TermCourse]:
        """Terms that are columns, too."""
        return self._columns.terms

    def car_key(self, deviations: Mapping[str, float], prepared: Prepared) -> Key:
        """Deviations that a car's outputs hang on."""
        by_pressure = not prepared.pressure_known and prepared.hydraulics is not None
        return without(deviations, () if by_pressure else HYDRAULIC_COLUMNS)

    def pressures_by(
        self, deviations: Mapping[str, float], prepared: Prepared, is_free: bool, known: Iterable[Parts]
    ) -> tuple[Key, FloatArray | None]:
        """Pressures (n, 4) by the hydraulic unit and the deviations they hang on; None where the log tells nothing."""
        key = selected(deviations, self._of_pressures)
        same = next((one for one in known if one.pressure_key == key), None)
        return key, same.pressures if same else self.pressures.at(deviations, prepared, free=is_free)

    def parts_of(
        self,
        deviations: Mapping[str, float],
        prepared: Prepared,
        gains: FloatArray,
        horizon: int = 0,
        known: Iterable[Parts] = (),
    ) -> Parts:
        """Both parts of a prediction; those that the deviations leave as in a ``known`` one are taken from it."""
        pressure_key, pressures = self.pressures_by(deviations, prepared, not gains.any(), known)
        car_key = self.car_key(deviations, prepared)
        same = next((one for one in known if one.car_key == car_key), None)
        car = same.car if same else self.car_outputs(deviations, prepared, pressures, gains, horizon, prepared.chosen)
        return Parts(car_key, car, pressure_key, pressures)

    def reported(self, deviations: Mapping[str, float], prepared: Prepared, parts: Parts) -> FloatArray:
        """What the sensors report (n, c)."""
        count = len(prepared.chosen)
        moving = measured_signals(deviations, prepared.signals[:count], parts.car, prepared.carriers)
        columns = [moving]
        if prepared.replays_pressures and parts.pressures is not None:
            columns.append(reported_pressure(deviations, parts.pressures))
        if prepared.replays_master and prepared.hydraulics is not None:
            columns.append(self.pressures.unit.master(deviations, prepared.hydraulics)[:, None])
        return np.concatenate(columns, axis=1)

    def step_of(self, theta: FloatArray, column: int) -> float:
        """Step of a column's finite difference, towards the inside of its bounds."""
        parameter, name = self.parameters[column], self.columns[column]
        by_steps = not self.pressures.unit.flows and any(one.replays_pressures for one in self.prepared)
        jumps = everywhere(name) in _ACT_BY_JUMPS or (by_steps and acts_on_pressures(name))
        step = (_COARSE_STEP_SHARE if jumps else STEP_SHARE) * parameter.effect_std
        return step if theta[column] + step <= parameter.high else -step
