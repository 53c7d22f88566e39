"""Speed of the car from wheels and accelerometer, for methods that take the speed as known."""

from numba import njit

from estimators.longitudinal_start import start_speed


@njit(cache=True)
def track_speed(
    speed: float, acceleration: float, rim_f: float, rim_r: float, braking_start: float, time_step: float
) -> float:
    """Next speed [m/s]: that of the wheels while they roll, integrated from the accelerometer while the car brakes.

    A braked wheel is never faster than the car, so the faster axle is a lower bound while braking.
    """
    if acceleration > -braking_start:
        return max(0.0, start_speed(acceleration, rim_f, rim_r))
    return max(speed + acceleration * time_step, rim_f, rim_r, 0.0)
