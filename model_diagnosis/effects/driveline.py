"""Effects of engine, driveline and differential."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


def _driveline(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    signals: tuple[str, ...] = ("longitudinal_acceleration", *_WHEEL_SPEEDS),
) -> Effect:
    return Effect(
        name=name,
        group=Group.DRIVELINE,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source="usual lumped driveline; ranges of passenger cars",
    )


def _absolute(name: str, unit: str, low: float, high: float, scatter: float, width: float) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, relative=False)


DRIVELINE_EFFECTS: tuple[Effect, ...] = (
    _driveline(
        "engine_braking",
        "T <- T - d on the driven axles without drive torque",
        (_absolute("torque", "N m", 0.0, 300.0, 2.0, 50.0),),
        ("brake_drag_torque", "driveline_drag"),
        "coasting with the clutch open and closed",
    ),
    _driveline(
        "driveline_drag",
        "T <- T - T0 - c w on the driven axles",
        (
            _absolute("constant", "N m", 0.0, 60.0, 1.0, 14.0),
            _absolute("viscous", "N m s/rad", 0.0, 0.6, 0.01, 0.15),
        ),
        ("engine_braking", "brake_drag_torque", "rolling_resistance"),
        "coast-down in neutral, driven and free axle",
    ),
    _driveline(
        "wheel_inertia_reflected",
        "J <- J + d, d = i^2 J_e/2, driven wheels",
        (_absolute("inertia", "kg m^2", -0.5, 4.0, 0.03, 0.6),),
        ("tyre_relaxation_length", "caliper_lag", "tyre_peak_shape"),
        "pressure pulses with the clutch open and closed",
        _WHEEL_SPEEDS,
    ),
    _driveline(
        "differential_locking",
        "T_l - T_r = 2 (T_pre sgn(w_r - w_l) + c (w_r - w_l)), driven axle",
        (
            _absolute("preload", "N m", 0.0, 400.0, 2.0, 70.0),
            _absolute("viscous", "N m s/rad", 0.0, 60.0, 0.5, 15.0),
        ),
        ("anti_roll_bar", "wheel_radius_change"),
        "parking circle, and mu-split",
        ("yaw_rate", *_WHEEL_SPEEDS),
    ),
)
