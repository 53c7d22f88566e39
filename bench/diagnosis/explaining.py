"""The catalogue of effects for people: one effect in full, all of them as a list, and the page docs/effects.md."""

from collections.abc import Iterable
from typing import Any

from bench.report.formatting import number
from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from signals.wheels import WHEELS

APPLICATIONS = {
    Application.PLANT: "the car",
    Application.INPUT: "an input of the car",
    Application.SENSOR: "the sensors",
    Application.CLOCK: "the clocks of the data",
    Application.CONTROLLER: "the control unit",
}


def effect_text(effect: Effect) -> str:
    """Everything that the catalogue knows of an effect."""
    lines = [
        f"{effect.name}  ({effect.group.value}; acts on {APPLICATIONS[effect.application]})",
        f"  equation     {effect.equation}",
        f"  seen in      {signals_text(effect) or '-'}",
        f"  looks like   {', '.join(effect.confounded_with) or 'nothing else of the catalogue'}",
        f"  told apart   {effect.separating_manoeuvre or '-'}",
    ]
    lines += [f"  remark       {effect.remarks}"] if effect.remarks else []
    lines += [f"  source       {effect.source}"] if effect.source else []
    lines += ["", "  parameters, as deviations from the vehicle file (0 is neutral):"]
    for parameter in effect.parameters:
        lines += [
            f"    {parameter.name} [{unit_text(parameter)}]  {range_text(parameter)}",
            f"      an ordinary car is off by {scatter_text(parameter)}; where the effect is present by about "
            f"{_quantity(parameter.effect_std, parameter)}",
        ]
        lines += [f"      in the vehicle file: {parameter.vehicle_path}"] if parameter.vehicle_path else []
    return "\n".join(lines)


def effect_json(effect: Effect) -> dict[str, Any]:
    """The same as plain data."""
    return {
        "name": effect.name,
        "group": effect.group.value,
        "application": effect.application.value,
        "equation": effect.equation,
        "signals": list(effect.signals),
        "confounded_with": list(effect.confounded_with),
        "separating_manoeuvre": effect.separating_manoeuvre,
        "discrete": effect.discrete,
        "source": effect.source,
        "remarks": effect.remarks,
        "parameters": [vars(parameter) for parameter in effect.parameters],
    }


def catalogue_text(effects: Iterable[Effect]) -> str:
    """A line for each effect, by group."""
    listed = list(effects)
    width = max((len(effect.name) for effect in listed), default=0)
    lines = []
    for group in Group:
        members = [effect for effect in listed if effect.group is group]
        lines += [f"{group.value}", *(f"  {e.name:<{width}}  {e.equation}" for e in members)] if members else []
    return "\n".join([*lines, "", f"{len(listed)} effects; all of one: bench diagnose explain EFFECT"])


def effects_page(effects: Iterable[Effect]) -> str:
    """``docs/effects.md``."""
    listed = list(effects)
    lines = [
        "# Catalogue of effects",
        "",
        "What a simulation of a braking car usually gets wrong, and what the measuring chain adds: the causes that",
        "`bench diagnose` can name. Made from `model_diagnosis/effects/` by `python docs/generate.py`;",
        "`bench diagnose explain EFFECT` prints the same for one effect.",
        "",
        f"{len(listed)} effects with {sum(len(e.parameters) for e in listed)} parameters. A parameter is a deviation",
        "from the vehicle file whose value 0 is neutral: relative (in %), or in the unit given. *Ordinary* is how far",
        "a healthy car is off its file (one standard deviation; the file's own `scatter:` wins over it),",
        "*effect* the same where the effect is present. An effect is named only beyond the ordinary.",
        "",
    ]
    for group in Group:
        members = [effect for effect in listed if effect.group is group]
        if not members:
            continue
        lines += [f"## {group.value.capitalize()}", ""]
        for effect in members:
            lines += _section(effect)
    return "\n".join(lines).rstrip() + "\n"


def unit_text(parameter: EffectParameter) -> str:
    """Unit of a deviation; per cent where it is relative."""
    return "%" if _in_percent(parameter) else parameter.unit


def range_text(parameter: EffectParameter) -> str:
    """Bounds of a deviation."""
    factor = 100.0 if _in_percent(parameter) else 1.0
    unit = unit_text(parameter)
    ends = f"{number(factor * parameter.low, 3)} … {number(factor * parameter.high, 3)}"
    return ends if unit == "1" else f"{ends} {unit}"


def signals_text(effect: Effect) -> str:
    """Signals that show an effect; four wheels as one."""
    stems = [name[: -len(wheel)] + "*" for name in effect.signals for wheel in WHEELS if name.endswith(f"_{wheel}")]
    whole = {stem for stem in stems if stems.count(stem) == len(WHEELS)}
    shown = [stem if (stem := name[:-2] + "*") in whole else name for name in effect.signals]
    return ", ".join(dict.fromkeys(shown))


def scatter_text(parameter: EffectParameter) -> str:
    """How far an ordinary car is off."""
    return _quantity(parameter.ordinary_std, parameter) if parameter.ordinary_std > 0.0 else "nothing"


def _section(effect: Effect) -> list[str]:
    lines = [f"### `{effect.name}`", "", f"`{effect.equation}`", ""]
    lines.append(f"- acts on {APPLICATIONS[effect.application]}; seen in {signals_text(effect) or 'no signal'}")
    if effect.confounded_with:
        lines.append("- looks like " + ", ".join(f"`{name}`" for name in effect.confounded_with))
    if effect.separating_manoeuvre:
        lines.append(f"- told apart by: {effect.separating_manoeuvre}")
    if effect.remarks:
        lines.append(f"- {effect.remarks}")
    if effect.source:
        lines.append(f"- source: {effect.source}")
    lines += ["", "| parameter | deviation | ordinary | effect | in the vehicle file |", "|---|---|---|---|---|"]
    for parameter in effect.parameters:
        path = f"`{parameter.vehicle_path}`" if parameter.vehicle_path else ""
        lines.append(
            f"| `{parameter.name}` | {range_text(parameter)} | {scatter_text(parameter)} | "
            f"{_quantity(parameter.effect_std, parameter)} | {path} |"
        )
    return [*lines, ""]


def _in_percent(parameter: EffectParameter) -> bool:
    return parameter.relative and parameter.unit == "1"


def _quantity(value: float, parameter: EffectParameter) -> str:
    factor = 100.0 if _in_percent(parameter) else 1.0
    unit = unit_text(parameter)
    return f"{number(factor * value, 3)} {unit if unit != '1' else ''}".strip()
