"""The numbers of another car: what a vehicle file would have to say where several of its numbers are far off."""

from model_diagnosis.evidence.answer import INTERVAL_STD
from model_diagnosis.evidence.wrong_vehicle import WrongVehicle
from model_diagnosis.extension.extended_vehicle import FoundEffect, Interval
from model_diagnosis.replay.base import ReplayBase
from model_diagnosis.result import Gain


def numbers_of(replay: ReplayBase, wrong: WrongVehicle, gain: Gain | None) -> list[FoundEffect]:
    """Every number of the car as an effect of its own, with the 90 % interval of what the data say."""
    if wrong.theta is None:
        return []
    left = "" if gain is None else f"error left on data that took no part: {100 * gain.overall.ratio:.0f} %"
    deviations: dict[int, dict[str, Interval]] = {}
    for column, std in zip(wrong.numbers, wrong.std, strict=True):
        value, reach = float(wrong.theta[column]), INTERVAL_STD * std
        interval = Interval(value, value - reach, value + reach)
        deviations.setdefault(int(replay.owner[column]), {})[replay.parameters[column].name] = interval
    return [
        FoundEffect(replay.effects[number], found, evidence=left)
        for number, found in deviations.items()
        if any(one.value != 0.0 for one in found.values())
    ]
