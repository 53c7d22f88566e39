"""Wheels of the replay: steering with its compliance, slip with relaxation, tyre force, spin; compiled.

The spin is linearly implicit in the slope of the tyre force, so that steps of 2 ms are stable down to walking speed;
friction of brake and rolling is set-valued, a braked wheel stands still.
"""

import math

from numba import njit

from model_diagnosis.replay.brake_step import brake_capacity
from model_diagnosis.replay.lag_step import behind, followed
from model_diagnosis.replay.lanes import some, where
from model_diagnosis.replay.record import COASTING_NM, Record
from model_diagnosis.replay.tyre_step import LIGHTEST_N, warm_tread, wheel_forces

_SLOWEST_M_S = 0.5
"""Least divisor of slips: the replay is compared above walking speed only."""
_PRELOAD_SPAN_RAD_S = 0.5


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def steer_wheels(p: Record, s: Record, step: float) -> None:
    """Angles of the road wheels: linkage, compliance under the aligning moment, toe."""
    angle = s.steer * p.steering_scale
    common = 0.5 * (s.aligning[0] + s.aligning[1])
    for i in range(2):
        wanted = angle + p.steering_offset + p.toe[i]
        if some(p.ackermann != 0.0):
            side = -1.0 if i == 0 else 1.0
            tangent = math.tan(angle)
            full = math.atan2(tangent, 1.0 + side * tangent * p.track_front / (2.0 * p.wheelbase))
            wanted += p.ackermann * (full - angle)
        # the linkage holds the tyre's moment and turns the spinning wheel with the body's roll
        turned = p.guide_lean * s.mid_roll_rate * p.spin_inertia[i] * s.spin[i]
        moment = s.aligning[i] + p.steering_link * (common - s.aligning[i])
        wanted += (moment - turned) / p.steering_stiffness
        share = step / (2.0 * p.steering_lag + step)
        mean = s.angle[i] + share * (wanted - s.angle[i])
        s.angle[i], s.sine[i], s.cosine[i] = followed(s.angle[i], wanted, 0.0, share), math.sin(mean), math.cos(mean)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def drive_torque(p: Record, s: Record, i: int) -> float:
    """Drive torque of a wheel: half the axle's, losses of the driveline, and what the differential hands across."""
    axle = s.drive_front if i < 2 else s.drive_rear
    torque, share = 0.5 * axle, p.drive_share[i]
    if not some(share != 0.0):
        return torque
    omega = s.spin[i]
    turning = min(max(omega, -1.0), 1.0)
    torque -= share * (p.driveline_drag * turning + p.driveline_viscous * omega)
    if some(p.engine_drag != 0.0):
        torque -= where(s.drive_front + s.drive_rear <= COASTING_NM, share * p.engine_drag * turning, 0.0)
    if some((p.locking_preload != 0.0) | (p.locking_viscous != 0.0)):
        slower = s.spin[i ^ 1] - omega
        locked = p.locking_preload * math.tanh(slower / _PRELOAD_SPAN_RAD_S) + p.locking_viscous * slower
        torque += where(share != 0.0, locked, 0.0)
    return torque


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def move_wheel(
    p: Record,
    s: Record,
    i: int,
    step: float,
) -> None:
    """One step of a wheel: its tyre forces and its spin."""
    load = max(s.load[i], LIGHTEST_N)
    turn, omega = s.mid_yaw_rate, s.spin[i]
    # the body turns about the axis that its links leave it and carries the contact along; as a form, by less than that
    rate = s.travel_rate[i]
    carried_x = -p.pitch_scrub * p.height * s.mid_pitch_rate - p.link_scrub * p.guide_brake[i] * rate
    carried_y = p.roll_scrub * p.height * s.mid_roll_rate - p.link_scrub * p.guide_side[i] * rate
    at_x = s.mid_speed - turn * p.wheel_y[i] + carried_x + p.guide_lean * s.mid_pitch * rate
    at_y = s.mid_lateral_speed + turn * p.wheel_x[i] + carried_y - p.guide_lean * s.mid_roll * rate
    sine, cosine = s.sine[i], s.cosine[i]
    v_x, v_y = cosine * at_x + sine * at_y, cosine * at_y - sine * at_x
    radius = p.radius[i] - p.radius_load * (load - p.static_load[i]) + p.radius_speed * v_x * v_x

    roll = radius * omega
    slide_x = roll - v_x
    divisor = max(max(abs(v_x), abs(v_y)), max(abs(roll), _SLOWEST_M_S))
    inverse = 1.0 / divisor
    now_x, now_y = slide_x * inverse, -v_y * inverse
    slip_slope = radius * inverse * where((roll >= divisor) & (v_x > 0.0), v_x * inverse, 1.0)
    way = step * divisor
    # means over the step, which the spin's change goes into by half
    on_slip = 1.0 - p.lag_on_force
    share_of_x = way / (2.0 * on_slip * p.relaxation_x[i] + way)
    share_of_y = way / (2.0 * on_slip * p.relaxation_y[i] + way)
    slip_x = s.lagged_x[i] + share_of_x * (now_x - s.lagged_x[i])
    slip_y = s.lagged_y[i] + share_of_y * (now_y - s.lagged_y[i])
    s.slip_x[i], s.slip_y[i] = now_x, now_y

    force_x, force_y, slope, relative = wheel_forces(p, s, i, slip_x, slip_y, load, abs(v_x))
    slope = max(slope * slip_slope, 0.0) * share_of_x
    force_share_x = force_share_y = 1.0
    if some(p.lag_on_force != 0.0):
        force_share_x = way / (2.0 * p.lag_on_force * p.relaxation_x[i] + way)
        force_share_y = way / (2.0 * p.lag_on_force * p.relaxation_y[i] + way)
    mean_x = s.lagged_force_x[i] + force_share_x * (force_x - s.lagged_force_x[i])
    mean_y = s.lagged_force_y[i] + force_share_y * (force_y - s.lagged_force_y[i])
    slope *= force_share_x
    change, mean_x = _spin(p, s, i, step, load, radius, mean_x, slope)
    s.lagged_x[i] = followed(s.lagged_x[i], now_x, slip_slope * change, share_of_x)
    s.lagged_y[i] = followed(s.lagged_y[i], now_y, 0.0, share_of_y)
    s.lagged_force_x[i] = behind(s.lagged_force_x[i], mean_x, force_share_x)
    s.lagged_force_y[i] = behind(s.lagged_force_y[i], mean_y, force_share_y)
    s.tyre_x[i], s.tyre_y[i] = mean_x, mean_y
    relative += p.trail_across * (abs(slip_y) * p.inverse_peak_y[i] - relative)
    s.aligning[i] = -p.trail[i] * max(1.0 - relative, 0.0) * (1.0 + p.trail_bulge * relative) * mean_y
    if some(p.heat_fade != 0.0):
        heat = abs(mean_x * slide_x) + abs(mean_y * v_y)
        warm_tread(s, i, heat, step)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _spin(
    p: Record,
    s: Record,
    i: int,
    step: float,
    load: float,
    radius: float,
    force_x: float,
    slope: float,
) -> tuple[float, float]:
    """One step of a wheel's spin: its change, and the mean tyre force over it."""
    omega, speed = s.spin[i], s.speed
    brake = brake_capacity(p, s, i, s.pressure[i], step)
    rolling = p.rolling_resistance[i] + p.rolling_speed * speed * p.rolling_reference[i]
    capacity = brake + max(rolling, 0.0) * load * radius
    inertia = p.spin_inertia[i]
    s.drive_torque[i] = drive_torque(p, s, i)
    torque = s.drive_torque[i] - force_x * radius
    # half of the step's change is in the mean; more where half would overshoot
    stiff = step * radius * slope
    half = where(stiff > 0.0, slope * max(0.5, 1.0 - inertia / stiff), 0.0)
    momentum = inertia * omega + step * torque + step * radius * half * omega
    stands = abs(momentum) <= step * capacity
    friction = where(stands, abs(momentum) / step, capacity)
    slowed = momentum - math.copysign(step * capacity, momentum)
    new = where(stands, 0.0, slowed / (inertia + step * radius * half))
    s.spin[i], s.spin_rate[i] = new, (new - omega) / step
    s.brake_torque[i] = min(friction, brake)
    s.rolling_torque[i] = friction - s.brake_torque[i]
    return new - omega, force_x + half * (new - omega)
