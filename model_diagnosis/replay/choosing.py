"""Which replay a log is for: of a car, or of one wheel on a rig."""

from collections.abc import Sequence

from model_diagnosis.data.rig import is_on_rig
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.rig import RigReplay


def replay_class(manoeuvres: Sequence[Manoeuvre]) -> type[Replay] | type[RigReplay]:
    """``RigReplay`` where every manoeuvre is of one wheel on a rig, else ``Replay``."""
    return RigReplay if is_on_rig(manoeuvres) else Replay
