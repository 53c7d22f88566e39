"""Parameters of the MuJoCo car by dotted path, and how they fill the memory of the compiled step."""

import numpy as np
from numpy.typing import NDArray

from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS
from vehicle_model.plant_record import Record
from vehicle_model.rigid_bodies import RigidBodies
from vehicle_model.tyres.coefficients import write_tyre
from vehicle_model.tyres.tyre_file import CurveTyre, TirTyre, TyrePair
from vehicle_model.vehicle_file import STANDARD_GRAVITY, VehicleFile

SECTIONS = ("body", "axles", "wheels", "suspension", "steering", "aerodynamics", "tyres")
RIGID_BODY_SECTIONS = ("body", "axles", "wheels")
ONLY_WHEN_BUILT = frozenset(
    {"body.length", "body.width", "body.height", *(f"wheels.{wheel}.unloaded_radius" for wheel in WHEELS)}
)
"""Parameters from which others are estimated when a file is read; a car in use no longer asks for them."""


class PlantOptions(FileModel):
    """Numerics of the MuJoCo car."""

    steps_per_tick: int = parameter("1", 1, low=1, high=50, description="integration steps of the car per millisecond")
    wheel_substeps: int = parameter(
        "1", 5, low=1, high=200, description="steps of the wheels' spin per integration step"
    )


def write_masses(record: NDArray[np.void], vehicle: VehicleFile, at_rest: VehicleFile, bodies: RigidBodies) -> None:
    """Fill geometry, masses and static loads.

    Parameters
    ----------
    record : shape (1,), dtype ``PARAMETER_RECORD``
    vehicle, at_rest : VehicleFile
        Present parameters; those with which the car was built, which fix ride height and preloads.
    bodies : RigidBodies
        The car taken apart, from the present parameters.
    """
    p = record[0]
    p["height"] = at_rest.body.centre_of_gravity_height
    p["wheel_x"], p["wheel_y"], p["wheel_z"] = bodies.wheel_positions.T
    p["sprung_mass"], p["sprung_centre"] = bodies.sprung_mass, bodies.sprung_centre
    p["sprung_inertia"] = bodies.sprung_inertia
    p["unsprung_mass"], p["spin_inertia"] = bodies.unsprung_mass, bodies.spin_inertia
    p["transverse_inertia"] = bodies.transverse_inertia
    p["static_load"] = at_rest.static_loads()


def write_numerics(record: NDArray[np.void], options: PlantOptions) -> None:
    """Fill the numbers of steps."""
    record["steps"], record["substeps"] = options.steps_per_tick, options.wheel_substeps


def write_tyres(record: NDArray[np.void], tyre_rows: NDArray[np.float64], vehicle: VehicleFile) -> None:
    """Fill the tyres' rows (shape ``(4, TYRE_SIZE)``) and their contact states."""
    pair = vehicle.tyre_pair
    for i in range(4):
        tyre = pair.front if i < 2 else pair.rear
        _write_contact(record[0], i, tyre)
        write_tyre(tyre, tyre_rows[i], right=i % 2 == 1)


def write_running_gear(record: NDArray[np.void], vehicle: VehicleFile, at_rest: VehicleFile) -> None:
    """Fill wheels, suspension, steering and air forces; static loads are there already."""
    _write_wheels(record[0], vehicle, at_rest)
    _write_steering_and_air(record[0], vehicle)


def _write_wheels(p: Record, vehicle: VehicleFile, at_rest: VehicleFile) -> None:
    for i, name in enumerate(WHEELS):
        wheel, wheel_at_rest = getattr(vehicle.wheels, name), getattr(at_rest.wheels, name)
        suspension = vehicle.suspension.front if i < 2 else vehicle.suspension.rear
        p["radius"][i] = wheel.radius
        p["vertical_stiffness"][i] = wheel.vertical_stiffness
        p["vertical_damping"][i] = wheel.vertical_damping
        p["rolling_resistance"][i] = wheel.rolling_resistance
        p["friction_factor"][i] = wheel.friction_factor
        p["toe"][i] = wheel.toe
        p["spring_rate"][i] = suspension.spring_rate
        # the spring carries what rests on the wheel without the wheel itself
        p["spring_preload"][i] = p["static_load"][i] - wheel_at_rest.unsprung_mass * STANDARD_GRAVITY
        p["compression_damping"][i] = suspension.compression_damping
        p["rebound_damping"][i] = suspension.rebound_damping
        p["anti_roll_rate"][i] = suspension.anti_roll_rate


def _write_steering_and_air(p: Record, vehicle: VehicleFile) -> None:
    steering, air = vehicle.steering, vehicle.aerodynamics
    p["steering_ratio"], p["steering_offset"], p["ackermann"] = steering.ratio, steering.offset, steering.ackermann
    p["half_track_over_wheelbase"] = vehicle.axles.front.track / (2.0 * vehicle.body.wheelbase)
    p["steering_stiffness"], p["steering_damping"] = steering.stiffness, steering.damping
    area = 0.5 * air.air_density * air.frontal_area
    p["drag"] = area * air.drag_coefficient  # D_a of eq. 28
    p["side_force"] = area * air.side_force_coefficient
    p["lift_front"], p["lift_rear"] = area * air.lift_coefficient_front, area * air.lift_coefficient_rear
    p["drag_height"] = air.drag_height


def _write_contact(p: Record, i: int, tyre: CurveTyre | TirTyre) -> None:
    contact = tyre.contact
    p["relaxation_x"][i] = tyre.relaxation_length_longitudinal
    p["relaxation_y"][i] = tyre.relaxation_length_lateral
    p["contact_stiffness_x"][i], p["contact_stiffness_y"][i] = contact.longitudinal_stiffness, contact.lateral_stiffness
    p["contact_damping"][i] = contact.damping
    p["contact_full_below"][i] = contact.full_below
    p["contact_none_above"][i] = max(contact.none_above, 1.01 * contact.full_below)


def copy_of(vehicle: VehicleFile) -> VehicleFile:
    """Deep copy whose tyres are read."""
    copied = vehicle.model_copy(deep=True)
    pair: TyrePair = copied.tyre_pair
    copied.tyres = pair
    return copied
