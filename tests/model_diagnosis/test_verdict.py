"""The verdict where nothing is found: about the data, about the car, or neither."""

import pytest

from model_diagnosis.effects.catalogue import EFFECTS
from model_diagnosis.evidence.excitation import DATA_GROUPS
from model_diagnosis.evidence.wrong_vehicle import WrongVehicle
from model_diagnosis.result import DataFault
from model_diagnosis.verdict import verdict_of

CAR = [effect.name for effect in EFFECTS if effect.group not in DATA_GROUPS]
SIGN = DataFault(kind="channel_sign", channel="yaw_rate", repaired=True, message="turned round")
MISSING = DataFault(kind="missing_channel", channel="yaw_rate", message="no log has it")


@pytest.mark.parametrize(("unseen", "verdict"), [(CAR[:20], "wrong_vehicle"), (CAR[:-2], "insufficient_data")])
def test_data_that_shows_hardly_one_effect_speaks_of_no_other_car(unseen, verdict):
    """A wheel on a rig has one load that is no car's: mass, height and place of its centre all follow it."""
    wrong = WrongVehicle(100.0, 0.0, (0, 1, 2), (20.0, -15.0, 6.0))
    assert verdict_of([], [], [], wrong, unseen, len(EFFECTS)) == verdict


@pytest.mark.parametrize(
    ("faults", "unseen", "verdict"),
    [
        ([], CAR[:20], "nothing_found"),
        ([MISSING], CAR[:20], "nothing_found"),
        ([SIGN], CAR[:20], "data_fault"),
        ([], CAR[:-10], "insufficient_data"),
        ([SIGN], CAR[:-10], "data_fault"),
        # a wheel on a rig: its loads are turned round, but that says nothing of the car
        ([SIGN], CAR[:-2], "insufficient_data"),
    ],
)
def test_nothing_found_is_one_of_three_answers(faults, unseen, verdict):
    assert verdict_of([], [], faults, None, unseen, len(EFFECTS)) == verdict


@pytest.mark.parametrize(
    ("far_off", "selected_evidence", "selected_cost", "is_incomplete", "beats"),
    [
        (3, 90.0, -50.0, False, True),
        (2, 90.0, 50.0, True, False),  # two numbers that are off are two causes
        (3, 110.0, 50.0, False, False),
        # a full answer that lacks another number of the car
        (3, 110.0, 50.0, True, True),
        (3, 110.0, -50.0, True, False),
    ],
)
def test_another_car_says_more_or_fits_better_than_a_full_answer(
    far_off: int, selected_evidence: float, selected_cost: float, is_incomplete: bool, beats: bool
) -> None:
    wrong = WrongVehicle(100.0, 0.0, tuple(range(far_off)), (20.0,) * far_off)
    assert wrong.beats(selected_evidence, selected_cost, is_incomplete) is beats
