"""The house of equations: the model's balances stacked as they carry each other, the violated one lit."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from markupsafe import Markup, escape

from bench.diagnosis_report.words import WHEEL_WORDS, plain
from bench.report.formatting import number
from model_diagnosis.replay.disturbances import ALIKE
from model_diagnosis.result import LIT_RATIO, ViolatedEquation
from signals.wheels import WHEELS

WIDTH = 720
ROOF_HEIGHT, FLOOR_HEIGHT, GAP = 96, 70, 10
LEAST_RATIO = LIT_RATIO
"""Likelihood ratio below which a balance counts as kept."""


@dataclass(frozen=True)
class Room:
    """One balance: its key among the likelihood ratios, what the box says, and the balance as a formula."""

    key: str
    title: str
    formula: str


FLOORS: tuple[tuple[Room, ...], ...] = (
    (
        Room("longitudinal force", "longitudinal force", "m (v̇ₓ − v_y r) = Σ Fₓ − drag"),
        Room("lateral force", "lateral force", "m (v̇_y + vₓ r) = Σ F_y"),
        Room("yaw moment", "yaw moment", "I_z ṙ = Σ (x F_y − y Fₓ)"),
    ),
    (Room("load transfer", "load transfer", "F_z = shares of m g, moved by h aₓ and h a_y"),),
    (Room(ALIKE, "wheels of an axle alike", "J ω̇ = T_d − T_b − R Fₓ at the left and at the right, one error"),),
    tuple(Room(f"wheel torque {w}", f"wheel {WHEEL_WORDS[w]}", "J ω̇ = T_d − T_b − R Fₓ") for w in WHEELS),
    tuple(Room(f"hydraulics {w}", f"brake {WHEEL_WORDS[w]}", "ṗ = E(p) q(Δp, valves)") for w in WHEELS),
)
ROOF = Room("sensor chain", "sensor chain", "y = s x(t − τ) + offset + noise")


def house_of_equations(
    equation_errors: Mapping[str, float], innovations: Mapping[str, ViolatedEquation] | None = None
) -> Markup:
    """Draw the house; empty where nothing was localised.

    Parameters
    ----------
    equation_errors : mapping
        Balance -> likelihood ratio of "this balance has an error of its own" against "it has none", by equation error.
    innovations : mapping, optional
        The same by the innovations of the stochastic replay, which light the rooms where they are there.
    """
    by_innovations = {name: one.likelihood_ratio for name, one in (innovations or {}).items()}
    if not equation_errors and not by_innovations:
        return Markup("")
    ratios, beside = grouped(by_innovations or equation_errors), grouped(equation_errors)
    highest = max(ratios.values())
    height = ROOF_HEIGHT + GAP + (FLOOR_HEIGHT + GAP) * len(FLOORS) + 6
    label = f"house of equations; most violated: {max(ratios, key=lambda key: ratios[key])}"
    parts = [f'<svg class="house" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{escape(label)}">']
    parts.append(_roof(ratios.get(ROOF.key), highest, _numbers(ROOF, ratios, beside, by_innovations)))
    for level, rooms in enumerate(FLOORS):
        top = ROOF_HEIGHT + GAP + level * (FLOOR_HEIGHT + GAP)
        width = (WIDTH - GAP * (len(rooms) - 1)) / len(rooms)
        for place, room in enumerate(rooms):
            text = _numbers(room, ratios, beside, by_innovations)
            parts.append(_room(room, ratios.get(room.key), highest, place * (width + GAP), top, width, text))
    return Markup("".join([*parts, "</svg>"]))


def grouped(likelihood_ratios: Mapping[str, float]) -> dict[str, float]:
    """Ratios of the rooms; whatever is no balance of the house belongs to the sensor chain, the largest counts."""
    rooms = {room.key for floor in FLOORS for room in floor}
    ratios: dict[str, float] = {}
    for name, ratio in likelihood_ratios.items():
        key = plain(name)
        key = key if key in rooms else ROOF.key
        ratios[key] = max(ratio, ratios.get(key, -math.inf))
    return ratios


def outside(likelihood_ratios: Mapping[str, float]) -> list[tuple[str, float]]:
    """Violated balances without a room of their own, the most violated first."""
    rooms = {room.key for floor in FLOORS for room in floor} | {ROOF.key}
    found = [(name, ratio) for name, ratio in likelihood_ratios.items() if plain(name) not in rooms]
    return sorted((entry for entry in found if entry[1] > LEAST_RATIO), key=lambda entry: -entry[1])


def brightness(ratio: float | None, highest: float) -> float:
    """0 for a balance that is kept, up to 1 for the most violated, by the logarithm of the ratio."""
    if ratio is None or ratio <= LEAST_RATIO or highest <= LEAST_RATIO:
        return 0.0
    return 0.15 + 0.85 * (math.log(ratio / LEAST_RATIO) / math.log(highest / LEAST_RATIO) if highest > ratio else 1.0)


def _roof(ratio: float | None, highest: float, text: str) -> str:
    outline = f"{WIDTH / 2},2 {WIDTH - 2},{ROOF_HEIGHT} 2,{ROOF_HEIGHT}"
    return (
        f'<g class="{_state(ratio, highest)}"><polygon class="wall" points="{outline}"/>'
        f'<polygon class="light" points="{outline}" fill-opacity="{brightness(ratio, highest):.2f}"/>'
        f"{_texts(ROOF, text, WIDTH / 2, ROOF_HEIGHT - 44)}</g>"
    )


def _room(room: Room, ratio: float | None, highest: float, left: float, top: float, width: float, text: str) -> str:
    box = f'x="{left + 1:.1f}" y="{top + 1:.1f}" width="{width - 2:.1f}" height="{FLOOR_HEIGHT - 2}" rx="6"'
    return (
        f'<g class="{_state(ratio, highest)}"><rect class="wall" {box}/>'
        f'<rect class="light" {box} fill-opacity="{brightness(ratio, highest):.2f}"/>'
        f"{_texts(room, text, left + width / 2, top + 24)}</g>"
    )


def _numbers(
    room: Room, ratios: Mapping[str, float], beside: Mapping[str, float], by_innovations: Mapping[str, float]
) -> str:
    """Likelihood ratios of a room: by innovations, and by equation error."""
    if room.key not in ratios and room.key not in beside:
        return "not seen in this data"
    if not by_innovations:
        return f"LR {_ratio_text(ratios[room.key])}"
    return " · ".join(
        f"{word} {_ratio_text(values[room.key])}" if room.key in values else f"{word} –"
        for word, values in (("LR", ratios), ("by balance", beside))
    )


def _ratio_text(ratio: float) -> str:
    return number(round(max(ratio, 0.0), 1), 3)


def _texts(room: Room, text: str, x: float, y: float) -> str:
    return (
        f'<text class="name" x="{x:.1f}" y="{y:.1f}" text-anchor="middle">{escape(room.title)}</text>'
        f'<text class="formula" x="{x:.1f}" y="{y + 18:.1f}" text-anchor="middle">{escape(room.formula)}</text>'
        f'<text class="ratio" x="{x:.1f}" y="{y + 35:.1f}" text-anchor="middle">{escape(text)}</text>'
    )


def _state(ratio: float | None, highest: float) -> str:
    if ratio is None:
        return "unseen"
    return "guilty" if ratio >= highest and ratio > LEAST_RATIO else "lit" if ratio > LEAST_RATIO else "kept"
