"""Inputs of the replay from the channels of a manoeuvre, and what stands in for those that were not measured.

Drive torque that no channel tells is taken from the measured acceleration while the car is not braked, and so is the
braking of a car without any brake channel; the longitudinal balance says nothing about such samples, so their
acceleration and speed get no weight.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.derived import GRAVITY
from model_diagnosis.replay.record import (
    INPUT_BANK,
    INPUT_DRIVE_FRONT,
    INPUT_DRIVE_REAR,
    INPUT_GRADE,
    INPUT_STEER,
    INPUTS,
)
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

SLOWEST_M_S = 4.0
"""Speed below which nothing is compared: slip and the observer's gain lose their meaning."""

_BRAKED_PA = 1.5e5
_LARGEST_INFERRED_M_S2 = 2.0
"""Acceleration, along or across, up to which wheels are compared where its cause was not measured."""

_SMOOTHING_SAMPLES = 11
_RELEASE_SAMPLES = 10
_START_SAMPLES = 20


@dataclass(frozen=True)
class Inputs:
    """What drives the replay of one manoeuvre.

    Attributes
    ----------
    values : (n, INPUTS)
    inferred : (n,) True where the longitudinal force was taken from the measured acceleration
    forced : (n,) True where an acceleration that no channel explains is so large that wheels and forces say nothing
    steered : True where a steering channel is there
    forces_measured : True where brakes and drive have their own channels
    """

    values: FloatArray
    inferred: NDArray[np.bool_]
    forced: NDArray[np.bool_]
    steered: bool
    forces_measured: bool


def reference_speed(manoeuvre: Manoeuvre, vehicle: VehicleFile) -> FloatArray:
    """Speed of the car (n,) [m/s] for gates: the measured one, else the second fastest wheel's."""
    if "speed" in manoeuvre.channels:
        return manoeuvre.channels["speed"]
    wheels = [
        manoeuvre.channels[f"wheel_speed_{wheel}"] * getattr(vehicle.wheels, wheel).radius
        for wheel in WHEELS
        if f"wheel_speed_{wheel}" in manoeuvre.channels
    ]
    if not wheels:
        return np.zeros(manoeuvre.samples)
    fastest = np.sort(np.stack(wheels), axis=0)
    return fastest[-2] if len(wheels) > 1 else fastest[-1]


def start_of(manoeuvre: Manoeuvre, vehicle: VehicleFile) -> FloatArray:
    """Speed, yaw rate and spins of the wheels (6,) at the first sample: straight lines through the first 0.2 s.

    The spins are 0 where the speed is measured; where it is not, they tell it for any radii.
    """
    count = min(_START_SAMPLES, manoeuvre.samples)

    def first(values: FloatArray) -> float:
        line = np.polyfit(np.arange(count), values[:count], 1) if count > 2 else values[:1]
        return max(float(line[-1]), 0.0)

    yaw_rate = turning(manoeuvre, vehicle)
    is_known = "speed" in manoeuvre.channels
    spins = [0.0 if is_known else first(manoeuvre.channels[f"wheel_speed_{wheel}"]) for wheel in WHEELS]
    turn = 0.0 if yaw_rate is None else float(np.median(yaw_rate[: count // 2]))
    return np.array([first(reference_speed(manoeuvre, vehicle)), turn, *spins])


def read_inputs(manoeuvre: Manoeuvre, channels: Mapping[str, FloatArray], vehicle: VehicleFile, car: np.void) -> Inputs:
    """Inputs of a manoeuvre from its channels, which may have been changed by effects of the sensors.

    ``car`` (``REPLAY_RECORD``), with its deviations, is the one that forces nobody measured are inferred for.
    """
    values = np.zeros((manoeuvre.samples, INPUTS))
    braked = _write_pressures(values, channels)
    driven = _write_drive(values, channels, vehicle)
    steer = _steer(channels, vehicle)
    values[:, INPUT_STEER] = _kinematic_steer(manoeuvre, vehicle) if steer is None else steer
    for column, name in ((INPUT_GRADE, "road_grade"), (INPUT_BANK, "road_bank")):
        if name in channels:
            values[:, column] = channels[name]
    inferred = np.zeros(manoeuvre.samples, dtype=np.bool_)
    if not braked:
        inferred[:] = True
    elif not driven:
        inferred = _not_braked(values[:, :4])
    if inferred.any():
        _infer(values, inferred, braked, channels, reference_speed(manoeuvre, vehicle), car)
    measured = _acceleration(manoeuvre.channels, reference_speed(manoeuvre, vehicle))
    forced = inferred & (np.abs(measured) > _LARGEST_INFERRED_M_S2)
    if steer is None and "yaw_rate" not in channels:
        turn = turning(manoeuvre, vehicle)
        if turn is not None:
            forced |= np.abs(smooth(turn) * reference_speed(manoeuvre, vehicle)) > _LARGEST_INFERRED_M_S2
    return Inputs(values, inferred, forced, steer is not None, braked and driven)


def with_pressures(inputs: Inputs, channels: Mapping[str, FloatArray]) -> FloatArray:
    """Values (n, INPUTS) of inputs whose forces were measured, with other pressures."""
    values = inputs.values.copy()
    _write_pressures(values, channels)
    return values


def _write_pressures(values: FloatArray, channels: Mapping[str, FloatArray]) -> bool:
    found = False
    for i, wheel in enumerate(WHEELS):
        pressure = channels.get(f"brake_pressure_{wheel}", channels.get("master_pressure"))
        if pressure is not None:
            values[:, i] = pressure
            found = True
    return found


def _write_drive(values: FloatArray, channels: Mapping[str, FloatArray], vehicle: VehicleFile) -> bool:
    """Drive torque of the axles: measured there, or the engine's through the engaged gear."""
    found = False
    for column, name in ((INPUT_DRIVE_FRONT, "drive_torque_f"), (INPUT_DRIVE_REAR, "drive_torque_r")):
        if name in channels:
            values[:, column] = channels[name]
            found = True
    if not found and "engine_torque" in channels and "gear" in channels:
        line = vehicle.driveline
        ratios = np.array([0.0, *line.gear_ratios])
        gear = np.clip(np.round(channels["gear"]), 0, len(ratios) - 1).astype(int)
        losses = np.where(channels["engine_torque"] > 0.0, line.efficiency, 1.0 / line.efficiency)
        torque = channels["engine_torque"] * ratios[gear] * line.final_drive * losses
        front = 2.0 * line.wheel_share()[0]
        values[:, INPUT_DRIVE_FRONT], values[:, INPUT_DRIVE_REAR] = front * torque, (1.0 - front) * torque
        found = True
    return found


def _steer(channels: Mapping[str, FloatArray], vehicle: VehicleFile) -> FloatArray | None:
    """Road-wheel angle (n,) [rad] from the channel nearest to the wheels."""
    if "road_wheel_angle" in channels:
        return channels["road_wheel_angle"]
    if "steering_wheel_angle" in channels:
        angle = channels["steering_wheel_angle"]
        table = vehicle.steering.map
        if table is None:
            return angle / vehicle.steering.ratio
        mean = 0.5 * (np.array(table.left) + np.array(table.right))
        return np.interp(angle, table.steering_wheel_angle, mean)
    return channels.get("steering_command")


def turning(manoeuvre: Manoeuvre, vehicle: VehicleFile) -> FloatArray | None:
    """Yaw rate (n,) [rad/s] by the gyroscope, else by the rear wheels' speeds; None without both."""
    channels = manoeuvre.channels
    if "yaw_rate" in channels:
        return channels["yaw_rate"]
    if "wheel_speed_rl" not in channels or "wheel_speed_rr" not in channels:
        return None
    difference = channels["wheel_speed_rr"] - channels["wheel_speed_rl"]
    return smooth(difference) * vehicle.wheels.rl.radius / vehicle.axles.rear.track


def _kinematic_steer(manoeuvre: Manoeuvre, vehicle: VehicleFile) -> FloatArray:
    """Angle (n,) [rad] at which the car would turn as it did if its tyres did not slip.

    The lateral balance is not compared then.
    """
    turn = turning(manoeuvre, vehicle)
    if turn is None:
        return np.zeros(manoeuvre.samples)
    return smooth(turn) * vehicle.body.wheelbase / np.maximum(reference_speed(manoeuvre, vehicle), SLOWEST_M_S)


def _not_braked(pressures: FloatArray) -> NDArray[np.bool_]:
    """True where no wheel is braked, nor was shortly before."""
    braked = pressures.max(axis=1) > _BRAKED_PA
    spread = np.convolve(braked, np.ones(2 * _RELEASE_SAMPLES + 1), "same") > 0.0
    return ~spread


def smooth(values: FloatArray) -> FloatArray:
    """Moving mean over 0.11 s."""
    half = _SMOOTHING_SAMPLES // 2
    padded = np.pad(values, half, mode="edge")
    return np.convolve(padded, np.full(_SMOOTHING_SAMPLES, 1.0 / _SMOOTHING_SAMPLES), "valid")


def _acceleration(channels: Mapping[str, FloatArray], speed: FloatArray) -> FloatArray:
    """Longitudinal acceleration (n,) [m/s^2], smoothed: measured, else the change of the speed."""
    felt = channels.get("longitudinal_acceleration")
    if felt is None:
        felt = np.gradient(smooth(speed), SAMPLE_TIME_S)
    return smooth(felt)


def _infer(
    values: FloatArray,
    inferred: NDArray[np.bool_],
    braked: bool,
    channels: Mapping[str, FloatArray],
    speed: FloatArray,
    car: np.void,
) -> None:
    """Drive torque, and where no brake is measured the brakes' too, that the acceleration in ``channels`` asks for.

    The car at hand, with its own deviations, is turned round: no mass, air or loss of torque can be blamed for an
    acceleration that was taken from the measurement. Brakes without a channel are a torque of the axles, shared as the
    pads share it, so that no effect of the brakes is seen in them; ``inferred_front`` leaves that share open.
    """
    radius, acceleration = float(np.mean(car["radius"])), _acceleration(channels, speed)
    pads, drive_share = car["torque_per_pressure"], car["drive_share"]
    brake_share = pads / max(float(np.sum(pads)), 1e-12)
    if "longitudinal_acceleration" in channels:
        pitch = np.where(acceleration > 0.0, _pitch(car, drive_share, "drive"), _pitch(car, brake_share, "brake"))
        leaning = float(car["accelerometer_leaning"])
        # what is levelled reads neither the body's lean nor the road's, and the drive climbs the road all the same
        acceleration = acceleration / (1.0 + leaning * GRAVITY * pitch) + (1.0 - leaning) * GRAVITY * car["grade"]
    along = speed + car["wind_along"]
    force = car["mass"] * acceleration + car["drag"] * np.abs(along) * along
    torque = force * radius + acceleration * np.sum(car["spin_inertia"]) / radius + _losses(car, speed, radius)
    # the replay adds the engine's drag to a torque that does not drive
    torque = np.where(torque > 0.0, torque, np.minimum(torque + car["engine_drag"], 0.0))
    drives = inferred & ((torque > 0.0) | braked)
    brakes_in_front = float(np.clip(np.sum(brake_share[:2]) + car["inferred_front"], 0.0, 1.0))
    front = np.where(drives, np.sum(drive_share[:2]), brakes_in_front)
    values[inferred, INPUT_DRIVE_FRONT] = (front * torque)[inferred]
    values[inferred, INPUT_DRIVE_REAR] = ((1.0 - front) * torque)[inferred]


def _pitch(car: np.void, share: FloatArray, guide: str) -> float:
    """Steady pitch per acceleration [rad s^2/m], by which an accelerometer in the body reads gravity too.

    ``share`` (4,) of the wheels in the force; ``guide`` tells what the links carry of it, "drive" or "brake".
    """
    place, weight = car["wheel_x"], car["mass"] * GRAVITY
    arm = car["height"] - car["radius"][0] + car["pitch_weight_arm"]
    stiffness = float(np.sum(car["mean_rate"] * place**2)) - weight * arm
    moment = car["mass"] * (car["height"] + float(np.sum(place * car[f"guide_{guide}"] * share)))
    return float(moment / max(stiffness, weight))


def _losses(car: np.void, speed: FloatArray, radius: float) -> FloatArray:
    """Torque (n,) [N m] of all wheels together that rolling, dragging brakes and the driveline take."""
    rolling = float(np.sum(car["rolling_resistance"] * car["static_load"])) * radius
    growth = float(car["rolling_speed"] * np.sum(car["rolling_reference"] * car["static_load"])) * radius
    lost = rolling + growth * speed + float(np.sum(car["drag_torque"]))
    driveline: FloatArray = car["driveline_drag"] + car["driveline_viscous"] * speed / radius
    return lost + driveline
