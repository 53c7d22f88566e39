"""Effects of the road."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


_road = partial(
    Effect, group=Group.ROAD, application=Application.PLANT, source="slopes and friction of public roads", remarks=""
)


def _absolute(name: str, unit: str, low: float, high: float, scatter: float, width: float) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, relative=False)


ROAD_EFFECTS: tuple[Effect, ...] = (
    _road(
        name="road_grade",
        equation="dv/dt <- dv/dt - g (s + d), the accelerometer does not see it",
        parameters=(_absolute("grade", "1", -0.1, 0.1, 0.001, 0.015),),
        signals=("speed", "longitudinal_acceleration"),
        confounded_with=("accelerometer_offset", "rolling_resistance", "head_wind"),
        separating_manoeuvre="both directions on the same road; a speed reference",
    ),
    _road(
        name="road_bank",
        equation="dv_y/dt <- dv_y/dt - g (b + d)",
        parameters=(_absolute("bank", "1", -0.08, 0.08, 0.001, 0.012),),
        signals=("lateral_acceleration", "yaw_rate"),
        confounded_with=("accelerometer_offset", "tyre_camber_conicity", "side_wind"),
        separating_manoeuvre="both directions on the same road",
    ),
    _road(
        name="mu_step",
        equation="mu <- mu (1 + d) behind the place 30 m + x0",
        parameters=(
            EffectParameter("level", "1", -0.85, 1.0, 0.0, 0.25, relative=False, least_named=0.05),
            EffectParameter("place", "m", -30.0, 170.0, 0.0, 30.0, relative=False, trial_step=10.0, places="level"),
        ),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS),
        confounded_with=("tyre_friction", "brake_pad_friction"),
        separating_manoeuvre="the same stop on another spot",
        remarks="the place counts from the first sample of each manoeuvre; all roads vary by some per cent",
        needs_limit=True,
    ),
    _road(
        name="mu_split",
        equation="mu <- mu (1 + d) on the left, mu (1 - d) on the right",
        parameters=(_absolute("level", "1", -0.7, 0.7, 0.005, 0.15),),
        signals=("yaw_rate", *_WHEEL_SPEEDS),
        confounded_with=("wheel_brake_weak",),
        separating_manoeuvre="the same stop on another spot",
        needs_limit=True,
    ),
)
