"""The numbers of a car as a vehicle file takes them: another car's, or this one's within its scatter."""

from model_diagnosis.evidence.answer import INTERVAL_STD
from model_diagnosis.evidence.car_numbers import CarNumbers
from model_diagnosis.extension.extended_vehicle import FoundEffect, Interval
from model_diagnosis.replay.base import ReplayBase
from model_diagnosis.result import Gain


def numbers_of(replay: ReplayBase, numbers: CarNumbers | None, gain: Gain | None) -> list[FoundEffect]:
    """Every number of the car as an effect of its own, with the 90 % interval of what the data say."""
    if numbers is None:
        return []
    left = "" if gain is None else f"error left on data that took no part: {100 * gain.overall.ratio:.0f} %"
    deviations: dict[int, dict[str, Interval]] = {}
    for column, std in zip(numbers.columns, numbers.std, strict=True):
        value, reach = float(numbers.theta[column]), INTERVAL_STD * std
        interval = Interval(value, value - reach, value + reach)
        deviations.setdefault(int(replay.owner[column]), {})[replay.parameters[column].name] = interval
    return [
        FoundEffect(replay.effects[number], found, evidence=left)
        for number, found in deviations.items()
        if any(one.value != 0.0 for one in found.values())
    ]
