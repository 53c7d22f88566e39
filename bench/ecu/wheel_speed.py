"""Wheel speed and acceleration from pulse counters and the time of the last pulse, as an ECU computes them."""

from typing import Any

import numpy as np
from numba import njit

from bench.ecu.records import (
    AGE_TICKS,
    EDGES_FL,
    SPEED_FRONT,
    SPEED_REAR,
    TASK_S,
    TASK_TICKS,
    WINDOW,
    bus_position,
)

COUNT_MODULUS = 65536.0
TIME_MODULUS_S = 1.048576
UNAMBIGUOUS_S = 1.0
"""Silence after which the wrapped time of an edge says nothing any more."""

_COUNT = bus_position("wheel_edge_count_fl")
_TIME = bus_position("wheel_edge_time_fl")
_SPEED = bus_position("wheel_speed_fl")
_YAW_RATE = bus_position("yaw_rate")


@njit(cache=True)
def _wrapped(now: float, before: float, modulus: float) -> float:
    return (now - before) % modulus


@njit(cache=True)
def _remember_edge(state: Any, wheel: int, angle: float, time: float) -> None:
    position = (state.window_position[wheel] + 1) % WINDOW
    state.window_position[wheel] = position
    state.window_fill[wheel] = min(state.window_fill[wheel] + 1, WINDOW)
    state.window_angle[wheel, position] = angle
    state.window_time[wheel, position] = time


@njit(cache=True)
def _speed_over_window(state: Any, wheel: int, averaging_time: float) -> float:
    """Angle over time between the newest edge and the youngest one that is at least the averaging time older."""
    newest = state.window_position[wheel]
    angle, time = state.window_angle[wheel, newest], state.window_time[wheel, newest]
    speed = 0.0
    for back in range(1, state.window_fill[wheel]):
        older = (newest - back) % WINDOW
        duration = time - state.window_time[wheel, older]
        speed = (angle - state.window_angle[wheel, older]) / max(duration, 1e-6)
        if duration >= averaging_time:
            break
    return float(speed)


@njit(cache=True)
def _restart(state: Any, wheel: int, count: float, time: float) -> None:
    """First edge after a long silence: nothing to measure against yet."""
    state.have_edges[wheel] = 1
    state.edge_count[wheel], state.edge_time[wheel] = count, time
    state.window_fill[wheel] = 0
    state.silent_tasks[wheel] = 0
    _remember_edge(state, wheel, 0.0, 0.0)


@njit(cache=True)
def _speed_from_edges(calibration: Any, state: Any, wheel: int, count: float, time: float) -> float:
    """Rotational speed of a wheel, rad/s."""
    pitch = 2.0 * np.pi / calibration.car_tone_ring_teeth
    silence = state.silent_tasks[wheel] * TASK_S
    new_edges = _wrapped(count, state.edge_count[wheel], COUNT_MODULUS)
    if new_edges == 0.0:
        state.silent_tasks[wheel] += 1
        silence += TASK_S
        if silence > calibration.wheel_speed_standstill_time:
            return 0.0
        return min(float(state.wheel_speed[wheel]), pitch / silence)
    if state.have_edges[wheel] == 0 or silence > UNAMBIGUOUS_S - 2.0 * TASK_S:
        _restart(state, wheel, count, time)
        return float(state.wheel_speed[wheel])
    newest = state.window_position[wheel]
    angle = state.window_angle[wheel, newest] + new_edges * pitch
    moment = state.window_time[wheel, newest] + _wrapped(time, state.edge_time[wheel], TIME_MODULUS_S)
    state.edge_count[wheel], state.edge_time[wheel] = count, time
    state.silent_tasks[wheel] = 0
    _remember_edge(state, wheel, angle, moment)
    return _speed_over_window(state, wheel, calibration.wheel_speed_averaging_time)


@njit(cache=True)
def _rotation(calibration: Any, state: Any, values: Any, wheel: int, with_edges: bool) -> float:
    if not with_edges:
        return max(float(values[_SPEED + wheel]), 0.0)
    return _speed_from_edges(calibration, state, wheel, values[_COUNT + wheel], values[_TIME + wheel])


@njit(cache=True)
def measure_wheels(calibration: Any, state: Any, values: Any, health: Any, with_edges: bool) -> None:
    """Update speed, acceleration and path speed (freed of the car's yaw rate) of the four wheels.

    Parameters
    ----------
    values
        Decoded signals, layout of block "bus".
    health
        Ages of the messages: without a new frame a wheel keeps its speed, missing frames are no missing pulses.
    with_edges
        False where the bus has no pulse counters: the speeds of the wheel-speed frames are used.
    """
    share = TASK_S / (calibration.wheel_speed_acceleration_time_constant + TASK_S)
    yaw_rate = values[_YAW_RATE] if state.inertial_ok else 0.0
    state.yaw_rate = yaw_rate
    state.slowest_wheel = 1e9
    for wheel in range(4):
        source = EDGES_FL + wheel if with_edges else (SPEED_FRONT if wheel < 2 else SPEED_REAR)
        state.fresh[wheel] = 1 if health[source, AGE_TICKS] < TASK_TICKS else 0
        if state.fresh[wheel]:
            state.wheel_speed[wheel] = _rotation(calibration, state, values, wheel, with_edges)
            speed = state.wheel_speed[wheel] * calibration.wheel_radius[wheel]
            raw = (speed - state.previous_speed[wheel]) / TASK_S
            state.raw_acceleration[wheel] = raw
            filtered = state.acceleration[wheel] + share * (raw - state.acceleration[wheel])
            state.acceleration[wheel] = filtered if abs(filtered) > 1e-6 else 0.0
            state.previous_speed[wheel] = speed
        # a wheel on the left is slower in a left turn
        side = 0.5 * calibration.car_track if wheel % 2 == 0 else -0.5 * calibration.car_track
        state.path_speed[wheel] = state.previous_speed[wheel] + yaw_rate * side
        state.slowest_wheel = min(state.slowest_wheel, state.previous_speed[wheel])
