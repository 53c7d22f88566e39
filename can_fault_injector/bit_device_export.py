"""Faults of a fault file as disturbances for a bit-banging injector; what the device cannot do is refused by name."""

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from can_fault_injector.disturbance import ENDLESS, Disturbance
from can_fault_injector.faults import bit_level as bl
from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults.bit_actions import BUILDERS, Marks, mark
from can_fault_injector.faults.contents import Contents, NoContents
from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.frame_actions import Passage
from can_fault_injector.faults.running import FaultEvent, RunningFault, Way
from can_fault_injector.faults.trigger import EXTENDED_MASK, STANDARD_MASK
from can_fault_injector.frame import Frame
from signals.errors import InputError

_WAYS: dict[str, tuple[Way, ...]] = {"to_ecu": ("to_ecu",), "to_bench": ("to_bench",), "both": ("to_ecu", "to_bench")}
_UNCONDITIONAL = ("payload", "start", "until", "phase", "state")
_ANY_PAYLOAD = bytes(8)
"""The device addresses bits by field while they pass, so the payload that they are looked up in is of no account."""
_BY_CONTENTS = (bl.Janus, bl.InconsistentOmission, fl.SpoofErrorPassive)
"""What they do to a frame depends on its contents, or on what its sender does."""


def disturbances(faults: Iterable[Fault], contents: Contents | None = None) -> list[Disturbance]:
    """Disturbances for `BitDevice.load`.

    Parameters
    ----------
    contents : optional
        Knows where the signals of a message lie, for places such as ``data.signal(NAME).bit 5``.

    Raises
    ------
    InputError
        Naming every fault that a device cannot do, and what of it.
    """
    result: list[Disturbance] = []
    refused = []
    for fault in faults:
        reason = _obstacle(fault)
        if not reason:
            made, reason = _disturbances_of(fault, contents or NoContents())
            result += made
        if reason:
            refused.append(f"{fault.name or fault.disturbance.kind}: {reason}")
    if refused:
        raise InputError(
            "the bit device cannot do " + "; ".join(refused),
            allowed="disturbances of bits, for one identifier and mask, from the nth frame on, so many times",
            mend="bench inject does all of it in a model of the bus",
        )
    return result


def _obstacle(fault: Fault) -> str:
    """What of a fault the device cannot do, or an empty text."""
    trigger, model = fault.trigger, fault.disturbance.model
    if isinstance(model, _BY_CONTENTS) or not (type(model) in BUILDERS or isinstance(model, bl.EndlessOverload)):
        return f"disturbance {fault.disturbance.kind}"
    if getattr(model, "mode", "raw") != "raw":
        return f"{fault.disturbance.kind}: mode protocol_correct"
    if isinstance(model, bl.Glitch) and model.start + model.width > 1.0:
        return "glitch: a pulse beyond the bit"
    if isinstance(model, fl.Corrupt) and (model.byte is None or model.mask is None):
        return "corrupt: bits that depend on the contents"
    for name in _UNCONDITIONAL:
        if getattr(trigger, name) is not None:
            return f"trigger.{'from' if name == 'start' else name}"
    if trigger.every != 1 or trigger.probability != 1.0 or trigger.event != "frame":
        return "trigger.every, probability or event"
    if trigger.id is not None and len(trigger.id) > 1:
        return "trigger.id: several identifiers"
    return "repeat or duration" if fault.repeat > 1 or fault.duration is not None else ""


def _disturbances_of(fault: Fault, contents: Contents) -> tuple[list[Disturbance], str]:
    trigger = fault.trigger
    identifier = trigger.id[0] if trigger.id is not None else None
    if isinstance(fault.disturbance.model, bl.EndlessOverload):
        return [Disturbance("dominant", "intermission.0", repeat=ENDLESS)], ""
    model = fault.disturbance.model
    begin, width = 0.0, 1.0
    if isinstance(model, bl.Glitch):
        # the model of bits asks whether its sample point lies in the pulse; a device makes the pulse
        begin, width = model.start, model.width
        model = bl.Force(at=model.at, length=model.length, tap=model.tap, node=model.node, level=model.level)
    extended = identifier is not None and (trigger.extended or identifier > STANDARD_MASK)
    frame = Frame(identifier or 0, _ANY_PAYLOAD, extended=bool(extended))
    made: list[Disturbance] = []
    notes: list[FaultEvent] = []
    for way in _WAYS[trigger.direction]:
        running = RunningFault(
            fault, vector=None, phases=(), contents=contents, generator=np.random.default_rng(0), log=notes.append
        )
        marks = Marks()
        mark(marks, model, Passage(running, frame, way, 0, contents, deque()))
        for item in marks.disturbances:
            chosen = replace(
                item,
                identifier=identifier,
                mask=EXTENDED_MASK if trigger.mask is None else trigger.mask,
                skip=trigger.nth - 1,
                repeat=ENDLESS if fault.times is None else fault.times,
                begin=begin,
                width=width,
            )
            if chosen not in made:
                made.append(chosen)
    return made, "; ".join(note.detail for note in notes)
