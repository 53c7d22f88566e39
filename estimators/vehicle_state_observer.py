"""The vehicle-state observers as estimators: which of the four parts work, and what they write.

Each estimator is a choice of parts of one compiled tick (:mod:`estimators.vehicle_state_tick`), so that the cascade is
the four others and not a second implementation.
"""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numba import njit

from estimators.description import Output
from estimators.inputs import forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.kalman.sigma_points import unscented_weights
from estimators.magic_formula_fit_solver import slsqp_fit
from estimators.magic_formula_fit_step import conclude_fit
from estimators.vehicle_numbers import tone_ring
from estimators.vehicle_state_car import document_car
from estimators.vehicle_state_lateral import LateralMemory, lateral_memory
from estimators.vehicle_state_outputs import ALL_OUTPUTS, positions_of
from estimators.vehicle_state_record import (
    BUFFER,
    CURVE_RECORD,
    CURVES,
    INERTIAL,
    LATERAL_STATES,
    LOG_COLUMNS,
    LOG_ROWS,
    STATE_RECORD,
    TUNING_RECORD,
    VIRTUAL,
)
from estimators.vehicle_state_results import write_results
from estimators.vehicle_state_settings import (
    CurveSettings,
    GradeSettings,
    LateralSettings,
    LongitudinalSettings,
    StateSettings,
    lateral_inputs,
    state_inputs,
)
from estimators.vehicle_state_tick import TREND, ObserverParts, forget_state, observe

_LISTING_NOISE = {"process_lateral_speed": 0.01, "process_yaw_rate": 0.1, "process_slope": 0.1}
_CONSISTENT_NOISE = {"process_lateral_speed": 1e-6, "process_yaw_rate": 1e-5, "process_slope": 1e-3}
_HAND_OVER_VARIANCE = 0.05
_GAINS = {1: 100.0, 2: 150000.0}
_GYRO_TIME_S = 1.0
_DRIVEN = {"front": (0.5, 0.5, 0.0, 0.0), "rear": (0.0, 0.0, 0.5, 0.5)}


@njit(cache=True)
def _tick(
    parts: ObserverParts,
    everything: FloatArray,
    places: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    active = observe(parts, inputs, ages)
    write_results(parts.state, parts.curves, parts.memory, parts.tuning, active, everything)
    for k in range(places.shape[0]):
        out[k] = everything[places[k]]


@njit(cache=True)
def _tick_rows(
    parts: ObserverParts,
    everything: FloatArray,
    places: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    """A tick for every row of recorded blocks; arrays of shape (n, width)."""
    for k in range(inputs.shape[0]):
        _tick(parts, everything, places, inputs[k], ages[k], out[k])


class StateObserver(Estimator):
    """Base of the vehicle-state observers; build one with :func:`estimators.create`.

    Attributes
    ----------
    state, covariance : array, shape (10,) and (10, 10)
        Views of the lateral filter, document axes and wheel order (3.3).
    """

    lateral: ClassVar[bool] = False
    longitudinal: ClassVar[bool] = False
    fits: ClassVar[tuple[bool, bool]] = (False, False)
    grade: ClassVar[bool] = False
    estimator_name: ClassVar[str]
    written: ClassVar[tuple[Output, ...]]

    def __init__(self, vehicle: Mapping[str, float], settings: StateSettings, sample_time_s: float = 0.001) -> None:
        self.settings = settings
        lateral = getattr(settings, "lateral", LateralSettings())
        fit = getattr(settings, "fit", CurveSettings())
        car = document_car(vehicle, exact_arms=lateral.exact_arms, needs_steering=self.lateral)
        car.record["driven"] = _DRIVEN[settings.longitudinal.driven_axle]
        self._car = car
        self._tuning = np.zeros(1, TUNING_RECORD)
        mean, covariance, spread = self._weights(lateral)
        self._tuning["spread"] = spread
        self._fill(settings.longitudinal, sample_time_s)
        teeth, window = tone_ring(vehicle, settings.wheel_speed_teeth, settings.wheel_speed_window)
        self._tuning["teeth"], self._tuning["window"] = teeth, window
        self._fill_lateral(lateral, sample_time_s)
        self._fill_fit(fit, lateral)
        self._fill_grade(getattr(settings, "grade", GradeSettings()), sample_time_s)
        self._rows = np.zeros(1, STATE_RECORD)
        self._curves = np.zeros(CURVES, CURVE_RECORD)
        self._memory: LateralMemory = lateral_memory((mean, covariance))
        self.state, self.covariance = self._memory.x, self._memory.covariance
        self._pairs, self._scratch = np.zeros((CURVES, 2, BUFFER)), np.zeros((2, BUFFER))
        self._log, self._logged = np.zeros((LOG_ROWS, len(LOG_COLUMNS))), np.zeros(1)
        rows = state_inputs(settings)
        inputs = rows if self.longitudinal else lateral_inputs(settings)
        fed = tuple(name if name in inputs else None for name in rows)
        self._guard, self._positions = input_guard(fed, settings.input_timeout)
        super().__init__(self.estimator_name, inputs, sample_time_s)
        parts = ObserverParts(
            self._rows,
            self._curves,
            self._memory,
            self._pairs,
            self._scratch,
            self._log,
            self._logged,
            car.record,
            car.steering,
            self._tuning,
            self._guard,
            self._positions,
        )
        places = np.array(positions_of(self.written), dtype=np.int64)
        self._bound = parts, np.zeros(len(ALL_OUTPUTS)), places
        self._outside_solver = fit.optimiser == "slsqp"
        compiled = partial(_tick, *self._bound)
        self.tick = partial(self._tick_with_solver, compiled, fit) if self._outside_solver else compiled
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new observer."""
        self._rows[:] = np.zeros(1, STATE_RECORD)
        self._curves[:] = np.zeros(CURVES, CURVE_RECORD)
        self._log[:], self._logged[:] = 0.0, 0.0
        forget_inputs(self._guard)
        forget_state(self._rows[0], self._curves, self._memory, self._car.record[0], self._tuning[0])

    def tick_rows(self, inputs: FloatArray, ages: FloatArray, out: FloatArray) -> None:
        """Tick once for every row, the loop compiled where the fits are solved within it."""
        if self._outside_solver:
            super().tick_rows(inputs, ages, out)
        else:
            _tick_rows(*self._bound, inputs, ages, out)

    def events(self) -> list[dict[str, Any]]:
        """The fits so far, the oldest first, at most the last 256.

        Each tells time [s], wheel, direction, sign of the slip in the document's axes, points, objective, R^2, attained
        friction, limit D, stiffness B, the share of D that was attained, and `early`: 1 where by the wheel's earlier
        curves the fit came before the latest share of the peak, 0 where it can no longer claim to predict.
        """
        wheels = ("fr", "fl", "rr", "rl")
        logged = int(self._logged[0])
        found = []
        for number in range(max(logged - LOG_ROWS, 0), logged):
            row = dict(zip(LOG_COLUMNS, self._log[number % LOG_ROWS].tolist(), strict=True))
            curve = int(row.pop("curve"))
            found.append({"wheel": wheels[curve % 4], "direction": ("lateral", "longitudinal")[curve // 4], **row})
        return found

    def _tick_with_solver(
        self, compiled: Any, fit: CurveSettings, inputs: FloatArray, ages: FloatArray, out: FloatArray
    ) -> None:
        """Tick, then let SLSQP solve what is due: the result is used from the next tick on."""
        compiled(inputs, ages, out)
        for number in np.flatnonzero(self._curves["pending"]):
            curve, direction = self._curves[number], number // 4
            count = int(curve["count"])
            x, mu = self._pairs[number, 0, :count], self._pairs[number, 1, :count]
            tuning = self._tuning[0]
            limits = (
                (float(tuning["low_d"]), float(tuning["high_d"])),
                (float(tuning["low_b"][direction]), float(tuning["high_b"][direction])),
            )
            d, b, _ = slsqp_fit(x, mu, fit.shape, (float(np.max(np.abs(mu))) / 0.6, float(curve["b"])), limits)
            conclude_fit(
                curve,
                self._pairs[number, 0],
                self._pairs[number, 1],
                self._scratch,
                self._log,
                self._logged,
                int(number),
                d,
                b,
                float(self._rows["time"][0]),
                tuning,
            )

    @staticmethod
    def _weights(lateral: LateralSettings) -> tuple[FloatArray, FloatArray, float]:
        kappa = 3.0 - LATERAL_STATES if lateral.kappa is None else lateral.kappa
        return unscented_weights(LATERAL_STATES, lateral.alpha, lateral.beta, kappa)

    def _fill(self, longitudinal: LongitudinalSettings, sample_time_s: float) -> None:
        t = self._tuning[0]
        t["dt"] = sample_time_s
        t["longitudinal"] = self.longitudinal
        t["gate_x"] = longitudinal.gate_speed
        t["surface_error"], t["surface_rate"] = longitudinal.surface_error, longitudinal.surface_rate
        t["gain"] = _GAINS[longitudinal.integrators] if longitudinal.gain is None else longitudinal.gain
        t["largest_slope"] = longitudinal.largest_slope
        t["slew_time"], t["integrators"] = longitudinal.slew_time, longitudinal.integrators
        t["reversal"], t["layer"] = longitudinal.reversal, longitudinal.boundary_layer
        t["smallest_slip"], t["initial_slope_x"] = longitudinal.smallest_slip, longitudinal.initial_slope
        t["anchor"], t["towing_slip"] = longitudinal.anchor, longitudinal.towing_slip
        # the odometer of the wheels that no engine drives
        t["anchor_rows"] = np.where(self._car.record["driven"][0] > 0.0, 0.0, 1.0)
        t["engine_torque_path"] = longitudinal.drive_torque == "engine"
        t["engine_weight"] = _weight(0.01, longitudinal.engine_time_constant)
        t["pair_weight"] = _weight(0.01, longitudinal.pair_time_constant)
        t["trend_weight"] = _weight(0.01, TREND * longitudinal.pair_time_constant)
        t["settling_time"] = longitudinal.settling_time
        t["measured_slip"] = longitudinal.pair_slip == "measured"
        t["brakes"] = longitudinal.brake_torque == "pressure"

    def _fill_lateral(self, lateral: LateralSettings, sample_time_s: float) -> None:
        t = self._tuning[0]
        listing = lateral.noise == "listing"
        defaults = _LISTING_NOISE if listing else _CONSISTENT_NOISE
        chosen = {key: value if (value := getattr(lateral, key)) is not None else defaults[key] for key in defaults}
        t["lateral"] = self.lateral
        t["lateral_ticks"] = max(round(lateral.step_time / sample_time_s), 1)
        t["redraw"], t["listing_noise"] = lateral.redraw, listing
        t["double_projection"], t["centripetal"] = lateral.double_projection, lateral.centripetal_term
        t["roll_compensation"], t["hand_over"] = lateral.roll_compensation, lateral.hand_over
        t["sway"] = self._car.record["h"][0] if lateral.body_sway else 0.0
        t["filtered_yaw"], t["yaw_delay"] = lateral.yaw_acceleration == "filtered", lateral.yaw_rate_delay
        t["gate_y"], t["smallest_alpha"] = lateral.gate_speed, lateral.smallest_slip_angle
        t["signal_weight"] = _weight(lateral.step_time, lateral.signal_time_constant)
        t["process_v_y"], t["process_w_z"] = chosen["process_lateral_speed"], chosen["process_yaw_rate"]
        t["process_slope"], t["process_limit"] = chosen["process_slope"], lateral.process_limit
        yaw_noise = lateral.measurement_yaw_rate
        t["noise_w_z"] = yaw_noise if yaw_noise is not None else 5e-4 if listing else 2.5e-5
        t["noise_slope"], t["noise_friction"] = lateral.measurement_slope, lateral.measurement_friction
        t["initial_slope"], t["initial_limit"] = lateral.initial_slope, lateral.initial_limit
        t["initial_v_y_variance"], t["initial_w_z_variance"] = 0.01, 1e-4
        t["initial_slope_variance"] = lateral.initial_slope_deviation**2
        t["initial_limit_variance"] = t["hand_over_variance"] = _HAND_OVER_VARIANCE
        t["gyro_weight"] = _weight(sample_time_s, _GYRO_TIME_S)
        t["stuck_after"], t["stuck_difference"] = lateral.stuck_after, lateral.stuck_difference

    def _fill_fit(self, fit: CurveSettings, lateral: LateralSettings) -> None:
        t = self._tuning[0]
        t["fit"], t["automatic"] = self.fits, fit.threshold == "automatic"
        t["curve_c"], t["initial_b"] = fit.shape, fit.initial_stiffness
        t["start_threshold"] = fit.threshold_lateral, fit.threshold_longitudinal
        t["low_threshold"] = fit.lowest_lateral, fit.lowest_longitudinal
        t["high_threshold"] = fit.highest_lateral, fit.highest_longitudinal
        t["threshold_times_b"] = fit.share_lateral, fit.share_longitudinal
        t["start_doubt"], t["doubt"] = fit.start_doubt, (fit.doubt, -1.0)
        t["agreement"] = fit.agreement
        t["doubtful_times_b"] = _times_b(fit.doubtful_share, fit.shape), 1.0
        t["latest_times_b"] = [_times_b(share, fit.shape) for share in (fit.latest_lateral, fit.latest_longitudinal)]
        t["hysteresis"], t["fewest_points"] = fit.hysteresis, fit.fewest_points
        t["lowest_r_squared"], t["largest_straightness"] = fit.lowest_r_squared, fit.straightness
        t["low_d"], t["high_d"] = fit.lowest_limit, fit.highest_limit
        t["low_b"] = fit.lowest_stiffness_lateral, fit.lowest_stiffness_longitudinal
        t["high_b"] = fit.highest_stiffness_lateral, fit.highest_stiffness_longitudinal
        t["outside_solver"] = fit.optimiser == "slsqp"

    def _fill_grade(self, grade: GradeSettings, sample_time_s: float) -> None:
        t = self._tuning[0]
        t["grade"] = self.grade
        t["block_ticks"] = max(round(grade.block_time / sample_time_s), 1)
        t["pitch_compensation"] = grade.pitch_compensation
        t["grade_model"] = VIRTUAL if grade.model_acceleration == "virtual" else INERTIAL
        t["largest_grade"], t["standstill_time"] = grade.largest_grade, grade.standstill_time


def _times_b(share: float, shape: float) -> float:
    """B x at which a curve reaches a share of its peak."""
    return math.tan(math.asin(share) / shape)


def _weight(step_s: float, time_constant_s: float) -> float:
    return 1.0 if time_constant_s <= 0.0 else step_s / (step_s + time_constant_s)
