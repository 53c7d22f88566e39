"""Attitude filters (attitude document, section 3): the bank, one filter alone, one with the virtual offset as a state.

bank = estimators.create("attitude_bank", numbers, {"form": "2A"}, sample_time_s=0.002)
found = bank.replay(columns)
bank.filter_states      # full state of each filter, shape (n, 10)
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from estimators.attitude_car import CAR_RECORD, attitude_car
from estimators.attitude_forms import (
    ACCELEROMETER,
    B_X,
    FORMS,
    LATERAL_SPEED,
    NONE,
    ROW_PITCH,
    ROW_ROLL,
    ROW_SPEED,
    ROW_Y,
    ROW_YAW,
    ROW_Z,
    SPEED,
    Form,
)
from estimators.attitude_memory import (
    ACCUMULATED,
    BEST,
    CAR,
    CHANNELS,
    DELAY,
    DOCUMENT_CYCLE,
    ELEVATION_POLE,
    EXTERNAL,
    FRICTION_SHARE,
    GRAVITY,
    LARGEST_CENTRE,
    LARGEST_ROLL,
    LEVEL_PITCH,
    LOOP,
    MINIMUM_SPEED,
    PERIOD,
    PERIOD_TICKS,
    RECENTRING,
    RECENTRING_START,
    REPORTED,
    RESETS,
    SAMPLE_TIME,
    SAMPLES,
    SETTLING_TICKS,
    SMOOTHING,
    STALE_AGE,
    STUDENT,
    SUSPICIOUS_STEPS,
    SUSPICIOUS_WEIGHT,
    TARGET,
    VIRTUAL,
    memory,
)
from estimators.attitude_settings import (
    SENSORS,
    AttitudeAugmentedSettings,
    AttitudeBankSettings,
    AttitudeSettings,
    AttitudeSingleSettings,
    attitude_inputs,
    guarded_inputs,
    speed_wheels,
)
from estimators.attitude_step import attitude_tick, forget, replay_rows
from estimators.attitude_two_wheeler import BIKE_RECORD, two_wheeler
from estimators.attitude_weights import GRID
from estimators.inputs import forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.vehicle_numbers import required
from signals.catalogue import block_slice, index_of

_SETTLING = 0.4
"""Periods of the cut-off frequency after which a low-pass has forgotten five sixths of its start."""

_DIFFERENCES = np.array([1e-5, 1e-5, 1e-3, 1e-3, 1e-6, 1e-6, 1e-6, 1e-3, 1e-3, 1e-3])
"""Steps of the Jacobians' differences, in units of the full vector."""

_ANGLE, _GYRO, _ACCELERATION = 6e-5, 6e-5, 4e-3
_CAR_ANGLE, _CAR_GYRO, _CAR_ACCELERATION = 2e-3, 5e-5, 1e-3
"""Process noise per root second: two-wheeler (3.5); car (6; its accelerometers' assumed)."""


class AttitudeFilter(Estimator):
    """Base of the attitude filters.

    Attributes
    ----------
    filter_states : array, shape (n, 10)
        Pitch, roll, speed, lateral speed, offsets of roll, yaw, pitch gyroscope and of accelerometers x, y, z of each
        filter; a view.
    filter_covariances : array, shape (n, k, k)
        A view.
    bank : array, shape (5, n)
        Likelihoods, weights and virtual offsets (:mod:`estimators.attitude_weights`); a view.
    form : Form
    """

    def __init__(
        self,
        name: str,
        vehicle: Mapping[str, float],
        settings: AttitudeSettings,
        form: Form,
        offsets: tuple[float, ...],
        sample_time_s: float,
    ) -> None:
        self.settings = settings
        self.form = form
        wheels = speed_wheels(settings)
        self.memory = memory(len(offsets), _entries(form, settings), _rows(form, settings), len(wheels))
        self.filter_states, self.filter_covariances = self.memory.state, self.memory.covariance
        self.bank = self.memory.bank
        self.bank[GRID] = offsets
        bike, car = np.zeros(1, BIKE_RECORD), np.zeros(1, CAR_RECORD)
        if form.car:
            car = attitude_car(vehicle, settings)
        else:
            bike = two_wheeler(vehicle, settings)
        names = guarded_inputs(settings)
        self.memory.radii[:] = [required(vehicle, f"wheels.{wheel}.radius") for wheel in wheels]
        self._tune(settings, sample_time_s)
        self.memory.tuning[TARGET] = settings.characteristic_value * (0.0 if form.car else bike[0]["balance_scale"])
        self.memory.tuning[GRAVITY] = (car if form.car else bike)[0]["gravity"]
        self._set_noise(form, settings)
        _set_sources(self.memory.sources, names, settings)
        self._guard, positions = input_guard(names, settings.input_timeout)
        super().__init__(name, attitude_inputs(settings), sample_time_s)
        self._bound = self.memory, bike, car, self._guard, positions
        self.tick = partial(attitude_tick, *self._bound)
        self.reset()

    def _tune(self, settings: AttitudeSettings, sample_time_s: float) -> None:
        t, ticks = self.memory.tuning, max(1, round(settings.period / sample_time_s))
        t[SAMPLE_TIME], t[PERIOD_TICKS], t[PERIOD] = sample_time_s, ticks, ticks * sample_time_s
        t[CAR], t[EXTERNAL] = self.form.car, settings.speed_source == "external"
        t[LOOP], t[DOCUMENT_CYCLE] = self.form.loop, settings.cycle == "document"
        t[MINIMUM_SPEED], t[LARGEST_ROLL] = settings.minimum_speed, settings.largest_roll
        t[VIRTUAL] = t[REPORTED] = self.form.virtual
        t[STALE_AGE] = settings.input_timeout
        t[SMOOTHING], t[FRICTION_SHARE], t[SUSPICIOUS_STEPS] = 1.0, np.inf, np.inf
        share = t[PERIOD] * 2.0 * math.pi * settings.elevation_low_pass
        t[ELEVATION_POLE] = share / (1.0 + share)
        self.memory.coefficients[0] = butterworth(settings.low_pass, sample_time_s)
        self.memory.coefficients[1] = butterworth(settings.low_pass_speed, sample_time_s)
        t[SETTLING_TICKS] = _SETTLING / (settings.low_pass * sample_time_s)
        t[DELAY] = math.sqrt(2.0) / (2.0 * math.pi * settings.low_pass)
        self.memory.matrices[0], self.memory.matrices[1] = settings.gyro_matrix, settings.accelerometer_matrix

    def _set_noise(self, form: Form, settings: AttitudeSettings) -> None:
        a = self.memory
        given = {
            ROW_Y: settings.measurement_lateral_acceleration,
            ROW_Z: settings.measurement_vertical_acceleration,
            ROW_SPEED: settings.measurement_speed,
            ROW_ROLL: settings.measurement_roll_balance,
            ROW_YAW: settings.measurement_yaw_balance,
            ROW_PITCH: settings.measurement_pitch_balance,
        }
        for place, row in enumerate(a.rows):
            chosen = given[int(row)]
            a.noise[place] = (form.measurement[int(row)] if chosen is None else chosen) ** 2
        period = a.tuning[PERIOD]
        for place, entry in enumerate(a.entries):
            process, initial = _deviations(int(entry), form, settings)
            a.process[place, place] = process**2 * period
            a.initial[place] = initial
        a.steps[:] = _DIFFERENCES

    def reset(self) -> None:
        """Return to the state of a new estimator."""
        forget(self.memory)
        self.memory.status[RESETS] = 0.0
        forget_inputs(self._guard)

    def tick_rows(self, inputs: FloatArray, ages: FloatArray, out: FloatArray) -> None:
        """Tick once for every row, the loop compiled."""
        replay_rows(*self._bound, inputs, ages, out)


def butterworth(cut_off_hz: float, sample_time_s: float) -> tuple[float, float, float, float, float]:
    """Coefficients b0, b1, b2, a1, a2 of a second-order Butterworth low-pass; cut-off 0 lets everything through."""
    if cut_off_hz <= 0.0 or cut_off_hz * sample_time_s >= 0.5:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    warped = math.tan(math.pi * cut_off_hz * sample_time_s)
    scale = 1.0 / (1.0 + math.sqrt(2.0) * warped + warped**2)
    b = warped**2 * scale
    return b, 2.0 * b, b, 2.0 * (warped**2 - 1.0) * scale, (1.0 - math.sqrt(2.0) * warped + warped**2) * scale


def _entries(form: Form, settings: AttitudeSettings) -> IntArray:
    states = [entry for entry in form.states if entry != SPEED or settings.speed_source != "external"]
    return np.array(states, dtype=np.int64)


def _rows(form: Form, settings: AttitudeSettings) -> IntArray:
    left_out = set()
    if settings.speed_source == "external":
        left_out.add(ROW_SPEED)
    if not (settings.characteristic_equation and (settings.roll_balance or not form.car)):
        left_out.add(ROW_ROLL)
    return np.array([row for row in form.rows if row not in left_out], dtype=np.int64)


def _deviations(entry: int, form: Form, settings: AttitudeSettings) -> tuple[float, float]:
    """Process noise per root second and deviation at the start of an entry of the full vector."""
    car = form.car

    def chosen(given: float | None, of_car: float, of_two_wheeler: float) -> float:
        return (of_car if car else of_two_wheeler) if given is None else given

    if entry == SPEED:
        return chosen(settings.process_speed, form.process_speed, form.process_speed), settings.initial_speed
    if entry == LATERAL_SPEED:
        return settings.process_lateral_speed, settings.initial_speed
    if entry < SPEED:
        return chosen(settings.process_angle, _CAR_ANGLE, _ANGLE), settings.initial_angle
    if entry < B_X:
        return chosen(settings.process_gyro_offset, _CAR_GYRO, _GYRO), settings.initial_gyro_offset
    noise = chosen(settings.process_acceleration_offset, _CAR_ACCELERATION, _ACCELERATION)
    return noise, settings.initial_acceleration_offset


def _set_sources(sources: IntArray, names: tuple[str, ...], settings: AttitudeSettings) -> None:
    """Rows of the guard for each sensor, -1 where it is not read; the first wheel; place and age of the ABS report."""
    for channel, sensor in enumerate(SENSORS):
        sources[channel] = names.index(sensor) if sensor in names else -1
    sources[6] = next(k for k, name in enumerate(names) if name.startswith(("wheel_speed", "ecu_reference")))
    sources[CHANNELS] = sources[CHANNELS + 1] = -1
    if settings.abs_signal == "bus":
        sources[CHANNELS] = index_of("abs_active") - block_slice("bus").start
        sources[CHANNELS + 1] = index_of("age_abs_status") - block_slice("bus_age").start


class AttitudeBank(AttitudeFilter):
    """Bank of filters that are told different virtual offsets; build it with :func:`estimators.create`."""

    def __init__(
        self, vehicle: Mapping[str, float], settings: AttitudeBankSettings, sample_time_s: float = 0.001
    ) -> None:
        super().__init__("attitude_bank", vehicle, settings, settings.chosen, settings.offsets, sample_time_s)
        t = self.memory.tuning
        period, constant = t[PERIOD], settings.likelihood_time_constant
        t[SMOOTHING] = period / (constant + period)
        t[STUDENT] = settings.degrees_of_freedom if settings.likelihood == "student" else 0.0
        t[ACCUMULATED], t[SAMPLES] = settings.weighting == "accumulated", settings.effective_samples
        t[BEST] = settings.output == "best"
        t[RECENTRING] = settings.recentring * period / settings.recentring_time_constant
        t[RECENTRING_START], t[LARGEST_CENTRE] = settings.recentring_start, settings.sensor_range
        t[FRICTION_SHARE], t[SUSPICIOUS_WEIGHT] = settings.largest_friction_share, settings.suspicious_weight
        t[SUSPICIOUS_STEPS] = settings.suspicious_time / period


def attitude_single(
    vehicle: Mapping[str, float], settings: AttitudeSingleSettings, sample_time_s: float = 0.001
) -> AttitudeFilter:
    """One filter of the bank alone; its weight is always 1."""
    return AttitudeFilter(
        "attitude_single", vehicle, settings, settings.chosen, (settings.virtual_offset,), sample_time_s
    )


def attitude_augmented(
    vehicle: Mapping[str, float], settings: AttitudeAugmentedSettings, sample_time_s: float = 0.001
) -> AttitudeFilter:
    """One filter with the virtual offset, or all accelerometers' offsets, among its states.

    A two-wheeler's with pitch takes the slope of G_z by the pitch angle on the level (:func:`level_pitch`): a straight
    ride tells that angle and the offset of G_x only together.
    """
    form = settings.chosen
    wanted = ACCELEROMETER.values() if settings.augment == "all" else (form.virtual,)
    added = tuple(entry for entry in wanted if entry not in form.states)
    grown = replace(form, states=(*form.states, *added), virtual=NONE)
    tilts = form.pitches and not form.car
    if tilts and B_X in added:
        # that of 2A is chosen to set a bank's filters apart (3.5); 2B and 2C have b_x for a state
        grown = replace(grown, measurement=FORMS["2B"].measurement)
    built = AttitudeFilter("attitude_augmented", vehicle, settings, grown, (0.0,), sample_time_s)
    built.memory.tuning[REPORTED] = form.virtual
    built.memory.tuning[LEVEL_PITCH] = tilts
    return built
