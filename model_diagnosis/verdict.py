"""The verdict, from what was found."""

from collections.abc import Sequence

from model_diagnosis.effects.catalogue import EFFECTS
from model_diagnosis.evidence.excitation import DATA_GROUPS
from model_diagnosis.evidence.wrong_vehicle import WrongVehicle
from model_diagnosis.result import Cause, DataFault, DiscoveredTerm, Verdict

UNSHOWN_SHARE = 0.5
"""Nothing found on data that does not excite this share of the catalogue's effects is no finding."""

BLIND_SHARE = 0.9
"""Data that shows hardly one effect of the car can neither acquit the car nor say that it is another one.

Several numbers far off are then one number, said by several that the data cannot tell apart.
"""

OF_THE_CAR = sum(effect.group not in DATA_GROUPS for effect in EFFECTS)
"""Effects that the sensitivities answer for, not the checks of the data."""

NOT_A_FAULT = ("missing_channel",)
"""Kinds that are told with the faults of the data but leave the rest of it good."""


def verdict_of(
    causes: Sequence[Cause],
    terms: Sequence[DiscoveredTerm],
    faults: Sequence[DataFault],
    wrong: WrongVehicle | None,
    insufficient: Sequence[str],
    effects: int,
) -> Verdict:
    """One word for the answer; the worst about the model first, then about the data."""
    blind = len(insufficient) > BLIND_SHARE * min(OF_THE_CAR, effects)  # a wheel on a rig shows a tyre's only
    if wrong is not None:
        return "insufficient_data" if blind else "wrong_vehicle"
    if causes:
        return "indistinguishable" if len(causes[0].group) > 1 else "effect_found"
    if terms:
        return "effect_found"
    if blind:
        return "insufficient_data"
    if any(fault.kind not in NOT_A_FAULT for fault in faults):
        return "data_fault"
    if len(insufficient) > UNSHOWN_SHARE * effects:
        return "insufficient_data"
    return "nothing_found"
