"""Logs of the MuJoCo car with ideal sensors: what the replay has to predict from the same vehicle file."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hydraulics import HydraulicUnit
from hydraulics.friction_brake import brake_torque
from hydraulics.parameters import PARAMETERS
from hydraulics.record import PARAMETER_RECORD, fill_record
from hydraulics.state import STATE_RECORD
from model_diagnosis.manoeuvre import Manoeuvre
from signals.wheels import WHEELS
from vehicle_model import Plant
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]
Course = Callable[[float], tuple[Sequence[float], float, float]]
"""Time [s] to pressures of the four wheels [Pa], drive torque of the driven axle [N m], steering-wheel angle [rad]."""

_TRUTH = {
    **{f"wheel_speed_{wheel}": f"true_wheel_speed_{wheel}" for wheel in WHEELS},
    "speed": "speed",
    "lateral_speed": "lateral_speed",
    "yaw_rate": "true_yaw_rate",
    "roll_angle": "roll_angle",
    "pitch_angle": "pitch_angle",
    **{f"vertical_load_{wheel}": f"vertical_load_{wheel}" for wheel in WHEELS},
}


def ideal_sensors(vehicle: VehicleFile) -> VehicleFile:
    """The vehicle with sensors that neither filter nor count edges: the plant's outputs are its signals."""
    copied = vehicle.model_copy(deep=True)
    copied.sensors.inertial.cut_off_frequency = 450.0
    copied.sensors.wheel_speed.window = 0.001
    return copied


class _WheelBrakes:
    """The brakes of the hydraulic unit behind given pressures."""

    def __init__(self, vehicle: VehicleFile) -> None:
        numbers = vehicle.numbers()
        self._parameters, self._state = np.zeros(1, PARAMETER_RECORD), np.zeros(1, STATE_RECORD)
        fill_record({p.path: float(numbers.get(p.path, p.default or 0.0)) for p in PARAMETERS}, self._parameters)
        self._state[0]["disc_temperature"] = self._parameters[0]["disc_start_temperature"]

    def torque(self, pressures: Sequence[float], state: dict[str, float]) -> FloatArray:
        """Torque capacities (4,) [N m] after another millisecond."""
        self._state[0]["pressure"] = pressures
        speeds = [state[f"true_wheel_speed_{wheel}"] for wheel in WHEELS]
        return np.array([brake_torque(self._parameters[0], self._state[0], i, speeds[i]) for i in range(4)])


def drive(
    vehicle: VehicleFile,
    course: Course,
    seconds: float,
    speed_m_s: float,
    road: RoadFile | None = None,
    name: str = "plant",
) -> Manoeuvre:
    """Drive the MuJoCo car along a course of inputs and keep every tenth millisecond."""
    plant = Plant(vehicle, road or RoadFile())
    plant.reset(speed_m_s=speed_m_s)
    brakes = _WheelBrakes(vehicle)
    shares = np.array(vehicle.driveline.wheel_share())
    rows: dict[str, list[float]] = {channel: [] for channel in _TRUTH}
    extra: dict[str, list[float]] = {name: [] for name in ("longitudinal_acceleration", "lateral_acceleration")}
    inputs = []
    for tick in range(round(seconds * 1000.0) + 1):
        pressures, torque, steer = course(tick * 1e-3)
        if tick % 10 == 0:
            state = plant.state()
            for channel, source in _TRUTH.items():
                rows[channel].append(state[source])
            grade, bank = state["road_grade"], state["road_bank"]
            extra["longitudinal_acceleration"].append(
                state["true_longitudinal_acceleration"] + 9.81 * (grade - np.sin(state["pitch_angle"]))
            )
            extra["lateral_acceleration"].append(
                state["true_lateral_acceleration"] + 9.81 * (bank + np.sin(state["roll_angle"]))
            )
            inputs.append((*pressures, torque, steer))
        plant.step(1, brake_torque=brakes.torque(pressures, plant.state()), drive_torque=shares * torque, steer=steer)
    given = np.array(inputs)
    front = 2.0 * shares[0]
    channels = {channel: np.array(values) for channel, values in (rows | extra).items()}
    channels |= {f"brake_pressure_{wheel}": given[:, i] for i, wheel in enumerate(WHEELS)}
    channels |= {
        "drive_torque_f": front * given[:, 4],
        "drive_torque_r": (1.0 - front) * given[:, 4],
        "steering_wheel_angle": given[:, 5],
    }
    time = np.arange(len(given)) * 0.01
    weights = {channel: np.ones(len(time)) for channel in channels}
    return Manoeuvre(name, time, channels, weights, "the MuJoCo car")


def _ramp(time: float, start: float, length: float) -> float:
    """0 before ``start``, 1 from ``length`` later on: inputs are known every 10 ms, so that none of them may jump."""
    return min(max((time - start) / length, 0.0), 1.0)


def gentle_stop(time: float) -> tuple[Sequence[float], float, float]:
    """30 bar from 0.5 s, straight."""
    return [3e6 * _ramp(time, 0.5, 0.2)] * 4, 0.0, 0.0


def pulsed_stop(time: float) -> tuple[Sequence[float], float, float]:
    """Pressure trains of an ABS at 5 Hz about the limit."""
    phase = (time * 5.0) % 1.0
    front = 6e6 + 5e6 * ((1.0 - phase) / 0.65 if phase > 0.35 else phase / 0.35)
    front *= _ramp(time, 0.4, 0.1)
    return [front, front, 0.5 * front, 0.5 * front], 0.0, 0.0


def sine_steer(time: float) -> tuple[Sequence[float], float, float]:
    """0.7 Hz, 60 degrees at the steering wheel, light drive torque."""
    angle = 1.05 * np.sin(2.0 * np.pi * 0.7 * (time - 0.5)) * _ramp(time, 0.5, 0.3)
    return [0.0] * 4, 150.0, float(angle)


def brake_in_turn(time: float) -> tuple[Sequence[float], float, float]:
    """Circle, then 25 bar."""
    torque = 200.0 * (1.0 - _ramp(time, 2.3, 0.1))
    return [2.5e6 * _ramp(time, 2.5, 0.2)] * 4, torque, 0.9 * _ramp(time, 0.3, 0.5)


def coast_and_drive(time: float) -> tuple[Sequence[float], float, float]:
    """Coast, drive, light braking."""
    torque = 1500.0 * (_ramp(time, 2.0, 0.3) - _ramp(time, 5.0, 0.3))
    return [8e5 * _ramp(time, 6.0, 0.2)] * 4, torque, 0.0


def hydraulic_log(vehicle: VehicleFile, seconds: float = 4.0) -> Manoeuvre:
    """A stop from 30 m/s through the hydraulic unit, its valves pulsed at 4 Hz, with everything that goes into it."""
    plant, unit = Plant(vehicle, RoadFile()), HydraulicUnit(vehicle.numbers())
    plant.reset(speed_m_s=30.0)
    out, omega = np.zeros(18), np.zeros(4)
    rows: dict[str, list[float]] = {}
    for tick in range(round(seconds * 1000.0) + 1):
        time = tick * 1e-3
        force = 250.0 * min(max((time - 0.3) / 0.3, 0.0), 1.0)
        phase = (time * 4.0) % 1.0 if time > 1.0 else 0.0
        inlet = np.full(4, 1.0 if phase > 0.4 else 0.0)
        outlet = np.full(4, 1.0 if 0.5 < phase < 0.7 else 0.0)
        master = force * vehicle.brakes.booster_gain
        pump = float(time > 1.0)
        state = plant.state()
        omega[:] = [state[f"true_wheel_speed_{wheel}"] for wheel in WHEELS]
        unit.tick(master, inlet, outlet, pump, out, omega)
        if tick % 10 == 0:
            values = {channel: state[source] for channel, source in _TRUTH.items()}
            values |= {"pedal_force": force, "master_pressure": master, "pump": pump}
            values |= {"drive_torque_f": 0.0, "drive_torque_r": 0.0, "steering_wheel_angle": 0.0}
            for i, wheel in enumerate(WHEELS):
                values |= {f"valve_inlet_{wheel}": inlet[i], f"valve_outlet_{wheel}": outlet[i]}
                values[f"brake_pressure_{wheel}"] = unit.wheel_pressure_pa[i]
            for name, value in values.items():
                rows.setdefault(name, []).append(float(value))
        plant.step(1, brake_torque=out[10:14])
    channels = {name: np.array(values) for name, values in rows.items()}
    time = np.arange(len(channels["speed"])) * 0.01
    return Manoeuvre("valves", time, channels, {name: np.ones(len(time)) for name in channels}, "the MuJoCo car")
