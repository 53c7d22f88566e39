"""Effects of mass, its place and its inertia."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


def _body(
    name: str,
    equation: str,
    parameter: EffectParameter,
    signals: tuple[str, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
) -> Effect:
    return Effect(
        name=name,
        group=Group.BODY,
        application=Application.PLANT,
        equation=equation,
        parameters=(parameter,),
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source="rigid body on four wheels; ranges: load of a passenger car",
    )


BODY_EFFECTS: tuple[Effect, ...] = (
    _body(
        "mass_change",
        "m <- (1 + d) m",
        EffectParameter("factor", "1", -0.35, 0.6, 0.03, 0.15, "body.mass"),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS, "lateral_acceleration"),
        ("brake_pad_friction", "tyre_friction", "aero_drag"),
        "full throttle, coasting and braking: mass acts in all three",
    ),
    _body(
        "cg_height_change",
        "h <- (1 + d) h",
        EffectParameter("factor", "1", -0.4, 0.6, 0.03, 0.15, "body.centre_of_gravity_height"),
        ("longitudinal_acceleration", *_WHEEL_SPEEDS, "roll_rate"),
        ("brake_balance", "tyre_load_sensitivity", "spring_rate"),
        "ramp of braking to the limit, and a circle",
    ),
    _body(
        "cg_longitudinal",
        "a <- a + d",
        EffectParameter("shift", "m", -0.3, 0.3, 0.02, 0.1, "body.centre_of_gravity_to_front_axle", relative=False),
        ("yaw_rate", "lateral_acceleration", *_WHEEL_SPEEDS),
        ("tyre_cornering_stiffness", "brake_balance"),
        "circle, and a ramp of braking",
    ),
    _body(
        "yaw_inertia",
        "I_z <- (1 + d) I_z",
        EffectParameter("factor", "1", -0.4, 0.6, 0.03, 0.2, "body.yaw_inertia"),
        ("yaw_rate", "lateral_acceleration"),
        ("tyre_cornering_stiffness", "tyre_relaxation_length"),
        "sine sweep: the lag of the yaw rate above 1 Hz",
    ),
)
