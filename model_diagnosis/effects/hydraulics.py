"""Effects of booster, hydraulic unit and brake lines.

They show where the log tells what goes into the hydraulics (pedal force or master pressure, valve commands) beside the
pressures that come out; with wheel pressures alone the data says nothing on them.
"""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_PRESSURES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)
_ORIFICE = "orifice flow, friction document 2.6"
_NEEDS = "needs master pressure, valve commands and wheel pressures in the log"


def _hydraulic(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    source: str = _ORIFICE,
    signals: tuple[str, ...] = _PRESSURES,
    remarks: str = _NEEDS,
) -> Effect:
    return Effect(
        name=name,
        group=Group.HYDRAULICS,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source=source,
        remarks=remarks,
    )


def _conductance(valve: str) -> tuple[EffectParameter, ...]:
    return tuple(
        EffectParameter(wheel, "1", -0.7, 1.0, 0.03, 0.2, f"hydraulics.{valve}_conductance_{wheel}") for wheel in WHEELS
    )


def _delay(valve: str) -> tuple[EffectParameter, ...]:
    """A dead time; commands logged every 10 ms leave it open by 10 ms / sqrt(12)."""
    return (
        EffectParameter(
            "delay", "s", -0.02, 0.03, 3e-3, 0.01, f"hydraulics.{valve}_delay_*", relative=False, never_negative=True
        ),
    )


def _absolute(wheel: str, unit: str, high: float, scatter: float, width: float, path: str) -> EffectParameter:
    return EffectParameter(wheel, unit, 0.0, high, scatter, width, f"hydraulics.{path}_{wheel}", relative=False)


HYDRAULICS_EFFECTS: tuple[Effect, ...] = (
    _hydraulic(
        "inlet_valve_conductance",
        "q = C_d A (1 + d_i) sqrt(2 dp/rho) into the wheel brake",
        _conductance("inlet"),
        ("caliper_air",),
        "steps with the inlet valve alone at two pressure differences",
    ),
    _hydraulic(
        "outlet_valve_conductance",
        "q = C_d A (1 + d_i) sqrt(2 dp/rho) out of the wheel brake",
        _conductance("outlet"),
        ("low_pressure_accumulator_full",),
        "dump pulses",
    ),
    _hydraulic(
        "inlet_valve_delay",
        "u(t - tau - d) closes and opens the inlet valve",
        _delay("inlet"),
        ("can_latency", "pressure_sensor_lag"),
        "train of valve pulses; other messages' delays",
        "dead times of solenoid valves, 2 to 5 ms",
    ),
    _hydraulic(
        "outlet_valve_delay",
        "u(t - tau - d) opens and closes the outlet valve",
        _delay("outlet"),
        ("can_latency", "pressure_sensor_lag"),
        "train of valve pulses; other messages' delays",
        "dead times of solenoid valves, 2 to 5 ms",
    ),
    _hydraulic(
        "caliper_air",
        "V(p) = V_f(p) + V_a (1 - (p0/(p0 + p))^(1/n)), by wheel",
        tuple(_absolute(w, "m^3", 5e-6, 1e-8, 1.2e-6, "air_volume") for w in WHEELS),
        ("inlet_valve_conductance", "caliper_lag"),
        "slow and fast brake applications from 0 bar: air acts below 10 bar",
        "polytropic gas in the fluid",
    ),
    _hydraulic(
        "hydraulic_leak",
        "q = G p out of the wheel brake",
        tuple(_absolute(w, "m^3/s/Pa", 4e-13, 1e-15, 6e-14, "brake_leak") for w in WHEELS),
        ("outlet_valve_conductance",),
        "hold 60 bar for 5 s",
        "laminar leak",
    ),
    _hydraulic(
        "pump_rate",
        "Q <- (1 + d) Q",
        (EffectParameter("factor", "1", -1.0, 0.8, 0.05, 0.3, "hydraulics.pump_rate"),),
        ("low_pressure_accumulator_full",),
        "long stop on low friction",
    ),
    _hydraulic(
        "low_pressure_accumulator_full",
        "no more fluid leaves a wheel brake once V >= (1 + d) V_max",
        (EffectParameter("capacity", "1", -0.8, 1.0, 0.05, 0.3, "hydraulics.accumulator_volume"),),
        ("outlet_valve_conductance", "pump_rate"),
        "jump from high to low friction",
    ),
    _hydraulic(
        "circuit_failure",
        "p_circuit <- p_circuit (1 - d)",
        tuple(
            EffectParameter(number, "1", 0.0, 1.0, 0.002, 0.4, f"hydraulics.{number}_circuit_failure", relative=False)
            for number in ("first", "second")
        ),
        ("wheel_brake_weak",),
        "any stop",
        "dual-circuit brakes",
    ),
    _hydraulic(
        "brake_knock_back",
        "the pads stand back by dV after cornering above 4 m/s^2: no pressure before that volume has gone in",
        (EffectParameter("volume", "m^3", 0.0, 2e-6, 1e-8, 4e-7, relative=False),),
        ("caliper_air",),
        "brake straight, and after a slalom",
        "knock-back of floating calipers",
    ),
    _hydraulic(
        "booster_saturation",
        "p = k (1 + g) F, less d of what lies above the knee 80 bar + p_k",
        (
            EffectParameter("gain", "1", -0.5, 0.5, 0.03, 0.12, "brakes.booster_gain"),
            EffectParameter("slope_loss", "1", 0.0, 1.0, 0.0, 0.4, "brakes.booster_slope_loss", relative=False),
            EffectParameter("knee", "Pa", -7e6, 1e7, 2e5, 2e6, "brakes.booster_knee_pressure", relative=False),
        ),
        ("circuit_failure",),
        "full application of the pedal",
        "vacuum booster",
        ("master_pressure",),
        "needs pedal force and master pressure in the log",
    ),
)
