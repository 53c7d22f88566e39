"""Section of a vehicle file that describes the suspension."""

from itertools import pairwise

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter

MOST_DAMPER_POINTS = 16
_ASSUMED = "assumed: usual for a passenger car"


def _neutral(unit: str, low: float, high: float, description: str) -> float:
    declared: float = parameter(unit, 0.0, low=low, high=high, neutral=0.0, description=description)
    return declared


class AxleSuspension(FileModel):
    """Springs, dampers, stops and geometry of an axle, per wheel and reduced to the wheel; compression is positive."""

    spring_rate: float = parameter("N/m", low=1e3, high=1e6, description="wheel rate of the spring")
    compression_damping: float = parameter(
        "N s/m", low=0.0, high=5e4, description="wheel rate of the damper, compressing"
    )
    rebound_damping: float = parameter("N s/m", low=0.0, high=5e4, description="wheel rate of the damper, extending")
    damper_speeds: list[float] = Field(
        default_factory=list,
        max_length=MOST_DAMPER_POINTS,
        description="speeds of the damper's curve, rising, extending negative; replaces both damping rates",
        json_schema_extra={"unit": "m/s"},
    )
    damper_forces: list[float] = Field(
        default_factory=list,
        max_length=MOST_DAMPER_POINTS,
        description="forces of the damper at these speeds, at the wheel",
        json_schema_extra={"unit": "N"},
    )
    damping_scale: float = parameter(
        "1", 1.0, low=0.0, high=5.0, neutral=1.0, description="multiplies the damper's force, a worn damper has less"
    )
    anti_roll_rate: float = parameter(
        "N/m", 0.0, low=0.0, high=1e6, description="force at a wheel per difference of travel of the axle's two wheels"
    )
    bump_stop_clearance: float = parameter(
        "m", 0.07, low=0.0, high=0.5, description="compression at which the bump stop touches", source=_ASSUMED
    )
    bump_stop_rate: float = _neutral("N/m", 0.0, 1e7, "rate of the bump stop, 0 for none")
    bump_stop_progression: float = _neutral("N/m^2", 0.0, 1e9, "rise of the bump stop's rate with its compression")
    rebound_stop_clearance: float = parameter(
        "m", 0.09, low=0.0, high=0.5, description="extension at which the rebound stop touches", source=_ASSUMED
    )
    rebound_stop_rate: float = _neutral("N/m", 0.0, 1e7, "rate of the rebound stop, 0 for none")
    roll_centre_height: float = _neutral("m", -0.5, 0.8, "height of the axle's roll centre over the road")
    brake_support_angle: float = _neutral(
        "rad", -0.7, 0.7, "side-view angle that supports braking: anti-dive of the front axle, anti-lift of the rear"
    )
    drive_support_angle: float = _neutral(
        "rad", -0.7, 0.7, "side-view angle that supports driving: anti-lift of the front axle, anti-squat of the rear"
    )
    camber: float = _neutral("rad", -0.3, 0.3, "inclination at rest, the wheel's top outwards positive")
    camber_gain: float = _neutral("rad/m", -5.0, 5.0, "change of the camber with compression")

    @model_validator(mode="after")
    def _damper_curve(self) -> "AxleSuspension":
        speeds, forces = self.damper_speeds, self.damper_forces
        if len(speeds) != len(forces) or len(speeds) == 1:
            raise FieldError(
                "a curve needs as many forces as speeds",
                at=("damper_forces",),
                found=f"{len(forces)} forces and {len(speeds)} speeds",
                allowed="2 or more of each, or none",
            )
        problem = damper_curve_problem(speeds, forces)
        if problem is not None:
            raise FieldError(problem[1], at=(problem[0],), allowed=problem[2])
        return self


def damper_curve_problem(speeds: list[float], forces: list[float]) -> tuple[str, str, str] | None:
    """What is wrong with a damper's curve: field, problem, what is allowed; None if nothing is."""
    if any(later <= earlier for earlier, later in pairwise(speeds)):
        return "damper_speeds", "speeds that do not rise", "strictly rising speeds"
    if any(
        speed * force < 0.0 or (speed == 0.0) != (force == 0.0) for speed, force in zip(speeds, forces, strict=True)
    ):
        return "damper_forces", "a damper that drives", "forces with the sign of their speeds, 0 N at 0 m/s only"
    if speeds and 0.0 not in speeds:
        return "damper_speeds", "a curve without its zero", "0 m/s among the speeds"
    return None


class AdaptiveDamping(FileModel):
    """Valves that change the dampers while the car drives."""

    mode: float = parameter(
        "1", 0.0, low=0.0, high=1.0, neutral=0.0, description="1 lets the dampers follow the skyhook law, 0 is passive"
    )
    skyhook_damping: float = parameter(
        "N s/m", 2500.0, low=0.0, high=5e4, description="between each corner of the body and the sky", source=_ASSUMED
    )
    soft_scale: float = parameter(
        "1", 0.5, low=0.0, high=1.0, description="least force over the passive one", source=_ASSUMED
    )
    firm_scale: float = parameter(
        "1", 2.0, low=1.0, high=10.0, description="largest force over the passive one", source=_ASSUMED
    )
    time_constant: float = parameter("s", 0.01, low=0.001, high=1.0, description="of the valves", source=_ASSUMED)


class Suspension(FileModel):
    """Suspension of both axles."""

    front: AxleSuspension
    rear: AxleSuspension
    adaptive: AdaptiveDamping = AdaptiveDamping()
