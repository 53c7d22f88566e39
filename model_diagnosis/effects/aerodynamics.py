"""Effects of the air."""

from functools import partial

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group

_SOURCE = "Hucho, Aerodynamics of Road Vehicles; ranges of passenger cars"


_air = partial(Effect, group=Group.AERODYNAMICS, application=Application.PLANT, source=_SOURCE)


def _lift(axle: str) -> EffectParameter:
    return EffectParameter(axle, "1", -0.3, 0.3, 0.01, 0.08, f"aerodynamics.lift_coefficient_{axle}", relative=False)


AERODYNAMICS_EFFECTS: tuple[Effect, ...] = (
    _air(
        name="aero_drag",
        equation="F = rho/2 c_d (1 + d) A v^2",
        parameters=(EffectParameter("factor", "1", -0.8, 1.5, 0.03, 0.3, "aerodynamics.drag_coefficient"),),
        signals=("longitudinal_acceleration", "speed"),
        confounded_with=("head_wind", "rolling_resistance", "mass_change"),
        separating_manoeuvre="coast-down in both directions",
    ),
    _air(
        name="aero_lift_front_rear",
        equation="Fz <- Fz - rho/2 (c_l + d) A v^2, by axle",
        parameters=(_lift("front"), _lift("rear")),
        signals=("longitudinal_acceleration", "lateral_acceleration", "yaw_rate"),
        confounded_with=("tyre_velocity_fade",),
        separating_manoeuvre="limit of braking at 60 and at 160 km/h",
    ),
    _air(
        name="head_wind",
        equation="v_air = v + w",
        parameters=(EffectParameter("speed", "m/s", -15.0, 15.0, 0.3, 5.0, relative=False),),
        signals=("longitudinal_acceleration", "speed"),
        confounded_with=("aero_drag", "road_grade"),
        separating_manoeuvre="both directions on the same road",
    ),
    _air(
        name="side_wind",
        equation="v_air,y = v_y + w, w from the left",
        parameters=(EffectParameter("speed", "m/s", -15.0, 15.0, 0.3, 5.0, relative=False),),
        signals=("lateral_acceleration", "yaw_rate"),
        confounded_with=("road_bank", "tyre_camber_conicity", "steering_offset"),
        separating_manoeuvre="both directions on the same road",
    ),
)
