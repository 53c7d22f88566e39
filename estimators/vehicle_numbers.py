"""Nominal numbers of the car that estimators use, read from a flat vehicle file.

A vehicle file arrives as a mapping from dotted path (``body.mass``) to a number in SI units. Quantities of whole axles
are built here, once: both wheels turn with an axle's inertia, so it is the sum over its wheels (friction document,
2.4.3).
"""

from collections.abc import Mapping
from dataclasses import dataclass

from signals.errors import InputError

GRAVITY_M_S2 = 9.81


def required(vehicle: Mapping[str, float], path: str) -> float:
    """Number of a vehicle file.

    Raises
    ------
    InputError
        If the file does not give it.
    """
    try:
        return float(vehicle[path])
    except KeyError:
        raise InputError(f"the vehicle file gives no {path}, which the estimator needs") from None


@dataclass(frozen=True)
class LongitudinalCar:
    """Nominal single-track car; forces, inertias and gains of whole axles.

    Attributes
    ----------
    mass, wheelbase, front_length, height, drag_height
        [kg], [m]; ``front_length`` from the front axle to the centre of gravity.
    drag_factor : float
        Half of air density times drag coefficient times frontal area [kg/m] (eq. 28).
    rolling_coefficient : float
        Mean of the four wheels.
    radius, inertia, brake_gain : tuple (front, rear)
        Wheel radius [m], inertia of both wheels [kg m^2], torque per pressure of one wheel's brake [N m/Pa].
    """

    mass: float
    wheelbase: float
    front_length: float
    height: float
    drag_height: float
    drag_factor: float
    rolling_coefficient: float
    radius: tuple[float, float]
    inertia: tuple[float, float]
    brake_gain: tuple[float, float]

    @property
    def weight(self) -> float:
        """Weight of the car [N]."""
        return self.mass * GRAVITY_M_S2

    @property
    def rolling_force(self) -> float:
        """Rolling resistance of the car [N] (eq. 27)."""
        return self.weight * self.rolling_coefficient


def longitudinal_car(vehicle: Mapping[str, float], *, with_brakes: bool = True) -> LongitudinalCar:
    """Read the single-track car of a vehicle file.

    Parameters
    ----------
    vehicle : mapping
        Dotted path to SI number.
    with_brakes : bool
        Whether the gains of the brakes are needed; they are 0 otherwise.

    Raises
    ------
    InputError
        If a number is missing.
    """
    height = required(vehicle, "body.centre_of_gravity_height")
    front, rear = ("fl", "fr"), ("rl", "rr")
    rolling = [required(vehicle, f"wheels.{wheel}.rolling_resistance") for wheel in front + rear]
    return LongitudinalCar(
        mass=required(vehicle, "body.mass"),
        wheelbase=required(vehicle, "body.wheelbase"),
        front_length=required(vehicle, "body.centre_of_gravity_to_front_axle"),
        height=height,
        drag_height=float(vehicle.get("aerodynamics.drag_height", height)),
        drag_factor=0.5
        * required(vehicle, "aerodynamics.air_density")
        * required(vehicle, "aerodynamics.drag_coefficient")
        * required(vehicle, "aerodynamics.frontal_area"),
        rolling_coefficient=sum(rolling) / 4.0,
        radius=(_mean(vehicle, "radius", front), _mean(vehicle, "radius", rear)),
        inertia=(2.0 * _mean(vehicle, "inertia", front), 2.0 * _mean(vehicle, "inertia", rear)),
        brake_gain=(_brake_gain(vehicle, "front"), _brake_gain(vehicle, "rear")) if with_brakes else (0.0, 0.0),
    )


def tone_ring(vehicle: Mapping[str, float], teeth: float | None, window: float | None) -> tuple[float, float]:
    """Teeth and window [s] of the wheel-speed sensors; the vehicle's where a setting leaves them out."""
    return (
        float(vehicle.get("sensors.wheel_speed.teeth", 0.0)) if teeth is None else teeth,
        float(vehicle.get("sensors.wheel_speed.window", 0.0)) if window is None else window,
    )


def _mean(vehicle: Mapping[str, float], name: str, wheels: tuple[str, str]) -> float:
    return 0.5 * sum(required(vehicle, f"wheels.{wheel}.{name}") for wheel in wheels)


def _brake_gain(vehicle: Mapping[str, float], axle: str) -> float:
    """Torque of one wheel's brake over its pressure, two pads (eq. 78)."""
    numbers = (required(vehicle, f"brakes.{axle}.{name}") for name in ("pad_area", "pad_friction", "effective_radius"))
    area, friction, radius = numbers
    return 2.0 * area * friction * radius
