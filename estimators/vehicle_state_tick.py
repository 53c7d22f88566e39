"""One tick of the vehicle-state observers in the order of the document's 3.7, compiled.

Which of the four work is told by the tuning: the lateral filter, the wheels' sliding-mode observers, the fits of the
friction curves, the grade observer. What does not work keeps its neutral value: no grade, no lateral motion but the
measured yaw rate, the speed of the odometer.
"""

import math
from typing import Any, NamedTuple

from numba import njit

from estimators.inputs import FRESH, INPUTS_LOST, VALUE, accept_inputs
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.magic_formula_fit_step import forget_curve, observe_pair
from estimators.road_grade_step import accumulate_grade, follow_pitch, stand_on_grade
from estimators.vehicle_state_axes import BENCH_INDEX, mirrored
from estimators.vehicle_state_car import GRAVITY
from estimators.vehicle_state_lateral import lateral_step, rest_lateral, start_lateral
from estimators.vehicle_state_model import (
    air_drag,
    axle_torque,
    road_wheel_angle,
    rolling_coefficient,
    rolling_loads,
    slip,
    wheel_speeds,
)
from estimators.vehicle_state_record import CURVES
from estimators.wheel_sliding_mode_step import longitudinal_step, rest_longitudinal
from estimators.wheel_speed_sensor import sample_delay

# rows of the input guard
(
    IN_A_X,
    IN_WHEEL,
    IN_A_Y,
    IN_YAW_RATE,
    IN_STEERING,
    IN_ENGINE_TORQUE,
    IN_ENGINE_SPEED,
    IN_GEAR,
    IN_DRIVE_F,
    IN_DRIVE_R,
    IN_BRAKE_SWITCH,
) = (0, 1, 5, 6, 7, 8, 9, 10, 11, 12, 13)
IN_PRESSURE = 14

_STANDING = 0.1
_FIRST_FRAMES = 0.05
TREND = 3.0
"""Time constant of the low-pass that tells the lag of the longitudinal pairs, over the pairs' own."""
_LONGEST_EXTRAPOLATION = 0.02
_LONGEST_DELAY = 0.1
"""Of a wheel speed [s]: a ring of 48 teeth is that late below 0.5 m/s, where nothing runs; one near 0 tells none."""
_FASTEST_STEERING = 25.0


class ObserverParts(NamedTuple):
    """What a compiled tick works on, in place."""

    state: Any
    curves: Any
    memory: Any
    pairs: FloatArray
    scratch: FloatArray
    log: FloatArray
    logged: FloatArray
    car: Any
    steering: FloatArray
    tuning: Any
    guard: FloatArray
    positions: IntArray


@njit(cache=True)
def forget_state(s: Any, curves: Any, m: Any, car: Any, t: Any) -> None:
    """State of observers that have seen nothing; the counts of resets and fits stay."""
    s.started, s.moving, s.lateral_runs, s.longitudinal_runs = 0, 0, 0, 0
    s.v_x = s.v_y = s.w_z = s.a_x = s.a_y = s.dv_x = s.odometer = 0.0
    s.pitch = s.pitch_rate = s.theta_r = s.theta_with_pitch = 0.0
    s.grade_sum = s.grade_squares = s.grade_variance = 0.0
    s.grade_count = s.grade_known = 0
    s.standing_time = s.gyro_offset = s.stuck_time = s.sum_y = s.sum_yaw = 0.0
    s.rejected_y = 0
    s.running_time = 0.0
    s.engine_acceleration, s.engine_age, s.engine_speed = 0.0, 0.0, -1.0
    for i in range(4):
        s.omega[i] = s.measured[i] = s.measured_rate[i] = s.measured_age[i] = 0.0
        s.error[i] = s.error_rate[i] = s.slope_rate[i] = s.slip[i] = s.torque[i] = 0.0
        s.force_x[i] = s.force_y[i] = s.theta[i] = s.alpha[i] = 0.0
        s.slope[i] = t.initial_slope_x
        s.sum_slip[i] = s.sum_used[i] = s.wheel_friction[i] = 0.0
        s.pair_slip[i] = s.pair_used[i] = s.pair_trend[i] = 0.0
    for k in range(CURVES):
        forget_curve(curves[k], t, k // 4)
    start_lateral(m.x, m.covariance, s, t, 0.0)
    _load_wheels(s, car)


@njit(cache=True)
def _load_wheels(s: Any, car: Any) -> None:
    rolling = car.m * GRAVITY * math.cos(s.theta_r) * rolling_coefficient(s.v_x, car) * 0.5 * (car.r[0] + car.r[2])
    rolling = rolling if s.v_x > _STANDING else 0.0
    rolling_loads(s.a_x, s.roll, s.roll_rate, s.theta_r, air_drag(s.v_x, car), rolling, car, s.load)


@njit(cache=True)
def _towing_slip(s: Any, car: Any, t: Any, i: int) -> float:
    """Slip at which the road turns a free wheel against its rolling resistance: R_z k_x s = R_z f (2.5).

    Small as it is, it is a tenth of the slip at which a driven wheel on ice starts to bend its curve. The slope of a
    wheel that hardly slips is not observed: a smaller one than at the start does not count.
    """
    if t.towing_slip == 0:
        return 0.0
    return rolling_coefficient(s.v_x, car) / max(s.slope[i], t.initial_slope_x)


@njit(cache=True)
def _wheel_delay(s: Any, t: Any, i: int) -> float:
    """Age of a wheel speed when it is sampled [s]: it is the mean over a window of the tone ring's edges.

    Some milliseconds, by which slip would lag behind friction: what the car gains in them is a thirtieth of the slip of
    a launch on ice.
    """
    return min(sample_delay(s.measured[i], t.teeth, t.window), _LONGEST_DELAY)


@njit(cache=True)
def _read_wheels(s: Any, guard: FloatArray, car: Any, t: Any) -> None:
    """Wheel speeds in the document's order, their rates, and the odometer of the wheels that no engine drives."""
    for i in range(4):
        row = IN_WHEEL + BENCH_INDEX[i]
        value = guard[row, VALUE]
        s.measured_age[i] += t.dt
        if s.started == 0:
            s.measured[i], s.measured_rate[i], s.measured_age[i] = value, 0.0, 0.0
        elif guard[row, FRESH] > 0.0:
            since = max(s.measured_age[i], t.dt)
            rate = (value - s.measured[i]) / since
            # half of the old rate: the difference of two samples is mostly noise
            s.measured_rate[i] += 0.5 * (rate - s.measured_rate[i])
            s.measured[i], s.measured_age[i] = value, 0.0
        if s.measured_age[i] > _LONGEST_EXTRAPOLATION:
            s.measured_rate[i] = 0.0
    total = share = 0.0
    for i in range(4):
        if t.anchor_rows[i] > 0.0:
            measured = s.measured[i] + s.measured_rate[i] * s.measured_age[i]
            along = car.r[i] * measured * (1.0 + _towing_slip(s, car, t, i)) + s.dv_x * _wheel_delay(s, t, i)
            total += t.anchor_rows[i] * (along - wheel_speeds(0.0, 0.0, s.w_z, car, i)[0])
            share += t.anchor_rows[i]
    s.odometer = max(total / share, 0.0)


@njit(cache=True)
def _steering_now(s: Any, value: float, t: Any) -> float:
    """Steering-wheel angle brought forward from its frame to now [rad].

    One age stands for two frames: an angle that changed is a new one, one that stays for longer than a frame rests.
    """
    if s.started == 0:
        s.steering, s.steering_rate, s.steering_age = value, 0.0, 0.0
        return value
    s.steering_age += t.dt
    if value != s.steering:
        s.steering_rate = (value - s.steering) / s.steering_age
        s.steering, s.steering_age = value, 0.0
    elif s.steering_age > _LONGEST_EXTRAPOLATION:
        s.steering_rate = 0.0
    rate = min(max(s.steering_rate, -_FASTEST_STEERING), _FASTEST_STEERING)
    return s.steering + rate * s.steering_age


@njit(cache=True)
def _read_torques(s: Any, guard: FloatArray, car: Any, t: Any) -> None:
    """Torque fed to each wheel (2.5): from engine and gear, or as the powertrain reports it; less the brakes'."""
    s.engine_age += t.dt
    speed = guard[IN_ENGINE_SPEED, VALUE]
    if s.engine_speed < 0.0:
        s.engine_speed, s.engine_age = speed, 0.0
    elif speed != s.engine_speed or s.engine_age > _LONGEST_EXTRAPOLATION:
        # one age stands for two frames of the powertrain: a value that changed is a new one
        rate = (speed - s.engine_speed) / max(s.engine_age, t.dt)
        s.engine_acceleration += t.engine_weight * (rate - s.engine_acceleration)
        s.engine_speed, s.engine_age = speed, 0.0
    if t.engine_torque_path == 1:
        gear = int(guard[IN_GEAR, VALUE])
        torque = axle_torque(guard[IN_ENGINE_TORQUE, VALUE], s.engine_acceleration, gear, car)
        for i in range(4):
            s.torque[i] = car.driven[i] * torque
    else:
        for i in range(4):
            s.torque[i] = 0.5 * guard[IN_DRIVE_F if i < 2 else IN_DRIVE_R, VALUE]
    if t.brakes == 1:
        for i in range(4):
            pressure = max(guard[IN_PRESSURE + BENCH_INDEX[i], VALUE], 0.0)
            if s.omega[i] > 0.0:
                s.torque[i] -= car.brake_gain[i] * pressure


@njit(cache=True)
def _judge_lateral_accelerometer(s: Any, t: Any, value: float) -> None:
    """Reject an accelerometer that has stopped changing while speed and yaw rate tell of another value (5.2)."""
    if value != s.stuck_value:
        s.stuck_value, s.stuck_time = value, 0.0
    else:
        s.stuck_time += t.dt
    differs = abs(value - s.v_x * s.w_z) > t.stuck_difference
    if s.stuck_time < t.stuck_after:
        s.rejected_y = 0
    elif differs:
        s.rejected_y = 1


@njit(cache=True)
def _lateral(m: Any, s: Any, curves: Any, car: Any, t: Any, yaw_rate: float, side: float, step_due: bool) -> bool:
    s.sum_y += side
    s.sum_yaw += yaw_rate
    if not step_due:
        return True
    # means over the step: a frame comes more often than a step
    measured, yaw_rate = s.sum_y / t.lateral_ticks, s.sum_yaw / t.lateral_ticks
    s.sum_y = s.sum_yaw = 0.0
    if s.v_x < t.gate_y:
        rest_lateral(m.x, s, measured, yaw_rate)
        return True
    if t.roll_compensation == 1:
        # an accelerometer that leans with the body feels a part of gravity
        measured -= GRAVITY * math.sin(s.roll)
    return lateral_step(m, s, curves, car, t, yaw_rate, measured)


@njit(cache=True)
def _measured_slip(s: Any, car: Any, t: Any, i: int) -> float:
    """Slip of a wheel from its measured speed, brought forward as the car's speed changes.

    The slip of the wheel's model lags: it follows the slope, which the sign law moves at a limited rate, while the
    friction in use follows the torque at once. Together they would lie beside the curve, on a straighter one.
    """
    v_kx = wheel_speeds(s.v_x, s.v_y, s.w_z, car, i)[0]
    if v_kx <= 0.0:
        return 0.0
    late = min(s.measured_age[i], _LONGEST_EXTRAPOLATION) + _wheel_delay(s, t, i)
    omega = s.measured[i] + s.dv_x / car.r[i] * late
    return slip(v_kx, omega, car.r[i])


@njit(cache=True)
def _slip_of_now(s: Any, i: int) -> float:
    """Magnitude of a wheel's slip without the lag of the pairs' low-pass, which a slower one behind it tells.

    A slip that grows steadily is behind by its rate times the time constant: on ice a tenth of the threshold.
    """
    return abs(s.pair_slip[i] + (s.pair_slip[i] - s.pair_trend[i]) / TREND)


@njit(cache=True)
def _gather_pairs(parts: ObserverParts, step_due: bool) -> None:
    """Slip and friction of every wheel and direction for the fits, once per step of the lateral filter."""
    s, car, t, curves, pairs = parts.state[0], parts.car[0], parts.tuning[0], parts.curves, parts.pairs
    for i in range(4):
        s.sum_slip[i] += _measured_slip(s, car, t, i) if t.measured_slip == 1 else s.slip[i]
        s.sum_used[i] += s.slope[i] * s.slip[i]
    if not step_due:
        return
    for i in range(4):
        mean_slip, mean_used = s.sum_slip[i] / t.lateral_ticks, s.sum_used[i] / t.lateral_ticks
        s.sum_slip[i], s.sum_used[i] = 0.0, 0.0
        s.pair_slip[i] += t.pair_weight * (mean_slip - s.pair_slip[i])
        s.pair_used[i] += t.pair_weight * (mean_used - s.pair_used[i])
        s.pair_trend[i] += t.trend_weight * (s.pair_slip[i] - s.pair_trend[i])
        if s.lateral_runs == 1 and s.rejected_y == 0:
            observe_pair(
                curves[i], pairs[i, 0], pairs[i, 1], parts.scratch, parts.log, parts.logged, i, s.filtered_alpha[i],
                s.wheel_friction[i], abs(s.alpha[i]), s.time, t,
            )  # fmt: skip
        if s.running_time >= t.settling_time and s.longitudinal_runs == 1 and s.braking == 0:
            observe_pair(
                curves[4 + i], pairs[4 + i, 0], pairs[4 + i, 1], parts.scratch, parts.log, parts.logged, 4 + i,
                s.pair_slip[i], s.pair_used[i], _slip_of_now(s, i), s.time, t,
            )  # fmt: skip


@njit(cache=True)
def _stand(s: Any, t: Any, guard: FloatArray) -> None:
    """Standing car: offset of the gyroscope, grade from the accelerometer."""
    fastest = 0.0
    for i in range(4):
        fastest = max(fastest, abs(s.measured[i]))
    if fastest > _STANDING:
        s.standing_time = 0.0
        return
    s.standing_time += t.dt
    if s.standing_time >= t.standstill_time:
        s.gyro_offset += t.gyro_weight * (guard[IN_YAW_RATE, VALUE] - s.gyro_offset)
    if t.grade == 1:
        stand_on_grade(s, t, guard[IN_A_X, VALUE])


@njit(cache=True)
def observe(parts: ObserverParts, inputs: FloatArray, ages: FloatArray) -> bool:
    """Advance all observers that work by a tick; False while they cannot."""
    s, car, t, m = parts.state[0], parts.car[0], parts.tuning[0], parts.memory
    curves, guard = parts.curves, parts.guard
    s.time += t.dt
    s.verdict = accept_inputs(guard, parts.positions, inputs, ages, t.dt)
    if s.verdict == INPUTS_LOST:
        if s.started == 1:
            forget_state(s, curves, m, car, t)
            s.resets += 1
        return False
    s.braking = 1 if guard[IN_BRAKE_SWITCH, VALUE] > 0.5 else 0
    yaw_rate = mirrored(guard[IN_YAW_RATE, VALUE] - s.gyro_offset)
    if s.started == 0 or t.lateral == 0:
        s.w_z = yaw_rate
    wheel_angle = _steering_now(s, guard[IN_STEERING, VALUE], t)
    s.theta[0] = mirrored(road_wheel_angle(wheel_angle, parts.steering, 2))
    s.theta[1] = mirrored(road_wheel_angle(wheel_angle, parts.steering, 1))
    _read_wheels(s, guard, car, t)
    _read_torques(s, guard, car, t)
    if s.started == 0:
        s.started, s.ticks, s.v_x = 1, 0, s.odometer
        for i in range(4):
            s.omega[i] = s.measured[i]
        start_lateral(m.x, m.covariance, s, t, yaw_rate)
    s.moving = 1 if s.odometer > t.gate_x else 0
    _stand(s, t, guard)
    _load_wheels(s, car)
    _longitudinal(s, car, t)
    s.ticks += 1
    step_due = s.ticks % t.lateral_ticks == 0
    if t.lateral == 1:
        side = mirrored(guard[IN_A_Y, VALUE])
        _judge_lateral_accelerometer(s, t, side)
        if not _lateral(m, s, curves, car, t, yaw_rate, side, step_due):
            forget_state(s, curves, m, car, t)
            s.resets += 1
            return False
    _gather_pairs(parts, step_due)
    if t.grade == 1 and s.moving == 1:
        follow_pitch(s, car, t)
        if s.braking == 0 or t.brakes == 1:
            accumulate_grade(s, t, guard[IN_A_X, VALUE])
    return True


@njit(cache=True)
def _longitudinal(s: Any, car: Any, t: Any) -> None:
    if t.longitudinal == 1 and s.moving == 1:
        if s.longitudinal_runs == 0 or s.running_time < _FIRST_FRAMES:
            # the frames of the wheels come one after the other: a mean with one that is still missing is no speed
            s.v_x = s.odometer
            for i in range(4):
                s.omega[i] = s.measured[i]
        longitudinal_step(s, car, t)
        return
    if t.longitudinal == 1:
        rest_longitudinal(s, t)
        return
    s.v_x = s.odometer
