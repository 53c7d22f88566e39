"""``bench diagnose plan``: which manoeuvre tells causes apart."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.diagnosis.diagnosing import ANSWER_FILE, Progress
from bench.diagnosis_report.words import plain
from bench.report.formatting import number
from model_diagnosis.result import Diagnosis
from signals.errors import InputError
from signals.measured.channel_map import load_channel_map
from vehicle_model.vehicle_file import load_vehicle

if TYPE_CHECKING:
    from model_diagnosis.separating import Separation

SHOWN = 6


@dataclass(frozen=True)
class Plan:
    """Manoeuvres for a group of causes, the best first.

    Attributes
    ----------
    sensor : str or None
        What would separate them where no manoeuvre does.
    """

    effects: Sequence[str]
    ranked: "Sequence[Separation]"
    sensor: str | None


def planned(
    given: Sequence[str],
    vehicle: str | None,
    *,
    channels: Path | None = None,
    size: float = 1.0,
    progress: Progress | None = None,
) -> Plan:
    """Rank the manoeuvres of the library for the group of a diagnosis, or for effects by name.

    Raises
    ------
    InputError
        If there is no such diagnosis or effect, or nothing has to be told apart.
    """
    effects = _effects(given)
    if vehicle is None:
        raise InputError("a plan is made for a car", mend="give it: --vehicle NAME|FILE")
    from model_diagnosis.separating import USUAL_SIGNALS, sensor_for, separations

    car = load_vehicle(vehicle)
    signals = USUAL_SIGNALS if channels is None else tuple(load_channel_map(channels).channels)
    ranked = separations(car, effects, signals, size, progress)
    enough = bool(ranked) and ranked[0].enough
    return Plan(effects, ranked, None if enough else sensor_for(effects, signals))


def plan_text(plan: Plan) -> str:
    """A plan for people."""
    lines = [f"to tell apart: {', '.join(plain(name) for name in plan.effects)}", ""]
    width = max(len(one.name) for one in plan.ranked)
    lines += ["expected evidence (3 is enough, by the sensors' noise alone)"]
    for one in plan.ranked[:SHOWN]:
        mark = "✓" if one.enough else " "
        lines.append(f"{number(one.expected_evidence, 3):>8} {mark} {one.name:<{width}}  {one.description}")
    if not plan.ranked[0].enough:
        sensor = "a sensor would: " + plain(plan.sensor) if plan.sensor else "and no further sensor of the usual ones"
        lines += ["", f"no manoeuvre of the library separates them, {sensor}"]
    return "\n".join(lines)


def plan_json(plan: Plan) -> dict[str, Any]:
    """A plan as plain data."""
    return {
        "effects": list(plan.effects),
        "manoeuvres": [vars(one) | {"enough": one.enough} for one in plan.ranked],
        "sensor": plan.sensor,
    }


def _effects(given: Sequence[str]) -> list[str]:
    path = Path(given[0])
    file = path / ANSWER_FILE if path.is_dir() else path
    if len(given) > 1 or not (path.is_dir() or path.suffix == ".json"):
        return list(given)
    try:
        diagnosis = Diagnosis.model_validate(json.loads(file.read_text("utf-8")))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: no diagnosis ({str(error).splitlines()[0]})") from None
    group = next((cause.group for cause in diagnosis.causes if len(cause.group) > 1), None)
    if group is None:
        raise InputError(f"{file}: no cause of it stands in a group, nothing has to be told apart")
    return group
