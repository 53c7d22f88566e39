"""Which parameter of a named cause is the one that the generator changed, and its value in the label's terms."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from model_diagnosis.effects.conditions import everywhere
from signals.errors import BenchError

_BY_EFFECT = {
    "tyre_friction": "front",
    "tyre_peak_shape": "sliding_loss",
    "tyre_camber_conicity": "conicity",
    "rolling_resistance": "constant",
    "wheel_radius_load": "speed",
    "spring_rate": "front",
    "damper_rate": "front",
    "anti_roll_bar": "front",
    "roll_centre_height": "front",
    "driveline_drag": "viscous",
    "differential_locking": "preload",
    "accelerometer_offset": "longitudinal",
    "accelerometer_scale": "longitudinal",
    "mu_step": "level",
    "brake_pad_fade": "coefficient",
}
"""Parameter that holds the change, for effects with several that are not told apart by a wheel or an axle."""


@dataclass(frozen=True)
class Estimate:
    """Value and 90 % interval in the label's terms."""

    value: float
    low: float
    high: float


def estimate_of(effect: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Any]]) -> Estimate | None:
    """Estimate of a label's effect from the parameters of a cause; None where the cause has none for it.

    A relative effect's label is the physical value over the data sheet's, an absolute one's the physical value.

    Raises
    ------
    BenchError
        If the label's value is in another unit than the cause's: the two would be compared as if they were alike.
    """
    if effect["name"] == "disc_thickness_variation":
        return _amplitude(str(effect["place"]), parameters)
    found = _parameter(effect, parameters)
    if found is None:
        return None
    value, low, high, nominal = (float(found[key]) for key in ("value", "low", "high", "nominal"))
    if not effect["relative"]:
        if found["unit"] != effect["unit"]:
            raise BenchError(
                f"the generator states {effect['name']} in another unit than the catalogue",
                found=str(effect["unit"]),
                allowed=str(found["unit"]),
                mend="state it in the catalogue's unit",
            )
        return Estimate(value, low, high)
    if nominal == 0.0:
        return Estimate(1.0 + value, 1.0 + low, 1.0 + high)
    ends = sorted((low / nominal, high / nominal))
    return Estimate(value / nominal, ends[0], ends[1])


def _parameter(effect: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Any]]) -> Mapping[str, Any] | None:
    if len(parameters) == 1:
        name = next(iter(parameters))
        place = str(effect["place"])
        return parameters[name] if place in ("", name) or name not in _PLACES else None
    parameters = {everywhere(name): found for name, found in parameters.items()}
    place = str(effect["place"])
    for name in (place, _FIRST_WHEEL.get(place, ""), _BY_EFFECT.get(str(effect["name"]), "")):
        if name in parameters:
            return parameters[name]
    return None


_FIRST_WHEEL = {"front": "fl", "rear": "rl"}
"""Of an axle, for effects that act on both of its wheels and are told by wheel."""

_PLACES = ("fl", "fr", "rl", "rr", "front", "rear")


def _amplitude(place: str, parameters: Mapping[str, Mapping[str, Any]]) -> Estimate | None:
    """Amplitude from sine and cosine parts; its interval from theirs."""
    parts = [parameters.get(f"{place}_{part}") for part in ("sine", "cosine")]
    known = [part for part in parts if part is not None]
    if not known:
        return None
    value = math.hypot(*(float(part["value"]) for part in known))
    half = max(0.5 * (float(part["high"]) - float(part["low"])) for part in known)
    return Estimate(value, value - half, value + half)
