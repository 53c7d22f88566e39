"""Calibration files of the emulated ABS ECU: every number of the controller, with unit and range."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from signals.errors import unknown_name
from signals.quantities import FileModel, parameter

_FOLDER = Path(__file__).parent / "calibrations"
CALIBRATIONS = tuple(sorted(path.stem for path in _FOLDER.glob("*.yaml")))


class Car(FileModel):
    """What the controller has to know of the car."""

    front_wheel_radius: float = parameter("m", 0.278, low=0.1, high=1.0, description="rolling radius, front")
    rear_wheel_radius: float = parameter("m", 0.278, low=0.1, high=1.0, description="rolling radius, rear")
    track: float = parameter("m", 1.5, low=0.5, high=3.0, description="mean track, for wheel speeds in a turn")
    tone_ring_teeth: float = parameter("1", 48.0, low=10, high=200, description="teeth of a tone ring")


class WheelSpeed(FileModel):
    """Wheel speed and acceleration from pulse counters."""

    averaging_time: float = parameter("s", 0.008, low=0.0, high=0.03, description="shortest time between used edges")
    acceleration_time_constant: float = parameter("s", 0.012, low=0.0, high=0.1, description="acceleration filter")
    standstill_time: float = parameter("s", 0.3, low=0.05, high=1.0, description="no edge for this long means 0")


class Reference(FileModel):
    """Reference speed."""

    use_accelerometer: bool = Field(default=True, description="accelerometer as a helper while plausible")
    largest_deceleration: float = parameter("m/s^2", 11.5, low=2, high=20, description="fastest fall of the reference")
    largest_acceleration: float = parameter("m/s^2", 12.0, low=2, high=30, description="fastest rise of the reference")
    deceleration_margin: float = parameter(
        "m/s^2", 1.0, low=0, high=5, description="the reference may fall faster than measured by this, before ABS"
    )
    recovery_gain: float = parameter("1", 0.35, low=0.01, high=1, description="rise to a faster wheel, per task")
    anchor_gain: float = parameter("1", 0.5, low=0.01, high=1, description="step to a rolling wheel's speed")
    anchor_pressure_ratio: float = parameter(
        "1", 0.45, low=0.05, high=0.9, description="a wheel rolls below this share of its lock pressure"
    )
    residual_slip: float = parameter("1", 0.05, low=0, high=0.2, description="slip per share of lock pressure")
    anchor_tasks: float = parameter("1", 3, low=1, high=20, description="tasks of steady rolling before it counts")
    anchor_tolerance: float = parameter("m/s^2", 6.0, low=0.5, high=30, description="steady: acceleration within this")
    underbraking_interval: float = parameter(
        "s", 0.6, low=0.1, high=10, description="without a rolling wheel for this long, a rear wheel is released"
    )
    underbraking_timeout: float = parameter("s", 0.12, low=0.02, high=1, description="longest release for that")
    bias_limit: float = parameter("m/s^2", 1.5, low=0, high=5, description="largest correction of the accelerometer")


class AxleSlip(FileModel):
    """Slip control of the wheels of an axle. Slip speeds are slip × reference speed + offset."""

    release: float = parameter("1", low=0.01, high=0.6, description="predicted slip that opens the outlet valve")
    release_end: float = parameter("1", low=-0.5, high=0.6, description="predicted slip that ends the release")
    build: float = parameter("1", low=-0.2, high=0.5, description="predicted slip below which pressure is rebuilt")
    entry: float = parameter("1", low=0.0, high=0.3, description="least slip of a first intervention")
    offset: float = parameter("m/s", 0.25, low=0, high=2, description="added to release, at any speed")
    prediction: float = parameter("s", low=0, high=0.2, description="time over which slip is extrapolated")
    critical_deceleration: float = parameter(
        "m/s^2",
        low=5,
        high=300,
        description="wheel deceleration beyond the car's that releases at any slip above entry",
    )
    recovery_acceleration: float = parameter(
        "m/s^2", 4, low=0.5, high=100, description="a wheel that gains this on the car is left to recover"
    )


class Slip(FileModel):
    """Slip control."""

    front: AxleSlip
    rear: AxleSlip
    turn_reduction: float = parameter(
        "1", 0.4, low=0, high=0.9, description="share by which rear thresholds shrink at 5 m/s^2 lateral acceleration"
    )
    rear_select_low: bool = Field(default=True, description="both rear wheels follow the one with more slip")


class Pressure(FileModel):
    """The ECU's own picture of the hydraulics and the pulse pattern of the stepped rebuild."""

    increase_time_constant: float = parameter("s", 0.05, low=0.001, high=1, description="of the hydraulic unit")
    decrease_time_constant: float = parameter("s", 0.03, low=0.001, high=1, description="of the hydraulic unit")
    fast_rebuild: float = parameter("1", low=0, high=1, description="share of the lock pressure rebuilt without holds")
    pulse_tasks: float = parameter("1", low=1, high=10, description="length of a build pulse, tasks")
    pulse_gap_tasks: float = parameter("1", low=0, high=40, description="hold between build pulses, tasks")
    quick_after_pulses: float = parameter("1", low=1, high=100, description="pulses without effect until gaps shrink")
    release_step: float = parameter("1", low=0.02, high=1, description="share released before the effect is awaited")
    release_gap_tasks: float = parameter("1", low=0, high=40, description="wait after a release step")
    hold_tasks: float = parameter("1", low=1, high=100, description="hold at moderate slip before a probing pulse")
    pump_run_on: float = parameter("s", 0.5, low=0, high=5, description="pump after the last release")


class Split(FileModel):
    """Yaw-moment delay: how fast the high front wheel may leave the low one on split friction."""

    allowed_difference: float = parameter("Pa", 2e6, low=0, high=3e7, description="pressure difference at once")
    difference_rate: float = parameter("Pa/s", 4e6, low=0, high=1e9, description="growth of the allowed difference")


class Distribution(FileModel):
    """Electronic brake-force distribution: the rear wheels' slip against the front wheels'."""

    hold: float = parameter("1", 0.02, low=0, high=0.2, description="rear slip beyond the front's that holds")
    release: float = parameter("1", 0.05, low=0, high=0.3, description="rear slip beyond the front's that releases")
    offset: float = parameter("m/s", 0.12, low=0, high=2, description="added to both, at any speed")
    least_speed: float = parameter("m/s", 2.0, low=0, high=10, description="no distribution below this")


class Limits(FileModel):
    """Speeds and the brake."""

    cut_in_speed: float = parameter("m/s", 2.2, low=0, high=10, description="no intervention begins below this")
    cut_out_speed: float = parameter("m/s", 1.1, low=0, high=10, description="control ends below this")
    braking_pressure: float = parameter("Pa", 2e5, low=0, high=2e6, description="master pressure that means braking")


class Monitoring(FileModel):
    """Watching the inputs and healing."""

    timeout_periods: float = parameter("1", 5, low=1, high=100, description="missing for more periods is a fault")
    rejected_frames: float = parameter("1", 8, low=1, high=1000, description="refused frames of one message in a row")
    start_time: float = parameter("s", 0.5, low=0, high=10, description="patience for the first frames after key-on")
    bulb_check_time: float = parameter("s", 1.8, low=0, high=10, description="lamp on after key-on")
    implausible_time: float = parameter("s", 0.1, low=0.01, high=5, description="contradiction lasting this long")
    missing_wheel_time: float = parameter("s", 1.0, low=0.1, high=60, description="wheel stands, the others roll")
    speed_difference: float = parameter("1", 0.15, low=0.01, high=1, description="own speed against the frame's")
    wheel_acceleration: float = parameter("m/s^2", 1500, low=50, high=1e5, description="no wheel is faster than this")
    inertial_required: bool = Field(default=False, description="a fault of the inertial sensor switches the ABS off")
    healing_time: float = parameter("s", 1.0, low=0, high=60, description="healthy drive before the lamp goes out")
    healing_speed: float = parameter("m/s", 10 / 3.6, low=0, high=30, description="speed of that healthy drive")


class CalibrationFile(FileModel):
    """Schema of a calibration file."""

    format: Literal[1]
    name: str
    description: str = ""
    car: Car = Field(default_factory=Car)
    wheel_speed: WheelSpeed = Field(default_factory=WheelSpeed)
    reference: Reference = Field(default_factory=Reference)
    slip: Slip
    pressure: Pressure
    split: Split = Field(default_factory=Split)
    distribution: Distribution = Field(default_factory=Distribution)
    limits: Limits = Field(default_factory=Limits)
    monitoring: Monitoring = Field(default_factory=Monitoring)


def calibration_path(name_or_path: str | Path) -> Path:
    """File of a shipped calibration by name, or the path itself.

    Raises
    ------
    InputError
        If it is neither.
    """
    if str(name_or_path) in CALIBRATIONS:
        return _FOLDER / f"{name_or_path}.yaml"
    path = Path(name_or_path)
    if not path.exists():
        raise unknown_name("calibration", str(name_or_path), CALIBRATIONS)
    return path


def load_calibration(name_or_path: str | Path) -> CalibrationFile:
    """Read and validate a calibration.

    Raises
    ------
    InputError
        With every fault of the file, its line and column.
    """
    from signals.yaml_files import load_yaml, validate

    return validate(load_yaml(calibration_path(name_or_path)), CalibrationFile)
