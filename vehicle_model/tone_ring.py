"""Tone rings: edges in continuous time, counted and timed as a wheel-speed input of a control unit sees them.

Within a tick the wheel's speed is linear in time, so that the instant at which an edge passes the sensor has a closed
form. The control unit knows nothing but the number of edges and the time of the last one, read from a timer that counts
in steps and wraps. Its speed is the way between two edges over their time; the sensor has no sense of direction.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.interface import TIME_STEP_S

TURN = 2.0 * math.pi
TIMER_WRAP_S = 2**20 * 1e-6
"""Time after which the time of the last edge begins again at zero: a counter of 20 bits and 1 us."""
COUNTER_WRAP = 65536
HISTORY_TICKS = 128  # a power of two
MOST_TEETH = 512
_LARGEST_PITCH_ERROR = 0.45  # further away a tooth would meet its neighbour

RING_FIELDS = [
    ("pitch", "f8"),
    ("teeth", "i8"),
    ("timer_resolution", "f8"),
    ("edge_jitter", "f8"),
    ("window_ticks", "i8"),
    ("standstill_timeout", "f8"),
    ("ring_radius", "f8"),
    ("threshold_speed", "f8"),
    ("missing_teeth", "i8", (4,)),
    ("air_gap", "f8", (4,)),
]
RING_STATE_FIELDS = [
    ("angle", "f8", (4,)),  # of the wheel, 0 to 2 pi
    ("omega", "f8", (4,)),  # at the end of the last tick
    ("next_edge", "i8", (4,)),  # first edge ahead of the angle
    ("count", "i8", (4,)),
    ("edge_time", "f8", (4,)),  # of the last edge, not wrapped
    ("timer", "f8", (4,)),  # the same as the control unit's timer shows it
    ("speed", "f8", (4,)),
    ("history_position", "i8"),
    ("count_history", "i8", (4, HISTORY_TICKS)),
    ("time_history", "f8", (4, HISTORY_TICKS)),
    ("blind", "i8", (4,)),  # 1 while the sensor sees no edges
]


def edge_angles(
    teeth: int, pitch_error: float, eccentricity: float, errors: NDArray[np.float64], direction: float
) -> NDArray[np.float64]:
    """Angles of the wheel at which an edge passes the sensor.

    Parameters
    ----------
    teeth : int
        Edges per turn.
    pitch_error : float
        Standard deviation of a tooth's place, in pitches.
    eccentricity : float
        Eccentricity of the ring over its radius.
    errors : shape (teeth,) or longer
        Standard normal numbers, one per tooth.
    direction : rad
        Angle of the wheel at which the ring's centre lies towards the sensor.

    Returns
    -------
    shape (teeth,), rising, from 0 to 2 pi
    """
    offsets = np.clip(pitch_error * errors[:teeth], -_LARGEST_PITCH_ERROR, _LARGEST_PITCH_ERROR)
    on_ring = (np.arange(teeth) + offsets) * TURN / teeth
    # an eccentric ring passes the sensor at the angle on_ring = wheel + e sin(wheel - direction)
    wheel = on_ring.copy()
    for _ in range(60):
        wheel = on_ring - eccentricity * np.sin(wheel - direction)
    return np.asarray(np.sort(wheel % TURN))


@njit(cache=True)
def _after(number: int, teeth: int) -> int:
    return number + 1 if number + 1 < teeth else 0


@njit(cache=True)
def _before(number: int, teeth: int) -> int:
    return number - 1 if number > 0 else teeth - 1


@njit(cache=True)
def _note_edge(p: Any, s: Any, i: int, at: float, jitter: float) -> None:
    late = max(at + jitter, s.edge_time[i])
    resolution = p.timer_resolution
    s.edge_time[i] = math.floor(late / resolution + 1e-9) * resolution if resolution > 0.0 else late
    s.timer[i] = s.edge_time[i] % TIMER_WRAP_S
    s.count[i] += 1


@njit(cache=True)
def _turn(
    p: Any, s: Any, i: int, edges: Any, slow: float, fast: float, start: float, duration: float, jitter: float
) -> None:
    """Turn a wheel with a speed from ``slow`` to ``fast`` (of one sign, in this order) and note the edges."""
    forward = slow + fast > 0.0
    first, last = abs(slow), abs(fast)
    way = 0.5 * (first + last) * duration
    if way <= 0.0:
        return
    growth = (last - first) / duration
    teeth = p.teeth
    number = s.next_edge[i] if forward else _before(s.next_edge[i], teeth)
    ahead = (edges[number] - s.angle[i]) if forward else (s.angle[i] - edges[number])
    if ahead < 0.0:
        ahead += TURN
    while ahead <= way:
        root = math.sqrt(max(first * first + 2.0 * growth * ahead, 0.0))
        elapsed = min(2.0 * ahead / (first + root), duration) if first + root > 0.0 else duration
        if number >= p.missing_teeth[i] and s.blind[i] == 0:
            _note_edge(p, s, i, start + elapsed, jitter)
        after = _after(number, teeth) if forward else _before(number, teeth)
        gap = edges[after] - edges[number] if forward else edges[number] - edges[after]
        ahead += gap if gap > 0.0 else gap + TURN
        number = after
    s.next_edge[i] = number if forward else _after(number, teeth)
    angle = s.angle[i] + (way if forward else -way)
    while angle >= TURN:
        angle -= TURN
    while angle < 0.0:
        angle += TURN
    s.angle[i] = angle


@njit(cache=True)
def turn_ring(p: Any, s: Any, i: int, edges: Any, omega: float, time: float, jitter: float) -> None:
    """Advance ring ``i`` by a tick in which the wheel's speed changes linearly to ``omega``.

    Parameters
    ----------
    p, s
        Records with ``RING_FIELDS`` and ``RING_STATE_FIELDS``.
    edges : shape (teeth,)
        Of this ring, from `edge_angles`.
    omega : rad/s
        Speed at the end of the tick.
    time : s
        Start of the tick.
    jitter : s
        Error of the time of this tick's edges.
    """
    before = s.omega[i]
    s.omega[i] = omega
    if before * omega < 0.0:
        turn_back = TIME_STEP_S * before / (before - omega)
        _turn(p, s, i, edges, before, 0.0, time, turn_back, jitter)
        _turn(p, s, i, edges, 0.0, omega, time + turn_back, TIME_STEP_S - turn_back, jitter)
    else:
        _turn(p, s, i, edges, before, omega, time, TIME_STEP_S, jitter)


@njit(cache=True)
def measure_speed(p: Any, s: Any, i: int, now: float) -> float:
    """Speed [rad/s] that the control unit's input makes of its edges; call once per tick, after `turn_ring`.

    Way between the last edge and the last one of a window ago over the time between them. Without a new edge the speed
    cannot be higher than a pitch over the time since the last one, and is zero after the timeout.
    """
    position = s.history_position
    then = (position - p.window_ticks) & (HISTORY_TICKS - 1)
    passed = s.count[i] - s.count_history[i, then]
    since = now - s.edge_time[i]
    if passed > 0:
        between = s.edge_time[i] - s.time_history[i, then]
        if between > 0.0:
            s.speed[i] = passed * p.pitch / between
    if since > p.standstill_timeout:
        s.speed[i] = 0.0
    elif s.speed[i] * since > p.pitch:
        s.speed[i] = p.pitch / since
    s.count_history[i, position] = s.count[i]
    s.time_history[i, position] = s.edge_time[i]
    return s.speed[i]
