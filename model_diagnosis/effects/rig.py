"""What one wheel on a rig can show of the catalogue: effects of its tyre, and forms of the rig's own sensors."""

from collections.abc import Collection
from dataclasses import replace

from model_diagnosis.effects.effect import Effect
from model_diagnosis.effects.form import FORM_EFFECTS, FORM_RIG_EFFECTS
from model_diagnosis.effects.tyre import TYRE_EFFECTS

AXLES = ("front", "rear")

_OF_A_WHEEL = (
    "tyre_friction",
    "tyre_longitudinal_stiffness",
    "tyre_cornering_stiffness",
    "tyre_load_sensitivity",
    "tyre_relaxation_length",
    "tyre_peak_shape",
    "tyre_temperature_fade",
    "tyre_velocity_fade",
    "tyre_camber_conicity",
)
"""Those whose forces follow from slips, load and speed; radius and rolling resistance act on a spin that a rig sets."""

_FORMS_OF_A_WHEEL = ("form_transient",)


def rig_effects(axles: Collection[str]) -> tuple[Effect, ...]:
    """Effects of wheels of these axles, without the parameters of the other one."""
    of_tyre = [effect for effect in TYRE_EFFECTS if effect.name in _OF_A_WHEEL]
    of_form = [effect for effect in FORM_EFFECTS if effect.name in _FORMS_OF_A_WHEEL]
    return tuple(_of_axles(effect, axles) for effect in (*of_tyre, *of_form, *FORM_RIG_EFFECTS))


def _of_axles(effect: Effect, axles: Collection[str]) -> Effect:
    kept = tuple(one for one in effect.parameters if one.name not in AXLES or one.name in axles)
    return effect if kept == effect.parameters else replace(effect, parameters=kept)
