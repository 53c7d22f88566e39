"""The driver's hands, compiled: steering profiles, and following a path by preview with human delay and limits.

The driver aims at the point of the path that the car would reach within the preview time and steers the arc that leads
there from the direction in which the car moves (its course, not its heading). Against a yaw rate that this arc does not
need the driver countersteers. What the hands do lags what the eyes see by the reaction delay, and is bounded in rate
and angle.
"""

import math
from typing import Any

from numba import njit

from vehicle_model.driver_record import (
    ANGLE,
    CIRCLE,
    LONGEST_REACTION_TICKS,
    PATH,
    SINE,
    SINE_WITH_DWELL,
    STRAIGHT,
    TABLE,
)
from vehicle_model.interface import TIME_STEP_S

_SHORTEST_PREVIEW_M = 4.0
_SLOWEST_M_S = 0.5  # below it the hands rest: there is no course to correct
_TRIM_RATE = 0.1  # 1/s: how fast a lasting offset from the path is steered away
_LARGEST_TRIM = 0.01  # 1/m


@njit(cache=True)
def _table_angle(s: Any, table: Any, elapsed: float) -> float:
    count = table.shape[1]
    while s.table_row < count - 1 and table[0, s.table_row + 1] <= elapsed:
        s.table_row += 1
    row = s.table_row
    if elapsed <= table[0, 0] or row == count - 1:
        return table[1, row]
    share = (elapsed - table[0, row]) / (table[0, row + 1] - table[0, row])
    return table[1, row] + share * (table[1, row + 1] - table[1, row])


@njit(cache=True)
def _sine(c: Any, elapsed: float) -> float:
    """Sine, or sine with a pause of ``dwell`` at its second peak; zero after the end."""
    turns = c.frequency * elapsed
    if c.hands == SINE_WITH_DWELL:
        pause = c.dwell * c.frequency
        turns = turns if turns <= 0.75 else max(0.75, turns - pause)
    if turns >= c.periods:
        return 0.0
    return c.amplitude * math.sin(2.0 * math.pi * turns)


@njit(cache=True)
def _begin(c: Any, s: Any, values: Any, time: float) -> None:
    s.hands_serial = c.hands_serial
    s.hands_began = time
    s.steering_start = s.steering
    s.table_row = 0
    follows = c.hands in (STRAIGHT, CIRCLE, PATH)
    if follows and s.follows == 0:
        s.trim = 0.0
        for k in range(LONGEST_REACTION_TICKS):
            s.history[k] = s.steering
    s.follows = 1 if follows else 0
    if c.hands == CIRCLE:
        course = _course(c, values)
        s.centre_x = values[c.position_x] - c.path_radius * math.sin(course)
        s.centre_y = values[c.position_y] + c.path_radius * math.cos(course)


@njit(cache=True)
def _course(c: Any, values: Any) -> float:
    v_x, v_y = values[c.speed], values[c.lateral_speed]
    slip = math.atan2(v_y, v_x) if v_x > _SLOWEST_M_S else 0.0
    return values[c.yaw_angle] + slip


@njit(cache=True)
def _path_at(table: Any, x: float) -> float:
    """y of the path at a place along the road."""
    last = table.shape[1] - 1
    if x <= table[0, 0]:
        return table[1, 0]
    for k in range(1, last + 1):
        if x < table[0, k]:
            share = (x - table[0, k - 1]) / (table[0, k] - table[0, k - 1])
            return table[1, k - 1] + share * (table[1, k] - table[1, k - 1])
    return table[1, last]


@njit(cache=True)
def _arc_to_path(c: Any, s: Any, values: Any, table: Any, ahead: float) -> tuple[float, float]:
    """Curvature of the arc to the point of the path ``ahead`` metres on, and the car's offset to the path's left."""
    x, y = values[c.position_x], values[c.position_y]
    course = _course(c, values)
    if c.hands == STRAIGHT:
        offset = y - c.path_y
        to_x, to_y = ahead, -offset
    elif c.hands == PATH:
        offset = y - _path_at(table, x)
        to_x, to_y = ahead, _path_at(table, x + ahead) - y
    else:
        from_x, from_y = x - s.centre_x, y - s.centre_y
        radius = abs(c.path_radius)
        side = 1.0 if c.path_radius > 0.0 else -1.0
        offset = side * (radius - math.sqrt(from_x * from_x + from_y * from_y))
        turned = math.atan2(from_y, from_x) + side * ahead / radius
        to_x = radius * math.cos(turned) - from_x
        to_y = radius * math.sin(turned) - from_y
    across = math.cos(course) * to_y - math.sin(course) * to_x
    return 2.0 * across / (to_x * to_x + to_y * to_y), offset


@njit(cache=True)
def _follow(c: Any, s: Any, values: Any, table: Any) -> float:
    """Steering-wheel angle that the hands reach for now [rad]."""
    v_x, v_y = values[c.speed], values[c.lateral_speed]
    speed = math.sqrt(v_x * v_x + v_y * v_y)
    if speed < _SLOWEST_M_S:
        return s.steering
    ahead = max(c.preview * speed, _SHORTEST_PREVIEW_M)
    arc, offset = _arc_to_path(c, s, values, table, ahead)
    trim = s.trim - _TRIM_RATE * TIME_STEP_S * 2.0 * offset / (ahead * ahead)
    s.trim = min(max(trim, -_LARGEST_TRIM), _LARGEST_TRIM)
    curvature = arc + s.trim
    wanted = c.steering_ratio * curvature * (c.wheelbase + c.understeer * speed * speed)
    wanted -= c.countersteer_gain * (values[c.true_yaw_rate] - curvature * speed)
    s.history[s.position] = min(max(wanted, -c.maximum_angle), c.maximum_angle)
    seen = s.history[(s.position - c.reaction_ticks) % LONGEST_REACTION_TICKS]
    s.position = (s.position + 1) % LONGEST_REACTION_TICKS
    return seen


@njit(cache=True)
def steer(c: Any, s: Any, values: Any, table: Any, time: float) -> None:
    """Advance the hands by 1 ms; see `driver.driver_step`."""
    if s.hands_serial != c.hands_serial:
        _begin(c, s, values, time)
    elapsed = time - s.hands_began
    if c.hands == TABLE:
        s.steering = _table_angle(s, table, elapsed)
    elif c.hands == SINE or c.hands == SINE_WITH_DWELL:
        s.steering = s.steering_start + _sine(c, elapsed)
    else:
        target = c.angle if c.hands == ANGLE else _follow(c, s, values, table)
        change = c.rate * TIME_STEP_S
        s.steering += min(max(target - s.steering, -change), change)
