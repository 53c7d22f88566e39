"""A diagnosis in words: headline, causes and parameters as people say them."""

import math
from dataclasses import dataclass

from bench.report.formatting import display, number
from model_diagnosis.result import Cause, Diagnosis, ParameterEstimate, Subject, Verdict
from signals.wheels import WHEELS

WHEEL_WORDS = dict(zip(WHEELS, ("front left", "front right", "rear left", "rear right"), strict=True))
BADGES: dict[Verdict, tuple[str, str]] = {
    "effect_found": ("fail", "effect found"),
    "nothing_found": ("pass", "nothing found"),
    "data_fault": ("inconclusive", "data fault"),
    "indistinguishable": ("inconclusive", "cannot be told apart"),
    "insufficient_data": ("inconclusive", "insufficient data"),
    "wrong_vehicle": ("fail", "wrong vehicle"),
}
SUBJECTS: dict[Subject, str] = {"car": "car", "wheel_on_rig": "tyre"}
DRIVEN: dict[Subject, str] = {"car": "inputs", "wheel_on_rig": "slips, load and speed of a rig"}
"""What drives the replay, as measured."""
REPLAYS: dict[Subject, str] = {"car": "observer replay", "wheel_on_rig": "replay"}
"""What the residuals are of."""
_SIGNAL_WORDS = {
    "longitudinal_acceleration": "longitudinal acceleration",
    "speed": "speed over ground",
}


@dataclass(frozen=True)
class ParameterText:
    """One parameter of a cause: its words, value, interval and the vehicle file's value, with the unit shown once."""

    name: str
    value: str
    interval: str
    nominal: str
    change: str


def plain(name: str) -> str:
    """Name of an effect, parameter or manoeuvre without underscores."""
    return name.replace("_", " ")


def signal_words(name: str) -> str:
    """Words for a signal: ``wheel_speed_fl`` → wheel speed front left."""
    stem, _, wheel = name.rpartition("_")
    if wheel in WHEEL_WORDS:
        return f"{plain(stem)} {WHEEL_WORDS[wheel]}"
    return _SIGNAL_WORDS.get(name, plain(name))


def shown(signal: str, unit: str) -> tuple[float, str]:
    """Factor and unit in which a signal is shown; wheel speeds stay in rad/s."""
    return (1.0, unit) if signal.startswith("wheel_speed") else display(1.0, unit)


def headline(diagnosis: Diagnosis) -> str:
    """One sentence that answers the question."""
    causes, subject = diagnosis.causes, SUBJECTS[diagnosis.subject]
    match diagnosis.verdict:
        case "effect_found":
            return (
                f"The {subject} differs from its vehicle file: {_and([_with_change(c) for c in accepted(diagnosis)])}."
            )
        case "indistinguishable":
            group = causes[0].group if causes else []
            return f"One of {_or([plain(name) for name in group])}; this data cannot tell which."
        case "nothing_found":
            return (
                f"The vehicle file explains the data: nothing goes beyond its stated scatter.{_own_numbers(diagnosis)}"
            )
        case "data_fault":
            faults = _and(list(dict.fromkeys(f"{plain(f.kind)} in {f.channel}" for f in diagnosis.data_faults)))
            return f"The data has a fault, the {subject} has none that shows: {faults}.{_own_numbers(diagnosis)}"
        case "wrong_vehicle":
            said = f"Several parameters are far off at once: this is probably not the {subject} of the vehicle file."
            own = " The extended vehicle file has the numbers that the data say."
            return said + (own if diagnosis.extension_file else "")
        case "insufficient_data":
            return f"This data cannot answer the question.{_own_numbers(diagnosis)}"


def _own_numbers(diagnosis: Diagnosis) -> str:
    """Sentence on an extended vehicle file without causes."""
    return " The extended vehicle file has this car's numbers within their scatter." if diagnosis.extension_file else ""


def parameter_texts(cause: Cause) -> list[ParameterText]:
    """Every parameter of a cause."""
    return [_parameter(name, estimate) for name, estimate in cause.parameters.items()]


def percent(probability: float) -> str:
    """Probability without false certainty: never 0 or 100 %."""
    value = 100.0 * probability
    if value >= 99.5:
        return "> 99 %"
    return "< 1 %" if value < 0.5 else f"{value:.0f} %"


def gain_words(ratio: float, low: float, high: float) -> str:
    """Error left over after the extension, with its interval."""
    return f"{100 * ratio:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"


def accepted(diagnosis: Diagnosis) -> list[Cause]:
    """Causes that stand together: those that are likelier than not, the first in any case."""
    likely = [cause for cause in diagnosis.causes if cause.probability >= 0.5]
    return likely or diagnosis.causes[:1]


def _with_change(cause: Cause) -> str:
    """Name with the change of its only parameter, if it has one only, and what this data cannot tell from it."""
    texts = parameter_texts(cause)
    words = texts[0].change or texts[0].value if len(texts) == 1 else ""
    others = [plain(name) for name in cause.group if name != cause.effect]
    return " or ".join([f"{plain(cause.effect)} {words}".strip(), *others])


def _parameter(name: str, estimate: ParameterEstimate) -> ParameterText:
    value, unit = display(estimate.value, estimate.unit)
    low, high, nominal = (
        display(quantity, estimate.unit)[0] for quantity in (estimate.low, estimate.high, estimate.nominal)
    )
    return ParameterText(
        name=plain(name),
        value=f"{number(value, 3)} {unit}".strip(),
        interval=f"{number(low, 3)} … {number(high, 3)}",
        nominal=f"{number(nominal, 3)} {unit}".strip(),
        change=_change(estimate),
    )


def _change(estimate: ParameterEstimate) -> str:
    """Change relative to the vehicle file, where its value is not zero."""
    if estimate.nominal == 0.0 or not math.isfinite(estimate.value):
        return ""
    percentage = 100.0 * (estimate.value / estimate.nominal - 1.0)
    return f"{'+' if percentage > 0 else '−'}{number(abs(round(percentage, 1)))} %"


def _and(names: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]])) if names else "nothing that has a name"


def _or(names: list[str]) -> str:
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]])) if names else "several causes"
