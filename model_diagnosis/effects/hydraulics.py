"""Effects of booster, hydraulic unit and brake lines.

They show where the log tells what goes into the hydraulics (pedal force or master pressure, valve commands) beside the
pressures that come out; with wheel pressures alone the data says nothing on them.
"""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_PRESSURES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)
_ORIFICE = "orifice flow, friction document 2.6"
_NEEDS = "needs master pressure, valve commands and wheel pressures in the log"


_hydraulic = partial(
    Effect, group=Group.HYDRAULICS, application=Application.PLANT, signals=_PRESSURES, source=_ORIFICE, remarks=_NEEDS
)


def _conductance(valve: str) -> tuple[EffectParameter, ...]:
    return tuple(
        EffectParameter(wheel, "1", -0.7, 1.0, 0.03, 0.2, f"hydraulics.{valve}_conductance_{wheel}") for wheel in WHEELS
    )


def _delay(valve: str) -> tuple[EffectParameter, ...]:
    """A dead time of all valves, and of one beside the others.

    Commands logged every 10 ms leave the first open by 10 ms / sqrt(12), the others not: they come in one frame.
    """
    path = f"hydraulics.{valve}_delay"
    return (
        _dead_time("delay", 3e-3, f"{path}_*", -0.02, never_negative=True),
        # a valve that sticks is late beside the others; two scatters early is all that making one leaves
        *(_dead_time(wheel, 5e-4, f"{path}_{wheel}", -1e-3) for wheel in WHEELS),
    )


def _dead_time(
    name: str, scatter_s: float, path: str, least_s: float, *, never_negative: bool = False
) -> EffectParameter:
    """Commands are told every 10 ms: valleys of the cost are half as wide (measured), and two values lie in each."""
    return EffectParameter(
        name,
        "s",
        least_s,
        0.03,
        scatter_s,
        0.01,
        path,
        relative=False,
        never_negative=never_negative,
        trial_step=2.5e-3,
    )


def _absolute(wheel: str, unit: str, high: float, scatter: float, width: float, path: str) -> EffectParameter:
    return EffectParameter(wheel, unit, 0.0, high, scatter, width, f"hydraulics.{path}_{wheel}", relative=False)


HYDRAULICS_EFFECTS: tuple[Effect, ...] = (
    _hydraulic(
        name="inlet_valve_conductance",
        equation="q = C_d A (1 + d_i) sqrt(2 dp/rho) into the wheel brake",
        parameters=_conductance("inlet"),
        confounded_with=("caliper_air",),
        separating_manoeuvre="steps with the inlet valve alone at two pressure differences",
    ),
    _hydraulic(
        name="outlet_valve_conductance",
        equation="q = C_d A (1 + d_i) sqrt(2 dp/rho) out of the wheel brake",
        parameters=_conductance("outlet"),
        confounded_with=("low_pressure_accumulator_full",),
        separating_manoeuvre="dump pulses",
    ),
    _hydraulic(
        name="inlet_valve_delay",
        equation="u(t - tau - d) closes and opens the inlet valve",
        parameters=_delay("inlet"),
        confounded_with=("can_latency", "pressure_sensor_lag"),
        separating_manoeuvre="train of valve pulses; other messages' delays",
        source="dead times of solenoid valves, 2 to 5 ms",
    ),
    _hydraulic(
        name="outlet_valve_delay",
        equation="u(t - tau - d) opens and closes the outlet valve",
        parameters=_delay("outlet"),
        confounded_with=("can_latency", "pressure_sensor_lag"),
        separating_manoeuvre="train of valve pulses; other messages' delays",
        source="dead times of solenoid valves, 2 to 5 ms",
    ),
    _hydraulic(
        name="caliper_air",
        equation="V(p) = V_f(p) + V_a (1 - (p0/(p0 + p))^(1/n)), by wheel",
        parameters=tuple(_absolute(w, "m^3", 5e-6, 1e-8, 1.2e-6, "air_volume") for w in WHEELS),
        confounded_with=("inlet_valve_conductance", "caliper_lag"),
        separating_manoeuvre="slow and fast brake applications from 0 bar: air acts below 10 bar",
        source="polytropic gas in the fluid",
    ),
    _hydraulic(
        name="hydraulic_leak",
        equation="q = G p out of the wheel brake",
        # a tight brake has none; what the form of filling and return leaves is 3 % of a front brake's pressure a second
        parameters=tuple(_absolute(w, "m^3/s/Pa", 4e-13, 5e-15, 6e-14, "brake_leak") for w in WHEELS),
        confounded_with=("outlet_valve_conductance",),
        separating_manoeuvre="hold 60 bar for 5 s",
        source="laminar leak",
    ),
    _hydraulic(
        name="pump_rate",
        equation="Q <- (1 + d) Q",
        parameters=(EffectParameter("factor", "1", -1.0, 0.8, 0.05, 0.3, "hydraulics.pump_rate"),),
        confounded_with=("low_pressure_accumulator_full",),
        separating_manoeuvre="long stop on low friction",
    ),
    _hydraulic(
        name="low_pressure_accumulator_full",
        equation="no more fluid leaves a wheel brake once V >= (1 + d) V_max",
        parameters=(EffectParameter("capacity", "1", -0.8, 1.0, 0.05, 0.3, "hydraulics.accumulator_volume"),),
        confounded_with=("outlet_valve_conductance", "pump_rate"),
        separating_manoeuvre="jump from high to low friction",
    ),
    _hydraulic(
        name="circuit_failure",
        equation="p_circuit <- p_circuit (1 - d)",
        # a unit that follows its supply by steps of 1 bar rests 0.3 bar (1 bar over root 12) off it: 1 % of 30 bar
        parameters=tuple(
            EffectParameter(
                number, "1", 0.0, 1.0, 0.0, 0.4, f"hydraulics.{number}_circuit_failure", relative=False, form_std=0.01
            )
            for number in ("first", "second")
        ),
        confounded_with=("wheel_brake_weak",),
        separating_manoeuvre="any stop",
        source="dual-circuit brakes",
        one_at_a_time=True,
        remarks="there are two circuits so that never both fail; both low is a scale of sensors",
    ),
    _hydraulic(
        name="brake_knock_back",
        equation="the pads stand back by dV after cornering above 4 m/s^2: no pressure before that volume has gone in",
        parameters=(EffectParameter("volume", "m^3", 0.0, 2e-6, 1e-8, 4e-7, relative=False),),
        confounded_with=("caliper_air",),
        separating_manoeuvre="brake straight, and after a slalom",
        source="knock-back of floating calipers",
    ),
    _hydraulic(
        name="booster_saturation",
        equation="p = k (1 + g) F, less d of what lies above the knee 80 bar + p_k",
        parameters=(
            EffectParameter("gain", "1", -0.5, 0.5, 0.03, 0.12, "brakes.booster_gain"),
            EffectParameter("slope_loss", "1", 0.0, 1.0, 0.0, 0.4, "brakes.booster_slope_loss", relative=False),
            EffectParameter("knee", "Pa", -7e6, 1e7, 2e5, 2e6, "brakes.booster_knee_pressure", relative=False),
        ),
        confounded_with=("circuit_failure",),
        separating_manoeuvre="full application of the pedal",
        source="vacuum booster",
        signals=("master_pressure",),
        remarks="needs pedal force and master pressure in the log",
    ),
)
