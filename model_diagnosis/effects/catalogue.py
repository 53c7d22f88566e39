"""The catalogue of effects, all groups together."""

from functools import cache

from model_diagnosis.effects.aerodynamics import AERODYNAMICS_EFFECTS
from model_diagnosis.effects.body import BODY_EFFECTS
from model_diagnosis.effects.brake import BRAKE_EFFECTS
from model_diagnosis.effects.can import CAN_EFFECTS
from model_diagnosis.effects.clock import CLOCK_EFFECTS
from model_diagnosis.effects.controller import CONTROLLER_EFFECTS
from model_diagnosis.effects.driveline import DRIVELINE_EFFECTS
from model_diagnosis.effects.effect import Effect
from model_diagnosis.effects.hydraulics import HYDRAULICS_EFFECTS
from model_diagnosis.effects.road import ROAD_EFFECTS
from model_diagnosis.effects.sensors import SENSOR_EFFECTS
from model_diagnosis.effects.steering import STEERING_EFFECTS
from model_diagnosis.effects.suspension import SUSPENSION_EFFECTS
from model_diagnosis.effects.tyre import TYRE_EFFECTS
from signals.errors import unknown_name

EFFECTS: tuple[Effect, ...] = (
    *TYRE_EFFECTS,
    *BRAKE_EFFECTS,
    *HYDRAULICS_EFFECTS,
    *SUSPENSION_EFFECTS,
    *BODY_EFFECTS,
    *AERODYNAMICS_EFFECTS,
    *ROAD_EFFECTS,
    *DRIVELINE_EFFECTS,
    *STEERING_EFFECTS,
    *SENSOR_EFFECTS,
    *CLOCK_EFFECTS,
    *CAN_EFFECTS,
    *CONTROLLER_EFFECTS,
)


IMPOSTORS = (
    "tyre_friction",
    "tyre_longitudinal_stiffness",
    "tyre_cornering_stiffness",
    "tyre_relaxation_length",
    "brake_pad_friction",
    "brake_balance",
    "caliper_lag",
    "mass_change",
    "cg_height_change",
    "yaw_inertia",
    "steering_ratio",
    "wheel_radius_change",
    "aero_drag",
    "accelerometer_offset",
    "accelerometer_scale",
    "gyro_scale",
)
"""Effects that shift phases or levels: what a refit may use instead of a delay, or of another form."""


@cache
def _by_name() -> dict[str, Effect]:
    return {effect.name: effect for effect in EFFECTS}


def effect(name: str) -> Effect:
    """The effect of that name.

    Raises
    ------
    InputError
        If the catalogue has none; the message names the nearest.
    """
    found = _by_name().get(name)
    if found is None:
        raise unknown_name("effect of the catalogue", name, tuple(_by_name()))
    return found
