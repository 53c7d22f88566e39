"""Longitudinal sliding-mode observers, one for each wheel, and the speed of the car (3.5), compiled."""

import math
from typing import Any

from numba import njit

from estimators.vehicle_state_car import GRAVITY
from estimators.vehicle_state_model import air_drag, rolling_coefficient, slip, wheel_speeds

LARGEST_OMEGA = 200.0
LARGEST_SPEED = 100.0
LARGEST_ERROR_RATE = 50.0
_SHORTEST_ROLL = 0.3


@njit(cache=True)
def surface(error: float, error_rate: float, t: Any) -> float:
    """Sliding surface c_1 D + c_2 dD/dt with D = model - measured (l. 3045)."""
    return t.surface_error * error + t.surface_rate * error_rate


@njit(cache=True)
def adapt_slope(slope: float, slope_rate: float, error: float, sigma: float, dt: float, t: Any) -> tuple[float, float]:
    """Slope k_x of a wheel and its rate after a step of the two integrators (listing B), or of the single one.

    Parameters
    ----------
    error : rad/s
        Model less measured; where an integrator is at its end and the error pushes outward, it is held.
    sigma : float
        Sign of the sliding surface, already turned for negative slip.
    """
    largest = t.largest_slope
    if t.integrators == 1:
        return min(max(slope + t.gain * sigma * dt, 0.0), largest), 0.0
    end = largest / t.slew_time
    rate = slope_rate + t.gain * sigma * dt
    if abs(rate) <= end:
        slope_rate = rate
    elif rate * error <= 0.0:
        slope_rate = min(max(rate, -end), end)
    moved = slope + slope_rate * dt
    if moved < 0.0 or moved > largest:
        # held at its end; the rate must not go on winding up outward
        slope_rate = 0.0
        return min(max(moved, 0.0), largest), slope_rate
    return moved, slope_rate


@njit(cache=True)
def turn_wheel(
    omega: float, torque: float, force_slope: float, v_kx: float, load: float, i: int, dt: float, car: Any
) -> float:
    """Speed of a wheel after a step, linearly implicit in it (2.5): stable where an explicit step is not.

    Parameters
    ----------
    torque : N m
        Drive less brake.
    force_slope : N
        R_z k_x, longitudinal force over slip.
    """
    radius = car.r[i]
    rolling = load * rolling_coefficient(v_kx, car) * radius if omega > 0.0 else 0.0
    stiffness = force_slope * radius * radius / v_kx
    momentum = car.j_k[i] * omega + dt * (torque + force_slope * radius - rolling)
    return min(max(momentum / (car.j_k[i] + dt * stiffness), 0.0), LARGEST_OMEGA)


@njit(cache=True)
def _compare(s: Any, t: Any, i: int) -> tuple[float, float]:
    """Error of the wheel's model against the measured speed brought forward to now, and sigma.

    Both are turned for negative slip, where a larger slope speeds the wheel up instead of slowing it.
    """
    measured = s.measured[i] + s.measured_rate[i] * s.measured_age[i]
    error = s.omega[i] - measured
    rate = (error - s.error[i]) / t.dt
    s.error_rate[i] = min(max(rate, -LARGEST_ERROR_RATE), LARGEST_ERROR_RATE)
    s.error[i] = error
    value = surface(error, s.error_rate[i], t)
    if t.layer > 0.0:
        sigma = min(max(value / t.layer, -1.0), 1.0)
    else:
        sigma = 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0
    if t.reversal == 1 and s.slip[i] < 0.0:
        return -error, -sigma
    return error, sigma


@njit(cache=True)
def rest_longitudinal(s: Any, t: Any) -> None:
    """Below the speed gate: wheels as measured, speed of the odometer, no forces (l. 6170-6247)."""
    s.longitudinal_runs = 0
    s.running_time = 0.0
    s.v_x = s.odometer
    s.a_x, s.dv_x = 0.0, 0.0
    for i in range(4):
        s.omega[i] = s.measured[i]
        s.slip[i], s.force_x[i] = 0.0, 0.0
        s.error[i], s.error_rate[i] = 0.0, 0.0


@njit(cache=True)
def longitudinal_step(s: Any, car: Any, t: Any) -> None:
    """Advance wheels, slopes and speed by a tick; torques, loads, v_y and w_z are those of now."""
    dt = t.dt
    force = 0.0
    for i in range(4):
        v_kx = max(wheel_speeds(s.v_x, s.v_y, s.w_z, car, i)[0], _SHORTEST_ROLL)
        error, sigma = _compare(s, t, i)
        if abs(s.slip[i]) >= t.smallest_slip:
            s.slope[i], s.slope_rate[i] = adapt_slope(s.slope[i], s.slope_rate[i], error, sigma, dt, t)
        s.omega[i] = turn_wheel(s.omega[i], s.torque[i], s.load[i] * s.slope[i], v_kx, s.load[i], i, dt, car)
        s.slip[i] = slip(v_kx, s.omega[i], car.r[i])
        s.force_x[i] = s.load[i] * s.slope[i] * s.slip[i]
        cosine, sine = math.cos(s.theta[i]), math.sin(s.theta[i])
        force += s.force_x[i] * cosine - s.force_y[i] * sine
    s.a_x = (force - air_drag(s.v_x, car)) / car.m - GRAVITY * math.sin(s.theta_r)
    anchor = 0.0 if s.braking == 1 and t.brakes == 0 else t.anchor
    s.dv_x = s.a_x + s.w_z * s.v_y + anchor * (s.odometer - s.v_x)
    s.v_x = min(max(s.v_x + dt * s.dv_x, 0.0), LARGEST_SPEED)
    s.longitudinal_runs = 1
    s.running_time += dt
