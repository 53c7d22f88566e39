"""Keys and outputs of the observers of the vertical wheel loads."""

from typing import Literal

from pydantic import Field

from estimators.description import Output, with_deviation
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS

_SOURCE = "vertical-load document"


class VerticalLoadSettings(FileModel):
    """Settings that all observers of the vertical loads share."""

    transfer: Literal["full", "steady"] = Field(
        default="full",
        description="lateral load transfer: full has the roll damping in it (11c), steady is the source's choice (12c)",
    )
    accelerometer: Literal["body", "level"] = Field(
        default="body",
        description="body: fixed to the rolling body, gravity adds g times the roll angle; level: it stays level",
    )
    cornering_stiffness_front: float | None = parameter(
        "N/rad",
        None,
        low=1e3,
        high=1e6,
        description="C_af of one front tyre; left out: two_track.cornering_stiffness_front of the vehicle file, or the "
        "slope of its tyre at the static load",
    )
    cornering_stiffness_rear: float | None = parameter(
        "N/rad", None, low=1e3, high=1e6, description="C_ar of one rear tyre, likewise"
    )
    front_roll_share: float | None = parameter(
        "1",
        None,
        low=0.0,
        high=1.0,
        description="lambda_f of the roll moment; left out: the vehicle file's, or the front share of the weight",
        source=f"{_SOURCE} 2.3, assumed",
    )
    static_load_front: float | None = parameter(
        "N", None, low=100.0, high=1e5, description="F_f of the axle at rest; left out: from mass and lengths"
    )
    static_load_rear: float | None = parameter(
        "N", None, low=100.0, high=1e5, description="F_r of the axle at rest, likewise"
    )
    minimum_speed: float = parameter(
        "m/s", 3.0, low=0.5, high=20.0, description="V_min: the model's speed never falls below it", source="2.7"
    )
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )


class _DynamicSettings(VerticalLoadSettings):
    """Settings of the observers that have a state."""

    period: float = parameter(
        "s", 0.01, low=0.001, high=0.1, description="time between two steps; between them the outputs are held"
    )
    noise_set: Literal["a", "b"] = Field(
        default="b",
        description="a: insensitive to an offset of the gyroscope, for smooth roads; b: the roll angle follows the "
        "measured roll rate, for roads that roll the car",
    )
    process_noise: list[float] | None = Field(
        default=None,
        min_length=4,
        max_length=4,
        description="diagonal of Q per step instead of the set's: (m/s)^2, (rad/s)^2, rad^2, (rad/s)^2",
    )
    measurement_acceleration: float = parameter(
        "m/s^2", 0.05, low=1e-6, description="noise of the lateral acceleration", source=f"{_SOURCE} 5"
    )
    measurement_yaw_rate: float = parameter(
        "rad/s", 0.002, low=1e-6, description="noise of the yaw rate", source=f"{_SOURCE} 5"
    )
    measurement_roll_rate: float = parameter(
        "rad/s", 0.005, low=1e-6, description="noise of the roll rate", source=f"{_SOURCE} 5"
    )

    def variances(self) -> list[float]:
        """Diagonal of Q."""
        return self.process_noise or PROCESS_NOISE[self.noise_set]


PROCESS_NOISE = {"a": [1e-3, 1e-5, 1e-7, 1e-4], "b": [1e-3, 1e-5, 1e-8, 1e-2]}
"""Q_A and Q_B (section 5, assumed there)."""


class VerticalLoadUkfSettings(_DynamicSettings):
    """Settings of the unscented Kalman filter."""

    points: Literal["full", "diagonal"] = Field(
        default="full",
        description="sigma points from a Cholesky factor of the covariance, or from its diagonal alone as printed (24)",
    )
    redraw: bool = Field(
        default=True, description="draw the points anew between prediction and correction; printed: no"
    )
    kappa: float = parameter("1", 1.0, low=-3.9, high=10.0, description="of (23)", source="3.2")
    enlargement: float = parameter(
        "1", 0.0, low=0.0, high=1.0, description="lambda of (25): points are enlarged by sqrt(1 + lambda^2)"
    )
    initial_covariance: list[float] = Field(
        default=[0.1, 0.01, 1e-4, 1e-3],
        min_length=4,
        max_length=4,
        description="diagonal of P_0: (m/s)^2, (rad/s)^2, rad^2, (rad/s)^2 (3.3)",
    )


class VerticalLoadKalmanSettings(_DynamicSettings):
    """Settings of the filters with a fixed gain."""

    design_speed: float = parameter(
        "m/s", 19.4444, low=3.0, high=80.0, description="V_x at which the gain is designed: 70 km/h", source="3.1"
    )


_CORNERING = ("lateral_acceleration", "yaw_rate", "steering_wheel_angle", "longitudinal_acceleration")
_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


def vertical_load_inputs(settings: VerticalLoadSettings) -> tuple[str, ...]:
    """Decoded signals of the observers with three sensors; the speed is the mean of the wheels' rim speeds."""
    return (*_CORNERING, "roll_rate", *_WHEEL_SPEEDS)


def two_sensor_inputs(settings: VerticalLoadSettings) -> tuple[str, ...]:
    """Decoded signals of the observer without roll rate."""
    return (*_CORNERING, *_WHEEL_SPEEDS)


def static_inputs(settings: VerticalLoadSettings) -> tuple[str, ...]:
    """The static loads need no signal; the wheel speeds tell that the bus is alive."""
    return _WHEEL_SPEEDS


VERTICAL_LOAD_OUTPUTS: tuple[Output, ...] = (
    Output("active", "1", "1 while the observer runs, 0 while inputs are lost"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
    *with_deviation("lateral_speed", "m/s", "lateral speed of the centre of gravity", ("lateral_speed",)),
    *with_deviation("yaw_rate", "rad/s", "yaw rate", ("true_yaw_rate",)),
    *with_deviation("roll_angle", "rad", "roll angle of the body", ("roll_angle",)),
    *with_deviation("roll_rate", "rad/s", "roll rate of the body", ("true_roll_rate",)),
    *(
        output
        for wheel in WHEELS
        for output in with_deviation(
            f"vertical_load_{wheel}", "N", f"vertical load of the wheel {wheel}", (f"vertical_load_{wheel}",)
        )
    ),
    Output("lateral_acceleration", "m/s^2", "lateral acceleration in the road's plane"),
    Output("innovation", "1", "normalised innovation squared of the last step"),
)
