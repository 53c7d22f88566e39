"""Parameters of the MuJoCo car by dotted path, and how they fill the memory of the compiled step."""

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS
from vehicle_model.guidance import Guidance
from vehicle_model.plant_record import Record
from vehicle_model.rigid_bodies import RigidBodies
from vehicle_model.suspension_file import damper_curve_problem
from vehicle_model.tyres.coefficients import write_tyre
from vehicle_model.tyres.relaxation import fill_in
from vehicle_model.tyres.tyre_file import AnyTyre, TirTyre, TyrePair
from vehicle_model.vehicle_file import STANDARD_GRAVITY, VehicleFile

SECTIONS = ("body", "axles", "wheels", "suspension", "steering", "aerodynamics", "tyres", "terms")
RIGID_BODY_SECTIONS = ("body", "axles", "wheels")
GUIDANCE_SECTIONS = ("axles", "wheels", "suspension")
"""Sections on which the lines depend along which the wheels travel."""
STEERING_AND_AIR_SECTIONS = ("body", "axles", "steering", "aerodynamics")

WHEEL_NUMBERS = frozenset({"vertical_stiffness", "vertical_damping", "rolling_resistance", "friction_factor", "toe"})
"""Parameters of a wheel that nothing else follows from."""

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


def write_guidance(record: NDArray[np.void], guidance: Guidance) -> None:
    """Fill what the wheels do while they travel."""
    p = record[0]
    p["slide_x"], p["slide_y"] = guidance.slides[:, 0], guidance.slides[:, 1]
    p["carrier_pitch"] = guidance.carrier_pitch
    p["guided"] = np.any(guidance.slides[:, :2] != 0.0, axis=1)


def write_wheel_number(record: NDArray[np.void], wheel: str, name: str, value: float) -> None:
    """Fill one of ``WHEEL_NUMBERS`` of a wheel."""
    record[name][0, WHEELS.index(wheel)] = value


def write_wheels(record: NDArray[np.void], vehicle: VehicleFile, at_rest: VehicleFile) -> None:
    """Fill the wheels; static loads are there already."""
    p = record[0]
    for i, name in enumerate(WHEELS):
        wheel, wheel_at_rest = getattr(vehicle.wheels, name), getattr(at_rest.wheels, name)
        p["radius"][i] = p["nominal_radius"][i] = wheel.radius
        for number in WHEEL_NUMBERS:
            p[number][i] = getattr(wheel, number)
        # the spring carries what rests on the wheel without the wheel itself
        p["spring_preload"][i] = p["static_load"][i] - wheel_at_rest.unsprung_mass * STANDARD_GRAVITY


def write_suspension(record: NDArray[np.void], vehicle: VehicleFile) -> None:
    """Fill springs, dampers, stops and camber."""
    p = record[0]
    for i in range(4):
        axle = vehicle.suspension.front if i < 2 else vehicle.suspension.rear
        problem = damper_curve_problem(axle.damper_speeds, axle.damper_forces)
        if problem is not None:
            field, found, allowed = problem
            raise InputError(f"suspension.{'front' if i < 2 else 'rear'}.{field}", found=found, allowed=allowed)
        for name in ("spring_rate", "compression_damping", "rebound_damping", "damping_scale", "anti_roll_rate"):
            p[name][i] = getattr(axle, name)
        count = len(axle.damper_speeds)
        p["damper_points"][i] = count
        p["damper_speeds"][i, :count], p["damper_forces"][i, :count] = axle.damper_speeds, axle.damper_forces
        p["stops"][i] = max(axle.bump_stop_rate, axle.bump_stop_progression, axle.rebound_stop_rate) > 0.0
        p["bump_clearance"][i], p["rebound_clearance"][i] = axle.bump_stop_clearance, axle.rebound_stop_clearance
        p["bump_rate"][i], p["bump_progression"][i] = axle.bump_stop_rate, axle.bump_stop_progression
        p["rebound_rate"][i] = axle.rebound_stop_rate
        outwards = -1.0 if i % 2 == 0 else 1.0
        p["camber"][i], p["camber_gain"][i] = outwards * axle.camber, outwards * axle.camber_gain
    adaptive = vehicle.suspension.adaptive
    p["adaptive"] = adaptive.mode > 0.5
    p["skyhook_damping"], p["valve_time_constant"] = adaptive.skyhook_damping, adaptive.time_constant
    p["soft_scale"], p["firm_scale"] = adaptive.soft_scale, adaptive.firm_scale


def write_steering_and_air(record: NDArray[np.void], vehicle: VehicleFile) -> None:
    """Fill the steering linkage and the air forces."""
    p = record[0]
    steering, air = vehicle.steering, vehicle.aerodynamics
    p["steering_ratio"], p["steering_offset"], p["ackermann"] = steering.ratio, steering.offset, steering.ackermann
    p["half_track_over_wheelbase"] = vehicle.axles.front.track / (2.0 * vehicle.body.wheelbase)
    p["steering_stiffness"], p["steering_damping"] = steering.stiffness, steering.damping
    area = 0.5 * air.air_density * air.frontal_area
    p["drag"] = area * air.drag_coefficient  # D_a of eq. 28
    p["side_force"] = area * air.side_force_coefficient
    p["side_force_position"] = air.side_force_position
    p["lift_front"], p["lift_rear"] = area * air.lift_coefficient_front, area * air.lift_coefficient_rear
    p["drag_height"] = air.drag_height


def _write_contact(p: Record, i: int, tyre: AnyTyre) -> None:
    contact = tyre.contact
    if isinstance(tyre, TirTyre):
        fill_in(tyre)
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
