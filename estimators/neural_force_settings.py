"""Keys and outputs of the neural force observer and of the random-walk filter it is compared with."""

from typing import Literal

from pydantic import Field, model_validator

from estimators.description import Output, with_deviation
from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS

_ASSUMED = "force document 3.4, assumed"


class NeuralForceSettings(FileModel):
    """Settings of the cascade of two observers with radial-basis-function networks."""

    network: Literal["radial_basis", "integral", "none"] = Field(
        default="radial_basis",
        description="radial_basis: the document's; integral: one constant neuron (baseline B1); none: no force is "
        "learned (baseline B0)",
    )
    learning_front: float = parameter(
        "1", 3e7, low=0.0, description="g_1 of the front force, N per rad and rad/s", source=f"{_ASSUMED}: with noise"
    )
    learning_rear: float = parameter(
        "1", 1e6, low=0.0, description="g_2 of the rear force, N per m/s and s", source=f"{_ASSUMED}: with noise"
    )
    forgetting_front: float = parameter(
        "1/s", 0.0, low=0.0, high=100.0, neutral=0.0, description="kappa_1, sigma-modification", source=_ASSUMED
    )
    forgetting_rear: float = parameter("1/s", 0.0, low=0.0, high=100.0, neutral=0.0, description="kappa_2, likewise")
    poles_yaw: tuple[float, float] = Field(
        default=(-10.0, -500.0), description="poles of observer 1 [1/s] (l. 412); L_1 follows"
    )
    pole_speed: float = parameter("1/s", -150.0, low=-1000.0, high=-1.0, description="pole of v_x", source="l. 458")
    pole_steering: float = parameter("1/s", -7.0, low=-500.0, high=-0.1, description="pole of delta_f", source="l. 458")
    neurons_yaw: int = Field(default=5, ge=2, le=9, description="centres per axis of network 1, on [-1, 1] twice")
    neurons_speed: int = Field(default=5, ge=2, le=9, description="centres of network 2 over the speed, on [0, 1]")
    neurons_steering: int = Field(default=3, ge=2, le=9, description="and over the road-wheel angle, on [-1, 1]")
    width: float = parameter("1", 1.0, low=0.05, high=10.0, description="b, in units of the inputs", source=_ASSUMED)
    normalised: bool = Field(default=True, description="regressors of length 1, so that g does not depend on N and b")
    cornering_stiffness_front: float | None = parameter(
        "N/rad",
        None,
        low=100.0,
        high=1e6,
        description="C_f of the axle; left out: steered_track.cornering_stiffness_front of the vehicle file, or the "
        "slope of its tyres",
    )
    cornering_stiffness_rear: float | None = parameter("N/rad", None, low=100.0, high=1e6, description="C_r, likewise")
    steering_time_constant: float | None = parameter(
        "s", None, low=0.001, high=2.0, description="tau; left out: steered_track.steering_time_constant"
    )
    slowest: float = parameter(
        "m/s", 1.0, low=0.1, high=10.0, description="smallest v_x in divisors, and to begin at", source="3.6"
    )
    force_time_constant: float = parameter(
        "s",
        5.0,
        low=0.1,
        high=100.0,
        description="time in which the true front force is taken to wander: the confidence sets it against the rate of "
        "learning, which is zero while the wheels point ahead",
        source="assumed",
    )
    printed_rear_sign: bool = Field(default=False, description="force pushes the rear along its slip, as printed (13)")
    printed_double_count: bool = Field(default=False, description="actuator lag counted twice, as printed (22)")
    printed_update: float = parameter(
        "rad/m",
        0.0,
        low=0.0,
        high=10.0,
        neutral=0.0,
        description="weight of the lateral speed's error beside the yaw rate's in learning the front force, as printed "
        "(3), where F e has the whole state error; above 0 the observer rests until a demonstration tells it the true "
        "lateral speed, which nothing on the bus measures",
    )
    printed_exponent: bool = Field(default=False, description="exponent without square, as printed (l. 159)")
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )

    @model_validator(mode="after")
    def _stable(self) -> "NeuralForceSettings":
        if max(self.poles_yaw) >= 0.0:
            raise FieldError("a pole that is not stable", at=("poles_yaw",), allowed="two negative numbers")
        return self


class RandomWalkForceSettings(FileModel):
    """Settings of the extended Kalman filter with forces as random walks (baseline B2)."""

    measurement_speed: float = parameter("m/s", 0.02, low=1e-6, description="noise of v_x", source="4, assumed there")
    measurement_yaw_rate: float = parameter("rad/s", 0.001, low=1e-6, description="noise of the yaw rate")
    process_speed: float = parameter("m/s", 0.003, low=0.0, description="noise of v_x and v_y per root second")
    process_yaw_rate: float = parameter("rad/s", 0.001, low=0.0, description="noise of the yaw rate per root second")
    process_force_front: float = parameter("N", 200.0, low=0.0, description="noise of F_xf per root second")
    process_force_rear: float = parameter("N", 600.0, low=0.0, description="noise of F_xr per root second")
    cornering_stiffness_front: float | None = parameter(
        "N/rad", None, low=100.0, high=1e6, description="C_f of the axle, as for the neural observer"
    )
    cornering_stiffness_rear: float | None = parameter("N/rad", None, low=100.0, high=1e6, description="C_r, likewise")
    slowest: float = parameter("m/s", 1.0, low=0.1, high=10.0, description="smallest v_x in divisors", source="3.6")
    input_timeout: float = parameter(
        "s", 0.1, low=0.002, high=5.0, description="time without a good sample after which an input is lost"
    )


_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


def neural_force_inputs(settings: NeuralForceSettings) -> tuple[str, ...]:
    """v_x is the mean of the wheels' rim speeds, u the commanded road-wheel angle."""
    return ("yaw_rate", "road_wheel_angle", "steering_command", *_WHEEL_SPEEDS)


def random_walk_inputs(settings: RandomWalkForceSettings) -> tuple[str, ...]:
    """The same without the command."""
    return ("yaw_rate", "road_wheel_angle", *_WHEEL_SPEEDS)


_STATUS = (
    Output("active", "1", "1 while the observer runs, 0 while inputs are lost and at walking pace"),
    Output("resets", "1", "returns to the initial state so far"),
    Output("input_state", "1", "0 inputs good, 1 a wrong sample was held, 2 inputs lost"),
)
_FRONT = ("longitudinal_force_fl", "longitudinal_force_fr")
_REAR = ("longitudinal_force_rl", "longitudinal_force_rr")

_SETTLED = "0 to 1: time since the start against the slowest pole of observer 1"
_LEARNED = "0 to 1: learning against wandering of the front force; low without steering"

NEURAL_FORCE_OUTPUTS: tuple[Output, ...] = (
    *_STATUS,
    Output("lateral_speed", "m/s", "lateral speed of the centre of gravity", ("lateral_speed",)),
    Output("lateral_speed_confidence", "1", _SETTLED),
    Output("force_front", "N", "longitudinal force of both front tyres", _FRONT, total=True),
    Output("force_front_confidence", "1", _LEARNED),
    Output("force_rear", "N", "longitudinal force of both rear tyres", _REAR, total=True),
    Output("force_rear_confidence", "1", "as of the front force, whose error it carries with the opposite sign"),
    Output("force_total", "N", "sum of both, which is observable at any steer", _FRONT + _REAR, total=True),
    Output("force_total_confidence", "1", _SETTLED),
    Output("speed", "m/s", "filtered longitudinal speed", ("speed",)),
    Output("speed_confidence", "1", _SETTLED),
    Output("yaw_rate", "rad/s", "filtered yaw rate", ("true_yaw_rate",)),
    Output("yaw_rate_confidence", "1", _SETTLED),
    Output("road_wheel_angle", "rad", "filtered road-wheel angle", ("true_road_wheel_angle_fl",)),
    Output("road_wheel_angle_confidence", "1", _SETTLED),
)
RANDOM_WALK_OUTPUTS: tuple[Output, ...] = (
    *_STATUS,
    *with_deviation("speed", "m/s", "longitudinal speed", ("speed",)),
    *with_deviation("lateral_speed", "m/s", "lateral speed of the centre of gravity", ("lateral_speed",)),
    *with_deviation("yaw_rate", "rad/s", "yaw rate", ("true_yaw_rate",)),
    *with_deviation("force_front", "N", "longitudinal force of both front tyres", _FRONT, total=True),
    *with_deviation("force_rear", "N", "longitudinal force of both rear tyres", _REAR, total=True),
    Output("innovation", "1", "normalised innovation squared of this step"),
)
