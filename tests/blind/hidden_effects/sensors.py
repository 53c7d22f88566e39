"""Measuring chain of the hidden car: scale, offset, lag, noise with colour, quantisation.

Nominal errors are those of series sensors after their own zero adjustment; every car's chain is off within them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter

from hidden_effects.car import WHEELS, Number, Numbers, within_the_series
from hidden_effects.outputs import INDEX

FloatArray = NDArray[np.float64]

RATE_HZ = 1000.0
INERTIAL_CUT_OFF_HZ = 50.0

SENSOR_SHEET: dict[str, Number] = {
    "ax_offset": Number(0.0, 0.02, relative=False),
    "ay_offset": Number(0.0, 0.02, relative=False),
    "ax_scale": Number(1.0, 0.005),
    "ay_scale": Number(1.0, 0.005),
    "misalignment": Number(0.0, 0.004, relative=False),
    "gyro_offset": Number(0.0, 5e-4, relative=False),
    "gyro_scale": Number(1.0, 0.005),
    "ring_error": Number((0.0,) * 4, 5e-4, relative=False, common=False),
    "ring_phase": Number((0.0,) * 4, 3.0, relative=False, common=False),
    "pressure_scale": Number(1.0, 0.005),
    "pressure_offset": Number(0.0, 1e4, relative=False),
    "pressure_lag": Number(0.0),
    "wheel_delay": Number(0.0),
    "wheel_lag": Number(0.0),
}


@dataclass(frozen=True)
class Channel:
    """A measured channel: CAN message that carries it, white and coloured noise, step of its quantisation (SI)."""

    message: str
    unit: str
    noise: float
    colour: float
    resolution: float


CHANNELS: dict[str, Channel] = {
    **{f"wheel_speed_{w}": Channel("WHEELS", "rad/s", 0.06, 0.0, 0.08) for w in WHEELS},
    "longitudinal_acceleration": Channel("INERTIAL", "m/s^2", 0.05, 0.7, 0.01),
    "lateral_acceleration": Channel("INERTIAL", "m/s^2", 0.05, 0.7, 0.01),
    "yaw_rate": Channel("INERTIAL", "rad/s", 0.00175, 0.0, 0.0005),
    "roll_rate": Channel("BODY", "rad/s", 0.00175, 0.0, 0.0005),
    "pitch_rate": Channel("BODY", "rad/s", 0.00175, 0.0, 0.0005),
    "pedal_force": Channel("BRAKE", "N", 0.5, 0.0, 1.0),
    "master_pressure": Channel("BRAKE", "Pa", 3e4, 0.0, 2.5e4),
    **{f"brake_pressure_{w}": Channel("PRESSURE", "Pa", 3e4, 0.0, 2.5e4) for w in WHEELS},
    "steering_wheel_angle": Channel("STEERING", "rad", 0.0005, 0.0, 0.00175),
    "drive_torque_r": Channel("POWERTRAIN", "N m", 1.0, 0.0, 1.0),
    **{f"valve_inlet_{w}": Channel("VALVES", "1", 0.0, 0.0, 1.0) for w in WHEELS},
    **{f"valve_outlet_{w}": Channel("VALVES", "1", 0.0, 0.0, 1.0) for w in WHEELS},
    "pump": Channel("VALVES", "1", 0.0, 0.0, 1.0),
    "speed": Channel("REFERENCE", "m/s", 0.03, 0.0, 0.01),
}
"""Everything that the loggers of a healthy case write; ``speed`` comes from a second logger's optical sensor."""

LEVELLED = ("levelled_acceleration_x", "levelled_acceleration_y")
"""No logger writes these, unless in place of the accelerometers'."""

MESSAGES = tuple(dict.fromkeys(channel.message for channel in CHANNELS.values()))
SECOND_LOGGER = "REFERENCE"


def draw_sensors(random: np.random.Generator) -> Numbers:
    """The measuring chain of one car."""
    chain: Numbers = {}
    for name, number in SENSOR_SHEET.items():
        nominal = np.array(number.nominal, float)
        change = number.scatter * within_the_series(random, nominal.shape)
        chain[name] = nominal * (1.0 + change) if number.relative else nominal + change
    chain["ring_error"] = np.abs(chain["ring_error"])
    return chain


def true_channels(
    columns: FloatArray, pedal: FloatArray, steering: FloatArray, torque: FloatArray
) -> dict[str, FloatArray]:
    """What ideal sensors would read at 1 ms: name -> (n,) array."""
    channels = {name: columns[:, INDEX[name]] for name in ("speed", "yaw_rate", "roll_rate", "pitch_rate", "pump")}
    channels["longitudinal_acceleration"] = columns[:, INDEX["specific_force_x"]]
    channels["lateral_acceleration"] = columns[:, INDEX["specific_force_y"]]
    channels |= _levelled(columns)
    channels["master_pressure"] = columns[:, INDEX["master_pressure"]]
    for wheel in WHEELS:
        channels[f"wheel_speed_{wheel}"] = columns[:, INDEX[f"wheel_speed_{wheel}"]]
        channels[f"brake_pressure_{wheel}"] = columns[:, INDEX[f"pressure_{wheel}"]]
        channels[f"valve_inlet_{wheel}"] = columns[:, INDEX[f"valve_inlet_{wheel}"]]
        channels[f"valve_outlet_{wheel}"] = columns[:, INDEX[f"valve_outlet_{wheel}"]]
    rows = len(columns)
    channels["pedal_force"] = pedal[::2][:rows]
    channels["steering_wheel_angle"] = steering[::2][:rows]
    channels["drive_torque_r"] = torque[::2][:rows]
    return channels


def _levelled(columns: FloatArray) -> dict[str, FloatArray]:
    """Accelerations as a navigation system writes them: of the motion over ground alone, by names of their own."""
    speed, across, turn = (columns[:, INDEX[name]] for name in ("speed", "lateral_speed", "yaw_rate"))
    along_rate, across_rate = (np.gradient(value) * RATE_HZ for value in (speed, across))
    return {LEVELLED[0]: along_rate - turn * across, LEVELLED[1]: across_rate + turn * speed}


def through_chain(channels: dict[str, FloatArray], chain: Numbers) -> dict[str, FloatArray]:
    """The channels with the systematic errors of their sensors, still without noise, at 1 ms."""
    measured = dict(channels)
    ax, ay = channels["longitudinal_acceleration"], channels["lateral_acceleration"]
    cosine, sine = np.cos(chain["misalignment"]), np.sin(chain["misalignment"])
    measured["longitudinal_acceleration"] = chain["ax_scale"] * (cosine * ax + sine * ay) + chain["ax_offset"]
    measured["lateral_acceleration"] = chain["ay_scale"] * (cosine * ay - sine * ax) + chain["ay_offset"]
    measured["yaw_rate"] = chain["gyro_scale"] * channels["yaw_rate"] + chain["gyro_offset"]
    inertial = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "roll_rate", "pitch_rate")
    for name in (*inertial, *(name for name in LEVELLED if name in measured)):
        measured[name] = _second_order(measured[name])
    for i, wheel in enumerate(WHEELS):
        name = f"wheel_speed_{wheel}"
        angle = np.cumsum(channels[name]) / RATE_HZ
        value = channels[name] * (1.0 + chain["ring_error"][i] * np.cos(angle - chain["ring_phase"][i]))
        measured[name] = first_order(delayed(value, float(chain["wheel_delay"])), float(chain["wheel_lag"]))
        name = f"brake_pressure_{wheel}"
        value = first_order(channels[name], float(chain["pressure_lag"]))
        measured[name] = chain["pressure_scale"] * value + chain["pressure_offset"]
    return measured


def _second_order(value: FloatArray) -> FloatArray:
    b, a = butter(2, INERTIAL_CUT_OFF_HZ, fs=RATE_HZ)
    filtered, _ = lfilter(b, a, value - value[0], zi=np.zeros(2))
    return np.asarray(filtered + value[0])


def first_order(value: FloatArray, time_constant_s: float) -> FloatArray:
    """The signal behind a first-order lag; itself for a lag of 0."""
    if time_constant_s <= 0.0:
        return value
    share = 1.0 - np.exp(-1.0 / (RATE_HZ * time_constant_s))
    filtered, _ = lfilter([share], [1.0, share - 1.0], value - value[0], zi=np.zeros(1))
    return np.asarray(filtered + value[0])


def delayed(value: FloatArray, delay_s: float) -> FloatArray:
    """The signal later by ``delay_s``; its first value is held before."""
    if delay_s == 0.0:
        return value
    time = np.arange(len(value)) / RATE_HZ
    return np.interp(time - delay_s, time, value)


def noise(channel: Channel, samples: int, random: np.random.Generator) -> FloatArray:
    """Noise of the channel's standard deviation, first-order coloured at the sample rate of the log."""
    white = random.standard_normal(samples)
    if channel.colour == 0.0:
        return channel.noise * white
    innovation = np.sqrt(1.0 - channel.colour**2)
    coloured, _ = lfilter([innovation], [1.0, -channel.colour], white, zi=[channel.colour * random.standard_normal()])
    return np.asarray(channel.noise * coloured)


def quantised(value: FloatArray, resolution: float) -> FloatArray:
    """Nearest multiple of the resolution."""
    return np.round(value / resolution) * resolution
