"""Section of a vehicle file that describes the sensors."""

from typing import Literal

from pydantic import Field

from signals.quantities import FileModel, parameter

_ASSUMED = "assumed: usual for a series sensor"


class WheelSpeedSensors(FileModel):
    """Tone rings and their sensors."""

    teeth: int = parameter("1", 48, low=4, high=512, description="teeth of the tone ring", source=_ASSUMED)
    pitch_error: float = parameter(
        "1", 0.0, low=0.0, high=0.5, neutral=0.0, description="standard deviation of a tooth's place, in pitches"
    )
    eccentricity: float = parameter(
        "1", 0.0, low=0.0, high=0.2, neutral=0.0, description="eccentricity of the ring over its radius"
    )
    edge_jitter: float = parameter(
        "s", 0.0, low=0.0, high=1e-3, neutral=0.0, description="standard deviation of an edge's time"
    )
    timer_resolution: float = parameter(
        "s", 1e-6, low=0.0, high=1e-3, neutral=0.0, description="of the edge's time stamp", source=_ASSUMED
    )
    window: float = parameter(
        "s", 0.005, low=0.001, high=0.1, description="over which edges are counted for the speed", source=_ASSUMED
    )
    standstill_timeout: float = parameter(
        "s", 0.3, low=0.01, high=5.0, description="without an edge after which the speed is zero", source=_ASSUMED
    )


def _noise(unit: str) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, neutral=0.0, description="standard deviation")
    return declared


def _offset(unit: str) -> float:
    declared: float = parameter(unit, 0.0, neutral=0.0, description="constant error")
    return declared


def _resolution(unit: str) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, neutral=0.0, description="step of the digital value, 0 none")
    return declared


class AnalogueSensor(FileModel):
    """Errors of one measured quantity; neutral by default."""

    noise: float
    offset: float
    resolution: float
    scale: float = parameter("1", 1.0, low=-2.0, high=2.0, neutral=1.0, description="measured over true")
    delay: float = parameter("s", 0.0, low=0.0, high=0.1, neutral=0.0, description="dead time")


class AccelerationSensor(AnalogueSensor):
    """Accelerometer."""

    noise: float = _noise("m/s^2")
    offset: float = _offset("m/s^2")
    resolution: float = _resolution("m/s^2")


class RateSensor(AnalogueSensor):
    """Gyroscope."""

    noise: float = _noise("rad/s")
    offset: float = _offset("rad/s")
    resolution: float = _resolution("rad/s")


class PressureSensor(AnalogueSensor):
    """Pressure sensor."""

    noise: float = _noise("Pa")
    offset: float = _offset("Pa")
    resolution: float = _resolution("Pa")


class ForceSensor(AnalogueSensor):
    """Pedal force sensor."""

    noise: float = _noise("N")
    offset: float = _offset("N")
    resolution: float = _resolution("N")


class AngleSensor(AnalogueSensor):
    """Steering-wheel angle sensor."""

    noise: float = _noise("rad")
    offset: float = _offset("rad")
    resolution: float = _resolution("rad")


class InertialUnit(FileModel):
    """Second-order low-pass of the inertial unit and its place in the car."""

    cut_off_frequency: float = parameter("Hz", 50.0, low=1.0, high=450.0, description="-3 dB", source=_ASSUMED)
    damping_ratio: float = parameter("1", 0.7071067811865476, low=0.1, high=2.0, description="", source=_ASSUMED)
    position_x: float = parameter(
        "m", 0.0, low=-5.0, high=5.0, neutral=0.0, description="place before the centre of gravity"
    )
    position_y: float = parameter(
        "m", 0.0, low=-3.0, high=3.0, neutral=0.0, description="place left of the centre of gravity"
    )
    position_z: float = parameter(
        "m", 0.0, low=-3.0, high=3.0, neutral=0.0, description="place above the centre of gravity"
    )


class Sensors(FileModel):
    """Every sensor of the car; what the file leaves out is ideal."""

    acceleration_source: Literal["sensor", "noise_free", "ideal"] = Field(
        default="sensor",
        description="of longitudinal_acceleration: the sensor with all its errors; without noise, offset, scale, "
        "resolution and delay; the centre of gravity's acceleration itself, without filter and gravity",
    )
    wheel_speed: WheelSpeedSensors = WheelSpeedSensors()
    inertial: InertialUnit = InertialUnit()
    longitudinal_acceleration: AccelerationSensor = AccelerationSensor()
    lateral_acceleration: AccelerationSensor = AccelerationSensor()
    vertical_acceleration: AccelerationSensor = AccelerationSensor()
    yaw_rate: RateSensor = RateSensor()
    roll_rate: RateSensor = RateSensor()
    pitch_rate: RateSensor = RateSensor()
    master_pressure: PressureSensor = PressureSensor()
    brake_pressure: PressureSensor = PressureSensor()
    pedal_force: ForceSensor = ForceSensor()
    steering_wheel_angle: AngleSensor = AngleSensor()
    brake_switch_force: float = parameter(
        "N", 5.0, low=0.0, high=200.0, description="pedal force at which the switch closes", source=_ASSUMED
    )
