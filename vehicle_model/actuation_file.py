"""Sections of a vehicle file that describe brakes, hydraulic unit and driveline."""

from itertools import pairwise
from typing import Literal

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from vehicle_model.brakes_file import Brakes, Hydraulics

__all__ = ["Brakes", "Driveline", "Engine", "Hydraulics"]

_ASSUMED = "assumed: usual for a passenger car"


class Engine(FileModel):
    """Full-load torque curve and losses of the engine."""

    speed_points: list[float] = Field(
        min_length=2, description="speeds of the torque curve, rising", json_schema_extra={"unit": "rad/s"}
    )
    torque_points: list[float] = Field(
        min_length=2, description="full-load torque at these speeds", json_schema_extra={"unit": "N m"}
    )
    drag_torque: float = parameter(
        "N m", 40.0, low=0.0, high=1e3, description="with the accelerator released", source=_ASSUMED
    )
    idle_speed: float = parameter("rad/s", 84.0, low=10.0, high=500.0, description="", source="assumed: 800 rpm")
    maximum_speed: float = parameter(
        "rad/s", 680.0, low=100.0, high=2000.0, description="limiter", source="assumed: 6500 rpm"
    )
    limiter_band: float = parameter(
        "rad/s", 15.0, low=1.0, high=200.0, description="below the limiter's speed, in which it cuts the torque"
    )
    idle_gain: float = parameter(
        "N m s/rad", 5.0, low=0.0, high=100.0, description="torque of the idle control per missing speed"
    )
    inertia: float = parameter("kg m^2", 0.2, low=0.001, high=10.0, description="engine and flywheel", source=_ASSUMED)
    time_constant: float = parameter("s", 0.1, low=0.001, high=2.0, description="torque build-up", source=_ASSUMED)

    @model_validator(mode="after")
    def _curve(self) -> "Engine":
        speeds = self.speed_points
        if len(speeds) != len(self.torque_points):
            raise ValueError(
                f"torque_points: found {len(self.torque_points)} values, allowed: {len(speeds)} as speed_points"
            )
        if any(later <= earlier for earlier, later in pairwise(speeds)):
            raise ValueError("speed_points: found values that do not rise, allowed: strictly rising speeds")
        return self


class Driveline(FileModel):
    """Engine, gearbox and driven axles (open differentials)."""

    drive: Literal["front", "rear", "all"]
    front_share: float = parameter(
        "1", 0.4, low=0.0, high=1.0, description="share of the front axle, used with drive: all", source=_ASSUMED
    )
    gear_ratios: list[float] = Field(
        min_length=1, description="gearbox ratios, first gear first", json_schema_extra={"unit": "1"}
    )
    final_drive: float = parameter("1", low=0.5, high=20.0, description="ratio of the final drive")
    efficiency: float = parameter("1", 0.93, low=0.1, high=1.0, description="engine to wheel", source=_ASSUMED)
    clutch_torque: float = parameter(
        "N m", 600.0, low=1.0, high=1e4, description="capacity when closed", source=_ASSUMED
    )
    shaft_stiffness: float = parameter(
        "N m/rad", 1.2e4, low=100.0, high=1e6, description="all half shafts together", source=_ASSUMED
    )
    shaft_damping: float = parameter(
        "N m s/rad", 80.0, low=0.0, high=1e4, description="all half shafts together", source=_ASSUMED
    )
    engine: Engine

    @model_validator(mode="after")
    def _ratios(self) -> "Driveline":
        for number, ratio in enumerate(self.gear_ratios):
            if not 0.05 <= ratio <= 30.0:
                raise FieldError("out of range", at=("gear_ratios", number), allowed="0.05…30")
        return self

    def wheel_share(self) -> tuple[float, float, float, float]:
        """Share of each wheel in the drive torque and in the speed of the gearbox's output (open differentials)."""
        front = {"front": 1.0, "rear": 0.0, "all": self.front_share}[self.drive]
        return front / 2.0, front / 2.0, (1.0 - front) / 2.0, (1.0 - front) / 2.0
