"""Effects of the air."""

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group

_SOURCE = "Hucho, Aerodynamics of Road Vehicles; ranges of passenger cars"


def _air(
    name: str,
    equation: str,
    parameters: tuple[EffectParameter, ...],
    signals: tuple[str, ...],
    confounded_with: tuple[str, ...],
    separating_manoeuvre: str,
) -> Effect:
    return Effect(
        name=name,
        group=Group.AERODYNAMICS,
        application=Application.PLANT,
        equation=equation,
        parameters=parameters,
        signals=signals,
        separating_manoeuvre=separating_manoeuvre,
        confounded_with=confounded_with,
        source=_SOURCE,
    )


def _lift(axle: str) -> EffectParameter:
    return EffectParameter(axle, "1", -0.3, 0.3, 0.01, 0.08, f"aerodynamics.lift_coefficient_{axle}", relative=False)


AERODYNAMICS_EFFECTS: tuple[Effect, ...] = (
    _air(
        "aero_drag",
        "F = rho/2 c_d (1 + d) A v^2",
        (EffectParameter("factor", "1", -0.7, 1.5, 0.03, 0.3, "aerodynamics.drag_coefficient"),),
        ("longitudinal_acceleration", "speed"),
        ("head_wind", "rolling_resistance", "mass_change"),
        "coast-down in both directions",
    ),
    _air(
        "aero_lift_front_rear",
        "Fz <- Fz - rho/2 (c_l + d) A v^2, by axle",
        (_lift("front"), _lift("rear")),
        ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate"),
        ("tyre_velocity_fade",),
        "limit of braking at 60 and at 160 km/h",
    ),
    _air(
        "head_wind",
        "v_air = v + w",
        (EffectParameter("speed", "m/s", -15.0, 15.0, 0.3, 5.0, relative=False),),
        ("longitudinal_acceleration", "speed"),
        ("aero_drag", "road_grade"),
        "both directions on the same road",
    ),
    _air(
        "side_wind",
        "v_air,y = v_y + w, w from the left",
        (EffectParameter("speed", "m/s", -15.0, 15.0, 0.3, 5.0, relative=False),),
        ("lateral_acceleration", "yaw_rate"),
        ("road_bank", "tyre_camber_conicity", "steering_offset"),
        "both directions on the same road",
    ),
)
