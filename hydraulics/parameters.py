"""Parameters of the hydraulic unit and the wheel brakes: dotted path, unit, default, range.

``vehicle_model.brakes_file`` declares the same for vehicle files.
"""

from dataclasses import dataclass

from signals.wheels import WHEELS


@dataclass(frozen=True)
class Parameter:
    """One parameter of the unit.

    Attributes
    ----------
    path, unit
        Dotted path as in a vehicle file, SI unit.
    default
        Value when the vehicle file has none; None where the file has to give it.
    low, high
        Closed range of allowed values.
    description, source
        One line, and where the default comes from.
    """

    path: str
    unit: str
    default: float | None
    low: float
    high: float
    description: str
    source: str


def _hydraulics(name: str, unit: str, default: float, low: float, high: float, text: str, source: str) -> Parameter:
    return Parameter(f"hydraulics.{name}", unit, default, low, high, text, source)


def _per_wheel(
    name: str, unit: str, high: float, text: str, *, section: str = "hydraulics", low: float = 0.0, neutral: float = 0.0
) -> list[Parameter]:
    return [Parameter(f"{section}.{name}_{w}", unit, neutral, low, high, f"{text}, {w}", "neutral") for w in WHEELS]


def _brake(axle: str) -> list[Parameter]:
    def row(name: str, unit: str, default: float | None, low: float, high: float, text: str, source: str) -> Parameter:
        return Parameter(f"brakes.{axle}.{name}", unit, default, low, high, text, source)

    start = "disc temperature at which fade begins"
    return [
        row("pad_area", "m^2", None, 1e-5, 0.1, "effective area of one pad", "vehicle file"),
        row("pad_friction", "1", None, 0.0, 2.0, "friction of pad on disc", "vehicle file"),
        row("effective_radius", "m", None, 0.01, 1.0, "radius at which the pads act", "vehicle file"),
        row("fade", "1/degC", 0.0, 0.0, 0.02, "friction lost per degree above fade_temperature", "neutral"),
        row("fade_temperature", "degC", 300.0, 0.0, 1000.0, start, _USUAL),
        row("fade_floor", "1", 0.2, 0.0, 1.0, "share of the friction that fade leaves at least", _USUAL),
        row("disc_heat_capacity", "J/degC", 4000.0, 100.0, 1e5, "of disc or drum", _USUAL),
        row("disc_heat_share", "1", 0.9, 0.0, 1.0, "of the heat that goes into the disc", _USUAL),
        row("disc_cooling", "W/degC", 8.0, 0.0, 1e3, "heat to the air at rest", _USUAL),
        row("disc_cooling_per_speed", "W s/rad/degC", 0.5, 0.0, 100.0, "more heat per speed of the wheel", _USUAL),
        row("disc_start_temperature", "degC", 20.0, -40.0, 1000.0, "at the start of the run", _USUAL),
        row("pad_speed_exponent", "1", 0.0, -0.5, 0.5, "power of rubbing speed / 10 m/s", "neutral"),
        row("pad_pressure_exponent", "1", 1.0, 0.5, 1.5, "power of pressure / 30 bar", "neutral"),
        row("threshold_pressure", "Pa", 0.0, 0.0, 1e6, "pressure that only moves the pads", "neutral"),
    ]


_USUAL = "assumed: usual for a passenger car"
_SPEC = "friction document 2.6.4"
_STUCK = "valve fault: 0 none, 1 stuck open, 2 stuck closed"

PARAMETERS: tuple[Parameter, ...] = (
    *_brake("front"),
    *_brake("rear"),
    Parameter(
        "brakes.hydraulic_delay", "s", 0.005, 0.0, 0.12, "delay of the brake of eq. 79", "friction document 2.4.2"
    ),
    Parameter(
        "brakes.first_order_time_constant",
        "s",
        0.02,
        1e-4,
        1.0,
        "time constant of the brake of eq. 79",
        "friction document 2.4.2",
    ),
    _hydraulics("increase_time_constant", "s", 0.05, 1e-4, 2.0, "pressure build-up", _SPEC),
    _hydraulics("hold_time_constant", "s", 0.05, 1e-4, 2.0, "settling after the valves close", _SPEC),
    _hydraulics("decrease_time_constant", "s", 0.03, 1e-4, 2.0, "pressure release", _SPEC),
    _hydraulics("pressure_change_threshold", "Pa", 1e5, 0.0, 5e6, "driver's change that re-arms a segment", _SPEC),
    _hydraulics(
        "accumulator_pressure", "Pa", 5e5, 0.0, 2e6, "pressure of a full low-pressure accumulator", "document 2.6.1"
    ),
    _hydraulics("accumulator_volume", "m^3", 4e-6, 1e-7, 1e-4, "capacity per circuit", "assumed: usual 2 to 4 cm^3"),
    _hydraulics("pump_back_pressure", "1", 0.0, 0.0, 1.0, "accumulators' share left by a running pump", "neutral"),
    _hydraulics("pump_flow", "m^3/s", 6e-6, 0.0, 1e-3, "return pump, per circuit", "assumed"),
    _hydraulics("pump_pressure", "Pa", 1.5e7, 0.0, 4e7, "pressure of active build-up", "assumed"),
    _hydraulics("active_build_up", "1", 0.0, 0.0, 1.0, "1 while an ESP logic builds pressure by pump", "neutral"),
    _hydraulics(
        "caliper_stiffness_front",
        "Pa/m^3",
        7e12,
        1e11,
        1e15,
        "pressure per volume",
        "assumed: 0.014 cm^3/bar above the knee",
    ),
    _hydraulics(
        "caliper_stiffness_rear",
        "Pa/m^3",
        1.6e13,
        1e11,
        1e15,
        "pressure per volume",
        "assumed: 0.006 cm^3/bar above the knee",
    ),
    _hydraulics("rearm_near_target", "1", 0.0, 0.0, 1.0, "1 re-arms build-up each step near the target", _SPEC),
    _hydraulics("literal_event", "1", 0.0, 0.0, 1.0, "1 uses the printed AND form of the event", "document 2.6.3"),
    _hydraulics("flow_through", "1", 0.0, 0.0, 1.0, "1 lets fluid through two open valves, 0 holds", "document 2.6.1"),
    _hydraulics("pump_failure", "1", 0.0, 0.0, 1.0, "1 stops the return pump", "neutral"),
    *_per_wheel("inlet_stuck", "1", 2.0, f"inlet {_STUCK}"),
    *_per_wheel("outlet_stuck", "1", 2.0, f"outlet {_STUCK}"),
    *_per_wheel("inlet_delay", "s", 0.1, "dead time of the inlet valve"),
    *_per_wheel("outlet_delay", "s", 0.1, "dead time of the outlet valve"),
    *_per_wheel("inlet_conductance", "1", 10.0, "flow of the inlet valve over its healthy one", low=0.01, neutral=1.0),
    *_per_wheel(
        "outlet_conductance", "1", 10.0, "flow of the outlet valve over its healthy one", low=0.01, neutral=1.0
    ),
    *_per_wheel("inlet_leak", "m^3/s/Pa", 1e-11, "flow past the closed inlet valve per pressure"),
    *_per_wheel("outlet_leak", "m^3/s/Pa", 1e-11, "flow past the closed outlet valve per pressure"),
    *_per_wheel("brake_leak", "m^3/s/Pa", 1e-11, "flow out of the wheel brake per pressure"),
    *_per_wheel("air_volume", "m^3", 1e-5, "air in the wheel brake, at the atmosphere's pressure"),
    _hydraulics("pump_rate", "1", 1.0, 0.0, 2.0, "flow of the return pump over its healthy one, 0 is dead", "neutral"),
    _hydraulics("circuit_split", "1", 0.0, 0.0, 1.0, "0 diagonal circuits, 1 front and rear", "neutral"),
    _hydraulics("first_circuit_failure", "1", 0.0, 0.0, 1.0, "line pressure lost, front left's circuit", "neutral"),
    _hydraulics("second_circuit_failure", "1", 0.0, 0.0, 1.0, "line pressure lost, the other circuit", "neutral"),
    _hydraulics("first_accumulator_blocked", "1", 0.0, 0.0, 1.0, "share that takes no fluid", "neutral"),
    _hydraulics("second_accumulator_blocked", "1", 0.0, 0.0, 1.0, "share that takes no fluid", "neutral"),
    _hydraulics("fluid_temperature", "degC", 20.0, -40.0, 150.0, "of the brake fluid in lines and valves", "neutral"),
    _hydraulics("laminar_share", "1", 0.1, 0.0, 1.0, "of the valves' resistance, which grows with viscosity", _USUAL),
    Parameter("brakes.ambient_temperature", "degC", 20.0, -60.0, 80.0, "of the air at the discs", _USUAL),
    Parameter("brakes.caliper_time_constant", "s", 0.0, 0.0, 0.2, "lag of the torque behind the pressure", "neutral"),
    *_per_wheel("pad_glazing", "1", 1.0, "share of the pads' friction lost to a glazed surface", section="brakes"),
    *_per_wheel("piston_friction", "Pa", 5e7, "pressure that the caliper's piston needs to move", section="brakes"),
    *_per_wheel("drag_torque", "N m", 1e3, "torque without pressure", section="brakes"),
    *_per_wheel("thickness_variation", "1", 0.5, "amplitude of the torque over a turn of the disc", section="brakes"),
)
