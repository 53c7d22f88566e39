"""Effects of the control unit's own settings.

With measured pressures or valve commands as inputs the controller cannot matter, so the replay has no column for them:
a replay cannot tell them, only a closed loop with the control unit can.
"""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_SIGNALS = tuple(f"{name}_{wheel}" for name in ("valve_inlet", "valve_outlet", "wheel_speed") for wheel in WHEELS)
_SOURCE = "usual slip thresholds 0.05 to 0.3 and phases of 5 to 100 ms"

CONTROLLER_EFFECTS: tuple[Effect, ...] = (
    Effect(
        name="abs_threshold",
        group=Group.CONTROLLER,
        application=Application.CONTROLLER,
        equation="release where -slip > lambda_on, rebuild where -slip < lambda_off",
        parameters=(
            EffectParameter("release_slip", "1", -0.15, 0.3, 0.01, 0.04, relative=False),
            EffectParameter("rebuild_slip", "1", -0.15, 0.3, 0.01, 0.03, relative=False),
        ),
        signals=_SIGNALS,
        confounded_with=("tyre_peak_shape", "outlet_valve_conductance"),
        separating_manoeuvre="ABS stop with valve commands in the log",
        source=_SOURCE,
    ),
    Effect(
        name="abs_cycle_timing",
        group=Group.CONTROLLER,
        application=Application.CONTROLLER,
        equation="hold and stepped rebuild last t_hold, t_step",
        parameters=(
            EffectParameter("hold_time", "s", -0.1, 0.2, 0.002, 0.02, relative=False),
            EffectParameter("step_period", "s", -0.1, 0.2, 0.002, 0.02, relative=False),
        ),
        signals=_SIGNALS,
        confounded_with=("inlet_valve_conductance", "inlet_valve_delay"),
        separating_manoeuvre="ABS stop with valve commands in the log",
        source=_SOURCE,
    ),
)
