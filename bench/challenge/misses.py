"""What is wrong with an answer, in words."""

from bench.challenge.figures import is_gain_reached, is_value_within
from bench.challenge.planned import LOOK_ALIKES
from bench.challenge.scoring import NAMED_FROM, CaseScore


def misses_of(score: CaseScore) -> list[str]:
    """Everything that counts against a case in the figures; empty where nothing does."""
    surplus = sum(probability >= NAMED_FROM and not right for probability, right in score.stated)
    wrong = {
        "not first, nor in a justified group": score.in_group is False,
        "false alarm": score.false_alarm,
        "not both": score.both is False,
        "fault not named": score.fault_named is False,
        "physics beside the fault": score.physics_named,
        "fault invented": score.fault_invented,
        "not its variables": score.variables is False,
        "wrong verdict": score.right_verdict is False,
        "not separated by the proposed data": score.separated is False,
        # a false alarm is surplus as a whole, and of look-alikes one has to be
        f"{surplus} surplus": surplus and score.family not in ("clean", LOOK_ALIKES),
    }
    words = [text for text, is_wrong in wrong.items() if is_wrong]
    if score.parameter_error is not None and not is_value_within(score):
        words.append(f"value {100 * score.parameter_error:.0f} % off")
    if score.gain_share is not None and not is_gain_reached(score):
        words.append(f"{100 * score.gain_share:.0f} % of the possible gain")
    return words
