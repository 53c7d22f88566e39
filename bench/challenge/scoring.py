"""Score of one case: answer against label."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.challenge.parameters import estimate_of

NAMED_FROM = 0.5
"""Probability from which a first cause counts as named."""
LARGEST_GROUP = 3
SEPARABLE_FROM = 3.0
"""Expected log evidence from which a group would have had to be told apart."""
SMALLEST_PROBABILITY = 1e-3

Separate = Callable[[int, Sequence[str]], list[dict[str, float | None]]]
"""Number of a case and names of rivals to the expected evidence of each hidden effect against them."""


@dataclass
class CaseScore:
    """What a case contributes to the figures; None where it says nothing.

    Attributes
    ----------
    first, in_group : the true cause is the first; it is in a justified group of the first
    grouped : the answer is a group of more than one
    false_alarm : a cause or term was named where none was hidden
    parameter_error : |found / true − 1| of the physical value of a rightly named cause
    covered : its 90 % interval holds the true value
    value_std : smallest standard deviation of an estimate of that value over it, by the generator's own theory
    stated : (probability, right) of each statement "this is the cause"
    log_score : log of the probability given to the truth
    """

    case: str
    family: str
    hidden: str
    units: float
    answer: str
    first: bool | None = None
    in_group: bool | None = None
    grouped: bool = False
    justified: bool | None = None
    false_alarm: bool | None = None
    both: bool | None = None
    fault_named: bool | None = None
    physics_named: bool | None = None
    fault_invented: bool | None = None
    right_verdict: bool | None = None
    separated: bool | None = None
    variables: bool | None = None
    parameter_error: float | None = None
    covered: bool | None = None
    value_std: float | None = None
    gain_share: float | None = None
    stated: list[tuple[float, bool]] = field(default_factory=list)
    log_score: float | None = None
    seconds: float = 0.0
    error: str = ""


def score_case(
    case: str, index: int, label: Mapping[str, Any], answer: Mapping[str, Any], separate: Separate
) -> CaseScore:
    """Score one answer; ``separate`` is asked only where a group has to be justified."""
    diagnosis = answer.get("diagnosis") or {"verdict": "none", "causes": [], "data_faults": [], "discovered_terms": []}
    effects = label["effects"]
    score = CaseScore(
        case=case,
        family=label["family"],
        hidden=_hidden(label),
        units=max((effect["units"] for effect in effects), default=0.0),
        answer=_answered(diagnosis),
        seconds=float(answer.get("seconds", 0.0)),
        error=str(answer.get("error", "")),
    )
    score.stated = _stated(diagnosis, label)
    _FAMILIES[label["family"]](score, index, label, diagnosis, separate)
    return score


def named_causes(diagnosis: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Causes that count as named."""
    return [cause for cause in diagnosis["causes"] if _probability_of_group(cause) >= NAMED_FROM]


def _probability_of_group(cause: Mapping[str, Any]) -> float:
    """Probability of a cause or of what cannot be told from it."""
    members = cause.get("group_probabilities") or {}
    return max(float(cause["probability"]), min(sum(members.values()), 1.0))


def _hidden(label: Mapping[str, Any]) -> str:
    if label["effects"]:
        return " + ".join(effect["name"] for effect in label["effects"])
    if label["data_fault"] is not None:
        return str(label["data_fault"]["kind"])
    if label["unknown"] is not None:
        return f"unknown: {label['unknown']['kind']}"
    return "wrong vehicle" if label["wrong_car"] else "nothing"


def _answered(diagnosis: Mapping[str, Any]) -> str:
    """The first named cause, else the first discovered term, else the verdict."""
    causes = named_causes(diagnosis)
    if diagnosis["verdict"] in ("wrong_vehicle", "none"):
        return str(diagnosis["verdict"]).replace("_", " ")
    if causes:
        return str(causes[0]["effect"])
    if diagnosis["discovered_terms"]:
        return "discovered term"
    return "nothing"


def _stated(diagnosis: Mapping[str, Any], label: Mapping[str, Any]) -> list[tuple[float, bool]]:
    """Probabilities stated for single effects, with their truth; the members of a group count each."""
    truth = {effect["name"] for effect in label["effects"]}
    stated: list[tuple[float, bool]] = []
    for cause in diagnosis["causes"]:
        members = cause.get("group_probabilities") or {cause["effect"]: cause["probability"]}
        stated += [(float(probability), name in truth) for name, probability in members.items()]
    return stated


def _log_score(diagnosis: Mapping[str, Any], name: str) -> float:
    best = 0.0
    for cause in diagnosis["causes"]:
        members = cause.get("group_probabilities") or {cause["effect"]: cause["probability"]}
        best = max(best, float(members.get(name, 0.0)))
    return math.log(max(best, SMALLEST_PROBABILITY))


def _fault_kinds(diagnosis: Mapping[str, Any]) -> set[str]:
    return {str(fault["kind"]) for fault in diagnosis["data_faults"]}


def _judge_effect(
    score: CaseScore,
    index: int,
    number: int,
    label: Mapping[str, Any],
    diagnosis: Mapping[str, Any],
    separate: Separate,
) -> tuple[bool, bool]:
    """Whether effect ``number`` of the label is named by a cause, and whether by a cause or its justified group."""
    name = label["effects"][number]["name"]
    if name in _fault_kinds(diagnosis):
        return True, True
    if any(cause["effect"] == name for cause in named_causes(diagnosis)):
        return True, True
    for cause in named_causes(diagnosis):
        if name in cause["group"] and len(cause["group"]) <= LARGEST_GROUP:
            score.justified = _justified(index, number, name, cause["group"], separate)
            return False, score.justified
    return False, False


def _justified(index: int, number: int, name: str, group: Sequence[str], separate: Separate) -> bool:
    """True if the data cannot tell the truth from any other member of the group."""
    rivals = [member for member in group if member != name]
    evidence = separate(index, rivals)[number]
    return all((value := evidence.get(rival)) is not None and value < SEPARABLE_FROM for rival in rivals)


def _measure(score: CaseScore, effect: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> None:
    """Physical value and interval of a rightly named effect."""
    cause = next((cause for cause in named_causes(diagnosis) if cause["effect"] == effect["name"]), None)
    estimate = estimate_of(effect, cause["parameters"]) if cause is not None else None
    true = float(effect["value"])
    if estimate is None or true == 0.0:  # errors are relative
        return
    score.parameter_error = abs(estimate.value / true - 1.0)
    score.covered = estimate.low <= true <= estimate.high


def _single(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    effect = label["effects"][0]
    causes = named_causes(diagnosis)
    is_first = bool(causes) and causes[0]["effect"] == effect["name"]
    score.first = is_first or (not causes and effect["name"] in _fault_kinds(diagnosis))
    score.grouped = bool(causes) and len(causes[0]["group"]) > 1
    only_first = {**diagnosis, "causes": causes[:1]}
    score.in_group = score.first or _judge_effect(score, index, 0, label, only_first, separate)[1]
    score.log_score = _log_score(diagnosis, effect["name"])
    if is_first:
        _measure(score, effect, diagnosis)


def _confounded(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    """Right is the group that holds both."""
    wanted = {label["effects"][0]["name"], label["twin"]}
    causes = named_causes(diagnosis)
    score.grouped = bool(causes) and len(causes[0]["group"]) > 1
    score.right_verdict = (
        bool(causes) and wanted <= set(causes[0]["group"]) and len(causes[0]["group"]) <= LARGEST_GROUP
    )
    score.log_score = _log_score(diagnosis, label["effects"][0]["name"])


def _pair(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    judged = [_judge_effect(score, index, number, label, diagnosis, separate) for number in range(2)]
    score.both = all(group for _, group in judged)


def _clean(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    score.false_alarm = bool(diagnosis["causes"] or diagnosis["discovered_terms"]) or diagnosis["verdict"] == (
        "wrong_vehicle"
    )
    score.fault_invented = _invented(diagnosis, label)


def _data_fault(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    """The kind on one of its channels, or the lag within a sample or two; no cause may be named beside it."""
    hidden = label["data_fault"]
    kind = hidden["kind"]
    causes = [cause["effect"] for cause in named_causes(diagnosis)]
    score.fault_named = kind in causes or any(_is_fault(fault, hidden, label) for fault in diagnosis["data_faults"])
    score.physics_named = any(effect != kind for effect in causes)
    if score.fault_named and not score.physics_named:
        score.answer = str(kind)


_LAGS = ("wheel_speed_delay", "can_latency", "clock_offset")
"""A lag has one name by what it touches: a channel, a message, a logger; a table does not tell which that is."""
_HELD = ("frame_drop_hold", "gps_hold")
_LAG_WITHIN_S = 0.03


def _is_fault(found: Mapping[str, Any], hidden: Mapping[str, Any], label: Mapping[str, Any]) -> bool:
    kind, value = hidden["kind"], float(hidden["value"])
    if kind in _LAGS:
        if "speed" in hidden["channels"]:  # the second logger is late in every case
            value += float(label["clock_offset_s"])
        lag = found.get("value")
        return found["kind"] in _LAGS and lag is not None and abs(abs(float(lag)) - value) <= _LAG_WITHIN_S
    same = found["kind"] == kind or {found["kind"], kind} <= set(_HELD)
    return same and any(channel in found["channel"] for channel in hidden["channels"])


def _invented(diagnosis: Mapping[str, Any], label: Mapping[str, Any]) -> bool:
    """True where a data fault is named that is not there; lost frames and the second logger's lag are."""
    offset = float(label["clock_offset_s"])
    for fault in diagnosis["data_faults"]:
        lag = fault.get("value")
        is_offset = fault["kind"] in _LAGS and lag is not None and abs(abs(float(lag)) - offset) <= _LAG_WITHIN_S
        if fault["kind"] != "missing_channel" and not is_offset:
            return True
    return False


def _unknown(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    text = " ".join(f"{term['formula']} {term['target']}" for term in diagnosis["discovered_terms"])
    words = set(re.findall(r"[A-Za-z_]+", text))
    score.variables = bool(words) and all(
        words & set(_VARIABLE_WORDS[variable]) for variable in label["unknown"]["variables"]
    )


def _per_wheel(*names: str) -> tuple[str, ...]:
    return tuple(f"{name}{wheel}" for name in names for wheel in ("", "_fl", "_fr", "_rl", "_rr"))


_VARIABLE_WORDS: dict[str, tuple[str, ...]] = {
    "speed": ("speed", "v", *_per_wheel("wheel_speed")),
    "yaw_rate": ("yaw_rate", "r"),
    "brake_torque": _per_wheel("brake_torque", "brake_pressure", "T_b", "p"),
    "brake_pressure": _per_wheel("brake_pressure", "pressure", "p"),
    "pressure_rate": _per_wheel("pressure_rate", "brake_pressure_rate"),
}
"""Names under which a formula may use the variable that a hidden term depends on."""


def _unexcited(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    """Nothing invented, and the effect is among those that this data does not excite."""
    told = label["effects"][0]["name"] in diagnosis.get("insufficient", [])
    score.right_verdict = told and not diagnosis["causes"]


def _wrong_vehicle(
    score: CaseScore, index: int, label: Mapping[str, Any], diagnosis: Mapping[str, Any], separate: Separate
) -> None:
    score.right_verdict = diagnosis["verdict"] == "wrong_vehicle"


_FAMILIES = {
    "single": _single,
    "detection": _single,
    "one_manoeuvre": _single,
    "confounded": _confounded,
    "pair": _pair,
    "clean": _clean,
    "data_fault": _data_fault,
    "unknown": _unknown,
    "unexcited": _unexcited,
    "wrong_vehicle": _wrong_vehicle,
}
