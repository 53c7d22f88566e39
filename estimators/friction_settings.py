"""Keys of the friction filters; noise defaults of the friction document, 3.6.8 and 3.6.9."""

from typing import ClassVar, Literal

from pydantic import Field

from estimators.channels import MOTION_INPUTS, TORQUE_INPUTS
from estimators.longitudinal_settings import LongitudinalSettings
from signals.quantities import FileModel, parameter

_TABLE = "friction document 3.6.8, 3.6.9"


class TyreCurve(FileModel):
    """Shape of the reduced curve mu = k0 sin(k1 arctan(k2 s)), known once from a road with high grip (2.2.5)."""

    shape_front: float = parameter("1", 1.316, low=1.0, high=2.0, description="k1 front", source="set T of 2.2.5")
    stiffness_front: float = parameter("1", 14.34, low=1.0, high=200.0, description="k2 front", source="set T of 2.2.5")
    shape_rear: float = parameter("1", 1.316, low=1.0, high=2.0, description="k1 rear", source="set T of 2.2.5")
    stiffness_rear: float = parameter("1", 14.34, low=1.0, high=200.0, description="k2 rear", source="set T of 2.2.5")


class ProcessNoise(FileModel):
    """Standard deviations per millisecond step; what is left out follows from the torque mode."""

    speed: float | None = parameter(
        "m/s", None, low=0.0, description="speed; 0.0015 with torques, 0.0045 without", source=_TABLE
    )
    wheel_speed: float | None = parameter(
        "rad/s", None, low=0.0, description="wheel speeds; known 0.1, z1 300, z2 1", source=_TABLE
    )
    slip: float | None = parameter(
        "1", None, low=0.0, description="slips; known 0.02, z1 1.5, z2 0.05; in the UKF 0.005", source=_TABLE
    )
    friction_limit: float | None = parameter(
        "1", None, low=0.0, description="friction limits k0; 0.0015 with torques, 0.002 without", source=_TABLE
    )
    friction_limit_rate: float | None = parameter(
        "1/s",
        None,
        low=0.0,
        description="rates of the limits; 0.01 with torques, 0.0005 without",
        source=_TABLE,
    )


class MeasurementNoise(FileModel):
    """Standard deviations of the eight measurement rows; what is left out follows from the torque mode."""

    acceleration: float | None = parameter(
        "m/s^2", None, low=1e-6, description="row 1, accelerometer; 0.25 with torques, 0.3 without", source=_TABLE
    )
    wheel_speed: float | None = parameter("rad/s", None, low=1e-6, description="rows 2 and 3; 0.05", source=_TABLE)
    slip: float | None = parameter(
        "1", None, low=1e-6, description="rows 4 and 5, equation of the slip; 0.001", source=_TABLE
    )
    friction_limit: float | None = parameter(
        "1",
        None,
        low=1e-6,
        description="rows 6 and 7, the prior; 10 with torques, 0.6 without",
        source=_TABLE,
    )
    speed: float | None = parameter(
        "m/s", None, low=1e-6, description="row 8, speed from the accelerometer; 0.0075 or 0.002", source=_TABLE
    )


class InitialDeviation(FileModel):
    """Standard deviations of the initial state."""

    speed: float = parameter("m/s", 0.5, low=0.0, description="speed", source=_TABLE)
    wheel_speed: float = parameter("rad/s", 0.2, low=0.0, description="wheel speeds", source=_TABLE)
    slip: float = parameter("1", 0.02, low=0.0, description="slips", source=_TABLE)
    friction_limit: float = parameter("1", 0.3, low=0.0, description="friction limits", source=_TABLE)
    friction_limit_rate: float = parameter("1/s", 0.1, low=0.0, description="their rates", source=_TABLE)


class FrictionSettings(LongitudinalSettings):
    """Settings that the extended and the unscented friction filter share."""

    # default noise of the slips with torques known, Z1, Z2 (3.6.8, 3.6.9)
    slip_noise: ClassVar[tuple[float, float, float]] = (0.02, 1.5, 0.05)

    torque_mode: Literal["known", "z1", "z2"] = Field(
        default="known",
        description="known: torques from brake pressures and powertrain; z1: torques set to zero as published; "
        "z2: torques dropped, wheel speeds and slips as random walks",
    )
    slip_rate_sign: Literal[1, -1] = Field(
        default=1, description="sign of R eta / v in the slip rate: 1 correct, -1 as printed in eq. 98"
    )
    exact_load_transfer: bool = Field(
        default=True,
        description="drag and rolling resistance count in the load transfer (3.6.3); false: eq. 95 as printed",
    )
    brake_torque: Literal["capacity", "actual"] = Field(
        default="capacity",
        description="capacity: a brake stops a wheel but never turns it backwards; actual: taken as the torque itself",
    )
    input_rule: Literal["fresh", "hold"] | None = Field(
        default=None,
        description="fresh: rows 1 to 3 only with samples that are new in this tick; hold: every tick with the last "
        "one; left out: fresh with torque_mode known, else hold",
    )
    tyre_curve: TyreCurve = Field(default_factory=TyreCurve, description="shape of the tyre curve")
    process_noise: ProcessNoise = Field(default_factory=ProcessNoise, description="process noise per millisecond")
    measurement_noise: MeasurementNoise = Field(default_factory=MeasurementNoise, description="measurement noise")
    initial_deviation: InitialDeviation = Field(default_factory=InitialDeviation, description="initial covariance")
    minimum_speed: float | None = parameter(
        "m/s", None, low=0.5, high=20.0, description="the filter runs above it; 1.5 with torques, 3 without"
    )
    speed_hysteresis: float = parameter(
        "m/s", 0.2, low=0.0, high=2.0, description="it stops this much below the minimum speed", source="assumed"
    )
    speed_floor: float = parameter(
        "m/s", 0.5, low=0.05, high=5.0, description="smallest speed inside the equations", source="3.6.7"
    )
    prior_friction_limit: float = parameter(
        "1", 1.0, low=0.05, high=2.0, description="initial friction limit and value of rows 6 and 7", source="eq. 103"
    )
    smallest_friction_limit: float = parameter(
        "1",
        0.02,
        low=-10.0,
        high=0.5,
        description="guard: a friction limit that falls below is put there",
        source="assumed",
    )
    largest_friction_limit: float = parameter(
        "1",
        2.5,
        low=0.5,
        high=100.0,
        description="guard: a friction limit that rises above is put there; at a slip near zero it would grow for ever",
        source="assumed: no tyre on a road reaches it",
    )
    speed_row_delay: float = parameter(
        "s",
        1.0,
        low=0.0,
        high=10.0,
        description="after a start in the middle of a braking, row 8 joins this much later",
        source="assumed",
    )
    braking_start: float = parameter(
        "m/s^2", 2.0, low=0.0, high=20.0, description="deceleration at the start that makes it one", source="assumed"
    )
    locked_rate_time_constant: float = parameter(
        "s",
        0.01,
        low=1e-3,
        description="while no wheel's speed tells its force, the rates of the friction limits die out with it",
        source="assumed",
    )
    confidence_ratio: float = parameter(
        "1", 0.3, low=0.0, high=1.0, description="share of the limit in use above which it is told", source="3.6.7"
    )
    confidence_time: float = parameter("s", 0.05, low=0.0, description="for at least this time", source="3.6.7")
    post_filter: Literal["none", "low_pass", "median"] = Field(
        default="none", description="filter of the ..._filtered outputs"
    )
    post_filter_time_constant: float = parameter("s", 0.2, low=1e-3, description="of the low-pass", source="3.6.7")
    post_filter_window: int = Field(default=51, ge=3, le=1001, description="samples of the running median (3.6.7)")


class FrictionUkfSettings(FrictionSettings):
    """Settings of the unscented Kalman filter for friction.

    Its slip noise is smaller than the EKF's: sigma points around the peak of the tyre curve lie below it, and the
    friction limit would come out too high by as much.
    """

    slip_noise: ClassVar[tuple[float, float, float]] = (0.005, 0.005, 0.005)

    torque_mode: Literal["known", "z2"] = Field(
        default="known",
        description="known: torques from brake pressures and powertrain; "
        "z2: torques dropped, wheel speeds and slips as random walks",
    )

    points: Literal["unscented", "cubature"] = Field(
        default="unscented", description="sigma points: scaled unscented or third-degree cubature"
    )
    alpha: float = parameter(
        "1", 1.0, low=1e-3, high=2.0, description="spread of the unscented points", source="assumed"
    )
    beta: float = parameter("1", 2.0, low=0.0, high=10.0, description="2 for a Gaussian distribution", source="assumed")
    kappa: float = parameter("1", 0.0, low=-5.0, high=10.0, description="secondary scaling", source="assumed")


class FrictionEkfSettings(FrictionSettings):
    """Settings of the extended Kalman filter for friction."""

    gate: float = parameter(
        "1",
        0.0,
        low=0.0,
        description="rows whose innovation is above this many standard deviations are left out; 0: none",
    )
    prediction_substeps: int = Field(
        default=1, ge=1, le=50, description="Euler steps per tick in the prediction (3.6.4)"
    )


# (torque known, Z1, Z2); Z1 takes the wheel and slip noise of 3.6.9 and the rest of the column "torque unknown"
_PROCESS = {
    "speed": (0.0015, 0.0045, 0.0045),
    "wheel_speed": (0.1, 300.0, 1.0),
    "friction_limit": (0.0015, 0.002, 0.002),
    "friction_limit_rate": (0.01, 0.0005, 0.0005),
}
_MEASUREMENT = {
    "acceleration": (0.25, 0.3, 0.3),
    "wheel_speed": (0.05, 0.05, 0.05),
    "slip": (0.001, 0.001, 0.001),
    "friction_limit": (10.0, 0.6, 0.6),
    "speed": (0.0075, 0.002, 0.002),
}
_MINIMUM_SPEED = (1.5, 3.0, 3.0)
_MODES = ("known", "z1", "z2")


def process_deviations(settings: FrictionSettings) -> tuple[float, ...]:
    """Process noise per step for the nine states."""
    given = settings.process_noise
    speed, wheel, limit, rate = (_chosen(getattr(given, name), values, settings) for name, values in _PROCESS.items())
    slip = _chosen(given.slip, settings.slip_noise, settings)
    return (speed, wheel, wheel, slip, slip, limit, rate, limit, rate)


def measurement_deviations(settings: FrictionSettings) -> tuple[float, ...]:
    """Measurement noise of the eight rows."""
    acceleration, wheel, slip, limit, speed = (
        _chosen(getattr(settings.measurement_noise, name), values, settings) for name, values in _MEASUREMENT.items()
    )
    return (acceleration, wheel, wheel, slip, slip, limit, limit, speed)


def initial_deviations(settings: FrictionSettings) -> tuple[float, ...]:
    """Initial standard deviations of the nine states."""
    first = settings.initial_deviation
    limits = (first.friction_limit, first.friction_limit_rate) * 2
    return (first.speed, first.wheel_speed, first.wheel_speed, first.slip, first.slip, *limits)


def minimum_speed(settings: FrictionSettings) -> float:
    """Speed above which the filter runs [m/s]."""
    return _chosen(settings.minimum_speed, _MINIMUM_SPEED, settings)


def holds_inputs(settings: FrictionSettings) -> bool:
    """Whether the last sample is used again in ticks that bring no new one.

    With torques the model predicts the wheels between samples well, and using one sample twice would only add delay.
    Without torques wheels and slips are random walks: between samples nothing would hold the slip.
    """
    if settings.input_rule is None:
        return settings.torque_mode != "known"
    return settings.input_rule == "hold"


def _chosen(given: float | None, defaults: tuple[float, float, float], settings: FrictionSettings) -> float:
    return defaults[_MODES.index(settings.torque_mode)] if given is None else given


def friction_inputs(settings: FrictionSettings) -> tuple[str, ...]:
    """Decoded signals that a friction filter reads."""
    return MOTION_INPUTS + TORQUE_INPUTS if settings.torque_mode == "known" else MOTION_INPUTS
