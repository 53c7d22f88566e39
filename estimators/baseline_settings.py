"""Keys and outputs of the document's baselines: slip slope, cornering stiffness, simple braking evaluation."""

from typing import Literal

from pydantic import Field, model_validator

from estimators.channels import MOTION_INPUTS
from estimators.description import Output, with_deviation
from signals.quantities import FileModel, parameter

_WHEELS = ("fl", "fr", "rl", "rr")
_LOADS = tuple(f"vertical_load_{wheel}" for wheel in _WHEELS)
_USED = tuple(f"friction_used_{wheel}" for wheel in _WHEELS)
_LIMITS = tuple(f"friction_limit_{wheel}" for wheel in _WHEELS)
_FIRST_OUTPUTS = (
    Output("active", "1", "1 while it evaluates"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
)


class BaselineSettings(FileModel):
    """What the baselines share."""

    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )
    minimum_speed: float = parameter(
        "m/s", 3.0, low=0.5, high=20.0, description="it evaluates above this speed", source="assumed"
    )


class BrakingSettings(BaselineSettings):
    """What the baselines for braking share: how they know the speed."""

    braking_start: float = parameter(
        "m/s^2",
        1.0,
        low=0.1,
        high=20.0,
        description="deceleration above which wheels slip: the speed is then integrated from the accelerometer",
        source="assumed",
    )


class SlipSlopeSettings(BrakingSettings):
    """Settings of the slip-slope method."""

    speed_source: Literal["wheels_and_accelerometer", "ecu_reference_speed"] = Field(
        default="wheels_and_accelerometer",
        description="vehicle speed, which the method takes as known: wheels while rolling, integrated accelerometer "
        "while braking; or the reference speed that the ECU reports",
    )
    forgetting: float = parameter("1", 0.98, low=0.9, high=1.0, description="forgetting factor lambda", source="l. 575")
    stiffness_ratio: float = parameter(
        "1", 1.0, low=0.1, high=10.0, description="epsilon, slip slope front over rear", source="6.1.4"
    )
    linear_slip: float = parameter(
        "1",
        0.10,
        low=0.01,
        high=0.5,
        description="slip below which force is proportional to it",
        source="l. 548",
    )
    table_slip: float = parameter(
        "1",
        0.03,
        low=0.005,
        high=0.1,
        description="slip below which the table is asked",
        source="3.2 item 5",
    )
    smallest_force: float = parameter(
        "1", 0.1, low=0.0, high=1.0, description="and friction in use above which it is", source="assumed"
    )
    peak_time_constant: float = parameter(
        "s", 0.5, low=0.01, high=10.0, description="the largest friction in use is forgotten with it", source="assumed"
    )
    slopes: list[float] = Field(
        default=[1.67, 6.03, 17.9, 20.6, 21.4],
        description="table: slip slopes, rising (Table 3, secant at 3 % slip)",
        json_schema_extra={"unit": "1"},
    )
    limits: list[float] = Field(
        default=[0.05, 0.19, 0.80, 1.09, 1.17],
        description="table: friction limits at these slopes (Table 3, peaks)",
        json_schema_extra={"unit": "1"},
    )

    @model_validator(mode="after")
    def _table(self) -> "SlipSlopeSettings":
        if len(self.slopes) != len(self.limits) or len(self.slopes) < 2:
            raise ValueError(
                f"slopes, limits: found {len(self.slopes)} and {len(self.limits)}, allowed: equally many, >= 2"
            )
        if any(later <= earlier for earlier, later in zip(self.slopes, self.slopes[1:], strict=False)):
            raise ValueError("slopes: found values that do not rise, allowed: strictly rising slopes")
        return self


SLIP_SLOPE_OUTPUTS: tuple[Output, ...] = (
    *_FIRST_OUTPUTS,
    Output("speed", "m/s", "vehicle speed that the method uses"),
    Output("slip_front", "1", "slip of the front axle at that speed"),
    Output("slip_rear", "1", "slip of the rear axle at that speed"),
    *with_deviation("slip_slope", "1", "friction in use over slip, rear axle"),
    *with_deviation("friction_used", "1", "friction coefficient in use, whole car", _USED, _LOADS),
    Output("friction_limit", "1", "largest friction coefficient, whole car", _LIMITS, _LOADS),
    Output("friction_limit_confidence", "1", "1 while the table is in its range or the peak has been reached"),
)


def slip_slope_inputs(settings: SlipSlopeSettings) -> tuple[str, ...]:
    """Decoded signals that the slip-slope method reads."""
    if settings.speed_source == "ecu_reference_speed":
        return (*MOTION_INPUTS, "ecu_reference_speed")
    return MOTION_INPUTS


class SimpleBrakingSettings(BrakingSettings):
    """Settings of the simple evaluation for asphalt comparison."""

    head_wind: float = parameter("m/s", 0.0, low=-40.0, high=40.0, neutral=0.0, description="wind against the car, v_w")
    grade: float = parameter(
        "rad",
        0.0,
        low=-0.3,
        high=0.3,
        neutral=0.0,
        description="slope of the road, uphill positive",
    )


SIMPLE_BRAKING_OUTPUTS: tuple[Output, ...] = (
    *_FIRST_OUTPUTS,
    Output("speed", "m/s", "speed integrated from the accelerometer while braking"),
    Output("load_front", "N", "vertical load of the front axle"),
    Output("load_rear", "N", "vertical load of the rear axle"),
    Output("friction_used", "1", "friction coefficient in use, whole car", _USED, _LOADS),
    Output("friction_used_confidence", "1", "1 while braking"),
    Output("friction_mean", "1", "mean magnitude of the friction in use over this braking so far"),
    Output("friction_mean_std", "1", "standard deviation of the friction in use over this braking so far"),
    Output("friction_mean_confidence", "1", "1 once a braking of at least 0.1 s has been evaluated"),
)


def simple_braking_inputs(settings: SimpleBrakingSettings) -> tuple[str, ...]:
    """Decoded signals that the simple evaluation reads."""
    return MOTION_INPUTS


class CorneringStiffnessSettings(BaselineSettings):
    """Settings of the cornering-stiffness method."""

    slip_angle_span: float = parameter(
        "rad",
        0.0174533,
        low=1e-4,
        high=0.5,
        description="span of slip angles in a window, 1 deg",
        source="6.1.4",
    )
    longest_window: int = Field(default=1000, ge=10, le=5000, description="samples after which a window is given up")
    flat_slope: float = parameter(
        "1/rad",
        0.0,
        low=0.0,
        high=20.0,
        description="slope at which the limit counts as reached",
        source="l. 608",
    )
    yaw_acceleration_time_constant: float = parameter(
        "s", 0.02, low=1e-3, high=1.0, description="low-pass of the yaw rate's derivative", source="assumed"
    )
    side_slip_time_constant: float = parameter(
        "s",
        2.0,
        low=0.05,
        high=100.0,
        description="the integrated side-slip angle returns to that of steady rolling with it",
        source="assumed",
    )
    roll_gradient: float = parameter(
        "rad s^2/m",
        0.0,
        low=0.0,
        high=0.05,
        neutral=0.0,
        description="roll angle per lateral acceleration; a rolled accelerometer feels a part of gravity",
        source="assumed: a car that does not roll, as in the document",
    )
    signal_time_constant: float = parameter(
        "s",
        0.02,
        low=1e-4,
        high=1.0,
        description="low-pass before the regression",
        source="assumed",
    )


_EVALUATES = "1 while it evaluates"


def _slip_angle(axle: str, wheels: tuple[str, str]) -> Output:
    """The plant's slip angle is that of ISO 8855, negative with positive side force."""
    description = f"slip angle of the {axle} axle, positive with positive side force"
    return Output(f"slip_angle_{axle}", "rad", description, tuple(f"slip_angle_{wheel}" for wheel in wheels), sign=-1.0)


def _side_friction(axle: str, wheels: tuple[str, str]) -> Output:
    return Output(
        f"friction_used_{axle}",
        "1",
        f"side force over load, {axle} axle",
        tuple(f"lateral_force_{wheel}" for wheel in wheels),
        total=True,
        over=tuple(f"vertical_load_{wheel}" for wheel in wheels),
    )


CORNERING_STIFFNESS_OUTPUTS: tuple[Output, ...] = (
    *_FIRST_OUTPUTS,
    Output("side_slip_angle", "rad", "side-slip angle that the method uses", ("side_slip_angle",)),
    _slip_angle("front", ("fl", "fr")),
    _slip_angle("rear", ("rl", "rr")),
    _side_friction("front", ("fl", "fr")),
    _side_friction("rear", ("rl", "rr")),
    Output("slope_front", "1/rad", "slope of side friction over slip angle, front axle"),
    Output("slope_front_std", "1/rad", "standard deviation of the slope, front axle"),
    Output("slope_front_confidence", "1", "1 while the window spans the wanted slip angles, front axle"),
    Output("slope_rear", "1/rad", "slope of side friction over slip angle, rear axle"),
    Output("slope_rear_std", "1/rad", "standard deviation of the slope, rear axle"),
    Output("slope_rear_confidence", "1", "1 while the window spans the wanted slip angles, rear axle"),
    Output("window_front", "s", "length of the window, front axle"),
    Output("window_rear", "s", "length of the window, rear axle"),
    Output("limit_reached_front", "1", "1 while the slope tells that the front axle is at its limit"),
    Output("limit_reached_rear", "1", "1 while the slope tells that the rear axle is at its limit"),
    Output("side_slip_angle_confidence", "1", f"side-slip angle: {_EVALUATES}"),
    Output("slip_angle_front_confidence", "1", f"slip angle of the front axle: {_EVALUATES}"),
    Output("slip_angle_rear_confidence", "1", f"slip angle of the rear axle: {_EVALUATES}"),
    Output("friction_used_front_confidence", "1", f"side force over load, front axle: {_EVALUATES}"),
    Output("friction_used_rear_confidence", "1", f"side force over load, rear axle: {_EVALUATES}"),
)


def cornering_stiffness_inputs(settings: CorneringStiffnessSettings) -> tuple[str, ...]:
    """Decoded signals that the cornering-stiffness method reads."""
    return (*MOTION_INPUTS, "lateral_acceleration", "yaw_rate", "steering_wheel_angle")
