"""Wheels of the replay: steering with its compliance, slip with relaxation, tyre force, spin; compiled.

The spin is linearly implicit in the slope of the tyre force, so that steps of 2 ms are stable down to walking speed;
friction of brake and rolling is set-valued, a braked wheel stands still.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.brake_step import brake_capacity
from model_diagnosis.replay.chassis_step import static_load, wheel_x, wheel_y
from model_diagnosis.replay.record import INPUT_DRIVE_FRONT, INPUT_DRIVE_REAR, INPUT_STEER, Record
from model_diagnosis.replay.state import (
    ALIGNING,
    ANGLE,
    BRAKE_TORQUE,
    DISTANCE,
    LAGGED_X,
    LAGGED_Y,
    LATERAL_SPEED,
    LOAD,
    PITCH_RATE,
    ROLL_RATE,
    SLIP_X,
    SLIP_Y,
    SPEED,
    SPIN,
    SPIN_RATE,
    TYRE_HEAT,
    TYRE_X,
    TYRE_Y,
    YAW_RATE,
)
from model_diagnosis.replay.tyre_step import load_share, road_friction, tyre_forces

_SLOWEST_M_S = 0.5
"""Least divisor of slips: the replay is compared above walking speed only."""
_LIGHTEST_N = 1.0
_PRELOAD_SPAN_RAD_S = 0.5
_COASTING_NM = 1.0
_TREAD_HEAT_J_K = 5400.0
_TREAD_COOLING_1_S = 1.0 / 60.0


@njit(cache=True, nogil=True)
def steer_wheels(p: Record, wheels: NDArray[np.float64], inputs: NDArray[np.float64], step: float) -> None:
    """Angles of the road wheels: linkage, compliance under the aligning moment, toe."""
    angle = inputs[INPUT_STEER] * p.steering_scale
    for i in range(2):
        wanted = angle
        if p.ackermann != 0.0:
            side = -1.0 if i == 0 else 1.0
            tangent = math.tan(angle)
            full = math.atan2(tangent, 1.0 + side * tangent * p.track_front / (2.0 * p.wheelbase))
            wanted += p.ackermann * (full - angle)
        wanted += p.steering_offset + wheels[ALIGNING, i] / p.steering_stiffness + p.toe[i]
        lag = p.steering_damping / p.steering_stiffness
        wheels[ANGLE, i] = (lag * wheels[ANGLE, i] + step * wanted) / (lag + step)
    wheels[ANGLE, 2], wheels[ANGLE, 3] = p.toe[2], p.toe[3]


@njit(cache=True, nogil=True)
def drive_torque(p: Record, wheels: NDArray[np.float64], inputs: NDArray[np.float64], i: int) -> float:
    """Drive torque of a wheel: half the axle's, losses of the driveline, and what the differential hands across."""
    axle = inputs[INPUT_DRIVE_FRONT] if i < 2 else inputs[INPUT_DRIVE_REAR]
    torque = 0.5 * axle
    if p.drive_share[i] == 0.0:
        return torque
    omega = wheels[SPIN, i]
    turning = min(max(omega, -1.0), 1.0)
    torque -= p.drive_share[i] * (p.driveline_drag * turning + p.driveline_viscous * omega)
    if p.engine_drag != 0.0 and inputs[INPUT_DRIVE_FRONT] + inputs[INPUT_DRIVE_REAR] <= _COASTING_NM:
        torque -= p.drive_share[i] * p.engine_drag * turning
    if p.locking_preload != 0.0 or p.locking_viscous != 0.0:
        slower = wheels[SPIN, i ^ 1] - omega
        torque += p.locking_preload * math.tanh(slower / _PRELOAD_SPAN_RAD_S) + p.locking_viscous * slower
    return torque


@njit(cache=True, nogil=True)
def move_wheel(
    p: Record,
    tables: NDArray[np.float64],
    body: NDArray[np.float64],
    wheels: NDArray[np.float64],
    inputs: NDArray[np.float64],
    i: int,
    step: float,
) -> None:
    """One step of a wheel: its tyre forces and its spin.

    ``tables`` has shape (axle, direction, cells + 1, 2).
    """
    load = max(wheels[LOAD, i], _LIGHTEST_N)
    turn, omega = body[YAW_RATE], wheels[SPIN, i]
    at_x = body[SPEED] - turn * wheel_y(p, i) - p.height * body[PITCH_RATE]
    at_y = body[LATERAL_SPEED] + turn * wheel_x(p, i) + p.height * body[ROLL_RATE]
    sine, cosine = math.sin(wheels[ANGLE, i]), math.cos(wheels[ANGLE, i])
    v_x, v_y = cosine * at_x + sine * at_y, cosine * at_y - sine * at_x
    radius = p.radius[i] - p.radius_load * (load - static_load(p, i)) + p.radius_speed * v_x * v_x

    roll = radius * omega
    slide_x = roll - v_x
    divisor = max(max(abs(v_x), abs(v_y)), max(abs(roll), _SLOWEST_M_S))
    slip_slope = radius * v_x / (divisor * roll) if roll >= divisor and v_x > 0.0 else radius / divisor
    weight_x, weight_y = p.relaxation_x[i] + step * divisor, p.relaxation_y[i] + step * divisor
    slip_x = (p.relaxation_x[i] * wheels[LAGGED_X, i] + step * slide_x) / weight_x
    slip_y = (p.relaxation_y[i] * wheels[LAGGED_Y, i] - step * v_y) / weight_y
    slip_slope *= step * divisor / weight_x
    wheels[LAGGED_X, i], wheels[LAGGED_Y, i] = slip_x, slip_y
    wheels[SLIP_X, i], wheels[SLIP_Y, i] = slide_x / divisor, -v_y / divisor

    friction = road_friction(p, i, body[DISTANCE], abs(v_x), wheels[TYRE_HEAT, i])
    share_x = load_share(p.load_loss_x[i], load, p.reference_load[i])
    share_y = load_share(p.load_loss_y[i], load, p.reference_load[i])
    stiff = 1.0
    if p.friction_stiffens[i] != 1.0 and friction != 1.0:
        stiff = friction ** (1.0 - p.friction_stiffens[i])
    peak_slip_x = p.peak_slip_x[i] * stiff * share_x / load_share(p.stiffness_loss_x[i], load, p.reference_load[i])
    peak_slip_y = p.peak_slip_y[i] * stiff * share_y / load_share(p.stiffness_loss_y[i], load, p.reference_load[i])
    axle = i // 2
    force_x, force_y, slope, relative = tyre_forces(
        tables[axle, 0],
        tables[axle, 1],
        slip_x,
        slip_y,
        peak_slip_x * (1.0 + p.peak_shift) / p.longitudinal_stiffness[i],
        peak_slip_y * (1.0 + p.peak_shift) / p.cornering_stiffness[i],
        p.peak_x[i] * friction * share_x * load,
        p.peak_y[i] * friction * share_y * load,
    )
    force_y += p.camber_stiffness * p.camber_angle * load + p.conicity
    slope = max(slope * slip_slope, 0.0)
    force_x = _spin(p, body, wheels, inputs, i, step, load, radius, force_x, slope)
    wheels[TYRE_X, i], wheels[TYRE_Y, i] = force_x, force_y
    wheels[ALIGNING, i] = -p.trail[i] * max(1.0 - relative, 0.0) * force_y
    sliding = math.sqrt(slide_x * slide_x + v_y * v_y)
    heat = abs(force_x * slide_x) + abs(force_y * v_y) if sliding > 0.0 else 0.0
    wheels[TYRE_HEAT, i] += step * (0.5 * heat / _TREAD_HEAT_J_K - wheels[TYRE_HEAT, i] * _TREAD_COOLING_1_S)


@njit(cache=True, nogil=True)
def _spin(
    p: Record,
    body: NDArray[np.float64],
    wheels: NDArray[np.float64],
    inputs: NDArray[np.float64],
    i: int,
    step: float,
    load: float,
    radius: float,
    force_x: float,
    slope: float,
) -> float:
    """One step of a wheel's spin; the mean tyre force over it."""
    omega, speed = wheels[SPIN, i], body[SPEED]
    brake = brake_capacity(p, body, wheels, i, inputs[i], step)
    share = 1.0 + p.rolling_speed * speed + p.rolling_speed_4 * speed**4
    capacity = brake + p.rolling_resistance[i] * share * load * radius
    inertia = p.spin_inertia[i]
    torque = drive_torque(p, wheels, inputs, i) - force_x * radius
    momentum = inertia * omega + step * torque + step * radius * slope * omega
    if abs(momentum) <= step * capacity:
        new, friction = 0.0, abs(momentum) / step
    else:
        friction = capacity
        new = (momentum - math.copysign(step * capacity, momentum)) / (inertia + step * radius * slope)
    wheels[SPIN, i], wheels[SPIN_RATE, i] = new, (new - omega) / step
    wheels[BRAKE_TORQUE, i] = friction * (brake / capacity if capacity > 0.0 else 0.0)
    return force_x + slope * (new - omega)
