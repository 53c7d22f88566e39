"""What the bit-level disturbances do to the bits of one frame: disturbances of the model's bus."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from can_fault_injector.disturbance import ENDLESS, Disturbance
from can_fault_injector.faults import bit_level as bl
from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults.frame_actions import Passage, changed_payload
from can_fault_injector.faults.levels import DisturbanceModel, NodeName
from can_fault_injector.faults.running import Way
from can_fault_injector.frame import Frame
from can_fault_injector.places import resolve
from signals.errors import InputError

SAMPLE_POINT = 0.75
"""Share of a bit at which the model's nodes sample it."""
SENDER: dict[Way, NodeName] = {"to_ecu": "bench", "to_bench": "ecu"}
RECEIVER: dict[Way, NodeName] = {"to_ecu": "ecu", "to_bench": "bench"}
_FLAG_BITS = 6
_LEVEL_NAMES = ("dominant", "recessive")


@dataclass
class Marks:
    """What is to happen to a frame on the bus of the model.

    Attributes
    ----------
    disturbances : list of Disturbance
    single_shot : bool
        Its sender gives it up after an error.
    overwritten_by : Frame, optional
        Frame that the injector puts over it bit by bit.
    """

    disturbances: list[Disturbance] = field(default_factory=list)
    single_shot: bool = False
    overwritten_by: Frame | None = None

    def __bool__(self) -> bool:
        return bool(self.disturbances) or self.overwritten_by is not None


class _Builder:
    """Disturbances of one frame."""

    def __init__(self, on: Passage) -> None:
        self.on = on
        self.sender, self.receiver = SENDER[on.way], RECEIVER[on.way]
        self._layout = on.contents.signal_bits(on.frame)

    def one(
        self,
        action: Any,
        at: str,
        tap: bl.Tap,
        node: NodeName | None = None,
        *,
        length: int = 1,
        repeat: int = 1,
        reference: NodeName | None = None,
    ) -> Disturbance:
        """A disturbance in this frame; without a node the one that its tap suggests."""
        if tap == "bus":
            node = None
        elif node is None:
            node = self.sender if tap == "transmit" else self.receiver
        return Disturbance(
            action,
            resolve(at, self._layout),
            tap=tap,
            node=node,
            reference=reference,
            identifier=self.on.frame.identifier,
            length=length,
            repeat=repeat,
        )


Builder = Callable[[Any, _Builder, Marks], None]


def _at_place(action: Callable[[Any], str]) -> Builder:
    def build(model: Any, of: _Builder, marks: Marks) -> None:
        repeat = ENDLESS if model.every_attempt else 1
        marks.disturbances.append(
            of.one(action(model), model.at, model.tap, model.node, length=model.length, repeat=repeat)
        )

    return build


def _glitch(model: bl.Glitch, of: _Builder, marks: Marks) -> None:
    """The bits whose sample point lies in the pulse have its level; the others do not notice it."""
    end = model.start + model.width
    first = 0 if model.start <= SAMPLE_POINT else 1
    sampled = sum(model.start <= number + SAMPLE_POINT < end for number in range(model.length + 2))
    if sampled == 0:
        return
    field_name, _, number = resolve(model.at, of.on.contents.signal_bits(of.on.frame)).partition(".")
    repeat = ENDLESS if model.every_attempt else 1
    at = f"{field_name}.{int(number or 0) + first}"
    marks.disturbances.append(of.one(model.level, at, model.tap, model.node, length=sampled, repeat=repeat))


def _stuff_error(model: bl.StuffError, of: _Builder, marks: Marks) -> None:
    if f"stuff.{model.number}" not in set(of.on.frame.bit_names()):
        of.on.fault.note(of.on.now_ns, "cannot", f"frame {of.on.frame.identifier:#x} has no stuff bit {model.number}")
        return
    marks.disturbances.append(of.one("flip", f"stuff.{model.number}", "receive", model.node))


def _crc_error(model: bl.CrcError, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("flip", f"crc.{model.bit}", "receive", model.node))


def _form_error(model: bl.FormError, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("dominant", f"{model.field}.{model.bit}", model.tap, model.node))


def _ack_error(model: bl.AckError, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("recessive", "ack_slot.0", "receive", of.sender))


def _bit_error(model: bl.BitError, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("flip", model.at, "receive", of.sender))


def _error_flag(model: bl.ErrorFlag, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("dominant", model.at, "bus", length=_FLAG_BITS))


def _overload(model: bl.Overload, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("dominant", "intermission.0", "bus", repeat=model.frames))


def _double_receive(model: bl.DoubleReceive, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("dominant", "eof.6", "receive", of.sender))


def _inconsistent_omission(model: bl.InconsistentOmission, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("dominant", "eof.5", "receive", model.node))
    marks.single_shot = True


def _bus_off_attack(model: bl.BusOffAttack, of: _Builder, marks: Marks) -> None:
    marks.disturbances.append(of.one("flip", model.at, "receive", of.sender, repeat=ENDLESS))


def _janus(model: bl.Janus, of: _Builder, marks: Marks) -> None:
    other = of.on.with_data(bytes.fromhex(model.data))
    if not _force_bits(of, marks, other):
        of.on.fault.note(of.on.now_ns, "cannot", f"the two payloads differ in length on the wire: {model.data}")


def _force_bits(of: _Builder, marks: Marks, other: Frame) -> bool:
    """The receiver reads another frame of the same length on the wire; False if the lengths differ."""
    ours, theirs = of.on.frame.bits(), other.bits()
    if ours.size != theirs.size:
        return False
    for position in (ours != theirs).nonzero()[0]:
        level = _LEVEL_NAMES[int(theirs[position])]
        marks.disturbances.append(of.one(level, f"bit.{int(position)}", "receive", reference=of.sender))
    return True


def _raw_identifier(model: fl.RewriteId, of: _Builder, marks: Marks) -> None:
    """Identifier bits that differ are inverted where the original has them; nothing else is made to fit."""
    if model.mode != "raw":
        return
    frame = of.on.frame
    difference = frame.identifier ^ model.to
    width, high = (29, 18) if frame.extended else (11, 0)
    for number in range(width):
        if difference >> (width - 1 - number) & 1:
            at = f"id.{number}" if number < 11 or not high else f"id_ext.{number - 11}"
            marks.disturbances.append(of.one("flip", at, "receive", repeat=ENDLESS))


def _raw_payload(model: fl.Corrupt, of: _Builder, marks: Marks) -> None:
    """Payload bits are inverted where the original has them, the CRC stays."""
    if model.mode != "raw":
        return
    new = changed_payload(model, of.on).ljust(len(of.on.frame.data), b"\0")
    for byte, (before, after) in enumerate(zip(of.on.frame.data, new, strict=False)):
        for bit in range(8):
            if (before ^ after) >> (7 - bit) & 1:
                marks.disturbances.append(of.one("flip", f"data.{8 * byte + bit}", "receive", repeat=ENDLESS))


def _spoof_error_passive(model: fl.SpoofErrorPassive, of: _Builder, marks: Marks) -> None:
    on = of.on
    frame = on.repaired(on.with_data(bytes.fromhex(model.data)), model.repair)
    marks.overwritten_by = frame


BUILDERS: dict[type[DisturbanceModel], Builder] = {
    bl.Flip: _at_place(lambda model: "flip"),
    bl.Force: _at_place(lambda model: model.level),
    bl.Glitch: _glitch,
    bl.StuffError: _stuff_error,
    bl.CrcError: _crc_error,
    bl.FormError: _form_error,
    bl.AckError: _ack_error,
    bl.BitError: _bit_error,
    bl.ErrorFlag: _error_flag,
    bl.Overload: _overload,
    bl.DoubleReceive: _double_receive,
    bl.InconsistentOmission: _inconsistent_omission,
    bl.Janus: _janus,
    bl.BusOffAttack: _bus_off_attack,
    fl.RewriteId: _raw_identifier,
    fl.Corrupt: _raw_payload,
    fl.SpoofErrorPassive: _spoof_error_passive,
}
"""Disturbances that act on the bits of a frame."""


def mark(marks: Marks, model: DisturbanceModel, on: Passage) -> None:
    """Add what a disturbance does to this frame; one that names a bit that the frame lacks is noted in the log."""
    try:
        BUILDERS[type(model)](model, _Builder(on), marks)
    except InputError as error:
        on.fault.note(on.now_ns, "cannot", error.message)
