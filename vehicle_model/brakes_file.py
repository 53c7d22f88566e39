"""Sections of a vehicle file that describe brakes and hydraulic unit.

Their models are told in docs/models/hydraulics.md and docs/models/brakes.md. ``hydraulics.parameters`` has the same
names, units, defaults and ranges; a test compares the two tables.
"""

from signals.quantities import FileModel, parameter

_SPEC = "friction document 2.6.4 [DEF]"
_ASSUMED = "assumed: usual for a passenger car"


def _from_zero(description: str, unit: str, high: float) -> float:
    declared: float = parameter(unit, 0.0, low=0.0, high=high, neutral=0.0, description=description)
    return declared


def _heat_capacity(default: float) -> float:
    declared: float = parameter(
        "J/degC", default, low=100.0, high=1e5, description="of disc or drum", source="assumed: mass times 500 J/(kg K)"
    )
    return declared


class AxleBrake(FileModel):
    """One brake of an axle: torque = 2 pressure x area x friction x radius (eq. 78), friction by temperature."""

    pad_area: float = parameter("m^2", low=1e-5, high=0.1, description="effective area of one pad")
    pad_friction: float = parameter("1", low=0.0, high=2.0, description="friction of pad on disc")
    effective_radius: float = parameter("m", low=0.01, high=1.0, description="radius at which the pads act")
    fade: float = _from_zero("friction lost per degree above fade_temperature", "1/degC", 0.02)
    fade_temperature: float = parameter(
        "degC", 300.0, low=0.0, high=1000.0, description="disc temperature at which fade begins", source=_ASSUMED
    )
    fade_floor: float = parameter(
        "1", 0.2, low=0.0, high=1.0, description="share of the friction that fade leaves at least", source=_ASSUMED
    )
    disc_heat_capacity: float = _heat_capacity(4000.0)
    disc_heat_share: float = parameter(
        "1", 0.9, low=0.0, high=1.0, description="of the heat that goes into the disc, not the pads", source=_ASSUMED
    )
    disc_cooling: float = parameter(
        "W/degC", 8.0, low=0.0, high=1e3, description="heat to the air at rest", source=_ASSUMED
    )
    disc_cooling_per_speed: float = parameter(
        "W s/rad/degC",
        0.5,
        low=0.0,
        high=100.0,
        description="more heat to the air per speed of the wheel",
        source=_ASSUMED,
    )
    disc_start_temperature: float = parameter(
        "degC", 20.0, low=-40.0, high=1000.0, description="at the start of the run", source=_ASSUMED
    )
    pad_speed_exponent: float = parameter(
        "1", 0.0, low=-0.5, high=0.5, neutral=0.0, description="friction over rubbing speed, power of speed / 10 m/s"
    )
    pad_pressure_exponent: float = parameter(
        "1", 1.0, low=0.5, high=1.5, neutral=1.0, description="torque over pressure, power of pressure / 30 bar"
    )
    threshold_pressure: float = _from_zero("pressure that only moves the pads to the disc", "Pa", 1e6)


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
    booster_knee_pressure: float = parameter(
        "Pa", 8e6, low=0.0, high=4e7, description="master pressure up to which the booster helps fully", source=_ASSUMED
    )
    booster_slope_loss: float = _from_zero("share of the booster's gain lost above its knee", "1", 1.0)
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
    ambient_temperature: float = parameter(
        "degC", 20.0, low=-60.0, high=80.0, description="of the air at the discs", source=_ASSUMED
    )
    caliper_time_constant: float = _from_zero("lag of the torque behind the pressure at the pads", "s", 0.2)
    pad_glazing_fl: float = _from_zero("share of the pads' friction lost to a glazed surface", "1", 1.0)
    pad_glazing_fr: float = _from_zero("share of the pads' friction lost to a glazed surface", "1", 1.0)
    pad_glazing_rl: float = _from_zero("share of the pads' friction lost to a glazed surface", "1", 1.0)
    pad_glazing_rr: float = _from_zero("share of the pads' friction lost to a glazed surface", "1", 1.0)
    piston_friction_fl: float = _from_zero(
        "pressure that the caliper's piston needs to move; 500 bar is a seized piston", "Pa", 5e7
    )
    piston_friction_fr: float = _from_zero(
        "pressure that the caliper's piston needs to move; 500 bar is a seized piston", "Pa", 5e7
    )
    piston_friction_rl: float = _from_zero(
        "pressure that the caliper's piston needs to move; 500 bar is a seized piston", "Pa", 5e7
    )
    piston_friction_rr: float = _from_zero(
        "pressure that the caliper's piston needs to move; 500 bar is a seized piston", "Pa", 5e7
    )
    drag_torque_fl: float = _from_zero("torque without pressure, pads that do not come off the disc", "N m", 1e3)
    drag_torque_fr: float = _from_zero("torque without pressure, pads that do not come off the disc", "N m", 1e3)
    drag_torque_rl: float = _from_zero("torque without pressure, pads that do not come off the disc", "N m", 1e3)
    drag_torque_rr: float = _from_zero("torque without pressure, pads that do not come off the disc", "N m", 1e3)
    thickness_variation_fl: float = _from_zero(
        "amplitude of the torque over a turn of the disc, over the torque", "1", 0.5
    )
    thickness_variation_fr: float = _from_zero(
        "amplitude of the torque over a turn of the disc, over the torque", "1", 0.5
    )
    thickness_variation_rl: float = _from_zero(
        "amplitude of the torque over a turn of the disc, over the torque", "1", 0.5
    )
    thickness_variation_rr: float = _from_zero(
        "amplitude of the torque over a turn of the disc, over the torque", "1", 0.5
    )


def _stuck(valve: str) -> float:
    return _from_zero(f"{valve} valve fault: 0 none, 1 stuck open, 2 stuck closed", "1", 2.0)


def _dead_time(valve: str) -> float:
    return _from_zero(f"dead time of the {valve} valve", "s", 0.1)


def _conductance(valve: str) -> float:
    declared: float = parameter(
        "1", 1.0, low=0.01, high=10.0, neutral=1.0, description=f"flow through the {valve} valve over its healthy one"
    )
    return declared


def _leak(way: str) -> float:
    return _from_zero(f"flow {way} per pressure; 1e-13 is 1 cm^3/s at 100 bar", "m^3/s/Pa", 1e-11)


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
    pump_back_pressure: float = _from_zero(
        "share of an accumulator's pressure that stays behind the outlet valves while the pump runs", "1", 1.0
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
    flow_through: float = _from_zero("1 lets fluid through two open valves, 0 holds the pressure", "1", 1.0)
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
    inlet_conductance_fl: float = _conductance("inlet")
    inlet_conductance_fr: float = _conductance("inlet")
    inlet_conductance_rl: float = _conductance("inlet")
    inlet_conductance_rr: float = _conductance("inlet")
    outlet_conductance_fl: float = _conductance("outlet")
    outlet_conductance_fr: float = _conductance("outlet")
    outlet_conductance_rl: float = _conductance("outlet")
    outlet_conductance_rr: float = _conductance("outlet")
    inlet_leak_fl: float = _leak("past the closed inlet valve")
    inlet_leak_fr: float = _leak("past the closed inlet valve")
    inlet_leak_rl: float = _leak("past the closed inlet valve")
    inlet_leak_rr: float = _leak("past the closed inlet valve")
    outlet_leak_fl: float = _leak("past the closed outlet valve")
    outlet_leak_fr: float = _leak("past the closed outlet valve")
    outlet_leak_rl: float = _leak("past the closed outlet valve")
    outlet_leak_rr: float = _leak("past the closed outlet valve")
    brake_leak_fl: float = _leak("out of the wheel brake")
    brake_leak_fr: float = _leak("out of the wheel brake")
    brake_leak_rl: float = _leak("out of the wheel brake")
    brake_leak_rr: float = _leak("out of the wheel brake")
    air_volume_fl: float = _from_zero(
        "air in the wheel brake, as volume at the pressure of the atmosphere", "m^3", 1e-5
    )
    air_volume_fr: float = _from_zero(
        "air in the wheel brake, as volume at the pressure of the atmosphere", "m^3", 1e-5
    )
    air_volume_rl: float = _from_zero(
        "air in the wheel brake, as volume at the pressure of the atmosphere", "m^3", 1e-5
    )
    air_volume_rr: float = _from_zero(
        "air in the wheel brake, as volume at the pressure of the atmosphere", "m^3", 1e-5
    )
    pump_rate: float = parameter(
        "1", 1.0, low=0.0, high=2.0, neutral=1.0, description="flow of the return pump over its healthy one, 0 is dead"
    )
    circuit_split: float = _from_zero("0 diagonal circuits, front left with rear right; 1 front and rear", "1", 1.0)
    first_circuit_failure: float = _from_zero(
        "share of the line pressure lost in the front left wheel's circuit", "1", 1.0
    )
    second_circuit_failure: float = _from_zero("share of the line pressure lost in the other circuit", "1", 1.0)
    first_accumulator_blocked: float = _from_zero(
        "share of the first circuit's accumulator that takes no fluid", "1", 1.0
    )
    second_accumulator_blocked: float = _from_zero(
        "share of the other circuit's accumulator that takes no fluid", "1", 1.0
    )
    fluid_temperature: float = parameter(
        "degC", 20.0, low=-40.0, high=150.0, neutral=20.0, description="of the brake fluid in lines and valves"
    )
    laminar_share: float = parameter(
        "1",
        0.1,
        low=0.0,
        high=1.0,
        description="of the valves' resistance, which grows with viscosity",
        source=_ASSUMED,
    )
