"""Sections of a vehicle file that describe brakes, hydraulic unit and driveline."""

from itertools import pairwise
from typing import Literal

from pydantic import Field, model_validator

from signals.quantities import FileModel, parameter

_SPEC = "friction document 2.6.4 [DEF]"
_ASSUMED = "assumed: usual for a passenger car"


class AxleBrake(FileModel):
    """One brake of an axle: torque = 2 pressure x area x friction x radius (eq. 78)."""

    pad_area: float = parameter("m^2", low=1e-5, high=0.1, description="effective area of one pad")
    pad_friction: float = parameter("1", low=0.0, high=2.0, description="friction of pad on disc")
    effective_radius: float = parameter("m", low=0.01, high=1.0, description="radius at which the pads act")


class Brakes(FileModel):
    """Brakes and booster."""

    booster_gain: float = parameter(
        "Pa/N",
        3e4,
        low=0.0,
        high=1e6,
        description="master pressure over pedal force",
        source="assumed: 150 bar at 500 N",
    )
    hydraulic_delay: float = parameter(
        "s",
        0.005,
        low=0.0,
        high=0.12,
        description="delay of the brake of eq. 79",
        source="friction document 2.4.2 [DEF]",
    )
    first_order_time_constant: float = parameter(
        "s", 0.02, low=1e-4, high=1.0, description="of the brake of eq. 79", source="friction document 2.4.2 [DEF]"
    )
    front: AxleBrake
    rear: AxleBrake


def _from_zero(description: str, unit: str, high: float) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, high=high, neutral=0.0, description=description)
    return declared


def _stuck(valve: str) -> float:
    return _from_zero(f"{valve} valve fault: 0 none, 1 stuck open, 2 stuck closed", "1", 2.0)


def _dead_time(valve: str) -> float:
    return _from_zero(f"dead time of the {valve} valve", "s", 0.1)


class Hydraulics(FileModel):
    """The hydraulic control unit."""

    increase_time_constant: float = parameter(
        "s", 0.05, low=1e-4, high=2.0, description="pressure build-up", source=_SPEC
    )
    hold_time_constant: float = parameter(
        "s", 0.05, low=1e-4, high=2.0, description="settling after the valves close", source=_SPEC
    )
    decrease_time_constant: float = parameter(
        "s", 0.03, low=1e-4, high=2.0, description="pressure release", source=_SPEC
    )
    pressure_change_threshold: float = parameter(
        "Pa", 1e5, low=0.0, high=5e6, description="driver's change that re-arms a segment", source=_SPEC
    )
    accumulator_pressure: float = parameter(
        "Pa",
        5e5,
        low=0.0,
        high=2e6,
        description="pressure of a full accumulator",
        source="friction document 2.6.1 [DEF]",
    )
    accumulator_volume: float = parameter(
        "m^3", 4e-6, low=1e-7, high=1e-4, description="capacity per circuit", source="assumed: usual 2 to 4 cm^3"
    )
    pump_flow: float = parameter(
        "m^3/s", 6e-6, low=0.0, high=1e-3, description="return pump, per circuit", source="assumed"
    )
    pump_pressure: float = parameter(
        "Pa", 1.5e7, low=0.0, high=4e7, description="pressure of active build-up", source="assumed"
    )
    active_build_up: float = _from_zero("1 while an ESP logic builds pressure by pump", "1", 1.0)
    caliper_stiffness_front: float = parameter(
        "Pa/m^3",
        7e12,
        low=1e11,
        high=1e15,
        description="pressure per volume",
        source="assumed: 0.014 cm^3/bar above the knee",
    )
    caliper_stiffness_rear: float = parameter(
        "Pa/m^3",
        1.6e13,
        low=1e11,
        high=1e15,
        description="pressure per volume",
        source="assumed: 0.006 cm^3/bar above the knee",
    )
    rearm_near_target: float = _from_zero("1 re-arms build-up each step near the target", "1", 1.0)
    literal_event: float = _from_zero("1 uses the printed AND form of the event", "1", 1.0)
    pump_failure: float = _from_zero("1 stops the return pump", "1", 1.0)
    inlet_stuck_fl: float = _stuck("inlet")
    inlet_stuck_fr: float = _stuck("inlet")
    inlet_stuck_rl: float = _stuck("inlet")
    inlet_stuck_rr: float = _stuck("inlet")
    outlet_stuck_fl: float = _stuck("outlet")
    outlet_stuck_fr: float = _stuck("outlet")
    outlet_stuck_rl: float = _stuck("outlet")
    outlet_stuck_rr: float = _stuck("outlet")
    inlet_delay_fl: float = _dead_time("inlet")
    inlet_delay_fr: float = _dead_time("inlet")
    inlet_delay_rl: float = _dead_time("inlet")
    inlet_delay_rr: float = _dead_time("inlet")
    outlet_delay_fl: float = _dead_time("outlet")
    outlet_delay_fr: float = _dead_time("outlet")
    outlet_delay_rl: float = _dead_time("outlet")
    outlet_delay_rr: float = _dead_time("outlet")


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
