"""What a diagnosis tells beside its answer: what was accepted and refused, how far numbers are off, what is missing."""

from model_diagnosis.discovery.unknown import FoundUnknown
from model_diagnosis.evidence.selection import Selection
from model_diagnosis.evidence.wrong_vehicle import WrongVehicle
from model_diagnosis.replay import Replay, ReplayBase

OF_A_CAR_ONLY = "violated equations, unknown terms, plan of the next manoeuvre and stops with the control unit"


def remarks_of(
    replay: ReplayBase, selection: Selection, wrong: WrongVehicle | None, unknown: FoundUnknown | None
) -> list[str]:
    """Remarks in the order of the steps; ``wrong`` only where that is the answer."""
    remarks = list(selection.decisions)
    if unknown:
        remarks += unknown.selection.decisions
        remarks.append(f"{unknown.term.formula}: log evidence {unknown.evidence:.1f}, its price paid")
        remarks += [
            f"{unknown.term.formula}: on this data the same as {name} ({value:.2f})"
            for name, value in unknown.same_as.items()
        ]
    if wrong is not None:
        for column, deviation in zip(wrong.far_off, wrong.deviations, strict=True):
            remarks.append(f"{replay.columns[column]} is {deviation:+.1f} times its scatter off the vehicle file")
    if not isinstance(replay, Replay):
        remarks.append(f"{OF_A_CAR_ONLY}: not for a wheel on a rig")
    if len(replay.manoeuvres) == 1:
        remarks.append("one manoeuvre only: nothing is left to check the answer on")
    return remarks
