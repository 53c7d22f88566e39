"""Section of a vehicle file with terms that measured data showed and no parameter of the car describes.

A term is ``coefficient · f1(x1) · f2(x2) · …`` and is added to its target; the stack of terms runs compiled.
"""

from typing import Annotated, Any, Literal, get_args

from pydantic import Discriminator, Field, Tag

from signals.quantities import FileModel, parameter

MOST_TERMS = 32
MOST_FACTORS = 4

Target = Literal[
    "brake_torque_factor",
    "brake_torque",
    "drive_torque",
    "tyre_friction_factor",
    "tyre_lateral_force",
    "rolling_resistance",
    "wheel_radius_factor",
    "body_longitudinal_force",
    "body_lateral_force",
    "yaw_moment",
]
TARGETS: tuple[str, ...] = get_args(Target)
TARGET_UNITS = dict(zip(TARGETS, ("1", "N m", "N m", "1", "N", "1", "1", "N", "N", "N m"), strict=True))
"""Unit of what a term adds; a factor is 1 + the sum of its terms."""

CarVariable = Literal[
    "speed",
    "lateral_speed",
    "yaw_rate",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "steering_wheel_angle",
    "roll_angle",
    "pitch_angle",
    "time",
    "distance",
    "stop_energy",
]
WheelVariable = Literal[
    "wheel_speed",
    "wheel_angle",
    "axle_speed_difference",
    "slip_ratio",
    "slip_angle",
    "sliding_speed",
    "vertical_load",
    "longitudinal_force",
    "lateral_force",
    "suspension_travel",
    "brake_torque",
    "drive_torque",
    "brake_pressure",
    "brake_disc_temperature",
    "tyre_heating",
    "brake_pressure_rate",
]
CAR_VARIABLES: tuple[str, ...] = get_args(CarVariable)
WHEEL_VARIABLES: tuple[str, ...] = get_args(WheelVariable)
VARIABLES = CAR_VARIABLES + WHEEL_VARIABLES
VARIABLE_UNITS: dict[str, str] = {
    "speed": "m/s",
    "lateral_speed": "m/s",
    "yaw_rate": "rad/s",
    "longitudinal_acceleration": "m/s^2",
    "lateral_acceleration": "m/s^2",
    "steering_wheel_angle": "rad",
    "roll_angle": "rad",
    "pitch_angle": "rad",
    "time": "s",
    "distance": "m",
    "stop_energy": "J",
    "wheel_speed": "rad/s",
    "wheel_angle": "rad",
    "axle_speed_difference": "rad/s",
    "slip_ratio": "1",
    "slip_angle": "rad",
    "sliding_speed": "m/s",
    "vertical_load": "N",
    "longitudinal_force": "N",
    "lateral_force": "N",
    "suspension_travel": "m",
    "brake_torque": "N m",
    "drive_torque": "N m",
    "brake_pressure": "Pa",
    "brake_disc_temperature": "degC",
    "tyre_heating": "degC",
    "brake_pressure_rate": "Pa/s",
}

Wheels = Literal["all", "front", "rear", "left", "right", "fl", "fr", "rl", "rr"]
WHEELS_OF: dict[str, tuple[int, ...]] = {
    "all": (0, 1, 2, 3),
    "front": (0, 1),
    "rear": (2, 3),
    "left": (0, 2),
    "right": (1, 3),
    "fl": (0,),
    "fr": (1,),
    "rl": (2,),
    "rr": (3,),
}


def _exponent() -> float:
    declared: float = parameter("1", 1.0, low=0.0, high=6.0, description="e")
    return declared


def _threshold() -> float:
    declared: float = parameter("1", 0.0, description="in the variable's unit")
    return declared


def _width() -> float:
    declared: float = parameter("1", low=1e-9, description="half width, in the variable's unit")
    return declared


class _Factor(FileModel):
    """A function f of one variable x.

    ``symmetry`` none: f(x); even: f(|x|); odd: sign(x) f(|x|).
    """

    variable: CarVariable | WheelVariable
    symmetry: Literal["none", "even", "odd"] = "none"


class Power(_Factor):
    """sign(x) |x|^e."""

    function: Literal["power"] = "power"
    exponent: float = _exponent()


class Above(_Factor):
    """max(x - at, 0)^e."""

    function: Literal["above"]
    at: float = _threshold()
    exponent: float = _exponent()


class Below(_Factor):
    """max(at - x, 0)^e."""

    function: Literal["below"]
    at: float = _threshold()
    exponent: float = _exponent()


class Step(_Factor):
    """1 above ``at``, 0 below."""

    function: Literal["step"]
    at: float = _threshold()


class ExcessShare(_Factor):
    """1 - at / x above ``at``, else 0: what of x lies above ``at``, as a share of x."""

    function: Literal["excess_share"]
    at: float = parameter("1", low=1e-9, description="in the variable's unit")


class Limited(_Factor):
    """(x - at) / width, held within -1 and 1."""

    function: Literal["limited"]
    at: float = _threshold()
    width: float = _width()


class Sine(_Factor):
    """sin(wave_number x + phase)."""

    function: Literal["sine"]
    wave_number: float = parameter("1", description="rad per the variable's unit")
    phase: float = parameter("rad", 0.0, description="at x = 0")


class Relay(_Factor):
    """1 once x rose over at + width, -1 once it fell under at - width, -1 before."""

    function: Literal["relay"]
    at: float = _threshold()
    width: float = _width()


class Direction(_Factor):
    """Which way x moved last, -1 to 1, turning round within 2 widths: (x - play) / width, the play of ± width."""

    function: Literal["direction"]
    width: float = _width()


def _function_of(value: Any) -> str:
    if isinstance(value, dict):
        return str(value.get("function", "power"))
    return str(getattr(value, "function", type(value).__name__))


Factor = Annotated[
    Annotated[Power, Tag("power")]
    | Annotated[Above, Tag("above")]
    | Annotated[Below, Tag("below")]
    | Annotated[Step, Tag("step")]
    | Annotated[ExcessShare, Tag("excess_share")]
    | Annotated[Limited, Tag("limited")]
    | Annotated[Sine, Tag("sine")]
    | Annotated[Relay, Tag("relay")]
    | Annotated[Direction, Tag("direction")],
    Discriminator(_function_of),
]
FUNCTIONS = ("power", "above", "below", "step", "excess_share", "limited", "sine", "relay", "direction")


class Term(FileModel):
    """A term; its coefficient is in the target's unit over the units of the factors."""

    target: Target
    coefficient: float = parameter("1", neutral=0.0, description="in the target's unit over those of the factors")
    wheels: Wheels = Field(default="all", description="wheels on which it acts, or over which a force on the body sums")
    factors: list[Factor] = Field(default_factory=list, max_length=MOST_FACTORS)
    description: str = ""


class Terms(FileModel):
    """Added terms, all of them at work together."""

    stack: list[Term] = Field(default_factory=list, max_length=MOST_TERMS)
    tyre_heat_capacity: float = parameter(
        "J/degC", 5400.0, low=100.0, high=1e6, description="of a tread", source="assumed: 3 kg of rubber"
    )
    tyre_cooling_rate: float = parameter(
        "1/s",
        1.0 / 60.0,
        low=0.0,
        high=10.0,
        description="share of a tread's excess heat lost per time",
        source="assumed: a minute",
    )
