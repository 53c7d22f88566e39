"""Manoeuvres in files: what the driver does, step by step.

Each step has a name (the phase that criteria, stimuli and reports use), says what the driver's feet and hands do, and
lasts until its condition holds. What a step leaves out goes on as the step before left it.

    steps:
      - name: accelerate
        accelerate: {accelerator: 1, highest_gear: 3, shift_up_speeds: [50 km/h, 75 km/h]}
        steer: {follow: straight}
        until: {signal: speed, above: 110 km/h}
      - name: release
        release: true
        until: {signal: speed, below: 95 km/h}
      - name: brake
        brake: {pedal_force: 500 N, ramp: 4 kN/s}
        until: {signal: speed, below: 0.1 km/h}
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from signals.conditions import Condition
from signals.errors import FieldError, FieldErrors
from signals.quantities import FileModel, parameter

Gears = Literal["auto"] | Annotated[int, Field(ge=0, le=12)]
_HUMAN = "assumed: usual for a trained driver"


class Accelerate(FileModel):
    """Accelerate, from standstill with the clutch, and shift up."""

    accelerator: float = parameter("1", 1.0, low=0.0, high=1.0, description="pedal, 0 to 1")
    accelerator_rate: float = parameter(
        "1/s", 5.0, low=0.1, high=100.0, description="of the pedal's way", source=_HUMAN
    )
    accelerator_by_gear: list[float] = Field(
        default=[],
        description="pedal in gear 1, 2, …, in place of accelerator; the last holds for higher gears",
        json_schema_extra={"unit": "1"},
    )
    gears: Gears = Field(
        default="auto", description="auto shifts up from the gear that is engaged, a number stays in that gear"
    )
    highest_gear: int | None = Field(
        default=None, ge=1, le=12, description="last gear of auto; without it the gearbox's last"
    )
    shift_up_engine_speed: float | None = parameter(
        "rad/s", None, low=50.0, high=2000.0, description="of auto; without it 92 % of the engine's maximum"
    )
    shift_up_speeds: list[float] = Field(
        default=[],
        description="speeds of the car at which auto leaves gear 1, 2, …; they win over the engine speed",
        json_schema_extra={"unit": "m/s"},
    )
    shift_duration: float = parameter(
        "s", 0.35, low=0.0, high=3.0, description="accelerator released and clutch open for a shift", source=_HUMAN
    )
    launch_engine_speed: float = parameter(
        "rad/s",
        210.0,
        low=0.0,
        high=2000.0,
        description="at which the clutch begins to close when the car stands",
        source="assumed: 2000 rpm",
    )
    clutch_duration: float = parameter(
        "s", 0.4, low=0.01, high=5.0, description="clutch from open to closed, at the start and after a shift"
    )

    @model_validator(mode="after")
    def _lists(self) -> "Accelerate":
        speeds = self.shift_up_speeds
        for number, (lower, higher) in enumerate(pairwise(speeds), 1):
            if higher <= lower:
                raise FieldError("not rising", at=("shift_up_speeds", number), allowed=f"more than {lower:g} m/s")
        for number, pedal in enumerate(self.accelerator_by_gear):
            if not 0.0 <= pedal <= 1.0:
                raise FieldError("out of range", at=("accelerator_by_gear", number), allowed="0 to 1")
        return self


class HoldSpeed(FileModel):
    """Hold a speed with the accelerator; the brake is not used."""

    speed: float = parameter("m/s", low=0.0, high=120.0, description="to hold")
    gears: Gears = Field(
        default="auto", description="auto takes the gear that suits the speed, a number stays in that gear"
    )
    proportional_gain: float = parameter("s/m", 0.3, low=0.0, high=10.0, description="pedal over speed error")
    integral_gain: float = parameter("1/m", 0.1, low=0.0, high=10.0, description="pedal over way error")


class _Brake(FileModel):
    shape: Literal["linear", "human"] = Field(
        default="linear", description="human: a half cosine whose steepest slope is the ramp"
    )
    clutch: Literal["open", "closed"] = Field(
        "open", description="closed keeps the engine engaged until it would be stalled"
    )


class PedalForceBrake(_Brake):
    """Brake with a pedal force; the booster makes the pressure of it."""

    pedal_force: float = parameter("N", low=0.0, high=1500.0, description="at the end of the ramp")
    ramp: float = parameter("N/s", 4000.0, low=1.0, high=1e6, description="of the force", source=_HUMAN)


class MasterPressureBrake(_Brake):
    """Brake with a pressure in the master cylinder; the pedal force is what the booster would need for it."""

    master_pressure: float = parameter("Pa", low=0.0, high=3e7, description="at the end of the ramp")
    ramp: float = parameter(
        "Pa/s", 4e7, low=1e4, high=1e10, description="of the pressure", source="friction document 7, item 9"
    )


def _kind_of_brake(value: Any) -> str:
    names = value if isinstance(value, Mapping) else vars(value) if isinstance(value, FileModel) else ()
    return "MasterPressureBrake" if "master_pressure" in names else "PedalForceBrake"


Brake = Annotated[
    Annotated[PedalForceBrake, Tag("PedalForceBrake")] | Annotated[MasterPressureBrake, Tag("MasterPressureBrake")],
    Discriminator(_kind_of_brake),
]


class SteeringTable(FileModel):
    """Steering-wheel angle over the time since the step began, linear between the points, held after the last."""

    time: list[float] = Field(min_length=2, description="rising times", json_schema_extra={"unit": "s"})
    angle: list[float] = Field(min_length=2, description="angles at these times", json_schema_extra={"unit": "rad"})

    @model_validator(mode="after")
    def _pairs(self) -> "SteeringTable":
        if len(self.time) != len(self.angle):
            raise FieldError("as many angles as times", at=("angle",), allowed=f"{len(self.time)} values")
        for number, (earlier, later) in enumerate(pairwise(self.time), 1):
            if later <= earlier:
                raise FieldError("not rising", at=("time", number), allowed=f"more than {earlier:g} s")
        return self


class SteeringSine(FileModel):
    """Sine that starts at the angle of the step's begin; zero amplitude after the periods."""

    amplitude: float = parameter("rad", low=-12.0, high=12.0, description="positive starts to the left")
    frequency: float = parameter("Hz", low=0.01, high=10.0, description="")
    periods: float = parameter("1", 1.0, low=0.5, high=1000.0, description="number of periods")


class SteeringSineWithDwell(FileModel):
    """One sine period with a pause at its second peak (FMVSS 126, UN R140)."""

    amplitude: float = parameter("rad", low=-12.0, high=12.0, description="positive starts to the left")
    frequency: float = parameter("Hz", 0.7, low=0.01, high=10.0, description="", source="FMVSS 126: 0.7 Hz")
    dwell: float = parameter("s", 0.5, low=0.0, high=5.0, description="pause", source="FMVSS 126: 500 ms")


class SteeringStep(FileModel):
    """Quick change to an angle that is then held; also a slow ramp, with a small rate."""

    angle: float = parameter("rad", low=-12.0, high=12.0, description="at the end, positive to the left")
    rate: float = parameter("rad/s", 8.73, low=1e-3, high=100.0, description="", source="assumed: 500 deg/s")


class SteeringProfile(FileModel):
    """Steering-wheel angle over time; exactly one of the fields."""

    table: SteeringTable | None = None
    sine: SteeringSine | None = None
    sine_with_dwell: SteeringSineWithDwell | None = None
    step: SteeringStep | None = None
    ramp: SteeringStep | None = None

    @model_validator(mode="after")
    def _one(self) -> "SteeringProfile":
        _exactly_one(self, ("table", "sine", "sine_with_dwell", "step", "ramp"), "a steering profile has one kind")
        return self


class PathPoints(FileModel):
    """A path as y over x in road axes: straight between the points, level before the first and after the last."""

    x: list[float] = Field(min_length=2, description="rising places along the road", json_schema_extra={"unit": "m"})
    y: list[float] = Field(
        min_length=2, description="places across the road, positive to the left", json_schema_extra={"unit": "m"}
    )

    @model_validator(mode="after")
    def _pairs(self) -> "PathPoints":
        if len(self.x) != len(self.y):
            raise FieldError("as many y as x", at=("y",), allowed=f"{len(self.x)} values")
        for number, (earlier, later) in enumerate(pairwise(self.x), 1):
            if later <= earlier:
                raise FieldError("not rising", at=("x", number), allowed=f"more than {earlier:g} m")
        return self


class Steer(FileModel):
    """What the hands do; exactly one of angle, profile and follow."""

    angle: float | None = parameter("rad", None, low=-12.0, high=12.0, description="held, positive to the left")
    profile: SteeringProfile | None = None
    follow: Literal["straight", "circle", "path"] | None = Field(
        default=None,
        description="straight: the road's x axis at lateral_position; circle: from the car's place and course when the "
        "step begins; path: the points of path",
    )
    path: PathPoints | None = None
    radius: float | None = parameter("m", None, low=-1e4, high=1e4, description="of the circle, positive to the left")
    lateral_position: float = parameter("m", 0.0, low=-1e3, high=1e3, description="y of the straight to follow")
    preview: float = parameter("s", 1.0, low=0.1, high=5.0, description="how far ahead the driver aims", source=_HUMAN)
    reaction_delay: float = parameter(
        "s", 0.15, low=0.0, high=1.0, description="from seeing to steering", source=_HUMAN
    )
    countersteer: bool = Field(default=True, description="steer against a yaw rate that the path does not need")
    countersteer_gain: float = parameter(
        "s", 2.5, low=0.0, high=20.0, description="steering-wheel angle over excess yaw rate", source=_HUMAN
    )
    maximum_angle: float = parameter("rad", 9.42, low=0.01, high=20.0, description="", source="assumed: 1.5 turns")
    maximum_rate: float = parameter(
        "rad/s", 13.96, low=0.01, high=100.0, description="", source="assumed: 800 deg/s, a quick human"
    )

    @model_validator(mode="after")
    def _one(self) -> "Steer":
        _exactly_one(self, ("angle", "profile", "follow"), "the hands do one thing")
        if self.follow == "circle" and (self.radius is None or abs(self.radius) < 5.0):
            raise FieldError("a circle needs a radius", at=("radius",), allowed="at least 5 m, negative to the right")
        if self.follow != "circle" and self.radius is not None:
            raise FieldError("only a circle has a radius", at=("radius",), allowed="follow: circle beside it")
        if (self.follow == "path") != (self.path is not None):
            raise FieldError("follow: path and path go together", at=("path",), allowed="both or none of them")
        return self


PEDAL_ACTIONS = ("accelerate", "hold_speed", "release", "coast", "brake")


class Step(FileModel):
    """A phase of the manoeuvre."""

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", description="letters, digits and _, begins with a letter")
    accelerate: Accelerate | None = None
    hold_speed: HoldSpeed | None = None
    release: Literal[True] | None = Field(default=None, description="both pedals released, gear engaged")
    coast: Literal[True] | None = Field(default=None, description="both pedals released, clutch open")
    brake: Brake | None = None
    steer: Steer | None = None
    until: Condition | None = Field(default=None, description="ends the step; only the last step may be without")

    @model_validator(mode="after")
    def _feet(self) -> "Step":
        given = [name for name in PEDAL_ACTIONS if getattr(self, name) is not None]
        if len(given) > 1:
            raise FieldError("the feet do one thing", at=(given[1],), found=" and ".join(given), allowed="one of them")
        return self

    @property
    def pedal_action(self) -> str | None:
        """Field that says what the feet do, None if they go on as before."""
        return next((name for name in PEDAL_ACTIONS if getattr(self, name) is not None), None)


class ManoeuvreFile(FileModel):
    """A manoeuvre: its steps in order."""

    steps: list[Step] = Field(min_length=1)

    @model_validator(mode="after")
    def _steps(self) -> "ManoeuvreFile":
        errors = []
        first: dict[str, int] = {}
        for number, step in enumerate(self.steps):
            if step.name in first:
                found = f"{step.name!r}, as step {first[step.name] + 1}"
                errors.append(FieldError("two steps have the same name", at=("steps", number, "name"), found=found))
            first.setdefault(step.name, number)
            if step.until is None and number < len(self.steps) - 1:
                allowed = "a condition such as {signal: speed, below: 5 km/h}; only the last step may have none"
                errors.append(FieldError("the step never ends", at=("steps", number, "until"), allowed=allowed))
        if self.steps[0].pedal_action is None:
            allowed = ", ".join(PEDAL_ACTIONS)
            errors.append(FieldError("the first step says what the feet do", at=("steps", 0), allowed=allowed))
        if errors:
            raise FieldErrors(errors)
        return self

    @property
    def phase_names(self) -> tuple[str, ...]:
        """Names of the steps in order; ``manoeuvre_phase`` is an index into them."""
        return tuple(step.name for step in self.steps)

    def faults(self, units: Mapping[str, str]) -> list[FieldError]:
        """What in the steps' conditions does not fit a run with these signals (name → unit)."""
        return [
            FieldError(
                e.problem, at=("steps", number, "until", *e.at), found=e.found, allowed=e.allowed, nearest=e.nearest
            )
            for number, step in enumerate(self.steps)
            if step.until is not None
            for e in step.until.faults(units, self.phase_names)
        ]


def _exactly_one(model: FileModel, names: Sequence[str], problem: str) -> None:
    given = [name for name in names if getattr(model, name) is not None]
    if len(given) != 1:
        raise FieldError(problem, found=" and ".join(given) or "none of them", allowed=", ".join(names))
