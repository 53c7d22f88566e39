"""Section of a vehicle file that describes the sensors."""

from typing import Literal

from pydantic import Field

from signals.quantities import FileModel, parameter

_ASSUMED = "assumed: usual for a series sensor"
AccelerationSource = Literal["cluster_can", "noisy", "noise_free", "ideal"]


def _fault(description: str, unit: str, high: float) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, high=high, neutral=0.0, description=description)
    return declared


def _stuck() -> float:
    return _fault("1 keeps the last value", "1", 1.0)


def _dropout_rate() -> float:
    return _fault("interruptions of the contact per second, at random", "1/s", 100.0)


def _dropout_duration() -> float:
    declared: float = parameter(
        "s", 0.02, low=0.001, high=60.0, description="of one interruption", source="assumed: a loose plug"
    )
    return declared


def _ring_scale() -> float:
    declared: float = parameter(
        "1", 1.0, low=0.0, high=4.0, neutral=1.0, description="reported over right speed: a ring with other teeth"
    )
    return declared


def _missing_teeth() -> int:
    declared: int = parameter("1", 0, low=0, high=256, neutral=0, description="neighbouring teeth that are broken off")
    return declared


def _connected(wheel: int) -> int:
    declared: int = parameter(
        "1",
        wheel,
        low=0,
        high=3,
        neutral=wheel,
        description="wheel whose sensor is plugged in here: 0 fl, 1 fr, 2 rl, 3 rr",
    )
    return declared


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
    ring_radius: float = parameter("m", 0.05, low=0.01, high=0.3, description="of the tone ring", source=_ASSUMED)
    threshold_speed: float = parameter(
        "rad/s",
        2.0,
        low=0.01,
        high=50.0,
        description="lowest speed that an inductive sensor sees; used with an air gap fault",
        source="assumed: 2 km/h",
    )
    missing_teeth_fl: int = _missing_teeth()
    missing_teeth_fr: int = _missing_teeth()
    missing_teeth_rl: int = _missing_teeth()
    missing_teeth_rr: int = _missing_teeth()
    air_gap_fl: float = _fault("more than the right distance of sensor and ring", "m", 0.02)
    air_gap_fr: float = _fault("more than the right distance of sensor and ring", "m", 0.02)
    air_gap_rl: float = _fault("more than the right distance of sensor and ring", "m", 0.02)
    air_gap_rr: float = _fault("more than the right distance of sensor and ring", "m", 0.02)
    connected_fl: int = _connected(0)
    connected_fr: int = _connected(1)
    connected_rl: int = _connected(2)
    connected_rr: int = _connected(3)
    scale_fl: float = _ring_scale()
    scale_fr: float = _ring_scale()
    scale_rl: float = _ring_scale()
    scale_rr: float = _ring_scale()
    stuck_fl: float = _stuck()
    stuck_fr: float = _stuck()
    stuck_rl: float = _stuck()
    stuck_rr: float = _stuck()
    dropout_rate_fl: float = _dropout_rate()
    dropout_rate_fr: float = _dropout_rate()
    dropout_rate_rl: float = _dropout_rate()
    dropout_rate_rr: float = _dropout_rate()
    dropout_duration: float = _dropout_duration()


def _noise(unit: str) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, neutral=0.0, description="standard deviation")
    return declared


def _offset(unit: str) -> float:
    declared: float = parameter(unit, 0.0, neutral=0.0, description="constant error")
    return declared


def _resolution(unit: str) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, neutral=0.0, description="step of the digital value, 0 none")
    return declared


def _drift(unit: str) -> float:
    declared: float = parameter(unit, 0.0, neutral=0.0, description="growth of the error, from when it is set")
    return declared


class AnalogueSensor(FileModel):
    """Errors of one measured quantity; neutral by default."""

    noise: float
    offset: float
    resolution: float
    scale: float = parameter("1", 1.0, low=-2.0, high=2.0, neutral=1.0, description="measured over true")
    delay: float = parameter("s", 0.0, low=0.0, high=0.1, neutral=0.0, description="dead time")
    drift: float
    stuck: float = _stuck()
    dropout_rate: float = _dropout_rate()
    dropout_duration: float = _dropout_duration()


class AccelerationSensor(AnalogueSensor):
    """Accelerometer."""

    noise: float = _noise("m/s^2")
    offset: float = _offset("m/s^2")
    resolution: float = _resolution("m/s^2")
    drift: float = _drift("m/s^2/s")


class RateSensor(AnalogueSensor):
    """Gyroscope."""

    noise: float = _noise("rad/s")
    offset: float = _offset("rad/s")
    resolution: float = _resolution("rad/s")
    drift: float = _drift("rad/s/s")


class PressureSensor(AnalogueSensor):
    """Pressure sensor."""

    noise: float = _noise("Pa")
    offset: float = _offset("Pa")
    resolution: float = _resolution("Pa")
    drift: float = _drift("Pa/s")


class WheelPressureFault(FileModel):
    """Errors of one wheel's pressure sensor, on top of those that all four have."""

    scale: float = parameter("1", 1.0, low=-2.0, high=2.0, neutral=1.0, description="measured over true")
    offset: float = _offset("Pa")
    drift: float = _drift("Pa/s")
    stuck: float = _stuck()
    dropout_rate: float = _dropout_rate()


class WheelPressureSensors(PressureSensor):
    """Pressure sensors of the four wheel brakes: what they have in common, and the faults of each."""

    fl: WheelPressureFault = WheelPressureFault()
    fr: WheelPressureFault = WheelPressureFault()
    rl: WheelPressureFault = WheelPressureFault()
    rr: WheelPressureFault = WheelPressureFault()


class ForceSensor(AnalogueSensor):
    """Pedal force sensor."""

    noise: float = _noise("N")
    offset: float = _offset("N")
    resolution: float = _resolution("N")
    drift: float = _drift("N/s")


class AngleSensor(AnalogueSensor):
    """Steering-wheel angle sensor."""

    noise: float = _noise("rad")
    offset: float = _offset("rad")
    resolution: float = _resolution("rad")
    drift: float = _drift("rad/s")


def _mounting(angle: str) -> float:
    declared: float = parameter(
        "rad", 0.0, low=-3.15, high=3.15, neutral=0.0, description=f"{angle} of the unit's axes against the body's"
    )
    return declared


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
    mounting_roll: float = _mounting("roll")
    mounting_pitch: float = _mounting("pitch")
    mounting_yaw: float = _mounting("yaw")


class Sensors(FileModel):
    """Every sensor of the car; what the file leaves out is ideal."""

    acceleration_source: AccelerationSource = Field(
        default="cluster_can",
        description="of longitudinal_acceleration: the sensor cluster with all its errors; noisy: with "
        "noisy_acceleration on top; noise_free: without noise, offset, scale, resolution and delay; ideal: no sensor, "
        "the centre of gravity's acceleration itself, without filter and gravity",
    )
    noisy_acceleration: float = parameter(
        "m/s^2",
        0.3,
        low=0.0,
        high=10.0,
        description="standard deviation that acceleration_source: noisy adds to longitudinal_acceleration",
        source="friction document 4.8 A18",
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
    brake_pressure: WheelPressureSensors = WheelPressureSensors()
    pedal_force: ForceSensor = ForceSensor()
    steering_wheel_angle: AngleSensor = AngleSensor()
    brake_switch_force: float = parameter(
        "N", 5.0, low=0.0, high=200.0, description="pedal force at which the switch closes", source=_ASSUMED
    )
