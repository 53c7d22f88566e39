"""Effects outside the singles: those that the shipped manoeuvres do not excite, and those of one manoeuvre only."""

from hidden_effects.car import Numbers
from hidden_effects.effects import EFFECTS, HiddenEffect


def _fade(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["pad_fade"] = car["pad_fade"] + deviation


def _tyre_heat(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["friction_heat_loss"] = car["friction_heat_loss"] + deviation


def _friction_step(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """From 45 m after the start of the manoeuvre the road has another friction."""
    car["friction_step_at"] += 45.0 - car["friction_step_at"]
    car["friction_step"] = car["friction_step"] * (1.0 + deviation)


UNEXCITED: tuple[HiddenEffect, ...] = (
    # no disc reaches the 300 degC at which fade begins
    HiddenEffect("brake_pad_fade", "brake", "1/K", False, 1e-4, 20, (1,), _fade),
    # the treads warm by a few degrees only
    HiddenEffect("tyre_temperature_fade", "tyre", "1/K^2", False, 2e-6, 20, (1,), _tyre_heat),
)

VISIBLE_IN_ONE: tuple[HiddenEffect, ...] = (
    HiddenEffect("mu_step", "road", "1", True, 0.03, 14, (-1,), _friction_step),
    *(effect for effect in EFFECTS if effect.name in ("road_grade", "head_wind")),
)
