"""What every disturbance says of itself: its kind of fault, the level at which it is real, its class of E2E faults."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Literal, get_args

from signals.quantities import FileModel

NodeName = Literal["bench", "ecu", "bystander"]
"""Controllers in the model of the bus: that of the bench, that of the ECU, and one that only listens."""
NODES: tuple[NodeName, ...] = get_args(NodeName)

Group = Literal["bit", "frame", "signal", "node", "wire"]
"""Where on the way from one controller to the other a disturbance acts."""

Level = Literal["report_only", "can_gw", "frame_gateway", "bit_model", "wire_relay", "device"]
"""How real a disturbance is, the least real first.

report_only: error frames tell of it, nothing on the bus changes; can_gw: rules of the kernel's gateway; frame_gateway:
whole frames are held, changed, dropped or made; bit_model: every bit among modelled protocol nodes; wire_relay: relays
switch real conductors; device: a bit-banging device on the real bus.
"""
LEVELS: tuple[Level, ...] = get_args(Level)

E2EClass = Literal[
    "repetition",
    "loss",
    "delay",
    "insertion",
    "masquerade",
    "incorrect_addressing",
    "incorrect_sequence",
    "corruption",
    "asymmetric_information",
    "received_by_a_subset",
    "blocking",
]
"""Communication faults of AUTOSAR RS_E2E 4.1 (ISO 26262), in its order."""
E2E_CLASSES: tuple[E2EClass, ...] = get_args(E2EClass)


class DisturbanceModel(FileModel):
    """Base of everything that a fault can do.

    Attributes
    ----------
    group : str
        Where it acts.
    e2e : str
        Class of the AUTOSAR E2E fault list that it stands for.
    realised_as : str
        Level at which the bench's own model does it; on a real bus it may be less, see `realised_level`.
    continuous : bool
        It lasts, while its trigger holds or for a duration; else it acts on each matching frame.
    figures : mapping
        What it measures on a frame: name, (SI unit, description). In a run each is a signal of its own.
    """

    group: ClassVar[Group]
    e2e: ClassVar[E2EClass]
    realised_as: ClassVar[Level]
    continuous: ClassVar[bool] = False
    figures: ClassVar[Mapping[str, tuple[str, str]]] = MappingProxyType({})

    @property
    def lasts(self) -> bool:
        """Whether this one is continuous."""
        return self.continuous


def realised_level(kind: type[DisturbanceModel], *, real_bus: bool) -> Level:
    """Level at which a disturbance is realised.

    Parameters
    ----------
    real_bus : bool
        True where a side of the injector is real hardware: then nothing below a frame reaches the wire, only what the
        model makes of the frames, and error frames that report it.
    """
    return "report_only" if real_bus and kind.realised_as == "bit_model" else kind.realised_as


def at_least(level: Level, required: Level) -> bool:
    """Whether a level is as real as the required one."""
    return LEVELS.index(level) >= LEVELS.index(required)
