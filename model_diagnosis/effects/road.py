"""Effects of the road."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


def _road(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    signals: tuple[str, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
    remarks: str = "",
) -> Effect:
    return Effect(
        name=name,
        group=Group.ROAD,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source="slopes and friction of public roads",
        remarks=remarks,
    )


def _absolute(name: str, unit: str, low: float, high: float, scatter: float, width: float) -> EffectParameter:
    return EffectParameter(name, unit, low, high, scatter, width, relative=False)


ROAD_EFFECTS: tuple[Effect, ...] = (
    _road(
        "road_grade",
        "dv/dt <- dv/dt - g (s + d), the accelerometer does not see it",
        (_absolute("grade", "1", -0.1, 0.1, 0.001, 0.015),),
        ("speed", "longitudinal_acceleration"),
        ("accelerometer_offset", "rolling_resistance", "head_wind"),
        "both directions on the same road; a speed reference",
    ),
    _road(
        "road_bank",
        "dv_y/dt <- dv_y/dt - g (b + d)",
        (_absolute("bank", "1", -0.08, 0.08, 0.001, 0.012),),
        ("lateral_acceleration", "yaw_rate"),
        ("accelerometer_offset", "tyre_camber_conicity", "side_wind"),
        "both directions on the same road",
    ),
    _road(
        "mu_step",
        "mu <- mu (1 + d) behind the place 30 m + x0",
        (
            _absolute("level", "1", -0.85, 1.0, 0.0, 0.25),
            _absolute("place", "m", -30.0, 170.0, 0.0, 30.0),
        ),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS),
        ("tyre_friction", "brake_pad_friction"),
        "the same stop on another spot",
        "the place counts from the first sample of each manoeuvre",
    ),
    _road(
        "mu_split",
        "mu <- mu (1 + d) on the left, mu (1 - d) on the right",
        (_absolute("level", "1", -0.7, 0.7, 0.005, 0.15),),
        ("yaw_rate", *_WHEEL_SPEEDS),
        ("wheel_brake_weak",),
        "the same stop on another spot",
    ),
)
