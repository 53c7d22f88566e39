"""Faults of transport, mapping and coding: every one is answered as a data fault by ``model_diagnosis.data``."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_MOTION = (*_WHEEL_SPEEDS, "longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "speed")
_SOURCE = "faults seen in public driving logs"


def _fault(
    name: str,
    equation: str,
    parameter: EffectParameter,
    signals: tuple[str, ...],
    manoeuvre: str,
    *,
    confounded_with: tuple[str, ...] = (),
    discrete: bool = True,
) -> Effect:
    return Effect(
        name=name,
        group=Group.CAN,
        application=Application.CLOCK,
        equation=equation,
        parameters=(parameter,),
        signals=signals,
        separating_manoeuvre=manoeuvre,
        confounded_with=confounded_with,
        source=_SOURCE,
        discrete=discrete,
    )


def _count(name: str, high: float) -> EffectParameter:
    return EffectParameter(name, "1", 0.0, high, 0.0, high / 4.0, relative=False)


CAN_EFFECTS: tuple[Effect, ...] = (
    _fault(
        "can_latency",
        "t' = t + tau for every signal of one message",
        EffectParameter("delay", "s", 0.0, 0.2, 0.0, 0.03, relative=False),
        _MOTION,
        "any: the lag is common to the signals of a message, whatever they measure",
        confounded_with=("wheel_speed_delay", "clock_offset"),
        discrete=False,
    ),
    _fault(
        "can_jitter",
        "t'_k = t_k + e_k, e_k at random per frame",
        EffectParameter("std", "s", 0.0, 0.05, 0.0, 0.005, relative=False),
        _MOTION,
        "any",
        discrete=False,
    ),
    _fault(
        "frame_drop_hold",
        "y'_k = y'_{k-1} in a share of the samples",
        _count("share", 0.5),
        _MOTION,
        "any with changing signals",
        discrete=False,
    ),
    _fault("gps_hold", "y' holds each n-th value of y", _count("samples", 200.0), ("speed", "lateral_speed"), "any"),
    _fault("counter_wrap", "y' = y modulo 2^n q", _count("bits", 32.0), _MOTION, "one that passes the wrap"),
    _fault("channel_sign", "y' = -y", _count("channels", 1.0), _MOTION, "a turn, a stop"),
    _fault("channel_unit", "y' = u y, u a ratio of usual units", _count("factor", 1e5), _MOTION, "a turn, a stop"),
    _fault(
        "channel_swap",
        "wheel_i' = wheel_pi(i), left and right or front and rear exchanged",
        _count("permutation", 23.0),
        _WHEEL_SPEEDS,
        "a turn for left and right, braking for front and rear",
    ),
    _fault(
        "command_not_measurement",
        "y' = request, ahead of the response and without noise",
        EffectParameter("lead", "s", 0.0, 1.0, 0.0, 0.1, relative=False),
        tuple(f"brake_pressure_{wheel}" for wheel in WHEELS),
        "a step of the request",
    ),
)
