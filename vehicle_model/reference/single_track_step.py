"""One tick of the longitudinal single-track car, compiled (friction document 2.4 and 2.5).

The algebraic loop between acceleration, vertical loads and friction forces is solved in closed form (eqs 75 to 77),
here with drag, rolling resistance and grade. Spin is linearly implicit in the slope of the friction curve; brake and
rolling resistance are set-valued, so that a wheel and the car stand exactly still while less than their capacity moves
them. Below a low speed, where slip loses its meaning, elastic bristles carry the force.
"""

import math
from typing import Any

from numba import njit

from vehicle_model.interface import TIME_STEP_S
from vehicle_model.reference.single_track_outputs import write_outputs
from vehicle_model.reference.single_track_record import FRONT, REAR
from vehicle_model.road import friction_at, slopes_at, water_factor_at
from vehicle_model.tyres.kernel import PEAK_FORCE_X, STIFFNESS_X, along, peak_slips, prepare

_SMALLEST_SPEED = 1e-6
_SMALLEST_LOAD = 1.0


@njit(cache=True)
def axle_loads(
    weight: float, wheelbase: float, to_front: float, height: float, friction_f: float, friction_r: float, moment: float
) -> tuple[float, float]:
    """Vertical loads of both axles [N], never negative; they add up to the weight.

    Parameters
    ----------
    weight : N
        m g cos(gamma).
    wheelbase, to_front, height : m
        L, L_f and the centre of gravity's height h.
    friction_f, friction_r
        Friction coefficients of the axles, driving positive.
    moment : N m
        h (F_roll + F_aero) - h_aero F_aero: resistances act on the car but not through the tyres.

    Source: Enisz 2015, eqs 75 to 77 with D = L - (mu_r - mu_f) h; friction document 2.4.1.
    """
    divisor = wheelbase - (friction_r - friction_f) * height
    front = (weight * (wheelbase - to_front - friction_r * height) + moment) / divisor
    front = min(max(front, 0.0), weight)
    return front, weight - front


@njit(cache=True)
def _bristle_friction(
    p: Any, s: Any, axle: int, prepared: Any, slip: float, curve: float, slide: float, roll: float, h: float
) -> tuple[float, float]:
    """Friction coefficient that the bristles carry, and its slope by the sliding speed [s/m]."""
    load = max(s.load[axle], _SMALLEST_LOAD)
    stiffness = p.contact_stiffness[axle]
    rolling_stiffness = peak = 0.0
    for i in range(2 * axle, 2 * axle + 2):
        rolling_stiffness += prepared[i, STIFFNESS_X]
        peak += prepared[i, PEAK_FORCE_X]
    passed = abs(slip) > peak_slips(prepared[2 * axle])[0]
    limit = abs(curve) * load if passed else peak
    left = 1.0 + h * roll * stiffness / max(rolling_stiffness, 1.0)
    force = stiffness * (s.bristle[axle] + h * slide) / left + p.contact_damping[axle] * slide
    if abs(force) > limit:
        return (limit if force > 0.0 else -limit) / load, 0.0
    return force / load, (stiffness * h / left + p.contact_damping[axle]) / load


@njit(cache=True)
def _friction(p: Any, s: Any, axle: int, tyres: Any, prepared: Any, h: float) -> None:
    """Friction coefficient of an axle and its slope by the wheel's speed [s/rad], at the present slip."""
    rolling = p.radius[axle] * s.omega[axle]
    slide = rolling - s.speed
    speed = max(abs(rolling), abs(s.speed))
    divisor = max(speed, _SMALLEST_SPEED)
    slip = slide / divisor
    # the divisor turns with the wheel where that is the faster
    turning = abs(rolling) >= divisor and s.speed * rolling > 0.0
    slip_slope = p.radius[axle] * (s.speed / (divisor * rolling) if turning else 1.0 / divisor)
    friction = slope = 0.0
    for i in range(2 * axle, 2 * axle + 2):
        force, rise = along(tyres[i], prepared[i], slip, 0.0)
        s.wheel_friction[i] = 2.0 * force / s.prepared_load[axle]
        friction += force / s.prepared_load[axle]
        slope += rise / s.prepared_load[axle]
    slope *= slip_slope
    if speed < p.none_above[axle]:
        share = min((p.none_above[axle] - speed) / (p.none_above[axle] - p.full_below[axle]), 1.0)
        bristles, bristle_slope = _bristle_friction(p, s, axle, prepared, slip, friction, slide, abs(rolling), h)
        friction += share * (bristles - friction)
        slope += share * (p.radius[axle] * bristle_slope - slope)
        s.bristle_friction[axle], s.bristle_slope[axle] = bristles, bristle_slope
    s.friction[axle], s.slope[axle] = friction, max(slope, 0.0)


@njit(cache=True)
def _spin(
    inertia: float, omega: float, brake: float, drive: float, tyre: float, slope: float, h: float
) -> tuple[float, float]:
    """Speed of an axle after a sub-step and the torque that its brake took, at most its capacity ``brake``.

    Parameters
    ----------
    tyre, slope : N m, N m s/rad
        Torque of the tyres against the drive, and its slope by the speed.
    """
    momentum = inertia * omega + h * (drive - tyre + slope * omega)
    if abs(momentum) <= h * brake:
        return 0.0, momentum / h
    taken = brake if momentum > 0.0 else -brake
    return (momentum - h * taken) / (inertia + h * slope), taken


@njit(cache=True)
def _turn_axle(p: Any, s: Any, axle: int, brake: float, drive: float, h: float) -> None:
    """Spin of an axle over a sub-step; the friction coefficient becomes that of the implicit step.

    Source: friction document 2.4.1, dw/dt = (M - sgn(w) M_b - F_x R)/Theta with the axle's values (2.4.3).
    """
    omega, radius = s.omega[axle], p.radius[axle]
    load = s.load[axle]
    friction, slope = s.friction[axle], s.slope[axle]
    arm = load * radius
    turned, friction_torque = _spin(p.inertia[axle], omega, brake, drive, friction * arm, slope * arm, h)
    friction += slope * (turned - omega)
    limit = 0.5 * (s.friction_limit[2 * axle] + s.friction_limit[2 * axle + 1])
    if abs(friction) > limit:
        # the tangent of the curve leads beyond its peak
        friction = limit if friction > 0.0 else -limit
        turned, friction_torque = _spin(p.inertia[axle], omega, brake, drive, friction * arm, 0.0, h)
    s.friction[axle] = friction
    mean = 0.5 * (omega + turned)
    s.omega[axle] = turned
    s.mean_brake[axle] += friction_torque
    s.brake_energy += h * friction_torque * mean
    s.drive_energy += h * drive * mean
    s.tyre_energy += h * s.friction[axle] * load * radius * mean
    speed = s.speed
    slide = radius * turned - speed
    if max(abs(speed), abs(radius * turned)) >= p.none_above[axle]:
        carried = s.friction[axle]
    else:
        carried = s.bristle_friction[axle] + s.bristle_slope[axle] * radius * (turned - omega)
        carried = min(max(carried, -limit), limit)
    s.bristle[axle] = (carried * load - p.contact_damping[axle] * slide) / p.contact_stiffness[axle]


@njit(cache=True)
def _move(p: Any, s: Any, weight: float, pull: float, wind: float, h: float) -> None:
    """Motion of the car over a sub-step under the axles' forces, drag, grade and set-valued rolling resistance.

    Parameters
    ----------
    weight, pull : N
        Components of the car's weight onto the road and along it, the latter positive forwards.
    wind : m/s
        Speed of the air along the road.
    """
    before = s.speed
    force = s.friction[FRONT] * s.load[FRONT] + s.friction[REAR] * s.load[REAR]
    air = p.drag * abs(before - wind) * (before - wind)
    momentum = p.mass * before + h * (force - air + pull)
    capacity = p.rolling * weight
    if abs(momentum) <= h * capacity:
        s.speed, s.rolling_force = 0.0, momentum / h
    else:
        s.rolling_force = capacity if momentum > 0.0 else -capacity
        s.speed = (momentum - h * s.rolling_force) / p.mass
    s.air_force = air
    mean = 0.5 * (before + s.speed)
    way = h * mean
    s.tyre_energy -= force * way
    s.air_energy += air * way
    s.rolling_energy += s.rolling_force * way
    s.gravity_energy -= pull * way
    s.x += way * math.cos(s.yaw)
    s.y += way * math.sin(s.yaw)
    s.distance += abs(way)


@njit(cache=True)
def _look_at_road(
    p: Any, s: Any, tyres: Any, prepared: Any, road: Any, jumps: Any, patches: Any, surfaces: Any, time: float
) -> None:
    """Prepare the tyres for a tick: friction and surface under each wheel, load."""
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    for axle in range(2):
        along = p.to_front if axle == FRONT else p.to_front - p.wheelbase
        s.prepared_load[axle] = max(s.load[axle], _SMALLEST_LOAD)
        for side in range(2):
            i = 2 * axle + side
            across = p.half_track[axle] if side == 0 else -p.half_track[axle]
            x = s.x + along * cosine - across * sine
            y = s.y + along * sine + across * cosine
            friction, surface = friction_at(road, jumps, patches, x, y, time)
            friction *= water_factor_at(road, patches, x, y, abs(s.speed))
            load = 0.5 * s.prepared_load[axle]
            prepare(tyres[i], surfaces[surface], friction * p.friction_factor[i], load, s.speed, 0.0, prepared[i])
            s.friction_limit[i] = prepared[i, PEAK_FORCE_X] / load


@njit(cache=True)
def gravity(magnitude: float, grade: float, bank: float, yaw: float) -> tuple[float, float]:
    """Acceleration of gravity into the road (positive) and along the car's heading (positive forwards) [m/s^2]."""
    scale = magnitude / math.sqrt(1.0 + grade * grade + bank * bank)
    return scale, -scale * (grade * math.cos(yaw) + bank * math.sin(yaw))


@njit(cache=True)
def solve_loads(p: Any, s: Any, weight: float) -> None:
    """Vertical loads for the present friction coefficients, rolling resistance and drag."""
    moment = p.height * (s.rolling_force + s.air_force) - p.drag_height * s.air_force
    s.load[FRONT], s.load[REAR] = axle_loads(
        weight, p.wheelbase, p.to_front, p.height, s.friction[FRONT], s.friction[REAR], moment
    )


@njit(cache=True)
def single_track_tick(
    p_rows: Any,
    s_rows: Any,
    tyres: Any,
    prepared: Any,
    road_rows: Any,
    jumps: Any,
    patches: Any,
    points: Any,
    surfaces: Any,
    outputs: Any,
    brake: Any,
    drive: Any,
    time: float,
) -> None:
    """Advance by 1 ms.

    Parameters
    ----------
    p_rows, s_rows : shape (1,), dtypes ``PARAMETER_RECORD`` and ``STATE_RECORD``
    tyres, prepared : shapes (4, TYRE_SIZE) and (4, PREPARED_SIZE)
    road_rows, jumps, patches, points, surfaces
        Tables of the road.
    outputs
        Block "plant" of the catalogue.
    brake, drive : shape (4,), N m
        Capacity of the brakes and drive torques per wheel.
    time : s
    """
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    _look_at_road(p, s, tyres, prepared, road, jumps, patches, surfaces, time)
    grade, bank = slopes_at(road, points, s.x)
    down, along = gravity(road.gravity, grade, bank, s.yaw)
    weight, pull = p.mass * down, p.mass * along
    wind = road.wind_x * math.cos(s.yaw) + road.wind_y * math.sin(s.yaw)
    h = TIME_STEP_S / p.substeps
    start = s.speed
    for axle in range(2):
        s.mean_force[axle] = s.mean_load[axle] = s.mean_brake[axle] = 0.0
    for _ in range(p.substeps):
        for axle in range(2):
            _friction(p, s, axle, tyres, prepared, h)
        solve_loads(p, s, weight)
        for axle in range(2):
            capacity = max(brake[2 * axle], 0.0) + max(brake[2 * axle + 1], 0.0)
            _turn_axle(p, s, axle, capacity, drive[2 * axle] + drive[2 * axle + 1], h)
            s.mean_force[axle] += s.friction[axle] * s.load[axle] / p.substeps
            s.mean_load[axle] += s.load[axle] / p.substeps
        _move(p, s, weight, pull, wind, h)
    for axle in range(2):
        s.mean_brake[axle] /= p.substeps
    s.mean_acceleration = (s.speed - start) / TIME_STEP_S
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
    outputs: Any,
    drive: Any,
    time: float,
) -> None:
    """Loads at rest and outputs of a car that has just been put on the road; parameters as in `single_track_tick`."""
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    grade, bank = slopes_at(road, points, s.x)
    down, _ = gravity(road.gravity, grade, bank, s.yaw)
    solve_loads(p, s, p.mass * down)
    for axle in range(2):
        s.mean_load[axle] = s.load[axle]
    _look_at_road(p, s, tyres, prepared, road, jumps, patches, surfaces, time)
    write_outputs(p, s, drive, grade, bank, outputs)
