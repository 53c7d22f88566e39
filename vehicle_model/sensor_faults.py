"""Faults of sensors, compiled: loose contacts, wrong mounting, drift, stuck values, lost edges of a tone ring.

Neutral parameters leave every reported value bit for bit as it is.
"""

import math
from typing import Any

from numba import njit

from vehicle_model.interface import TIME_STEP_S

_TURN = 2.0 * math.pi


@njit(cache=True)
def contact_open(p: Any, s: Any, k: int, drawn: float) -> bool:
    """Whether the contact of channel ``k`` is open in this tick.

    Interruptions begin at random with the mean rate of the channel and last a fixed time.

    Parameters
    ----------
    drawn : float
        Uniform random number of the tick, 0 to 1.
    """
    if p.dropout_rate[k] == 0.0:
        s.open_ticks[k] = 0.0
        return False
    if s.open_ticks[k] <= 0.0 and drawn < p.dropout_rate[k] * TIME_STEP_S:
        s.open_ticks[k] = max(p.dropout_duration[k] / TIME_STEP_S, 1.0)
    if s.open_ticks[k] > 0.0:
        s.open_ticks[k] -= 1.0
        return True
    return False


@njit(cache=True)
def mount(p: Any, measured: Any) -> None:
    """Turn specific force (x, y, z) and rates (order z, x, y) from body axes into those of a unit that sits askew."""
    if p.mounting[0] == 0.0 and p.mounting[1] == 0.0 and p.mounting[2] == 0.0:
        return
    measured[0], measured[1], measured[2] = _turned(p.mounting, measured[0], measured[1], measured[2])
    measured[4], measured[5], measured[3] = _turned(p.mounting, measured[4], measured[5], measured[3])


@njit(cache=True)
def _turned(angles: Any, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector in axes turned by yaw, then pitch, then roll (ISO 8855 order)."""
    cosine, sine = math.cos(angles[2]), math.sin(angles[2])
    x, y = cosine * x + sine * y, cosine * y - sine * x
    cosine, sine = math.cos(angles[1]), math.sin(angles[1])
    x, z = cosine * x - sine * z, cosine * z + sine * x
    cosine, sine = math.cos(angles[0]), math.sin(angles[0])
    y, z = cosine * y + sine * z, cosine * z - sine * y
    return x, y, z


@njit(cache=True)
def reported(p: Any, s: Any, k: int, value: float, is_open: bool) -> float:
    """What an analogue channel reports of the value that a healthy one would: drift, open contact, stuck."""
    if p.drift[k] != 0.0:
        s.drifted[k] += p.drift[k] * TIME_STEP_S
    value += s.drifted[k]
    if is_open:
        value = 0.0
    if p.stuck[k] > 0.5 and s.started != 0:
        return float(s.held[k])
    s.held[k] = value
    return value


@njit(cache=True)
def slowest_seen(p: Any, i: int) -> float:
    """Wheel speed [rad/s] below which the sensor sees no edges because its air gap is too large.

    The field of a tone ring falls as exp(-2π gap / pitch) (Wallace's law, a magnetic pattern of that wavelength), the
    voltage that it induces rises with speed, so the speed at which the voltage suffices grows as exp(2π gap / pitch).
    """
    gap = p.air_gap[i]
    if gap == 0.0:
        return 0.0
    return float(p.threshold_speed * (math.exp(_TURN * gap / (p.ring_radius * p.pitch)) - 1.0))
