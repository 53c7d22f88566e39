"""Effects of the steering."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group

_SIGNALS = ("yaw_rate", "lateral_acceleration")


_steering = partial(
    Effect,
    group=Group.STEERING,
    application=Application.PLANT,
    signals=_SIGNALS,
    source="usual linkage; ranges of passenger cars",
)


STEERING_EFFECTS: tuple[Effect, ...] = (
    _steering(
        name="steering_ratio",
        equation="delta = steering-wheel angle/(i (1 + d))",
        parameters=(EffectParameter("factor", "1", -0.2, 0.2, 0.01, 0.05, "steering.ratio"),),
        confounded_with=("tyre_cornering_stiffness", "gyro_scale"),
        separating_manoeuvre="very slow circle, where r = v delta/L",
    ),
    _steering(
        name="steering_compliance",
        equation="delta <- delta + M_z/(k_s (1 + d))",
        parameters=(EffectParameter("stiffness", "1", -0.8, 2.0, 0.05, 0.35, "steering.stiffness"),),
        confounded_with=("tyre_cornering_stiffness",),
        separating_manoeuvre="parking and a circle",
    ),
    _steering(
        name="steering_offset",
        equation="delta <- delta + d",
        parameters=(EffectParameter("angle", "rad", -0.05, 0.05, 5e-4, 0.009, "steering.offset", relative=False),),
        confounded_with=("tyre_camber_conicity", "road_bank", "gyro_offset"),
        separating_manoeuvre="the same straight road in both directions",
    ),
)
