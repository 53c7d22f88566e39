"""Time faults of channels, messages and loggers.

``model_diagnosis.data`` settles them before any physics, so the replay has no column for them: a free delay inside an
observer makes it ring and finds false minima.
"""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_SOURCE = "usual message cycles and logger clocks of 10 to 100 ppm"


def _time(name: str, low: float, high: float, effect_std: float) -> EffectParameter:
    return EffectParameter(name, "s", low, high, 0.0, effect_std, relative=False)


CLOCK_EFFECTS: tuple[Effect, ...] = (
    Effect(
        name="wheel_speed_delay",
        group=Group.CLOCK,
        application=Application.CLOCK,
        equation="w'(t) = w(t - tau)",
        parameters=(_time("delay", 0.0, 0.2, 0.03),),
        signals=_WHEEL_SPEEDS,
        confounded_with=("tyre_relaxation_length", "caliper_lag", "clock_offset", "can_latency"),
        separating_manoeuvre="pressure pulses at two speeds: relaxation shrinks with speed, a delay does not",
        source=_SOURCE,
    ),
    Effect(
        name="wheel_speed_filter",
        group=Group.CLOCK,
        application=Application.CLOCK,
        equation="tau dw'/dt + w' = w",
        parameters=(_time("time_constant", 0.0, 0.2, 0.03),),
        signals=_WHEEL_SPEEDS,
        confounded_with=("wheel_speed_delay", "tyre_relaxation_length"),
        separating_manoeuvre="any fast change of wheel speed, an ABS stop",
        source=_SOURCE,
    ),
    Effect(
        name="clock_offset",
        group=Group.CLOCK,
        application=Application.CLOCK,
        equation="t' = t + t0, all channels of one logger",
        parameters=(_time("offset", -2.0, 2.0, 0.3),),
        signals=("longitudinal_acceleration", "lateral_acceleration", "yaw_rate"),
        confounded_with=("can_latency",),
        separating_manoeuvre="any brake application and any turn: all channels of the logger share the lag",
        source=_SOURCE,
    ),
    Effect(
        name="clock_drift",
        group=Group.CLOCK,
        application=Application.CLOCK,
        equation="t' = (1 + d) t, all channels of one logger",
        parameters=(EffectParameter("drift", "1", -5e-4, 5e-4, 0.0, 1e-4, relative=False),),
        signals=("longitudinal_acceleration", "lateral_acceleration", "yaw_rate"),
        confounded_with=("clock_offset",),
        separating_manoeuvre="a log of several minutes",
        source=_SOURCE,
    ),
    Effect(
        name="low_pass_channel",
        group=Group.CLOCK,
        application=Application.CLOCK,
        equation="tau dy'/dt + y' = y, any channel",
        parameters=(_time("time_constant", 0.0, 5.0, 0.2),),
        signals=("longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "speed"),
        confounded_with=("wheel_speed_delay", "clock_offset"),
        separating_manoeuvre="any fast input: a delay keeps the spectrum, a filter bends it",
        source=_SOURCE,
    ),
)
