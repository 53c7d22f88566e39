"""Effects of mass, its place and its inertia."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)


_body = partial(
    Effect,
    group=Group.BODY,
    application=Application.PLANT,
    source="rigid body on four wheels; ranges: load of a passenger car",
)


BODY_EFFECTS: tuple[Effect, ...] = (
    _body(
        name="mass_change",
        equation="m <- (1 + d) m",
        parameters=(EffectParameter("factor", "1", -0.42, 0.6, 0.03, 0.15, "body.mass"),),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS, "lateral_acceleration"),
        confounded_with=("brake_pad_friction", "tyre_friction", "aero_drag"),
        separating_manoeuvre="full throttle, coasting and braking: mass acts in all three",
    ),
    _body(
        name="cg_height_change",
        equation="h <- (1 + d) h",
        parameters=(EffectParameter("factor", "1", -0.4, 0.6, 0.03, 0.15, "body.centre_of_gravity_height"),),
        signals=("longitudinal_acceleration", *_WHEEL_SPEEDS, "roll_rate"),
        confounded_with=("brake_balance", "tyre_load_sensitivity", "spring_rate"),
        separating_manoeuvre="ramp of braking to the limit, and a circle",
    ),
    _body(
        name="cg_longitudinal",
        equation="a <- a + d",
        parameters=(
            EffectParameter("shift", "m", -0.3, 0.3, 0.02, 0.1, "body.centre_of_gravity_to_front_axle", relative=False),
        ),
        signals=("yaw_rate", "lateral_acceleration", *_WHEEL_SPEEDS),
        confounded_with=("tyre_cornering_stiffness", "brake_balance"),
        separating_manoeuvre="circle, and a ramp of braking",
    ),
    _body(
        name="yaw_inertia",
        equation="I_z <- (1 + d) I_z",
        parameters=(EffectParameter("factor", "1", -0.45, 0.6, 0.03, 0.2, "body.yaw_inertia"),),
        signals=("yaw_rate", "lateral_acceleration"),
        confounded_with=("tyre_cornering_stiffness", "tyre_relaxation_length"),
        separating_manoeuvre="sine sweep: the lag of the yaw rate above 1 Hz",
    ),
)
