"""One tick of all sensors, compiled."""

import math
from typing import Any

from numba import njit

from signals.record_memory import addresses_at, numbers_at, record_at
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.sensor_faults import contact_open, mount, reported, slowest_seen
from vehicle_model.sensors_record import (
    ACCELERATION_X,
    BRAKE_PRESSURE,
    CHANNELS,
    IDEAL,
    INERTIAL_CHANNELS,
    LONGEST_DELAY_TICKS,
    MASTER_PRESSURE,
    NOISE_FREE,
    PARAMETER_RECORD,
    PEDAL_FORCE,
    STATE_RECORD,
    STEERING,
)
from vehicle_model.tone_ring import COUNTER_WRAP, HISTORY_TICKS, measure_speed, turn_ring

STANDARD_GRAVITY = 9.81

AT_PARAMETERS, AT_STATE, AT_EDGES, AT_NOISE, AT_CONTACTS, AT_VALUES, AT_SENSED = range(7)
"""Places in the list of addresses: two records, then arrays of float64."""
ADDRESSES = 7
RANDOM_NUMBERS = CHANNELS + 4
"""Random numbers of a tick: a value per analogue channel and wheel-speed sensor."""
DRAWN_TICKS = 128
"""Ticks that they are drawn for in advance: few, so that no tick has to draw for long."""


@njit(cache=True)
def _inertial(p: Any, s: Any, values: Any, measured: Any) -> None:
    """What an ideal inertial unit at its place in the car measures: specific force and rates, body axes.

    Specific force is acceleration less gravity: at rest on a level road the accelerometer reads g upwards; braking with
    the nose down, or driving up a grade, gravity has a part along x. The z channel is reported without g.
    """
    yaw, roll, pitch = values[p.yaw_angle], values[p.roll_angle], values[p.pitch_angle]
    grade, bank = values[p.road_grade], values[p.road_bank]
    up = STANDARD_GRAVITY / math.sqrt(1.0 + grade * grade + bank * bank)
    cosine, sine = math.cos(yaw), math.sin(yaw)
    # along the heading, to its left and up from the road
    f_x = values[p.true_longitudinal_acceleration] + up * (grade * cosine + bank * sine)
    f_y = values[p.true_lateral_acceleration] + up * (bank * cosine - grade * sine)
    f_z = values[p.true_vertical_acceleration] + up
    cosine, sine = math.cos(pitch), math.sin(pitch)
    f_x, f_z = cosine * f_x - sine * f_z, sine * f_x + cosine * f_z
    cosine, sine = math.cos(roll), math.sin(roll)
    f_y, f_z = cosine * f_y + sine * f_z, cosine * f_z - sine * f_y
    w_x, w_y, w_z = values[p.true_roll_rate], values[p.true_pitch_rate], values[p.true_yaw_rate]
    if s.started != 0:
        a_x, a_y, a_z = (
            (w_x - s.rates[0]) / TIME_STEP_S,
            (w_y - s.rates[1]) / TIME_STEP_S,
            (w_z - s.rates[2]) / TIME_STEP_S,
        )
        x, y, z = p.place[0], p.place[1], p.place[2]
        turned = w_x * x + w_y * y + w_z * z
        square = w_x * w_x + w_y * w_y + w_z * w_z
        f_x += a_y * z - a_z * y + w_x * turned - square * x
        f_y += a_z * x - a_x * z + w_y * turned - square * y
        f_z += a_x * y - a_y * x + w_z * turned - square * z
    s.rates[0], s.rates[1], s.rates[2] = w_x, w_y, w_z
    measured[0], measured[1], measured[2] = f_x, f_y, f_z
    measured[3], measured[4], measured[5] = w_z, w_x, w_y
    mount(p, measured)
    measured[2] -= STANDARD_GRAVITY


@njit(cache=True)
def _low_pass(p: Any, s: Any, measured: Any) -> None:
    """Second-order low-pass of the inertial channels, exact for an input that is constant over the tick."""
    a, b = p.transition, p.entry
    for k in range(INERTIAL_CHANNELS):
        u = measured[k]
        if s.started == 0:
            s.low_pass[k, 0], s.low_pass[k, 1] = u, 0.0
        x, v = s.low_pass[k, 0], s.low_pass[k, 1]
        s.low_pass[k, 0] = a[0, 0] * x + a[0, 1] * v + b[0] * u
        s.low_pass[k, 1] = a[1, 0] * x + a[1, 1] * v + b[1] * u
        measured[k] = s.low_pass[k, 0]


@njit(cache=True)
def _delayed(p: Any, s: Any, k: int, value: float) -> float:
    """Value of a channel its dead time ago, linear between ticks."""
    if s.started == 0:
        for row in range(LONGEST_DELAY_TICKS):
            s.history[k, row] = value
    s.history[k, s.position] = value
    delay = p.delay_ticks[k]
    if delay <= 0.0:
        return value
    whole = int(delay)
    later = s.history[k, (s.position - whole) & (LONGEST_DELAY_TICKS - 1)]
    earlier = s.history[k, (s.position - whole - 1) & (LONGEST_DELAY_TICKS - 1)]
    return later + (delay - whole) * (earlier - later)


@njit(cache=True)
def _analogue(p: Any, s: Any, values: Any, noise: Any, contacts: Any, sensed: Any) -> None:
    measured = s.measured
    _inertial(p, s, values, measured)
    _low_pass(p, s, measured)
    measured[MASTER_PRESSURE] = values[p.true_master_pressure]
    for i in range(4):
        measured[BRAKE_PRESSURE + i] = values[p.true_brake_pressure_fl + i]
    measured[PEDAL_FORCE] = values[p.driver_pedal_force]
    measured[STEERING] = values[p.driver_steering_wheel_angle]
    filtered = measured[ACCELERATION_X]
    for k in range(CHANNELS):
        value = p.scale[k] * _delayed(p, s, k, measured[k]) + p.offset[k] + p.noise[k] * noise[DRAWN_TICKS * k]
        resolution = p.resolution[k]
        if resolution > 0.0:
            value = math.floor(value / resolution + 0.5) * resolution
        is_open = contact_open(p, s, k, contacts[DRAWN_TICKS * k])
        sensed[p.to_channel[k]] = reported(p, s, k, value, is_open)
    if p.acceleration_source == IDEAL:
        sensed[p.to_channel[ACCELERATION_X]] = values[p.true_longitudinal_acceleration]
    elif p.acceleration_source == NOISE_FREE:
        sensed[p.to_channel[ACCELERATION_X]] = filtered


@njit(cache=True)
def _wheels(p: Any, s: Any, edges: Any, noise: Any, contacts: Any, values: Any, sensed: Any, time: float) -> None:
    now = time + TIME_STEP_S
    for i in range(4):
        omega = values[p.true_wheel_speed_fl + i]
        if s.started == 0:
            s.omega[i] = omega
        is_open = contact_open(p, s, CHANNELS + i, contacts[DRAWN_TICKS * (CHANNELS + i)])
        s.blind[i] = 1 if is_open or abs(omega) < slowest_seen(p, i) else 0
        jitter = p.edge_jitter * noise[DRAWN_TICKS * (CHANNELS + i)]
        turn_ring(p, s, i, numbers_at(edges + 8 * p.teeth * i), omega, time, jitter)
        speed = measure_speed(p, s, i, now)
        if p.stuck[CHANNELS + i] <= 0.5 or s.started == 0:
            s.wheel_reports[i, 0] = p.ring_scale[i] * speed
            s.wheel_reports[i, 1] = s.count[i] & (COUNTER_WRAP - 1)
            s.wheel_reports[i, 2] = s.timer[i]
    for i in range(4):
        report = s.wheel_reports[p.connected[i]]
        sensed[p.to_wheel_speed_fl + i] = report[0]
        sensed[p.to_wheel_edge_count_fl + i] = report[1]
        sensed[p.to_wheel_edge_time_fl + i] = report[2]
    s.history_position = (s.history_position + 1) & (HISTORY_TICKS - 1)


@njit(cache=True)
def _powertrain(p: Any, values: Any, sensed: Any) -> None:
    drive = p.drive_torque_demand_fl
    output_speed = 0.0
    for i in range(4):
        output_speed += p.wheel_share[i] * values[p.true_wheel_speed_fl + i]
    sensed[p.to_engine_torque] = values[p.true_engine_torque]
    sensed[p.to_engine_speed] = values[p.true_engine_speed]
    sensed[p.to_gearbox_speed] = p.final_drive * output_speed
    sensed[p.to_gear] = values[p.driver_gear]
    sensed[p.to_drive_torque_f] = values[drive] + values[drive + 1]
    sensed[p.to_drive_torque_r] = values[drive + 2] + values[drive + 3]


@njit(cache=True)
def sensors_step(memory: int, time: float) -> None:
    """Advance by 1 ms.

    Parameters
    ----------
    memory
        Address of the list of addresses. These are, in the order ``AT_…``: records of ``PARAMETER_RECORD`` and
        ``STATE_RECORD``; angles of the edges, shape (4, teeth); standard normal and uniform random numbers, shapes
        (RANDOM_NUMBERS, DRAWN_TICKS), of which each tick takes a column; the signal vector; the layout of block "bus",
        where what comes from the ECU is left alone.
    time : s
        Start of the tick.
    """
    places: Any = addresses_at(memory)
    p = record_at(places[AT_PARAMETERS], PARAMETER_RECORD)
    s = record_at(places[AT_STATE], STATE_RECORD)
    # from the tick's column on: those of a channel lie a row apart
    noise = numbers_at(places[AT_NOISE] + 8 * s.row)
    contacts = numbers_at(places[AT_CONTACTS] + 8 * s.contact_row)
    values, sensed = numbers_at(places[AT_VALUES]), numbers_at(places[AT_SENSED])
    _analogue(p, s, values, noise, contacts, sensed)
    _wheels(p, s, places[AT_EDGES], noise, contacts, values, sensed, time)
    _powertrain(p, values, sensed)
    sensed[p.to_brake_switch] = 1.0 if values[p.driver_pedal_force] >= p.brake_switch_force else 0.0
    sensed[p.to_steering_command] = values[p.driver_steering_wheel_angle] / p.steering_ratio
    left = p.true_road_wheel_angle_fl
    sensed[p.to_road_wheel_angle] = 0.5 * (values[left] + values[left + 1])
    sensed[p.to_ignition] = 1.0
    s.position = (s.position + 1) & (LONGEST_DELAY_TICKS - 1)
    s.row += 1
    s.contact_row += 1
    s.started = 1
