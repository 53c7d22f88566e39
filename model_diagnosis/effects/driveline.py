"""Effects of engine, driveline and differential."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


_driveline = partial(
    Effect,
    group=Group.DRIVELINE,
    application=Application.PLANT,
    signals=("longitudinal_acceleration", *_WHEEL_SPEEDS),
    source="usual lumped driveline; ranges of passenger cars",
)


def _absolute(name: str, unit: str, low: float, high: float, scatter: float, width: float) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, relative=False)


DRIVELINE_EFFECTS: tuple[Effect, ...] = (
    _driveline(
        name="engine_braking",
        equation="T <- T - d on the driven axles without drive torque",
        parameters=(_absolute("torque", "N m", 0.0, 300.0, 2.0, 50.0),),
        confounded_with=("brake_drag_torque", "driveline_drag"),
        separating_manoeuvre="coasting with the clutch open and closed",
    ),
    _driveline(
        name="driveline_drag",
        equation="T <- T - T0 - c w on the driven axles",
        parameters=(
            _absolute("constant", "N m", 0.0, 60.0, 1.0, 14.0),
            _absolute("viscous", "N m s/rad", 0.0, 0.6, 0.01, 0.15),
        ),
        confounded_with=("engine_braking", "brake_drag_torque", "rolling_resistance"),
        separating_manoeuvre="coast-down in neutral, driven and free axle",
    ),
    _driveline(
        name="wheel_inertia_reflected",
        equation="J <- J + d, d = i^2 J_e/2, driven wheels",
        parameters=(_absolute("inertia", "kg m^2", -0.5, 4.0, 0.03, 0.6),),
        confounded_with=("tyre_relaxation_length", "caliper_lag", "tyre_peak_shape"),
        separating_manoeuvre="pressure pulses with the clutch open and closed",
        signals=_WHEEL_SPEEDS,
        needs_torque=True,
        remarks="no cause where every torque was taken from the acceleration: it shows in how wheels follow one",
    ),
    _driveline(
        name="differential_locking",
        equation="T_l - T_r = 2 (T_pre sgn(w_r - w_l) + c (w_r - w_l)), driven axle",
        parameters=(
            _absolute("preload", "N m", 0.0, 400.0, 2.0, 70.0),
            _absolute("viscous", "N m s/rad", 0.0, 60.0, 0.5, 15.0),
        ),
        confounded_with=("anti_roll_bar", "wheel_radius_change"),
        separating_manoeuvre="parking circle, and mu-split",
        signals=("yaw_rate", *_WHEEL_SPEEDS),
    ),
)
