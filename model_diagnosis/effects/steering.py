"""Effects of the steering."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group

_SIGNALS = ("yaw_rate", "lateral_acceleration")


def _steering(
    name: str,
    equation: str,
    parameter: EffectParameter,
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
) -> Effect:
    return Effect(
        name=name,
        group=Group.STEERING,
        application=Application.PLANT,
        equation=equation,
        parameters=(parameter,),
        signals=_SIGNALS,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source="usual linkage; ranges of passenger cars",
    )


STEERING_EFFECTS: tuple[Effect, ...] = (
    _steering(
        "steering_ratio",
        "delta = steering-wheel angle/(i (1 + d))",
        EffectParameter("factor", "1", -0.2, 0.2, 0.01, 0.05, "steering.ratio"),
        ("tyre_cornering_stiffness", "gyro_scale"),
        "very slow circle, where r = v delta/L",
    ),
    _steering(
        "steering_compliance",
        "delta <- delta + M_z/(k_s (1 + d))",
        EffectParameter("stiffness", "1", -0.8, 2.0, 0.05, 0.35, "steering.stiffness"),
        ("tyre_cornering_stiffness",),
        "parking and a circle",
    ),
    _steering(
        "steering_offset",
        "delta <- delta + d",
        EffectParameter("angle", "rad", -0.05, 0.05, 5e-4, 0.009, "steering.offset", relative=False),
        ("tyre_camber_conicity", "road_bank", "gyro_offset"),
        "the same straight road in both directions",
    ),
)
