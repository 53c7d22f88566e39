"""What counts against a case, in words."""

from dataclasses import replace

from bench.challenge.misses import misses_of
from bench.challenge.scoring import CaseScore

SINGLE = CaseScore("case_0000", "single", "aero_drag", 6.0, "aero_drag", first=True, in_group=True)


def test_nothing_is_wrong_with_a_right_answer() -> None:
    assert misses_of(replace(SINGLE, parameter_error=0.1, gain_share=0.85, stated=[(1.0, True), (0.49, False)])) == []


def test_value_gain_and_surplus_causes() -> None:
    wrong = replace(SINGLE, parameter_error=0.2, gain_share=0.5, stated=[(1.0, True), (0.99, False)])
    assert misses_of(wrong) == ["1 surplus", "value 20 % off", "50 % of the possible gain"]


def test_four_fifths_of_the_gain_are_enough_for_an_unknown_term() -> None:
    unknown = CaseScore("case_0001", "unknown", "unknown: power", 0.0, "discovered term", variables=True)
    assert misses_of(replace(unknown, gain_share=0.81)) == []
    assert misses_of(replace(unknown, gain_share=0.79)) == ["79 % of the possible gain"]


def test_a_fault_that_is_not_named_and_a_false_alarm() -> None:
    fault = CaseScore("case_0002", "data_fault", "channel_swap", 0.0, "nothing", fault_named=False, physics_named=False)
    assert misses_of(fault) == ["fault not named"]
    clean = CaseScore("case_0003", "clean", "nothing", 0.0, "aero_drag", false_alarm=True, stated=[(0.9, False)])
    assert misses_of(clean) == ["false alarm"]
