"""Effects outside the singles: those that the shipped manoeuvres do not excite, and those of one manoeuvre only."""

from hidden_effects.car import Numbers
from hidden_effects.effects import EFFECTS, HiddenEffect


def _fade(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["pad_fade"] = car["pad_fade"] + deviation


def _pump(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["pump_rate"] = car["pump_rate"] * (1.0 + deviation)


def _friction_step(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """From 45 m after the start of the manoeuvre the road has another friction."""
    car["friction_step_at"] += 45.0 - car["friction_step_at"]
    car["friction_step"] = car["friction_step"] * (1.0 + deviation)


UNEXCITED: tuple[HiddenEffect, ...] = (
    # no disc reaches the 300 degC at which fade begins
    HiddenEffect("brake_pad_fade", "brake", "1/K", False, 1e-4, 20, (1,), _fade),
    # the accumulators never fill, so what the pump takes out shows nowhere
    HiddenEffect("pump_rate", "hydraulics", "1", True, 0.05, 10, (-1,), _pump),
)

VISIBLE_IN_ONE: tuple[HiddenEffect, ...] = (
    HiddenEffect("mu_step", "road", "1", True, 0.03, 14, (-1,), _friction_step),
    *(effect for effect in EFFECTS if effect.name in ("road_grade", "head_wind")),
)
