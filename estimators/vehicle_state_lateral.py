"""Unscented filter of yaw and lateral motion, ten states (3.3), compiled.

State x = [v_y, w_z, k_y of the four wheels, mu_m of the four wheels], measurement the yaw rate and eight pseudo
measurements, so that h(x) = x[1:10].
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from estimators.kalman.covariance import FloatArray, IntArray, all_finite
from estimators.kalman.floored_covariance import floor_covariance
from estimators.kalman.sigma_points import correct_points, predict_points
from estimators.vehicle_state_car import GRAVITY
from estimators.vehicle_state_model import LEFT, magic_formula, roll_step, slip_angle
from estimators.vehicle_state_record import (
    CURVED,
    LATERAL_STATES,
    LIMIT,
    MEASUREMENTS,
    POINTS,
    SLOPE,
    V_Y,
    W_Z,
)

PREDICTED = 17
"""What the predictor gives for a state: the ten states, a_y, four slip angles, roll rate, roll."""

NODES = np.array([0.0, 3.0, 3.5, 4.0, 4.5, 5.0, 60.0])
"""|alpha| [deg] of the printed tables (l. 5574-5660)."""
PROCESS_TABLE = np.array([1e-8, 1e-7, 1e-4, 5e-3, 0.05, 0.05, 0.5])
NOISE_TABLE = np.array([1e8, 1e7, 0.1, 0.1, 0.05, 0.05, 0.05])

SMALLEST_SLOPE, LARGEST_SLOPE = 0.5, 60.0
SMALLEST_LIMIT, LARGEST_LIMIT = 0.03, 1.3
LARGEST_LATERAL_SPEED = 30.0
_SMALLEST_SHAPE = 1e-3


@njit(cache=True)
def table_value(degrees: float, table: FloatArray) -> float:
    """Linear interpolation in a printed table over |alpha| in degrees, going on straight beyond its ends."""
    k = 1
    while k < NODES.shape[0] - 1 and NODES[k] < degrees:
        k += 1
    share = (degrees - NODES[k - 1]) / (NODES[k] - NODES[k - 1])
    return (1.0 - share) * table[k - 1] + share * table[k]


@njit(cache=True)
def side_force(
    x: FloatArray, alpha: float, load: float, i: int, curved: bool, b: float, c: float, theta: float, t: Any
) -> float:
    """Side reaction R_ky of a wheel [N]: the linear law below the threshold, the curve above it."""
    if not curved:
        return load * x[SLOPE + i] * alpha
    force = load * magic_formula(alpha, b, c, x[LIMIT + i])
    # the listing projects the curve's forces here and once more in the sums (Annex B)
    return force * math.cos(theta) if t.double_projection == 1 else force


@njit(cache=True)
def lateral_speed_at_the_road(v_y: float, s: Any, t: Any) -> float:
    """Lateral speed below the centre of gravity, which sways to the left as the body leans there (``body_sway``)."""
    return v_y + t.sway * s.roll_rate


@njit(cache=True)
def predict_state(x: FloatArray, s: Any, curves: Any, car: Any, t: Any, dt: float, full: FloatArray) -> None:
    """Process model (l. 5327-5436): ``full`` (shape (17,)) receives the prediction of the state ``x``."""
    sum_y = moment = 0.0
    v_y = lateral_speed_at_the_road(x[V_Y], s, t)
    for i in range(4):
        alpha = slip_angle(s.v_x, v_y, x[W_Z], s.theta[i], car, i)
        curve = curves[i]
        force = side_force(x, alpha, s.load[i], i, curve.mode == CURVED, curve.b, t.curve_c, s.theta[i], t)
        along, across = math.cos(s.theta[i]), math.sin(s.theta[i])
        force_y = force * along + s.force_x[i] * across
        force_x = s.force_x[i] * along - force * across
        arm, track = (car.l_1, car.b_1) if i < 2 else (-car.l_2, car.b_2)
        sum_y += force_y
        moment += arm * force_y + LEFT[i] * 0.5 * track * force_x
        full[LATERAL_STATES + 1 + i] = alpha
    for k in range(LATERAL_STATES):
        full[k] = x[k]
    a_y = sum_y / car.m
    full[W_Z] = x[W_Z] + dt * moment / car.j_z
    # semi-implicit: the new yaw rate
    full[V_Y] = x[V_Y] + dt * (a_y - s.v_x * full[W_Z])
    roll, rate = roll_step(s.roll, s.roll_rate, sum_y, dt, car)
    full[LATERAL_STATES] = a_y
    full[LATERAL_STATES + 5], full[LATERAL_STATES + 6] = rate, roll


@njit(cache=True)
def start_lateral(x: FloatArray, covariance: FloatArray, s: Any, t: Any, w_z: float) -> None:
    """Start values; the document prints none (3.3)."""
    x[:] = 0.0
    covariance[:] = 0.0
    x[W_Z] = w_z
    for i in range(4):
        x[SLOPE + i], x[LIMIT + i] = t.initial_slope, t.initial_limit
        covariance[SLOPE + i, SLOPE + i] = t.initial_slope_variance
        covariance[LIMIT + i, LIMIT + i] = t.initial_limit_variance
        s.filtered_alpha[i] = 0.0
    covariance[V_Y, V_Y], covariance[W_Z, W_Z] = t.initial_v_y_variance, t.initial_w_z_variance
    s.roll, s.roll_rate = 0.0, 0.0
    s.yaw_before, s.yaw_acceleration, s.measured_y = w_z, 0.0, 0.0


@njit(cache=True)
def rest_lateral(x: FloatArray, s: Any, measured_y: float, measured_w: float) -> None:
    """Below the speed gate (l. 5333): no lateral speed, no slip angle, no roll; the other states are held."""
    s.lateral_runs = 0
    x[V_Y] = 0.0
    x[W_Z] = measured_w
    s.v_y, s.w_z, s.a_y = 0.0, measured_w, measured_y
    s.roll, s.roll_rate = 0.0, 0.0
    s.yaw_before, s.yaw_acceleration = measured_w, 0.0
    for i in range(4):
        s.alpha[i], s.filtered_alpha[i], s.force_y[i] = 0.0, 0.0, 0.0


@njit(cache=True)
def hand_over(x: FloatArray, covariance: FloatArray, curves: Any, t: Any) -> None:
    """Take the limit of a fit as the state's value, of a variance of its own (l. 5505-5534), by the event."""
    for i in range(4):
        curve = curves[i]
        if curve.handed_over == 0:
            continue
        curve.handed_over = 0
        if t.hand_over == 0:
            continue
        n = LIMIT + i
        x[n] = curve.d
        for k in range(LATERAL_STATES):
            covariance[n, k] = 0.0
            covariance[k, n] = 0.0
        covariance[n, n] = t.hand_over_variance


@njit(cache=True)
def wheel_accelerations(s: Any, measured_y: float, car: Any, t: Any) -> None:
    """Friction in use of each wheel from the accelerometer moved to it (l. 2816-2834), over g."""
    for i in range(4):
        arm = car.arm_1 if i < 2 else -car.arm_2
        value = measured_y + s.yaw_acceleration * arm
        if t.centripetal == 1:
            value += LEFT[i] * s.w_z * s.w_z * 0.5 * (car.b_1 if i < 2 else car.b_2)
        s.wheel_friction[i] = value / GRAVITY


@njit(cache=True)
def _fill_measurement(
    s: Any, curves: Any, t: Any, z: FloatArray, variances: FloatArray, rows: IntArray, noise: FloatArray
) -> None:
    """Pseudo measurements, their variances and the process noise of the limits, from the slip angles."""
    for i in range(4):
        alpha, used = s.filtered_alpha[i], s.wheel_friction[i]
        curve = curves[i]
        shape = math.sin(t.curve_c * math.atan(curve.b * alpha))
        good = abs(alpha) >= t.smallest_alpha and s.rejected_y == 0
        rows[1 + i] = 1 if good else 0
        rows[5 + i] = 1 if good and abs(shape) > _SMALLEST_SHAPE else 0
        if good:
            z[1 + i] = min(max(used / alpha, SMALLEST_SLOPE), LARGEST_SLOPE)
            z[5 + i] = min(max(used / shape, SMALLEST_LIMIT), LARGEST_LIMIT)
        else:
            z[1 + i] = z[5 + i] = 0.0
        degrees = abs(alpha) * 57.29577951308232
        if t.listing_noise == 1:
            noise[LIMIT + i, LIMIT + i] = table_value(degrees, PROCESS_TABLE)
            noise[SLOPE + i, SLOPE + i] = t.process_slope
            variances[1 + i], variances[5 + i] = t.noise_slope, table_value(degrees, NOISE_TABLE)
            continue
        # the tables' inverse dependence, as the text demands, with the knee at the threshold: what an error of the
        # friction in use makes of the slope falls with alpha, of the limit with the curve's shape
        curved = curve.mode == CURVED
        noise[SLOPE + i, SLOPE + i] = t.process_slope * (0.0 if curved else 1.0)
        noise[LIMIT + i, LIMIT + i] = t.process_limit if curved else 1e-8
        error = t.noise_friction * t.noise_friction
        variances[1 + i] = error / (alpha * alpha) if good else 1.0
        variances[5 + i] = error / (shape * shape) if rows[5 + i] == 1 else 1.0
        if curved:
            rows[1 + i] = 0
        else:
            rows[5 + i] = 0


class LateralMemory(NamedTuple):
    """Arrays of the filter: what it keeps, then scratch."""

    x: FloatArray
    held: FloatArray
    covariance: FloatArray
    weights: FloatArray
    rows: IntArray
    points: FloatArray
    full: FloatArray
    factor: FloatArray
    work: FloatArray
    noise: FloatArray
    outputs: FloatArray
    z: FloatArray
    variances: FloatArray
    measurement_noise: FloatArray
    expected: FloatArray
    innovation: FloatArray
    cross: FloatArray
    gain: FloatArray


def lateral_memory(weights: tuple[FloatArray, FloatArray]) -> LateralMemory:
    """Zeroed memory; ``weights`` of the mean and of the covariance."""
    n, m = LATERAL_STATES, MEASUREMENTS
    return LateralMemory(
        x=np.zeros(n),
        held=np.zeros(n),
        covariance=np.zeros((n, n)),
        weights=np.array(weights),
        rows=np.zeros(m, dtype=np.int64),
        points=np.zeros((POINTS, n)),
        full=np.zeros(PREDICTED),
        factor=np.zeros((n, n)),
        work=np.zeros((n, n)),
        noise=np.zeros((n, n)),
        outputs=np.zeros((POINTS, m)),
        z=np.zeros(m),
        variances=np.zeros(m),
        measurement_noise=np.zeros((m, m)),
        expected=np.zeros((2, m)),
        innovation=np.zeros((2, m, m)),
        cross=np.zeros((n, m)),
        gain=np.zeros((n, m)),
    )


@njit(cache=True)
def lateral_step(m: Any, s: Any, curves: Any, car: Any, t: Any, measured_w: float, measured_y: float) -> bool:
    """One step of the filter; False where it lost its numbers.

    Parameters
    ----------
    m : LateralMemory
    measured_w, measured_y : rad/s, m/s^2
        Yaw rate and lateral acceleration at the centre of gravity, both positive to the right.
    """
    dt = t.dt * t.lateral_ticks
    hand_over(m.x, m.covariance, curves, t)
    for j in range(LATERAL_STATES):
        m.held[j] = m.x[j]
    floor_covariance(m.covariance, m.factor, m.work)
    draw_rooted(m.x, m.factor, t.spread, m.points)
    # with the slip angles of the last step (3.7), which are as old as what the sensors' filters and frames let through
    _follow_sensors(s, t, measured_w, measured_y, dt)
    _predict_points(m, s, curves, car, t, dt)
    wheel_accelerations(s, s.measured_y, car, t)
    m.noise[V_Y, V_Y], m.noise[W_Z, W_Z] = t.process_v_y, t.process_w_z
    _fill_measurement(s, curves, t, m.z, m.variances, m.rows, m.noise)
    m.z[0] = measured_w + t.yaw_delay * s.yaw_acceleration
    m.variances[0], m.rows[0] = t.noise_w_z, 1
    predict_points(m.points, m.weights[0], m.weights[1], m.noise, m.x, m.covariance)
    floor_covariance(m.covariance, m.factor, m.work)
    if t.redraw == 1:
        draw_rooted(m.x, m.factor, t.spread, m.points)
    for k in range(POINTS):
        for j in range(MEASUREMENTS):
            m.outputs[k, j] = m.points[k, 1 + j]
    for j in range(MEASUREMENTS):
        m.measurement_noise[j, j] = m.variances[j]
    s.innovation = correct_points(
        m.x,
        m.covariance,
        m.points,
        m.outputs,
        m.weights[0],
        m.weights[1],
        m.measurement_noise,
        m.z,
        m.rows,
        m.expected,
        m.innovation,
        m.cross,
        m.gain,
    )
    if not (np.isfinite(s.innovation) and all_finite(m.x)):
        return False
    if s.rejected_y == 1:
        # without the accelerometer nothing tells the friction: the yaw rate alone would bend slopes and limits until
        # they explain it, and the lateral speed with them
        for j in range(SLOPE, LATERAL_STATES):
            m.x[j] = m.held[j]
    bound_state(m.x)
    floor_covariance(m.covariance, m.factor, m.work)
    _publish(m.x, s, curves, car, t)
    return True


@njit(cache=True)
def draw_rooted(x: FloatArray, factor: FloatArray, spread: float, points: FloatArray) -> None:
    """Sigma points from a root of the covariance that is at hand."""
    n = x.shape[0]
    for i in range(n):
        points[0, i] = x[i]
    for k in range(n):
        for i in range(n):
            offset = spread * factor[i, k]
            points[1 + k, i] = x[i] + offset
            points[1 + n + k, i] = x[i] - offset


@njit(cache=True)
def _predict_points(m: Any, s: Any, curves: Any, car: Any, t: Any, dt: float) -> None:
    """Send the points through the process model; roll is carried along with the centre point, outside of P."""
    n = LATERAL_STATES
    rate = roll = 0.0
    for k in range(POINTS):
        predict_state(m.points[k], s, curves, car, t, dt, m.full)
        if k == 0:
            for i in range(4):
                s.alpha[i] = m.full[n + 1 + i]
            rate, roll = m.full[n + 5], m.full[n + 6]
        for j in range(n):
            m.points[k, j] = m.full[j]
    s.roll_rate, s.roll = rate, roll


@njit(cache=True)
def _follow_sensors(s: Any, t: Any, measured_w: float, measured_y: float, dt: float) -> None:
    """Yaw acceleration, lateral acceleration and slip angles through the same low-pass, so that they fit together."""
    # of the filtered yaw rate, as in the listing: the gyroscope's own difference is mostly noise
    filtered = s.w_z if t.filtered_yaw == 1 else measured_w
    rate = (filtered - s.yaw_before) / dt
    s.yaw_before = filtered
    s.yaw_acceleration += t.signal_weight * (rate - s.yaw_acceleration)
    s.measured_y += t.signal_weight * (measured_y - s.measured_y)
    for i in range(4):
        s.filtered_alpha[i] += t.signal_weight * (s.alpha[i] - s.filtered_alpha[i])


@njit(cache=True)
def bound_state(x: FloatArray) -> None:
    """Keep slopes, limits and the lateral speed physical: the filter itself has no constraints (3.10)."""
    x[V_Y] = min(max(x[V_Y], -LARGEST_LATERAL_SPEED), LARGEST_LATERAL_SPEED)
    for i in range(4):
        x[SLOPE + i] = min(max(x[SLOPE + i], SMALLEST_SLOPE), LARGEST_SLOPE)
        x[LIMIT + i] = min(max(x[LIMIT + i], SMALLEST_LIMIT), LARGEST_LIMIT)


@njit(cache=True)
def _publish(x: FloatArray, s: Any, curves: Any, car: Any, t: Any) -> None:
    """Slip angles, side forces and lateral acceleration of the corrected state."""
    s.v_y, s.w_z = x[V_Y], x[W_Z]
    v_y = lateral_speed_at_the_road(s.v_y, s, t)
    total = 0.0
    for i in range(4):
        s.alpha[i] = slip_angle(s.v_x, v_y, s.w_z, s.theta[i], car, i)
        curve = curves[i]
        curved = curve.mode == CURVED
        s.force_y[i] = side_force(x, s.alpha[i], s.load[i], i, curved, curve.b, t.curve_c, s.theta[i], t)
        total += s.force_y[i] * math.cos(s.theta[i]) + s.force_x[i] * math.sin(s.theta[i])
    s.a_y = total / car.m
    s.lateral_runs = 1
