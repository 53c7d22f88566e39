"""Which deviations of an effect may be present together, and how its prior probability is shared among them."""

import numpy as np
from linear_car import LinearCar, effect

from model_diagnosis.effects import catalogue
from model_diagnosis.evidence.hypotheses import hypotheses_of


def _choices(car: LinearCar, name: str) -> dict[tuple[str, ...], float]:
    found = [one for one in hypotheses_of(car) if car.effects[one.effect].name == name]
    return {tuple(car.columns[column] for column in one.columns): one.share for one in found}


def test_the_two_circuits_of_a_brake_fail_one_at_a_time() -> None:
    """That is what there are two for; a pressure that is low in both is a sensor's or the supply's."""
    car = LinearCar([catalogue.effect("circuit_failure"), effect("wheels", 4)], np.zeros(6), seed=1)
    assert _choices(car, "circuit_failure") == {("circuit_failure.first",): 0.5, ("circuit_failure.second",): 0.5}
    assert len(_choices(car, "wheels")) == 5
    assert sum(_choices(car, "wheels").values()) == 1.0
