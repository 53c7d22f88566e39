"""One tick of the planar car that the vehicle-state document defines (its section 2), compiled.

The document's y axis points right and its z axis down; this is the same car in ISO 8855, y to the left: ``+`` and ``-``
of left and right wheels change places, the equations stay. Tyre forces are those of pure slip in each direction
(2.4: no combined slip). Everything is integrated at 0.1 ms; a wheel's spin is linearly implicit in the slope of its
curve, which stays stable down to standstill, where slip and slip angle refer to a smallest speed.
"""

import math
from typing import Any

from numba import njit

from vehicle_model.interface import TIME_STEP_S
from vehicle_model.reference.planar_outputs import write_outputs
from vehicle_model.road import friction_at, slopes_at
from vehicle_model.tyres.kernel import PEAK_FORCE_X, across, along, prepare

_SMALLEST_LOAD = 1.0
_STANDING = 1e-12
"""Speed [m/s] that counts as none: viscous forces let it fade without end."""


@njit(cache=True)
def table_angle(angle: float, places: Any, values: Any, points: int) -> float:
    """Linear interpolation in a rising table; the ends go on straight."""
    k = 1
    while k < points - 1 and places[k] < angle:
        k += 1
    share = (angle - places[k - 1]) / (places[k] - places[k - 1])
    return values[k - 1] + share * (values[k] - values[k - 1])


@njit(cache=True)
def static_loads(p: Any, weight: float, acceleration_y: float, longitudinal: float, loads: Any) -> None:
    """Normal reactions that balance at once (vehicle-state document, eq. 3.2), order fl fr rl rr [N].

    Parameters
    ----------
    weight : N
        m g cos(theta_r).
    acceleration_y : m/s^2
        To the left; the right wheels take the load.
    longitudinal : N m
        m h (a_x + g sin(theta_r)) + F_wx h_w + sum of M_f: moment that shifts load from front to rear.
    """
    wheelbase = p.to_front + p.to_rear
    half_f, half_r = p.wheel_y[0], p.wheel_y[2]
    rear = (weight * p.to_front + longitudinal) / wheelbase
    # moment about the line of the left contacts: Z_fr 2 y_f + Z_rr 2 y_r = m a_y h + W (y_f + y_r)/2, and the sums
    # over both diagonals are equal: Z_fr + Z_rl = W/2, with Z_rl + Z_rr = rear
    moment = 0.5 * (p.mass * acceleration_y * p.height + weight * 0.5 * (half_f + half_r))
    loads[3] = (moment - half_f * (0.5 * weight - rear)) / (half_f + half_r)
    loads[2] = rear - loads[3]
    loads[1] = 0.5 * weight - loads[2]
    loads[0] = 0.5 * weight - loads[3]


@njit(cache=True)
def rolling_loads(p: Any, weight: float, roll: float, roll_rate: float, longitudinal: float, loads: Any) -> None:
    """Normal reactions with the body's roll as a state (vehicle-state document 2.6, variant of both listings) [N].

    Each axle carries half of the roll moment; parameters as in :func:`static_loads`.
    """
    rear = (weight * p.to_front + longitudinal) / (p.to_front + p.to_rear)
    moment = 0.5 * (p.roll_stiffness * roll + p.roll_damping * roll_rate)
    for i in range(4):
        axle = weight - rear if i < 2 else rear
        loads[i] = 0.5 * axle - moment / (2.0 * p.wheel_y[i])
    for i in range(0, 4, 2):
        # a lifted wheel carries nothing, the other all of its axle
        both = loads[i] + loads[i + 1]
        loads[i] = min(max(loads[i], 0.0), both)
        loads[i + 1] = both - loads[i]


@njit(cache=True)
def spin(
    inertia: float, omega: float, resistance: float, drive: float, tyre: float, slope: float, h: float
) -> tuple[float, float]:
    """Speed of a wheel after a sub-step and the torque that brake and rolling took, at most ``resistance``.

    Parameters
    ----------
    tyre, slope : N m, N m s/rad
        Torque of the tyre against the drive, and its slope by the wheel's speed.
    """
    momentum = inertia * omega + h * (drive - tyre + slope * omega)
    if abs(momentum) <= h * resistance:
        return 0.0, momentum / h
    taken = resistance if momentum > 0.0 else -resistance
    return (momentum - h * taken) / (inertia + h * slope), taken


@njit(cache=True)
def _turn_wheel(p: Any, s: Any, i: int, tyre: Any, prepared: Any, brake: float, drive: float, h: float) -> None:
    """Slip, forces and spin of one wheel over a sub-step (2.2, 2.4, 2.5)."""
    v_x = s.speed - s.yaw_rate * p.wheel_y[i]
    v_y = s.lateral_speed + s.yaw_rate * p.wheel_x[i]
    radius, omega, load = p.radius[i], s.omega[i], s.load[i]
    divisor = max(abs(v_x), p.slowest)
    slip = (omega * radius - v_x) / divisor
    angle = math.atan(v_y / divisor) - s.steer[i]
    scale = load / s.prepared_load[i]
    force, rise = along(tyre, prepared, slip, 0.0)
    slope = max(rise, 0.0) * scale * radius / divisor
    force *= scale
    rolling = load * (p.rolling[i] + p.rolling_speed_factor * v_x * v_x) * radius
    resistance = rolling + brake
    turned, taken = spin(p.inertia[i], omega, resistance, drive, force * radius, slope * radius, h)
    # the force of the implicit step, which the tangent of the curve must not carry beyond the peak
    limit = prepared[PEAK_FORCE_X] * scale
    carried = min(max(force + slope * (turned - omega), -limit), limit)
    if carried != force + slope * (turned - omega):
        turned, taken = spin(p.inertia[i], omega, resistance, drive, carried * radius, 0.0, h)
    s.omega[i], s.force_x[i], s.slip[i], s.slip_angle[i] = turned, carried, slip, angle
    s.force_y[i] = across(tyre, prepared, 0.0, -angle, carried)[0] * scale
    share = brake / resistance if resistance > 0.0 else 0.0
    mean = 0.5 * (omega + turned)
    s.mean_brake[i] += taken * share / p.substeps
    s.rolling_moment += taken * (1.0 - share)
    s.brake_energy += h * taken * share * mean
    s.rolling_energy += h * taken * (1.0 - share) * mean
    s.drive_energy += h * drive * mean
    s.tyre_energy += h * carried * radius * mean


@njit(cache=True)
def _move(p: Any, s: Any, pull_x: float, pull_y: float, wind: float, h: float) -> tuple[float, float]:
    """Motion in the plane of the road over a sub-step (eq. 3.1); returns force along the car and sideways [N].

    Parameters
    ----------
    pull_x, pull_y : N
        Components of the weight along the car and to its left.
    wind : m/s
        Speed of the air along the car.
    """
    sum_x = sum_y = moment = 0.0
    for i in range(4):
        cosine, sine = math.cos(s.steer[i]), math.sin(s.steer[i])
        x = s.force_x[i] * cosine - s.force_y[i] * sine
        y = s.force_x[i] * sine + s.force_y[i] * cosine
        sum_x += x
        sum_y += y
        moment += p.wheel_x[i] * y - p.wheel_y[i] * x
    before_x, before_y, before_turn = s.speed, s.lateral_speed, s.yaw_rate
    air = p.drag * abs(before_x - wind) * (before_x - wind)
    s.acceleration_x = (sum_x - air + pull_x) / p.mass
    s.acceleration_y = (sum_y + pull_y) / p.mass
    s.yaw_rate += h * moment / p.yaw_inertia
    s.speed += h * (s.acceleration_x + before_y * before_turn)
    s.lateral_speed += h * (s.acceleration_y - before_x * before_turn)
    mean_x, mean_y = 0.5 * (before_x + s.speed), 0.5 * (before_y + s.lateral_speed)
    mean_turn = 0.5 * (before_turn + s.yaw_rate)
    s.tyre_energy -= h * (sum_x * mean_x + sum_y * mean_y + moment * mean_turn)
    s.air_energy += h * air * mean_x
    s.gravity_energy -= h * (pull_x * mean_x + pull_y * mean_y)
    if abs(s.speed) < _STANDING:
        s.speed = 0.0
    if abs(s.lateral_speed) < _STANDING:
        s.lateral_speed = 0.0
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    s.x += h * (mean_x * cosine - mean_y * sine)
    s.y += h * (mean_x * sine + mean_y * cosine)
    s.yaw += h * mean_turn
    s.distance += h * math.hypot(mean_x, mean_y)
    return sum_x, sum_y


@njit(cache=True)
def _lean(p: Any, s: Any, force_x: float, force_y: float, h: float) -> None:
    """Pitch and roll of the body over a sub-step (2.6 variant, 2.7); both forces act at the contacts, h below."""
    moment = force_x * p.height - p.pitch_stiffness * s.nose_up - p.pitch_damping * s.nose_up_rate
    s.nose_up_rate += h * moment / p.pitch_inertia
    s.nose_up += h * s.nose_up_rate
    moment = force_y * p.height - p.roll_stiffness * s.roll - p.roll_damping * s.roll_rate
    s.roll_rate += h * moment / p.roll_inertia
    s.roll += h * s.roll_rate


@njit(cache=True)
def _look_at_road(
    p: Any, s: Any, tyres: Any, prepared: Any, road: Any, jumps: Any, patches: Any, surfaces: Any, time: float
) -> None:
    """Prepare the tyres for a tick: friction and surface under each wheel, load."""
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    for i in range(4):
        x = s.x + p.wheel_x[i] * cosine - p.wheel_y[i] * sine
        y = s.y + p.wheel_x[i] * sine + p.wheel_y[i] * cosine
        friction, surface = friction_at(road, jumps, patches, x, y, time)
        load = max(s.load[i], _SMALLEST_LOAD)
        s.prepared_load[i] = load
        prepare(tyres[i], surfaces[surface], friction * p.friction_factor[i], load, abs(s.speed), 0.0, prepared[i])
        s.friction_limit[i] = prepared[i, PEAK_FORCE_X] / load


@njit(cache=True)
def gravity_along(magnitude: float, grade: float, bank: float, yaw: float) -> tuple[float, float, float]:
    """Acceleration of gravity into the road (positive), along the car's heading and to its left [m/s^2]."""
    scale = magnitude / math.sqrt(1.0 + grade * grade + bank * bank)
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return scale, -scale * (grade * cosine + bank * sine), -scale * (bank * cosine - grade * sine)


@njit(cache=True)
def _load_wheels(p: Any, s: Any, down: float, pull: float) -> None:
    air = p.drag * abs(s.speed) * s.speed
    moment = p.mass * p.height * (s.acceleration_x - pull) + air * p.drag_height + s.rolling_moment
    if p.roll_dynamics == 1:
        rolling_loads(p, p.mass * down, s.roll, s.roll_rate, moment, s.load)
    else:
        static_loads(p, p.mass * down, s.acceleration_y, moment, s.load)


@njit(cache=True)
def planar_tick(
    p_rows: Any,
    s_rows: Any,
    tyres: Any,
    prepared: Any,
    road_rows: Any,
    jumps: Any,
    patches: Any,
    points: Any,
    surfaces: Any,
    steering: Any,
    outputs: Any,
    brake: Any,
    drive: Any,
    wheel_angle: float,
    time: float,
) -> None:
    """Advance by 1 ms.

    Parameters
    ----------
    p_rows, s_rows : shape (1,), dtypes ``PARAMETER_RECORD`` and ``STATE_RECORD``
    tyres, prepared : shapes (4, TYRE_SIZE) and (4, PREPARED_SIZE)
    road_rows, jumps, patches, points, surfaces
        Tables of the road.
    steering : shape (3, n)
        Steering-wheel angles and the road-wheel angles fl, fr at them [rad].
    outputs
        Block "plant" of the catalogue.
    brake, drive : shape (4,), N m
        Capacity of the brakes and drive torques per wheel.
    wheel_angle : rad
        Steering-wheel angle, positive to the left.
    time : s
    """
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    for i in range(2):
        s.steer[i] = table_angle(wheel_angle, steering[0], steering[1 + i], p.map_points)
    _look_at_road(p, s, tyres, prepared, road, jumps, patches, surfaces, time)
    grade, bank = slopes_at(road, points, s.x)
    h = TIME_STEP_S / p.substeps
    s.mean_x = s.mean_y = 0.0
    for i in range(4):
        s.mean_force_x[i] = s.mean_force_y[i] = s.mean_load[i] = s.mean_brake[i] = 0.0
    for _ in range(p.substeps):
        down, along_car, across_car = gravity_along(road.gravity, grade, bank, s.yaw)
        _load_wheels(p, s, down, along_car)
        s.rolling_moment = 0.0
        for i in range(4):
            _turn_wheel(p, s, i, tyres[i], prepared[i], max(brake[i], 0.0), drive[i], h)
            s.mean_force_x[i] += s.force_x[i] / p.substeps
            s.mean_force_y[i] += s.force_y[i] / p.substeps
            s.mean_load[i] += s.load[i] / p.substeps
        wind = road.wind_x * math.cos(s.yaw) + road.wind_y * math.sin(s.yaw)
        force_x, force_y = _move(p, s, p.mass * along_car, p.mass * across_car, wind, h)
        _lean(p, s, force_x, force_y, h)
        s.mean_x += s.acceleration_x / p.substeps
        s.mean_y += s.acceleration_y / p.substeps
    write_outputs(p, s, drive, grade, bank, outputs)


@njit(cache=True)
def refresh(
    p_rows: Any,
    s_rows: Any,
    tyres: Any,
    prepared: Any,
    road_rows: Any,
    jumps: Any,
    patches: Any,
    points: Any,
    surfaces: Any,
    steering: Any,
    outputs: Any,
    drive: Any,
    time: float,
) -> None:
    """Loads at rest and outputs of a car that has just been put on the road; parameters as in `planar_tick`."""
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    grade, bank = slopes_at(road, points, s.x)
    down, along_car, _ = gravity_along(road.gravity, grade, bank, s.yaw)
    _load_wheels(p, s, down, along_car)
    for i in range(4):
        s.mean_load[i] = s.load[i]
    _look_at_road(p, s, tyres, prepared, road, jumps, patches, surfaces, time)
    write_outputs(p, s, drive, grade, bank, outputs)
