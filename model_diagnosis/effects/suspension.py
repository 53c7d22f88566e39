"""Effects of springs, dampers, anti-roll bars and guidance."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_REIMPELL = "Reimpell, Stoll, Betzler, The Automotive Chassis, 2nd ed."


_suspension = partial(Effect, group=Group.SUSPENSION, application=Application.PLANT, source=_REIMPELL)


def _relative(low: float, high: float, scatter: float, width: float, path: str) -> tuple[EffectParameter, ...]:
    return tuple(
        EffectParameter(axle, "1", low, high, scatter, width, f"suspension.{axle}.{path}") for axle in ("front", "rear")
    )


def _absolute(unit: str, bound: float, scatter: float, width: float, path: str) -> tuple[EffectParameter, ...]:
    return tuple(
        EffectParameter(axle, unit, -bound, bound, scatter, width, f"suspension.{axle}.{path}", relative=False)
        for axle in ("front", "rear")
    )


SUSPENSION_EFFECTS: tuple[Effect, ...] = (
    _suspension(
        name="anti_dive_anti_lift",
        equation="Fz past the spring = -+ Fx tan(eps + d): the links' pole moves, braking and driving alike",
        parameters=_absolute("rad", 0.2, 0.01, 0.06, "brake_support_angle"),
        signals=("longitudinal_acceleration", "pitch_rate", "pitch_angle"),
        confounded_with=("spring_rate",),
        separating_manoeuvre="ramp of braking with ride heights or pitch rate: pitch changes, load transfer does not",
        source=f"{_REIMPELL}, 3.11",
    ),
    _suspension(
        name="spring_rate",
        equation="k <- (1 + d) k",
        parameters=_relative(-0.5, 1.0, 0.03, 0.2, "spring_rate"),
        signals=("longitudinal_acceleration", "lateral_acceleration", "pitch_rate", "roll_rate"),
        confounded_with=("cg_height_change", "anti_dive_anti_lift", "anti_roll_bar"),
        separating_manoeuvre="sudden release of the brake and a slalom: frequency of pitch and roll",
    ),
    _suspension(
        name="damper_rate",
        equation="c <- (1 + d) c, bump and rebound",
        parameters=_relative(-0.8, 1.5, 0.05, 0.3, "damping_scale"),
        signals=("longitudinal_acceleration", "pitch_rate", "roll_rate", *_WHEEL_SPEEDS),
        confounded_with=("spring_rate",),
        separating_manoeuvre="sudden release of the brake: decay of the pitch",
    ),
    _suspension(
        name="anti_roll_bar",
        equation="k_phi <- (1 + d) k_phi",
        parameters=_relative(-0.9, 1.5, 0.05, 0.3, "anti_roll_rate"),
        signals=("lateral_acceleration", "roll_rate", "yaw_rate"),
        confounded_with=("spring_rate", "roll_centre_height"),
        separating_manoeuvre="circle at rising lateral acceleration with the roll angle",
    ),
    _suspension(
        name="bump_stop",
        equation="F <- F + k_b max(z - z_b, 0)",
        parameters=(
            EffectParameter("rate", "N/m", 0.0, 5e5, 0.0, 6e4, "suspension.*.bump_stop_rate", relative=False),
            EffectParameter(
                "clearance", "m", -0.06, 0.03, 0.003, 0.02, "suspension.*.bump_stop_clearance", relative=False
            ),
        ),
        signals=("longitudinal_acceleration", "pitch_rate", "pitch_angle"),
        confounded_with=("spring_rate",),
        separating_manoeuvre="hard stop of the loaded car",
    ),
    _suspension(
        name="roll_centre_height",
        equation="geometric part of the lateral load transfer, m ay (h_rc + d)/t",
        parameters=_absolute("m", 0.2, 0.01, 0.07, "roll_centre_height"),
        signals=("lateral_acceleration", "yaw_rate", "roll_rate"),
        confounded_with=("anti_roll_bar", "tyre_load_sensitivity"),
        separating_manoeuvre="circle at rising lateral acceleration with the roll angle",
        source=f"{_REIMPELL}, 3.4",
    ),
)
