"""The replay's car from a vehicle file: its record and the tables of its tyres."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.replay.record import CELLS, REPLAY_RECORD
from model_diagnosis.replay.tyre_table import TyreForm, fit_tyre, trail_of
from signals.wheels import WHEELS
from vehicle_model.rigid_bodies import rigid_bodies
from vehicle_model.tyres.relaxation import fill_in
from vehicle_model.tyres.tyre_file import CurveTyre, TirTyre
from vehicle_model.vehicle_file import VehicleFile

_DAMPER_SPEED_M_S = 0.1
"""Speed at which a damper's curve is read as a rate."""

_STOP_SPEED_M_S = 100.0 / 3.6

_STEP_PLACE_M = 30.0
"""Place of a step of the friction from which its deviation counts."""


@dataclass(frozen=True)
class NominalCar:
    """The car of the vehicle file.

    Attributes
    ----------
    record : shape (1,), dtype ``REPLAY_RECORD``
    tables : (2, 2, CELLS + 1, 2) of front and rear tyre, along and across
    tyre_error : largest difference of the tables' force from the tyre's own over the load, by axle
    """

    record: NDArray[np.void]
    tables: NDArray[np.float64]
    tyre_error: tuple[float, float]


_KEPT: dict[str, NominalCar] = {}
_MOST_KEPT = 8


def nominal_car(vehicle: VehicleFile, tyre_load: float | None = None) -> NominalCar:
    """Record and tables of a vehicle; those of the last few are kept, since fitting the tyres takes a while.

    ``tyre_load`` [N] is the one at which the tyres are sampled, the static loads of the axles if left out.
    """
    key = f"{tyre_load} {vehicle.model_dump_json()}"
    if key not in _KEPT:
        if len(_KEPT) >= _MOST_KEPT:
            _KEPT.pop(next(iter(_KEPT)))
        _KEPT[key] = _build(vehicle, tyre_load)
    return _KEPT[key]


def _build(vehicle: VehicleFile, tyre_load: float | None) -> NominalCar:
    record = np.zeros(1, REPLAY_RECORD)
    entry = record[0]
    _write_body(entry, vehicle)
    _write_suspension(entry, vehicle)
    _write_wheels(entry, vehicle)
    _write_brakes(entry, vehicle)
    _write_air_and_steering(entry, vehicle)
    _write_sensors(entry, vehicle)
    tables = np.zeros((2, 2, CELLS + 1, 2))
    errors = []
    for axle in range(2):
        form = _write_tyre(entry, vehicle, axle, tyre_load)
        tables[axle, 0], tables[axle, 1] = form.longitudinal.table, form.lateral.table
        errors.append(form.error)
    return NominalCar(record, tables, (errors[0], errors[1]))


def _write_body(entry: np.void, vehicle: VehicleFile) -> None:
    body = vehicle.body
    numbers = {
        path: value for section in ("body", "axles", "wheels") for path, value in vehicle.numbers(section).items()
    }
    bodies = rigid_bodies(numbers, numbers)
    entry["mass"], entry["yaw_inertia"] = body.mass, numbers["body.yaw_inertia"]
    # the wheels keep to the road, but go sideways and forwards with the body that turns above them
    swung = float(bodies.unsprung_mass @ bodies.wheel_positions[:, 2] ** 2)
    entry["roll_inertia"] = bodies.sprung_inertia[0, 0] + bodies.transverse_inertia.sum() + swung
    entry["pitch_inertia"] = bodies.sprung_inertia[1, 1] + swung
    entry["height"], entry["wheelbase"] = body.centre_of_gravity_height, body.wheelbase
    entry["front_arm"] = body.centre_of_gravity_to_front_axle
    entry["track_front"], entry["track_rear"] = vehicle.axles.front.track, vehicle.axles.rear.track
    entry["unsprung_mass"] = bodies.unsprung_mass
    entry["friction_step_place"] = _STEP_PLACE_M
    entry["stop_energy"] = 0.5 * body.mass * _STOP_SPEED_M_S**2


def _write_suspension(entry: np.void, vehicle: VehicleFile) -> None:
    for i in range(4):
        axle = vehicle.suspension.front if i < 2 else vehicle.suspension.rear
        entry["spring_rate"][i], entry["anti_roll_rate"][i] = axle.spring_rate, axle.anti_roll_rate
        compression, rebound = axle.compression_damping, axle.rebound_damping
        if axle.damper_speeds:
            speeds = np.array([_DAMPER_SPEED_M_S, -_DAMPER_SPEED_M_S])
            forces = np.interp(speeds, axle.damper_speeds, axle.damper_forces)
            compression, rebound = (float(rate) for rate in forces / speeds)
        entry["compression_damping"][i] = compression * axle.damping_scale
        entry["rebound_damping"][i] = rebound * axle.damping_scale
        entry["bump_clearance"][i], entry["bump_rate"][i] = axle.bump_stop_clearance, axle.bump_stop_rate
        entry["bump_progression"][i] = axle.bump_stop_progression
        entry["roll_centre_height"][i] = axle.roll_centre_height
        entry["brake_support"][i] = math.tan(axle.brake_support_angle)
        entry["drive_support"][i] = math.tan(axle.drive_support_angle)


def _write_wheels(entry: np.void, vehicle: VehicleFile) -> None:
    entry["camber_stiffness"] = 1.0
    shares = vehicle.driveline.wheel_share()
    for i, name in enumerate(WHEELS):
        wheel = getattr(vehicle.wheels, name)
        entry["radius"][i], entry["spin_inertia"][i] = wheel.radius, wheel.inertia
        entry["rolling_resistance"][i] = entry["rolling_reference"][i] = wheel.rolling_resistance
        entry["toe"][i] = wheel.toe
        entry["friction"][i], entry["vertical_stiffness"][i] = wheel.friction_factor, wheel.vertical_stiffness
        entry["longitudinal_stiffness"][i] = entry["cornering_stiffness"][i] = 1.0
        entry["drive_share"][i] = shares[i]


def _write_tyre(entry: np.void, vehicle: VehicleFile, axle: int, tyre_load: float | None) -> TyreForm:
    pair = vehicle.tyre_pair
    tyre = pair.front if axle == 0 else pair.rear
    if isinstance(tyre, TirTyre):
        fill_in(tyre)
    static_load = vehicle.static_loads()[2 * axle]
    load = static_load if tyre_load is None else tyre_load
    form = fit_tyre(tyre, load)
    wheels = slice(2 * axle, 2 * axle + 2)
    for letter, direction in (("x", form.longitudinal), ("y", form.lateral)):
        entry[f"peak_{letter}"][wheels] = direction.peak
        entry[f"peak_slip_{letter}"][wheels] = direction.peak_slip
        entry[f"load_loss_{letter}"][wheels] = direction.load_loss
        entry[f"stiffness_loss_{letter}"][wheels] = direction.stiffness_loss
    if isinstance(tyre, CurveTyre):
        entry["nominal_load"][wheels], entry["file_load_loss"][wheels] = tyre.nominal_load, tyre.load_sensitivity
    else:
        entry["nominal_load"][wheels] = static_load
    entry["reference_load"][wheels], entry["friction_stiffens"][wheels] = load, form.friction_stiffens
    entry["relaxation_x"][wheels] = tyre.relaxation_length_longitudinal
    entry["relaxation_y"][wheels] = tyre.relaxation_length_lateral
    entry["trail"][wheels] = trail_of(tyre, load)
    return form


def _write_brakes(entry: np.void, vehicle: VehicleFile) -> None:
    brakes = vehicle.brakes
    entry["ambient_temperature"] = brakes.ambient_temperature
    entry["caliper_lag"] = brakes.caliper_time_constant
    for i, name in enumerate(WHEELS):
        axle = brakes.front if i < 2 else brakes.rear
        # eq. 78 of the friction document: two pads
        entry["torque_per_pressure"][i] = 2.0 * axle.pad_area * axle.pad_friction * axle.effective_radius
        entry["brake_factor"][i] = 1.0 - getattr(brakes, f"pad_glazing_{name}")
        entry["drag_torque"][i] = getattr(brakes, f"drag_torque_{name}")
        entry["threshold_pressure"][i] = axle.threshold_pressure + getattr(brakes, f"piston_friction_{name}")
        entry["thickness_variation_sine"][i] = getattr(brakes, f"thickness_variation_{name}")
        entry["pad_speed_exponent"][i] = axle.pad_speed_exponent
        entry["pad_pressure_exponent"][i] = axle.pad_pressure_exponent
        entry["fade"][i], entry["fade_temperature"][i] = axle.fade, axle.fade_temperature
        entry["fade_floor"][i], entry["effective_radius"][i] = axle.fade_floor, axle.effective_radius
        entry["heat_capacity"][i], entry["heat_share"][i] = axle.disc_heat_capacity, axle.disc_heat_share
        entry["cooling"][i], entry["cooling_per_speed"][i] = axle.disc_cooling, axle.disc_cooling_per_speed
        entry["start_temperature"][i] = axle.disc_start_temperature


def _write_air_and_steering(entry: np.void, vehicle: VehicleFile) -> None:
    air, steering = vehicle.aerodynamics, vehicle.steering
    area = 0.5 * air.air_density * air.frontal_area
    entry["air"] = area
    entry["drag"] = area * air.drag_coefficient
    entry["drag_height"] = vehicle.numbers("aerodynamics")["aerodynamics.drag_height"]
    entry["lift_front"], entry["lift_rear"] = area * air.lift_coefficient_front, area * air.lift_coefficient_rear
    entry["side_force"] = area * air.side_force_coefficient
    entry["side_force_position"] = air.side_force_position
    entry["steering_scale"], entry["steering_offset"] = 1.0, steering.offset
    entry["steering_stiffness"], entry["steering_damping"] = steering.stiffness, steering.damping
    entry["ackermann"] = steering.ackermann


def _write_sensors(entry: np.void, vehicle: VehicleFile) -> None:
    inertial = vehicle.sensors.inertial
    # delay of a second-order low-pass at low frequencies
    lag = 2.0 * inertial.damping_ratio / (2.0 * math.pi * inertial.cut_off_frequency)
    entry["accelerometer_lag"] = entry["gyro_lag"] = lag
    entry["accelerometer_damping"] = inertial.damping_ratio
    entry["accelerometer_leaning"] = 1.0
    entry["wheel_speed_lag"] = 0.5 * vehicle.sensors.wheel_speed.window
    entry["roll_scrub"] = entry["pitch_scrub"] = entry["link_scrub"] = entry["guide_lean"] = 1.0
    entry["support_apart"] = 1.0
    entry["place_x"], entry["place_y"] = inertial.position_x, inertial.position_y
