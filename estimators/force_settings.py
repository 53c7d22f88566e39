"""Keys and outputs of the force-estimating filter."""

from typing import Literal

from pydantic import Field

from estimators.channels import MOTION_INPUTS, TORQUE_INPUTS
from estimators.description import Output, with_deviation
from estimators.longitudinal_settings import LongitudinalSettings
from signals.quantities import parameter


class ForceEkfSettings(LongitudinalSettings):
    """Settings of the force EKF. Noise is per millisecond step (L = I, Q already scaled); values are assumed."""

    drag: Literal["quadratic", "cosine"] = Field(
        default="quadratic", description="drag over speed: exact (eq. 82) or the cosine substitute (eq. 83)"
    )
    cosine_speed: float = parameter(
        "m/s", 40.0, low=5.0, high=120.0, description="steady speed v0 of the cosine substitute", source="assumed"
    )
    unmodelled_force: bool = Field(
        default=False, description="estimate a force of unmodelled effects; only for poor models, otherwise it harms"
    )
    brake_torque: Literal["capacity", "actual"] = Field(
        default="capacity",
        description="capacity: a brake stops a wheel but never turns it backwards; actual: taken as the torque itself",
    )
    input_rule: Literal["fresh", "hold"] = Field(
        default="fresh",
        description="fresh: only samples that are new in this tick; hold: every tick with the last one",
    )
    process_speed: float = parameter("m/s", 0.001, low=0.0, description="noise of the speed", source="assumed")
    process_wheel_speed: float = parameter(
        "rad/s", 0.02, low=0.0, description="noise of the wheel speeds", source="assumed"
    )
    process_force: float = parameter("N", 50.0, low=0.0, description="noise of the axle forces", source="assumed")
    process_force_rate: float = parameter("N/s", 5000.0, low=0.0, description="noise of their rates", source="assumed")
    process_unmodelled: float = parameter(
        "N", 1.0, low=0.0, description="noise of the unmodelled force, where it is estimated", source="assumed"
    )
    process_unmodelled_rate: float = parameter(
        "N/s", 1.0, low=0.0, description="noise of the rate of the unmodelled force", source="assumed"
    )
    measurement_acceleration: float = parameter("m/s^2", 0.1, low=1e-6, description="accelerometer", source="assumed")
    measurement_wheel_speed: float = parameter("rad/s", 0.05, low=1e-6, description="wheel speeds", source="assumed")
    initial_speed: float = parameter(
        "m/s", 0.5, low=0.0, description="initial deviation of the speed", source="assumed"
    )
    initial_wheel_speed: float = parameter(
        "rad/s", 0.2, low=0.0, description="initial deviation of the wheel speeds", source="assumed"
    )
    initial_force: float = parameter(
        "N", 2000.0, low=0.0, description="initial deviation of the forces", source="assumed"
    )
    initial_force_rate: float = parameter(
        "N/s", 1e4, low=0.0, description="initial deviation of their rates", source="assumed"
    )
    minimum_speed: float = parameter(
        "m/s", 1.5, low=0.5, high=20.0, description="the filter runs above it", source="3.6.7"
    )
    speed_hysteresis: float = parameter(
        "m/s", 0.2, low=0.0, high=2.0, description="it stops this much below the minimum speed", source="assumed"
    )
    speed_bound: Literal["standstill", "wheels"] = Field(
        default="standstill",
        description="what the speed is held above. standstill: 0, the end of eq. 82; wheels: also the rim speed of an "
        "axle without drive torque, which the document's filter does not ask",
    )
    rolling_speed: Literal["measured", "none"] = Field(
        default="measured",
        description="measured: while an axle has no torque its rim speed tells the speed, and what the accelerometer "
        "tells beside the forces is its offset; none: the document's rows alone, an offset passes for drag",
    )
    measurement_rolling_speed: float = parameter(
        "m/s",
        0.1,
        low=1e-3,
        description="rim speed of a rolling axle against the speed: slip, radius, torques below 2 % of the weight",
        source="assumed",
    )
    offset_time_constant: float = parameter(
        "s", 0.15, low=0.01, high=60.0, description="rolling time in which the offset is found", source="assumed"
    )
    largest_offset: float = parameter(
        "m/s^2",
        1.0,
        low=0.0,
        high=10.0,
        description="bound of the offset, a grade included; 0: none is taken out",
        source="assumed",
    )
    contradiction_samples: float = parameter(
        "1",
        100.0,
        low=1.0,
        high=1e4,
        description="accelerometer samples over which its residual is averaged",
        source="assumed",
    )
    contradiction_limit: float = parameter(
        "1",
        0.3,
        low=0.1,
        high=100.0,
        description="mean of the residual over its deviation above which the speed is not to be trusted",
        source="assumed: four deviations of the mean of 100 white samples",
    )
    restart: bool = Field(
        default=True,
        description="a speed that is not to be trusted is taken from the wheels again once an axle has no torque",
    )
    locked_rate_time_constant: float = parameter(
        "s",
        0.05,
        low=1e-3,
        description="while the brakes hold both axles still, the rates of the forces die out with it",
        source="assumed",
    )


def force_inputs(settings: ForceEkfSettings) -> tuple[str, ...]:
    """Decoded signals that the force EKF reads."""
    return MOTION_INPUTS + TORQUE_INPUTS


_FRONT = ("longitudinal_force_fl", "longitudinal_force_fr")
_REAR = ("longitudinal_force_rl", "longitudinal_force_rr")

FORCE_OUTPUTS: tuple[Output, ...] = (
    Output("active", "1", "1 while the filter runs, 0 at standstill and while inputs are lost"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
    *with_deviation("speed", "m/s", "vehicle speed", ("speed",)),
    *with_deviation(
        "wheel_speed_front", "rad/s", "mean front wheel speed", ("true_wheel_speed_fl", "true_wheel_speed_fr")
    ),
    *with_deviation(
        "wheel_speed_rear", "rad/s", "mean rear wheel speed", ("true_wheel_speed_rl", "true_wheel_speed_rr")
    ),
    *with_deviation("force_front", "N", "longitudinal force of both front tyres", _FRONT, total=True),
    *with_deviation("force_rear", "N", "longitudinal force of both rear tyres", _REAR, total=True),
    *with_deviation("unmodelled_force", "N", "force of unmodelled effects on the car"),
    Output("acceleration_offset", "m/s^2", "what the accelerometer told beside the forces while an axle rolled"),
    Output("innovation", "1", "normalised innovation squared of this step"),
    Output("speed_confidence", "1", "1 while accelerometer and wheels agree and the speed is within its bounds"),
)
