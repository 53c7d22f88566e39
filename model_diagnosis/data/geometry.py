"""The few numbers of a vehicle file that kinematic comparisons of channels need."""

from dataclasses import dataclass

from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FACES = 2.0
"""Pad faces on a disc, each with the pad's friction."""


@dataclass(frozen=True)
class Geometry:
    """Lengths [m], mass [kg] and brake torque per pressure [N m/Pa] of the car.

    Attributes
    ----------
    radii, brake_gains : by wheel
    """

    mass: float
    wheelbase: float
    to_front: float
    height: float
    track_front: float
    track_rear: float
    steering_ratio: float
    radii: dict[str, float]
    brake_gains: dict[str, float]


def geometry_of(vehicle: VehicleFile) -> Geometry:
    """Geometry of a vehicle file."""
    brakes = {"f": vehicle.brakes.front, "r": vehicle.brakes.rear}
    gains = {k: FACES * b.pad_area * b.pad_friction * b.effective_radius for k, b in brakes.items()}
    return Geometry(
        mass=vehicle.body.mass,
        wheelbase=vehicle.body.wheelbase,
        to_front=vehicle.body.centre_of_gravity_to_front_axle,
        height=vehicle.body.centre_of_gravity_height,
        track_front=vehicle.axles.front.track,
        track_rear=vehicle.axles.rear.track,
        steering_ratio=vehicle.steering.ratio,
        radii=wheel_radii(vehicle),
        brake_gains={wheel: gains[wheel[0]] for wheel in WHEELS},
    )


def wheel_radii(vehicle: VehicleFile) -> dict[str, float]:
    """Rolling radius of each wheel [m]."""
    return {wheel: float(getattr(vehicle.wheels, wheel).radius) for wheel in WHEELS}
