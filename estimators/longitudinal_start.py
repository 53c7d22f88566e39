"""When a longitudinal filter runs, and at which speed it starts (friction document 3.6.7)."""

from numba import njit

IDLE, START, RUN, STOP = range(4)


@njit(cache=True)
def decide(
    active: bool, inputs_lost: bool, rim_f: float, rim_r: float, speed: float, minimum: float, hysteresis: float
) -> int:
    """What to do in this tick.

    A filter starts when the slower axle rolls at the minimum speed; it stops when that axle *and* the estimated speed
    are below it, so that wheels locked at speed do not stop it, or when an input is lost.

    Parameters
    ----------
    rim_f, rim_r : float
        Rim speed of the front and rear wheels [m/s].
    speed : float
        Estimated speed [m/s].
    minimum, hysteresis : float
        Minimum speed and by how much less stops the filter [m/s].

    Returns
    -------
    int
        ``IDLE``, ``START``, ``RUN`` or ``STOP``.
    """
    slowest = min(rim_f, rim_r)
    if not active:
        return IDLE if inputs_lost or slowest < minimum else START
    threshold = minimum - hysteresis
    return STOP if inputs_lost or (slowest < threshold and speed < threshold) else RUN


@njit(cache=True)
def start_speed(acceleration: float, rim_f: float, rim_r: float) -> float:
    """Speed [m/s] of the wheels that slip least: the slower axle while accelerating, the faster one otherwise."""
    return min(rim_f, rim_r) if acceleration > 0.0 else max(rim_f, rim_r)
