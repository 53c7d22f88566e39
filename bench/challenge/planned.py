"""Whether the manoeuvre or sensor that a diagnosis proposes separates what it could not: the case recorded again."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.challenge.answering import answer_case
from bench.challenge.generator import record_further
from bench.challenge.scoring import named_causes

LOOK_ALIKES = "confounded"
"""Family whose right answer is a group."""

_SENSOR = "sensor:"

_RECORDED_AS = {"reference_pressure": "master_pressure"}
"""Proposed sensor -> channel of the hidden car: while the inlet valves are open the gauge of the master cylinder is a
second one of the wheels' fluid. Other sensors have the channel's name."""


def separated_by_plan(
    folder: Path,
    label: Mapping[str, Any],
    diagnosis: Mapping[str, Any],
    *,
    seed: int,
    index: int,
    family: str | None,
    generator: str,
) -> bool | None:
    """Whether the true effect stands alone once the proposed data is there; None without a group or a proposal.

    Parameters
    ----------
    folder : empty one, for the case with more data
    """
    proposal = diagnosis.get("next_manoeuvre")
    causes = named_causes(diagnosis)
    if proposal is None or not causes or len(causes[0]["group"]) < 2:
        return None
    name = str(proposal["name"])
    channel = channel_of(name)
    script = None if channel else _script(folder, name)
    if script is None and not channel:
        return False
    record_further(
        folder / "case", seed=seed, index=index, family=family, generator=generator, script=script, channel=channel
    )
    answer = answer_case(folder / "case").get("diagnosis")
    again = named_causes(answer) if answer is not None else []
    truth = label["effects"][0]["name"]
    return bool(again) and again[0]["effect"] == truth and label["twin"] not in again[0]["group"]


def channel_of(proposal: str) -> str:
    """Channel that the hidden car records for a proposed sensor; "" for a manoeuvre."""
    if not proposal.startswith(_SENSOR):
        return ""
    sensor = proposal.removeprefix(_SENSOR)
    return _RECORDED_AS.get(sensor, sensor)


def _script(folder: Path, name: str) -> Path | None:
    """The planned manoeuvre as the driver's pedal, steering and torque; None for one that is not in the library."""
    from model_diagnosis.evidence.manoeuvre_library import LIBRARY
    from model_diagnosis.manoeuvre import SAMPLE_TIME_S
    from vehicle_model import load_vehicle

    planned = next((one for one in LIBRARY if one.name == name), None)
    if planned is None:
        return None
    gain = load_vehicle("ekf_car").brakes.booster_gain
    time, inputs = planned.inputs("r")
    table = {
        "name": name,
        "speed": planned.speed,
        "time": [*time.tolist(), float(time[-1]) + SAMPLE_TIME_S],
        "pedal": _held(inputs["brake_pressure_fl"] / gain),
        "steering_wheel": _held(inputs["steering_wheel_angle"]),
        "drive_torque": _held(inputs["drive_torque_r"]),
    }
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(table), encoding="utf-8")
    return path


def _held(values: Any) -> list[float]:
    """Values with the last one once more, for the end of the last step."""
    return [*values.tolist(), float(values[-1])]
