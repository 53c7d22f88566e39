"""Single-track car of the force document for its observers: numbers, gains, error dynamics (its sections 2 and 3)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from estimators.inputs import VALUE
from estimators.kalman.covariance import FloatArray
from estimators.neural_force_settings import NeuralForceSettings, RandomWalkForceSettings
from estimators.vehicle_numbers import GRAVITY_M_S2, required
from estimators.vertical_load_car import slope_of_tyre
from signals.wheels import WHEELS

STAYS_AWAKE = 0.5
"""Share of the slowest speed below which a running observer rests."""

FORCE_CAR = np.dtype(
    [
        ("mass", "f8"),
        ("yaw_inertia", "f8"),
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("front", "f8"),  # C_f, C_r of the axles
        ("rear", "f8"),
        ("rear_sign", "f8"),  # +1; -1 pushes the rear along its slip, as printed
        ("time_constant", "f8"),
        ("slowest", "f8"),
        ("radius", "f8", (4,)),
    ]
)


def force_car(
    vehicle: Mapping[str, float], settings: NeuralForceSettings | RandomWalkForceSettings
) -> NDArray[np.void]:
    """Read the car from the numbers of a vehicle file; record of shape (1,), dtype ``FORCE_CAR``.

    Raises
    ------
    InputError
        If a number is missing and nothing stands for it.
    """
    record = np.zeros(1, FORCE_CAR)
    car = record[0]
    car["mass"], car["yaw_inertia"] = required(vehicle, "body.mass"), required(vehicle, "body.yaw_inertia")
    wheelbase = required(vehicle, "body.wheelbase")
    car["to_front"] = required(vehicle, "body.centre_of_gravity_to_front_axle")
    car["to_rear"] = wheelbase - car["to_front"]
    car["slowest"] = settings.slowest
    car["radius"] = [required(vehicle, f"wheels.{wheel}.radius") for wheel in WHEELS]
    weight = car["mass"] * GRAVITY_M_S2
    loads = weight * car["to_rear"] / wheelbase, weight * car["to_front"] / wheelbase
    given = settings.cornering_stiffness_front, settings.cornering_stiffness_rear
    for axle, value, load in zip(("front", "rear"), given, loads, strict=True):
        if value is None:
            value = vehicle.get(f"steered_track.cornering_stiffness_{axle}")
        car[axle] = 2.0 * slope_of_tyre(vehicle, axle, 0.5 * load) if value is None else value
    car["rear_sign"], car["time_constant"] = 1.0, 0.1
    if isinstance(settings, NeuralForceSettings):
        car["rear_sign"] = -1.0 if settings.printed_rear_sign else 1.0
        tau = settings.steering_time_constant
        car["time_constant"] = vehicle.get("steered_track.steering_time_constant", 0.1) if tau is None else tau
    return record


@njit(cache=True)
def mean_rim_speed(car: Any, guard: FloatArray, wheels: int) -> float:
    """Mean of the four rim speeds [m/s]; ``wheels`` is the row of the first wheel speed in the guard."""
    total = 0.0
    for i in range(4):
        total += 0.25 * car.radius[i] * guard[wheels + i, VALUE]
    return total


@njit(cache=True)
def rolls(car: Any, guard: FloatArray, wheels: int, runs: bool) -> bool:
    """Whether the wheels tell a speed to begin at, or to go on with.

    A wheel that has not shown its second edge yet reads zero: the mean of the four is too low by its share, and an
    observer that begins there answers with some 10 kN until its speed has caught up. So every wheel has to turn first.
    """
    if runs:
        return mean_rim_speed(car, guard, wheels) >= STAYS_AWAKE * car.slowest
    least = car.radius[0] * guard[wheels, VALUE]
    for i in range(1, 4):
        least = min(least, car.radius[i] * guard[wheels + i, VALUE])
    return least >= car.slowest


def observer_gains(settings: NeuralForceSettings, time_constant: float) -> tuple[float, float, float, float]:
    """L_11 [1/s], L_12 [m/(s rad)], L_21, L_22 [1/s] from the poles (3.2, 3.3)."""
    first, second = settings.poles_yaw
    return -(first + second), first * second, -settings.pole_speed, -settings.pole_steering - 1.0 / time_constant


def coupling(car: np.void, speed: float) -> tuple[float, float, float]:
    """k, d and beta of the error dynamics at a speed [m/s] (3.2)."""
    front, rear = float(car["front"]), float(car["rear_sign"] * car["rear"])
    k = (car["to_rear"] * rear - car["to_front"] * front) / (car["yaw_inertia"] * speed)
    d = (front + rear) / (car["mass"] * speed)
    return float(k), float(d), float(car["yaw_inertia"] / (car["mass"] * car["to_front"]))


def zero_of_error_dynamics(car: np.void, speed: float) -> float:
    """Limit of the slowest pole of observer 1 for a large gain [1/s]: -(d + k beta) (3.2)."""
    k, d, beta = coupling(car, speed)
    return -(d + k * beta)


def error_dynamics(car: np.void, speed: float, gain_yaw: float, gain_lateral: float) -> FloatArray:
    """A_e of observer 1 at a speed, shape (2, 2): errors of yaw rate and lateral speed (3.5)."""
    k, d, _ = coupling(car, speed)
    return np.array([[-gain_yaw, k], [-gain_lateral, -d]])


def lyapunov_matrices(
    car: np.void, speed: float, ratio: float, gain_yaw: float, gain_lateral: float
) -> tuple[FloatArray, FloatArray, float]:
    """P, Q and F_1 of section 3.5 for p_2 = 1 and rho = p_1 / p_2.

    P is the same at every speed: where P and Q are positive definite at all speeds of a range, it is a common Lyapunov
    matrix of the observer there.
    """
    _, _, beta = coupling(car, speed)
    p = np.array([[ratio, -beta], [-beta, 1.0]])
    a = error_dynamics(car, speed, gain_yaw, gain_lateral)
    weight = ratio * car["to_front"] / car["yaw_inertia"] - beta / car["mass"]
    return p, -(a.T @ p + p @ a), float(weight)


def centres(axes: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Grid of network centres, shape (n, 2)."""
    first, second = np.meshgrid(*axes, indexing="ij")
    return np.column_stack([first.ravel(), second.ravel()])


def network_centres(settings: NeuralForceSettings) -> tuple[FloatArray, FloatArray]:
    """Centres of both networks in units of their inputs (3.4)."""
    yaw = np.linspace(-1.0, 1.0, settings.neurons_yaw)
    speed = np.linspace(0.0, 1.0, settings.neurons_speed)
    steering = np.linspace(-1.0, 1.0, settings.neurons_steering)
    return centres((yaw, yaw)), centres((speed, steering))
