"""When a longitudinal filter runs, and at which speed it starts (friction document 3.6.7)."""

from numba import njit

IDLE, START, RUN, STOP = range(4)


@njit(cache=True)
def decide(
    active: bool,
    inputs_lost: bool,
    rim_f: float,
    rim_r: float,
    slowest: float,
    speed: float,
    minimum: float,
    hysteresis: float,
) -> int:
    """What to do in this tick.

    A filter starts when every wheel rolls at the minimum speed: where one of an axle does not report its speed yet, the
    axle's mean would start the filter at half the car's speed. It stops when the slower axle *and* the estimated speed
    are below the minimum, so that wheels locked at speed do not stop it, or when an input is lost.

    Parameters
    ----------
    rim_f, rim_r : float
        Rim speed of the front and rear wheels, mean of the axle [m/s].
    slowest : float
        Rim speed of the slowest wheel [m/s].
    speed : float
        Estimated speed [m/s].
    minimum, hysteresis : float
        Minimum speed and by how much less stops the filter [m/s].

    Returns
    -------
    int
        ``IDLE``, ``START``, ``RUN`` or ``STOP``.
    """
    if not active:
        return IDLE if inputs_lost or slowest < minimum else START
    threshold = minimum - hysteresis
    return STOP if inputs_lost or (min(rim_f, rim_r) < threshold and speed < threshold) else RUN


@njit(cache=True)
def start_speed(acceleration: float, rim_f: float, rim_r: float) -> float:
    """Speed [m/s] of the wheels that slip least: the slower axle while accelerating, the faster one otherwise."""
    return min(rim_f, rim_r) if acceleration > 0.0 else max(rim_f, rim_r)
