"""Effects of springs, dampers, anti-roll bars and guidance."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_REIMPELL = "Reimpell, Stoll, Betzler, The Automotive Chassis, 2nd ed."


def _suspension(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    signals: tuple[str, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    source: str = _REIMPELL,
) -> Effect:
    return Effect(
        name=name,
        group=Group.SUSPENSION,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source=source,
    )


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
        "anti_dive_anti_lift",
        "Fz past the spring = -+ Fx tan(eps + d) while braking",
        _absolute("rad", 0.2, 0.01, 0.06, "brake_support_angle"),
        ("longitudinal_acceleration", "pitch_rate", "pitch_angle"),
        ("spring_rate",),
        "ramp of braking with ride heights or pitch rate: pitch changes, the load transfer does not",
        f"{_REIMPELL}, 3.11",
    ),
    _suspension(
        "spring_rate",
        "k <- (1 + d) k",
        _relative(-0.5, 1.0, 0.03, 0.2, "spring_rate"),
        ("longitudinal_acceleration", "lateral_acceleration", "pitch_rate", "roll_rate"),
        ("cg_height_change", "anti_dive_anti_lift", "anti_roll_bar"),
        "sudden release of the brake and a slalom: frequency of pitch and roll",
    ),
    _suspension(
        "damper_rate",
        "c <- (1 + d) c, bump and rebound",
        _relative(-0.8, 1.5, 0.05, 0.3, "damping_scale"),
        ("longitudinal_acceleration", "pitch_rate", "roll_rate", *_WHEEL_SPEEDS),
        ("spring_rate",),
        "sudden release of the brake: decay of the pitch",
    ),
    _suspension(
        "anti_roll_bar",
        "k_phi <- (1 + d) k_phi",
        _relative(-0.9, 1.5, 0.05, 0.3, "anti_roll_rate"),
        ("lateral_acceleration", "roll_rate", "yaw_rate"),
        ("spring_rate", "roll_centre_height"),
        "circle at rising lateral acceleration with the roll angle",
    ),
    _suspension(
        "bump_stop",
        "F <- F + k_b max(z - z_b, 0)",
        (
            EffectParameter("rate", "N/m", 0.0, 5e5, 0.0, 6e4, "suspension.*.bump_stop_rate", relative=False),
            EffectParameter(
                "clearance", "m", -0.06, 0.03, 0.003, 0.02, "suspension.*.bump_stop_clearance", relative=False
            ),
        ),
        ("longitudinal_acceleration", "pitch_rate", "pitch_angle"),
        ("spring_rate",),
        "hard stop of the loaded car",
    ),
    _suspension(
        "roll_centre_height",
        "geometric part of the lateral load transfer, m ay (h_rc + d)/t",
        _absolute("m", 0.2, 0.01, 0.07, "roll_centre_height"),
        ("lateral_acceleration", "yaw_rate", "roll_rate"),
        ("anti_roll_bar", "tyre_load_sensitivity"),
        "circle at rising lateral acceleration with the roll angle",
        f"{_REIMPELL}, 3.4",
    ),
)
