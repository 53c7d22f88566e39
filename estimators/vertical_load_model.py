"""Single-track car with a roll axis, and the loads that follow from it, compiled (vertical-load document, section 2).

States: lateral speed [m/s], yaw rate [rad/s], roll angle [rad] (positive where the left side lifts), roll rate [rad/s].
Measured: lateral acceleration, yaw rate, roll rate. Input: road-wheel angle [rad].
"""

from typing import Any

from numba import njit

from estimators.kalman.covariance import FloatArray

STATES, MEASURED = 4, 3
LATERAL_SPEED, YAW_RATE, ROLL, ROLL_RATE = range(STATES)
_SCALINGS, _TERMS = 6, 9
"""Squarings and terms of the exponential: below 1e-15 relative for every car above 1 m/s at 100 ms."""


@njit(cache=True)
def continuous(car: Any, speed: float, a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> None:
    """Matrices of (8) and (16) at a speed [m/s].

    Parameters
    ----------
    car : record of ``LOAD_CAR``
    a, b, c, d : arrays, shapes (4, 4), (4,), (3, 4), (3,)
        Filled. A car whose accelerometer rolls with the body has g in ``c[0, 2]`` (finding F7).
    """
    front, rear = 2.0 * car.stiffness[0], 2.0 * car.stiffness[1]
    coupling = (car.to_rear * rear - car.to_front * front) / car.mass
    a[:] = 0.0
    b[:] = 0.0
    c[:] = 0.0
    d[:] = 0.0
    c[0, LATERAL_SPEED] = -(front + rear) / (car.mass * speed)
    c[0, YAW_RATE] = coupling / speed
    d[0] = front / car.mass
    # ay = vy' + V r (2)
    a[0, LATERAL_SPEED], a[0, YAW_RATE], b[0] = c[0, 0], c[0, 1] - speed, d[0]
    a[1, LATERAL_SPEED] = (car.to_rear * rear - car.to_front * front) / (car.yaw_inertia * speed)
    a[1, YAW_RATE] = -(car.to_rear**2 * rear + car.to_front**2 * front) / (car.yaw_inertia * speed)
    b[1] = car.to_front * front / car.yaw_inertia
    # the body leans outwards (10c); its own mass, not the whole car's, in the gravity term
    lever = car.sprung_mass * car.roll_arm / car.roll_inertia
    a[2, ROLL_RATE] = 1.0
    a[3, LATERAL_SPEED], a[3, YAW_RATE], b[3] = lever * c[0, 0], lever * c[0, 1], lever * d[0]
    a[3, ROLL] = (9.81 * car.sprung_mass * car.roll_arm - car.roll_stiffness) / car.roll_inertia
    a[3, ROLL_RATE] = -car.roll_damping / car.roll_inertia
    c[0, ROLL] = car.gravity_in_acceleration
    c[1, YAW_RATE] = 1.0
    c[2, ROLL_RATE] = 1.0


@njit(cache=True)
def discretise(a: FloatArray, b: FloatArray, step: float, phi: FloatArray, gamma: FloatArray, work: FloatArray) -> None:
    """Exact zero-order hold (2.7): exponential of the augmented matrix by scaling and squaring.

    Parameters
    ----------
    a, b : arrays, shapes (4, 4) and (4,)
    step : s
    phi, gamma : arrays, shapes (4, 4) and (4,)
        Filled.
    work : array, shape (4, 5, 5)
        Scratch.
    """
    n = STATES + 1
    scaled, term, total = work[0], work[1], work[2]
    factor = step / 2.0**_SCALINGS
    scaled[:] = 0.0
    for i in range(STATES):
        for j in range(STATES):
            scaled[i, j] = a[i, j] * factor
        scaled[i, STATES] = b[i] * factor
    for i in range(n):
        for j in range(n):
            term[i, j] = 1.0 if i == j else 0.0
            total[i, j] = term[i, j]
    for k in range(1, _TERMS + 1):
        _multiply(term, scaled, 1.0 / k, work[3, 0])
        for i in range(n):
            for j in range(n):
                total[i, j] += term[i, j]
    for _ in range(_SCALINGS):
        for i in range(n):
            for j in range(n):
                scaled[i, j] = total[i, j]
        _multiply(total, scaled, 1.0, work[3, 0])
    for i in range(STATES):
        for j in range(STATES):
            phi[i, j] = total[i, j]
        gamma[i] = total[i, STATES]


@njit(cache=True)
def _multiply(left: FloatArray, right: FloatArray, factor: float, row: FloatArray) -> None:
    """``left <- factor left right``, a row at a time in ``row``."""
    n = left.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += left[i, k] * right[k, j]
            row[j] = factor * total
        for j in range(n):
            left[i, j] = row[j]


@njit(cache=True)
def lateral_transfer_row(car: Any, axle: int, c: FloatArray, damped: bool, row: FloatArray) -> None:
    """Derivative by the states of half the load difference right minus left of an axle (11c, 12c)."""
    other = car.to_rear if axle == 0 else car.to_front
    side = car.mass * other / (car.to_front + car.to_rear) * car.roll_centre
    for i in range(STATES):
        row[i] = side * c[0, i]
    # the accelerometer's share of gravity is no side force
    row[ROLL] -= side * car.gravity_in_acceleration
    row[ROLL] += car.roll_share[axle] * car.roll_stiffness
    if damped:
        row[ROLL_RATE] += car.roll_share[axle] * car.roll_damping
    for i in range(STATES):
        row[i] /= car.track


@njit(cache=True)
def wheel_loads(
    car: Any, acceleration_x: float, acceleration_y: float, roll: float, roll_rate: float, damped: bool, out: FloatArray
) -> None:
    """Loads of the wheels fl fr rl rr [N], clipped at zero (15c), with (14c) and (11c) or, undamped, (12c).

    Parameters
    ----------
    acceleration_x, acceleration_y : m/s^2
        In the plane of the road.
    roll, roll_rate : rad, rad/s
    damped : bool
        Whether the dampers' moment is counted.
    out : array, shape (4,)
    """
    wheelbase = car.to_front + car.to_rear
    along = car.mass * acceleration_x * car.height / wheelbase
    moment = car.roll_stiffness * roll
    if damped:
        moment += car.roll_damping * roll_rate
    for axle in range(2):
        other = car.to_rear if axle == 0 else car.to_front
        side_force = car.mass * acceleration_y * other / wheelbase
        difference = 2.0 / car.track * (side_force * car.roll_centre + car.roll_share[axle] * moment)
        both = car.static_load[axle] + (-along if axle == 0 else along)
        out[2 * axle] = max(0.0, 0.5 * (both - difference))
        out[2 * axle + 1] = max(0.0, 0.5 * (both + difference))
