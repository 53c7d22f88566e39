"""Pressures of the wheel brakes by the vehicle's hydraulic unit, and what the unit tells of a manoeuvre beforehand."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import siegelslopes

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.effects.sensor_chain import PRESSURE_LAG, true_inputs, without_lag
from model_diagnosis.effects.sensors import SENSOR_EFFECTS
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.driving_pressures import driving_pressures, numbers_by_pressures
from model_diagnosis.replay.gaps import begun_anew
from model_diagnosis.replay.hydraulic import GAIN, HYDRAULIC_COLUMNS, HydraulicReplay, reported_pressure
from model_diagnosis.replay.inputs import with_pressures
from model_diagnosis.replay.prepared import PRESSURES, Prepared
from model_diagnosis.replay.sensors import own_noise
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

_STEPS_SHARE = 0.5
"""Share of the misfit by flow that one by steps must not exceed: such a unit follows its own pressures to their noise.

Its steps jump with deviations, and fits end before a jump."""


_SHOWN_PA = 5e5
"""Pressure, and difference of pressures, from which a sensor's scale shows beside its noise of 0.3 bar."""
_SAMPLES_OF_A_LINE = 400
"""Repeated medians cost their square; so many tell the slope to 0.1 % at pressures that vary by 20 bar."""
_TRIED_LAGS_S = (0.0, 0.004, 0.008, 0.012, 0.016, 0.02, 0.025, 0.035, 0.05)
"""Of the sensors, from which the numbers are sought, up to half of the catalogue's bound: from the nearest one two
steps end within 8 % of lags of 4 to 25 ms (tuning seeds 215 to 220)."""
_NO_LAG = (0.0,)
_SHOWN_LAG_S = 2e-3
"""Lag that a lead can be divided by: the catalogue's scatter of a series sensor's."""
_MOST_SAMPLES = 0.9
"""Share of the samples with a moved valve; a lost command or two are the rest."""
_FOLLOWED = 5.0
"""Standard deviations of the pressures' noise that a unit which does as it is told errs by in fewer samples. That share
of them is within 1.8 to 2.4 in ABS stops of the challenge's generator, and within 20 where pressures rest."""
_LARGEST_SCALE = 0.5
"""As far as the catalogue lets a sensor's scale be off."""

_KEPT: dict[str, dict[str, float]] = {}
_MOST_KEPT = 16
"""Checks of the data replay the same pressures a dozen times beside other channels."""

_ORDINARY = {column: one for column, one in HYDRAULIC_COLUMNS.items() if one.ordinary_std > 0.0}
"""Columns, and their parameters, in which every car's unit is off."""
_OF_READINGS = _ORDINARY | {
    column: parameter
    for effect in SENSOR_EFFECTS
    for column, parameter in zip(effect.columns, effect.parameters, strict=True)
    if column == PRESSURE_LAG
}
"""The same, and how far the sensors' readings are behind."""


class WheelPressures:
    """Wheel pressures of one vehicle in its manoeuvres.

    Attributes
    ----------
    unit : the vehicle's hydraulic unit, without deviations
    """

    def __init__(self, vehicle: VehicleFile) -> None:
        self.unit = HydraulicReplay(vehicle)
        self._vehicle = vehicle.brakes.model_dump_json() + vehicle.hydraulics.model_dump_json()
        self._noise = own_noise(vehicle, PRESSURES[0])

    def at(self, deviations: Mapping[str, float], prepared: Prepared, *, free: bool = False) -> FloatArray | None:
        """Pressures (n, 4) [Pa] by the unit, as the lag of their sensors lets them through where those measured them.

        None where the log tells nothing of it.
        """
        both = self._both(deviations, prepared, free=free)
        return None if both is None else both[0]

    def _both(
        self, deviations: Mapping[str, float], prepared: Prepared, *, free: bool = False
    ) -> tuple[FloatArray, FloatArray] | None:
        """Pressures as of ``at``, and those of the brakes that the sensors lag behind."""
        log = prepared.hydraulics
        if log is None or (prepared.pressure_known and not prepared.replays_pressures):
            return None
        measured = np.zeros((prepared.manoeuvre.samples, 4))
        true = without_lag(deviations)
        if prepared.pressure_known:
            # what the observer corrects on keeps its noise: without it, it would know of samples still to come
            manoeuvre = prepared.manoeuvre
            lagged = true_inputs(true, manoeuvre.time, manoeuvre.channels)
            measured = np.stack([lagged[name] for name in PRESSURES], axis=1)
        gain = 0.0 if free else GAIN
        # a unit that moves by steps is up to its threshold off: there the observer is needed for small differences too
        noise = self._noise if self.unit.flows else 0.0
        least = None if free else prepared.pressure_least
        seen = deviations if prepared.pressure_known else true
        return self.unit.wheels(seen, log, measured, prepared.pressure_valid, gain, noise, least)

    def settled(self, manoeuvres: Sequence[Prepared]) -> list[Prepared]:
        """The manoeuvres with what the vehicle's own unit tells of them, in the form that all of them show together."""
        by_steps = self._misfit({}, manoeuvres)
        self.unit.flows = True
        # which of the two the car has is a matter of form; a throttled return too rests above its supply
        throttled = {"form_return.lag": HYDRAULIC_COLUMNS["form_return.lag"].nuisance_std}
        # sensors that differ from the master's let a unit rest off its supply too
        ways: list[dict[str, float]] = [{}, throttled]
        if sensors := self._sensors(manoeuvres):
            ways.append(sensors)
        by_flow = min(self._misfit(deviations, manoeuvres) for deviations in ways)
        # of pressures that nobody measured both say nothing: those of real valves flow
        self.unit.flows = by_steps >= _STEPS_SHARE * by_flow
        # valves that are late, or sensors that are, err at every flank: a lost command is what their numbers leave
        of_readings = self._numbers(manoeuvres, _OF_READINGS)
        begun = [replace(one, pressure_least=self._least(of_readings, one)) for one in manoeuvres]
        lags = of_readings.get(PRESSURE_LAG, 0.0) >= _SHOWN_LAG_S and self._follows(of_readings, begun)
        numbers = of_readings if lags else self._numbers(begun, _ORDINARY)
        return [self._driven(numbers, one) for one in begun]

    def _sensors(self, manoeuvres: Sequence[Prepared]) -> dict[str, float]:
        """Scale and offset of the wheels' sensors against the master's: the straight line through their readings over
        the pressures of the unit run freely, where no valve is moved."""
        predicted, measured = [np.zeros(0)], [np.zeros(0)]
        for prepared in manoeuvres:
            log = prepared.hydraulics
            if log is None or not prepared.replays_pressures:
                continue
            free = self.at({}, prepared, free=True)
            assert free is not None
            rests = (log.inlet == 0.0) & (log.outlet == 0.0) & (prepared.pressure_valid > 0.0)
            shown = rests & (free > _SHOWN_PA)
            predicted.append(free[shown])
            measured.append(prepared.measured[:, _places(prepared)][shown])
        return _line(np.concatenate(predicted), np.concatenate(measured))

    def _misfit(self, deviations: Mapping[str, float], manoeuvres: Sequence[Prepared]) -> float:
        """Sum of squares of what the unit leaves of the measured pressures [Pa^2]."""
        total = 0.0
        for prepared in manoeuvres:
            if prepared.replays_pressures:
                left = prepared.weights[:, _places(prepared)] * self._error(deviations, prepared)
                total += float(np.sum(left**2))
        return total

    def _follows(self, deviations: Mapping[str, float], manoeuvres: Sequence[Prepared]) -> bool:
        """True for a unit that does as its valves are told, but for single commands."""
        off = [np.zeros(0)]
        for prepared in manoeuvres:
            if prepared.replays_pressures and prepared.hydraulics is not None:
                moved = (prepared.hydraulics.inlet + prepared.hydraulics.outlet) * prepared.pressure_valid > 0.0
                off.append(np.abs(self._error(deviations, prepared)[moved]))
        moving = np.concatenate(off)
        return len(moving) > 0 and bool(np.quantile(moving, _MOST_SAMPLES) < _FOLLOWED * self._noise)

    def _error(self, deviations: Mapping[str, float], prepared: Prepared) -> FloatArray:
        """Measured pressures (n, 4) less the unit's [Pa]."""
        predicted = self.at(deviations, prepared)
        assert predicted is not None
        error: FloatArray = prepared.measured[:, _places(prepared)] - reported_pressure(deviations, predicted)
        return error

    def _least(self, numbers: Mapping[str, float], prepared: Prepared) -> FloatArray:
        """Least gains (n, 4) of the observer, with those where a command of the valves was lost for such a unit."""
        if not prepared.replays_pressures:
            return prepared.pressure_least

        def off(least: FloatArray) -> FloatArray:
            return prepared.pressure_valid * np.abs(self._error(numbers, replace(prepared, pressure_least=least)))

        return begun_anew(off, prepared.pressure_least, self._noise)

    def _numbers(self, manoeuvres: Sequence[Prepared], columns: Mapping[str, EffectParameter]) -> dict[str, float]:
        """What the measured pressures tell of such columns; a unit that moves by steps jumps with them."""
        telling = [one for one in manoeuvres if one.replays_pressures and one.inputs.values[:, :4].any()]
        if not self.unit.flows or not telling:
            return {}

        def errors(deviations: Mapping[str, float]) -> FloatArray:
            return np.concatenate([(one.pressure_valid * self._error(deviations, one)).ravel() for one in telling])

        key = f"{self._digest(telling)} {' '.join(columns)}"
        if key not in _KEPT:
            # from no lag the steps end where late valves hide half of it
            starts = [{PRESSURE_LAG: lag} for lag in (_TRIED_LAGS_S if PRESSURE_LAG in columns else _NO_LAG)]
            found = numbers_by_pressures(errors, list(columns), list(columns.values()), self._noise, starts)
            while len(_KEPT) >= _MOST_KEPT:
                _KEPT.pop(next(iter(_KEPT)))
            _KEPT[key] = found
        return _KEPT[key]

    def _digest(self, manoeuvres: Sequence[Prepared]) -> str:
        """Digest of all that the unit's pressures and the measured ones depend on."""
        digest = hashlib.sha256(f"{self._vehicle} {self._noise}".encode())
        for one in manoeuvres:
            log = one.hydraulics
            assert log is not None
            digest.update(f"{log.behind_commands} {log.behind_master} {log.commanded}".encode())
            driving = (log.master, log.pedal, log.inlet, log.outlet, log.pump, log.cornering)
            of_samples = (one.measured[:, _places(one)], one.pressure_valid, one.pressure_least)
            for values in (*driving, *of_samples):
                digest.update(b"none" if values is None else np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()

    def _driven(self, numbers: Mapping[str, float], prepared: Prepared) -> Prepared:
        """The manoeuvre with the readings that drive the car by a unit with these numbers.

        With a lag of the sensors among them, with what the brakes lead their readings by, too: flanks are steeper than
        samples tell, the unit knows them, and what it lacks of the readings is smooth.
        """
        log = prepared.hydraulics
        if log is None or not prepared.replays_pressures:
            return prepared
        both = self._both(numbers, prepared)
        assert both is not None
        by_unit, brakes_by_unit = both
        valid = prepared.pressure_valid
        readings = driving_pressures(prepared.measured[:, _places(prepared)], by_unit, valid)
        brakes, leads = readings, {}
        lag = numbers.get(PRESSURE_LAG, 0.0)
        if lag > 0.0:
            lacking = readings - by_unit
            brakes = np.maximum(brakes_by_unit + lacking + lag * np.gradient(lacking, SAMPLE_TIME_S, axis=0), 0.0)
            leads = dict(zip(PRESSURES, (brakes - readings).T / lag, strict=True))
        between = self.unit.between_samples(without_lag(numbers), log, brakes, valid, prepared.pressure_least)
        driving = {**prepared.driving, **dict(zip(PRESSURES, readings.T, strict=True))}
        inputs = replace(prepared.inputs, values=with_pressures(prepared.inputs, driving))
        return replace(prepared, driving=driving, inputs=inputs, leads=leads, between=between)


def _line(true: FloatArray, read: FloatArray) -> dict[str, float]:
    """Scale and offset of readings (n,) over true pressures (n,) [Pa]; nothing where they hardly vary."""
    if len(true) < 2 or np.ptp(true) < _SHOWN_PA:
        return {}
    # flanks that the free unit takes too early or late are far off, and few
    slope, offset = siegelslopes(*_thinned(read, true))
    if abs(slope - 1.0) > _LARGEST_SCALE:
        return {}  # brakes that do not follow their supply at all
    return {"pressure_sensor_scale.wheels": float(slope) - 1.0, "pressure_sensor_offset.wheels": float(offset)}


def _thinned(*series: FloatArray) -> list[FloatArray]:
    """At most some hundreds of samples, evenly from the whole: every pair of them counts."""
    every = max(len(series[0]) // _SAMPLES_OF_A_LINE, 1)
    return [one[::every] for one in series]


def _places(prepared: Prepared) -> list[int]:
    """Columns of the wheel pressures among the compared signals."""
    return [prepared.signals.index(name) for name in PRESSURES]
