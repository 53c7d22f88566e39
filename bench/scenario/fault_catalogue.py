"""Every fault of hydraulics, brakes and sensors that a scenario can name, with the parameter that switches it on.

A fault is a parameter with a neutral value: put it into ``overrides`` (or, for sensors, into ``sensors``) of a
scenario, or set it while the run goes on with a stimulus. docs/faults.md is generated from this table.
"""

from dataclasses import dataclass

from signals.wheels import WHEELS


@dataclass(frozen=True)
class PhysicalFault:
    """One fault.

    Attributes
    ----------
    name
        Short name; where docs/effects.md has the effect, the same.
    group
        Valves, pump, circuits and fluid; brakes; wheel-speed sensors; other sensors.
    path
        Dotted path of the parameter; ``{wheel}`` stands for fl, fr, rl, rr, ``{axle}`` for front, rear.
    example
        A value that shows the fault, SI.
    effect
        What happens.
    scenario
        Shipped scenario that has it, or empty.
    """

    name: str
    group: str
    path: str
    example: float
    effect: str
    scenario: str = ""

    def paths(self) -> tuple[str, ...]:
        """Paths of all wheels or axles."""
        if "{wheel}" in self.path:
            return tuple(self.path.format(wheel=wheel) for wheel in WHEELS)
        if "{axle}" in self.path:
            return tuple(self.path.format(axle=axle) for axle in ("front", "rear"))
        return (self.path,)

    @property
    def example_path(self) -> str:
        """The path that the example stands for."""
        return self.paths()[0]


_H, _B, _W, _S = "valves, pump, circuits, fluid", "brakes", "wheel-speed sensors", "other sensors"
# channel: an error that shows, in its SI unit
_ANALOGUE = {
    "longitudinal_acceleration": 0.5,
    "lateral_acceleration": 0.5,
    "vertical_acceleration": 0.5,
    "yaw_rate": 0.05,
    "roll_rate": 0.05,
    "pitch_rate": 0.05,
    "master_pressure": 5e5,
    "brake_pressure": 5e5,
    "pedal_force": 20.0,
    "steering_wheel_angle": 0.1,
}

FAULTS: tuple[PhysicalFault, ...] = (
    PhysicalFault(
        "inlet_valve_stuck_open", _H, "hydraulics.inlet_stuck_{wheel}", 1.0,
        "1: never closes; hold and release become invalid combinations", "faults/inlet_stuck_open",
    ),
    PhysicalFault(
        "inlet_valve_stuck_closed", _H, "hydraulics.inlet_stuck_{wheel}", 2.0,
        "2: never opens; the wheel does not brake",
    ),
    PhysicalFault(
        "outlet_valve_stuck_open", _H, "hydraulics.outlet_stuck_{wheel}", 1.0,
        "1: never closes; invalid while the inlet is open, release while it is closed",
    ),
    PhysicalFault(
        "outlet_valve_stuck_closed", _H, "hydraulics.outlet_stuck_{wheel}", 2.0,
        "2: never opens; nothing is released", "faults/outlet_stuck_closed",
    ),
    PhysicalFault("inlet_valve_delay", _H, "hydraulics.inlet_delay_{wheel}", 0.03, "slow: acts after a dead time"),
    PhysicalFault("outlet_valve_delay", _H, "hydraulics.outlet_delay_{wheel}", 0.03, "slow: acts after a dead time"),
    PhysicalFault(
        "inlet_valve_conductance", _H, "hydraulics.inlet_conductance_{wheel}", 0.3, "clogged: pressure builds slowly",
    ),
    PhysicalFault(
        "outlet_valve_conductance", _H, "hydraulics.outlet_conductance_{wheel}", 0.3, "clogged: pressure falls slowly",
    ),
    PhysicalFault(
        "inlet_valve_leak", _H, "hydraulics.inlet_leak_{wheel}", 2e-13, "pressure rises behind the closed valve",
    ),
    PhysicalFault(
        "outlet_valve_leak", _H, "hydraulics.outlet_leak_{wheel}", 2e-13, "held pressure sinks into the accumulator",
    ),
    PhysicalFault("hydraulic_leak", _H, "hydraulics.brake_leak_{wheel}", 1e-12, "fluid leaves the wheel brake"),
    PhysicalFault(
        "pump_rate", _H, "hydraulics.pump_rate", 0.2, "weak pump, 0 dead: accumulators fill", "faults/pump_dead",
    ),
    PhysicalFault(
        "pump_back_pressure",
        _H,
        "hydraulics.pump_back_pressure",
        0.8,
        "the running pump leaves this share of an accumulator's pressure behind the outlets",
    ),
    PhysicalFault("pump_failure", _H, "hydraulics.pump_failure", 1.0, "1: the pump does not run"),
    PhysicalFault(
        "circuit_failure", _H, "hydraulics.first_circuit_failure", 1.0,
        "front left's circuit loses its pressure (`hydraulics.circuit_split`: 0 diagonal, 1 front and rear)",
        "faults/circuit_failure_diagonal",
    ),
    PhysicalFault("circuit_failure_second", _H, "hydraulics.second_circuit_failure", 1.0, "the other circuit"),
    PhysicalFault(
        "caliper_air", _H, "hydraulics.air_volume_{wheel}", 2e-6, "gas is soft: late build-up",
        "faults/air_in_front_left",
    ),
    PhysicalFault(
        "fluid_viscosity", _H, "hydraulics.fluid_temperature", -30.0, "cold fluid: slow build-up and release",
        "faults/cold_brake_fluid",
    ),
    PhysicalFault(
        "accumulator_blocked", _H, "hydraulics.first_accumulator_blocked", 1.0, "takes no fluid: nothing is released",
    ),
    PhysicalFault(
        "accumulator_blocked_second", _H, "hydraulics.second_accumulator_blocked", 1.0, "the other circuit's",
    ),
    PhysicalFault(
        "brake_pad_fade", _B, "brakes.{axle}.fade", 2e-3,
        "friction falls by this share per degree above `fade_temperature` of the disc", "faults/brake_fade",
    ),
    PhysicalFault("wheel_brake_weak", _B, "brakes.pad_glazing_{wheel}", 0.5, "glazed pad", "faults/glazed_pad"),
    PhysicalFault(
        "brake_hysteresis", _B, "brakes.piston_friction_{wheel}", 4e5,
        "the piston sticks: torque lags pressure both ways; 500 bar is a seized piston", "faults/seized_piston",
    ),
    PhysicalFault("brake_drag_torque", _B, "brakes.drag_torque_{wheel}", 50.0, "pads that do not come off the disc"),
    PhysicalFault(
        "disc_thickness_variation", _B, "brakes.thickness_variation_{wheel}", 0.1, "torque varies once per turn",
    ),
    PhysicalFault("caliper_lag", _B, "brakes.caliper_time_constant", 0.05, "torque comes later than its pressure"),
    PhysicalFault(
        "booster_saturation", _B, "brakes.booster_slope_loss", 0.5,
        "share of its help that the booster loses above `booster_knee_pressure`",
    ),
    PhysicalFault("brake_pad_speed", _B, "brakes.{axle}.pad_speed_exponent", -0.2, "friction over rubbing speed"),
    PhysicalFault("brake_pad_pressure", _B, "brakes.{axle}.pad_pressure_exponent", 0.9, "torque bends over pressure"),
    PhysicalFault("brake_threshold", _B, "brakes.{axle}.threshold_pressure", 2e5, "pressure that only moves the pads"),
    PhysicalFault(
        "missing_tooth", _W, "sensors.wheel_speed.missing_teeth_{wheel}", 2.0, "the speed dips once per turn",
        "faults/missing_tooth",
    ),
    PhysicalFault(
        "air_gap", _W, "sensors.wheel_speed.air_gap_{wheel}", 4e-3,
        "no edges below a speed that grows exponentially with the gap", "faults/air_gap",
    ),
    PhysicalFault(
        "channel_swap", _W, "sensors.wheel_speed.connected_{wheel}", 3.0, "another wheel's sensor is plugged in",
        "faults/swapped_wheels",
    ),
    PhysicalFault("wheel_speed_scale", _W, "sensors.wheel_speed.scale_{wheel}", 0.9, "ring with other teeth"),
    PhysicalFault("wheel_speed_stuck", _W, "sensors.wheel_speed.stuck_{wheel}", 1.0, "keeps its last value"),
    PhysicalFault(
        "wheel_speed_contact", _W, "sensors.wheel_speed.dropout_rate_{wheel}", 5.0,
        "loose plug: edges are lost for `dropout_duration`", "faults/loose_contact",
    ),
    PhysicalFault(
        "tone_ring_error", _W, "sensors.wheel_speed.eccentricity", 0.02, "speed varies once per turn, all rings",
    ),
    *(
        PhysicalFault(f"{kind}_of_{name}", _S, f"sensors.{name}.{field}", value, effect, scenario)
        for name, error in _ANALOGUE.items()
        for kind, field, value, effect, scenario in (
            ("offset", "offset", error, "constant error", ""),
            ("scale", "scale", 0.8, "reports too little or too much", ""),
            (
                "drift", "drift", error, "error that grows from when it is set",
                "faults/pressure_sensor_drift" if name == "master_pressure" else "",
            ),
            ("stuck", "stuck", 1.0, "keeps its last value", ""),
            ("contact", "dropout_rate", 5.0, "reports 0 for `dropout_duration`", ""),
            ("delay", "delay", 0.03, "dead time", ""),
        )
    ),
    *(
        PhysicalFault(f"{kind}_of_one_brake_pressure", _S, f"sensors.brake_pressure.{{wheel}}.{field}", value, effect)
        for kind, field, value, effect in (
            ("offset", "offset", 5e5, "of one wheel's sensor"),
            ("scale", "scale", 0.8, "of one wheel's sensor"),
            ("drift", "drift", 1e5, "of one wheel's sensor"),
            ("stuck", "stuck", 1.0, "of one wheel's sensor"),
            ("contact", "dropout_rate", 5.0, "of one wheel's sensor"),
        )
    ),
    PhysicalFault(
        "inertial_mounting_yaw", _S, "sensors.inertial.mounting_yaw", 0.14,
        "unit mounted askew: braking shows as lateral acceleration", "faults/inertial_unit_askew",
    ),
    PhysicalFault("inertial_mounting_pitch", _S, "sensors.inertial.mounting_pitch", 0.05, "gravity shows along x"),
    PhysicalFault("inertial_mounting_roll", _S, "sensors.inertial.mounting_roll", 0.05, "gravity shows along y"),
)  # fmt: skip


def faults_page() -> str:
    """docs/faults.md: a table per group."""
    from vehicle_model.vehicle_file import load_vehicle, parameter_table

    table = {info.path: info for info in parameter_table(load_vehicle("ekf_car"))}
    lines = [
        "# Faults of hydraulics, brakes and sensors",
        "",
        "Made by `python docs/generate.py` from `bench/scenario/fault_catalogue.py`. Each is a parameter whose neutral",
        "value leaves every result bit for bit as it is. Set it for a whole run in `overrides` of a scenario (faults",
        "of sensors also in `sensors`) or with `--set PATH=VALUE`, or while the run goes on with a stimulus:",
        "",
        "```yaml",
        "overrides: {hydraulics.inlet_stuck_fl: 1, brakes.front.fade: 0.0015}",
        "sensors: {wheel_speed: {missing_teeth_fl: 1}}",
        "stimuli:",
        "  - {target: brakes.piston_friction_fl, when: {time: 3 s}, step: 500 bar}",
        "```",
        "",
        "`{wheel}` is fl, fr, rl or rr, `{axle}` is front or rear. Models: [hydraulics](models/hydraulics.md),",
        "[brakes](models/brakes.md), [sensors](models/sensors.md). Faults of frames and of the bus are those of the",
        "injector. Physical effects are tested in `tests/hydraulics` and `tests/vehicle_model/test_sensor_faults.py`.",
    ]
    for group in dict.fromkeys(fault.group for fault in FAULTS):
        lines += ["", f"## {group[0].upper()}{group[1:]}", ""]
        lines += [
            "| Fault | Parameter | Neutral | Example | Unit | Effect | Scenario |",
            "|---|---|---|---|---|---|---|",
        ]
        for fault in (fault for fault in FAULTS if fault.group == group):
            info = table[fault.example_path]
            neutral = "its own" if "connected" in fault.path else f"{info.neutral:g}"
            shown = f"`{fault.scenario}`" if fault.scenario else ""
            values = f"{neutral} | {fault.example:g} | {info.unit}"
            lines.append(f"| {fault.name} | `{fault.path}` | {values} | {fault.effect} | {shown} |")
    return "\n".join(lines) + "\n"
