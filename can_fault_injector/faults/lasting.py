"""Disturbances that last: what happens when they begin, while they act, and when they end."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from can_fault_injector.disturbance import ENDLESS, Disturbance
from can_fault_injector.faults import bit_level as bl
from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults import node_level as nl
from can_fault_injector.faults import wire_level as wl
from can_fault_injector.faults.levels import DisturbanceModel, NodeName
from can_fault_injector.faults.running import Way
from can_fault_injector.frame import Frame
from can_fault_injector.node import BUS_OFF_LIMIT, PASSIVE_LIMIT
from can_fault_injector.wire_faults import Line, wiring

if TYPE_CHECKING:
    from can_fault_injector.faults.bit_stage import BitStage

_WAY_FROM: dict[NodeName, Way | None] = {"bench": "to_ecu", "ecu": "to_bench", "bystander": None}
LINE = ("bench", "bystander", "injector", "ecu")
"""Nodes along the line; the wire faults are on the ECU's side of the injector."""
_FOR_EVER_BITS = 2**60
_FILL_FRAMES = 8
_INTERMISSION_BITS = 3


def _nothing(until_ns: int) -> None:
    """A disturbance that only begins and ends."""


class Lasting(NamedTuple):
    """How a lasting disturbance goes on until a time, called before the bus runs up to it, and how it ends."""

    goes_on: Callable[[int], None]
    ends: Callable[[], None]


def _endless_overload(model: bl.EndlessOverload, stage: "BitStage") -> Lasting:
    number = stage.begin_lasting(Disturbance("dominant", "intermission.0", repeat=ENDLESS))
    return Lasting(_nothing, lambda: stage.end_lasting(number))


def _stuck_dominant(model: wl.StuckDominant, stage: "BitStage") -> Lasting:
    number = stage.begin_lasting(Disturbance("dominant", stage.bus.bit, length=_FOR_EVER_BITS))
    return Lasting(_nothing, lambda: stage.end_lasting(number))


def _wire(model: wl.Open | wl.Short, stage: "BitStage") -> Lasting:
    """Fault of the conductors between the injector and the ECU, the last node of the line."""
    line = Line(LINE, terminated=("bench", "ecu"))
    stage.bus.connect(wiring(line, stage.bus.names, model.wire_fault, "ecu"))
    return Lasting(_nothing, lambda: stage.bus.connect(None))


def _babbling_idiot(model: fl.BabblingIdiot, stage: "BitStage") -> Lasting:
    frame = Frame(model.id, bytes.fromhex(model.data)[:8])

    def goes_on(until_ns: int) -> None:
        while stage.injector_waiting < _FILL_FRAMES:
            stage.put_as_injector(frame)

    return Lasting(goes_on, stage.silence_injector)


def _bus_load(model: fl.BusLoad, stage: "BitStage") -> Lasting:
    frame = Frame(model.id, bytes(range(8)))
    frame_ns = (frame.bits().size + _INTERMISSION_BITS) * stage.bit_ns
    before = stage.now_ns
    owed_ns = 0.0

    def goes_on(until_ns: int) -> None:
        nonlocal before, owed_ns
        owed_ns += (until_ns - before) * model.load
        before = max(before, until_ns)
        while owed_ns >= frame_ns and stage.injector_waiting < _FILL_FRAMES:
            stage.put_as_injector(frame)
            owed_ns -= frame_ns
        owed_ns = min(owed_ns, _FILL_FRAMES * frame_ns)  # what found no room on the bus is not made up for

    return Lasting(goes_on, stage.silence_injector)


def _error_passive(model: nl.ErrorPassive, stage: "BitStage") -> Lasting:
    def goes_on(until_ns: int) -> None:
        if stage.bus.nodes[model.node].transmit_errors < PASSIVE_LIMIT:
            stage.bus.set_transmit_errors(model.node, PASSIVE_LIMIT)

    return Lasting(goes_on, lambda: None)


def _bus_off(model: nl.BusOff, stage: "BitStage") -> Lasting:
    stage.bus.configure(model.node, recovers=model.recovers)
    stage.bus.set_transmit_errors(model.node, BUS_OFF_LIMIT)
    stage.bus.drop_waiting(model.node)
    way = _WAY_FROM[model.node]
    if way is not None:
        stage.drop_waiting(way, "its sender is bus-off")
    return Lasting(_nothing, lambda: stage.bus.configure(model.node, recovers=True))


def _reset(model: nl.Reset, stage: "BitStage") -> Lasting:
    stage.bus.reset(model.node)
    way = _WAY_FROM[model.node]
    if way is not None:
        stage.drop_waiting(way, "its sender was reset")
    return _mute(stage, model.node, acknowledges=False)


def _off(model: nl.Off, stage: "BitStage") -> Lasting:
    return _mute(stage, model.node, acknowledges=model.acknowledges)


def _mute(stage: "BitStage", node: NodeName, *, acknowledges: bool) -> Lasting:
    stage.muted.add(node)
    stage.bus.configure(node, silent=not acknowledges)

    def ends() -> None:
        stage.muted.discard(node)
        stage.bus.configure(node, silent=False)

    return Lasting(_nothing, ends)


BEGINNERS: dict[type[DisturbanceModel], Callable[[Any, "BitStage"], Lasting]] = {
    bl.EndlessOverload: _endless_overload,
    fl.BabblingIdiot: _babbling_idiot,
    fl.BusLoad: _bus_load,
    nl.ErrorPassive: _error_passive,
    nl.BusOff: _bus_off,
    nl.Reset: _reset,
    nl.Off: _off,
    wl.Open: _wire,
    wl.Short: _wire,
    wl.StuckDominant: _stuck_dominant,
}
"""Lasting disturbances of the bus and its nodes."""
