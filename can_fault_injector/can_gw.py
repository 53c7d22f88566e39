"""Rules of the kernel's CAN gateway (can-gw) for the faults that it can do; all others are refused by name.

can-gw changes whole frames inside the kernel, always and for one identifier and mask: bits of identifier, length and
data are changed in the fixed order AND, OR, XOR, SET. It forwards a frame at most ``max_hops`` times (module parameter,
default 1), so two rules in a chain need ``modprobe can-gw max_hops=2``.
"""

import shlex
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.levels import DisturbanceModel
from can_fault_injector.faults.trigger import EXTENDED_MASK, STANDARD_MASK, Trigger
from signals.errors import InputError

_EXTENDED_FLAG, _REMOTE_FLAG = 0x80000000, 0x40000000
_DATA_BYTES = 8
_ORDER = "can-gw: always, one identifier and mask, AND, OR, XOR, SET of identifier, length and data"
_UNCONDITIONAL = ("payload", "start", "until", "phase", "state")
_DIRECTIONS = {"to_ecu": (0,), "to_bench": (1,), "both": (0, 1)}


@dataclass(frozen=True)
class Rule:
    """One rule: frames from one link to another, those of a filter, with modifications.

    Attributes
    ----------
    source, destination : str
        Network interfaces.
    selection : str
        Filter of cangw, ``123:C00007FF``, with ``~`` for all others; empty for every frame.
    modifications : tuple of str
        As cangw takes them, ``XOR:D:0.0.0100000000000000``.
    """

    source: str
    destination: str
    selection: str = ""
    modifications: tuple[str, ...] = ()

    def arguments(self) -> list[str]:
        """Arguments of ``cangw -A``."""
        words = ["-s", self.source, "-d", self.destination, "-e"]
        if self.selection:
            words += ["-f", self.selection]
        for modification in self.modifications:
            words += ["-m", modification]
        return words

    @property
    def command(self) -> str:
        """Command line that adds the rule."""
        return shlex.join(["cangw", "-A", *self.arguments()])


def _modification(instruction: str, elements: str, identifier: int = 0, length: int = 0, data: bytes = b"") -> str:
    return f"{instruction}:{elements}:{identifier:X}.{length:X}.{data.ljust(_DATA_BYTES, bytes(1)).hex().upper()}"


def _corrupt(model: fl.Corrupt) -> tuple[str, ...]:
    if model.data is not None:
        return _payload(model.data)
    if model.byte is None or model.mask is None:
        raise _Refused("random bits")
    if model.byte >= _DATA_BYTES:
        raise _Refused(f"byte {model.byte}")
    return (_modification("XOR", "D", data=bytes(model.byte) + bytes([model.mask])),)


def _payload(text: str) -> tuple[str, ...]:
    data = bytes.fromhex(text)
    if len(data) > _DATA_BYTES:
        raise _Refused(f"{len(data)} bytes")
    return (_modification("SET", "LD", length=len(data), data=data),)


def _rewrite(model: fl.RewriteId) -> tuple[str, ...]:
    flags = _EXTENDED_FLAG if model.to > STANDARD_MASK else 0
    return (_modification("SET", "I", model.to | flags),)


_MODIFICATIONS: dict[type[DisturbanceModel], Callable[[Any], tuple[str, ...]]] = {
    fl.Corrupt: _corrupt,
    fl.Masquerade: lambda model: _payload(model.data),
    fl.RewriteId: _rewrite,
    fl.WrongLength: lambda model: (_modification("SET", "L", length=model.length),),
    fl.ToRemote: lambda model: (_modification("OR", "I", _REMOTE_FLAG),),
}
"""What can-gw can do to a frame; dropping one needs no rule."""


class _Refused(ValueError):
    """What a fault has that can-gw cannot do."""


def _check(fault: Fault) -> None:
    """Raise for everything but "always, identifier and mask, a change without repair"."""
    trigger, model = fault.trigger, fault.disturbance.model
    kind = fault.disturbance.kind
    if type(model) is not fl.Drop and type(model) not in _MODIFICATIONS:
        raise _Refused(f"disturbance {kind}")
    if getattr(model, "mode", "protocol_correct") != "protocol_correct":
        raise _Refused(f"{kind}: mode raw")
    if getattr(model, "repair", "none") != "none":
        raise _Refused(f"{kind}: repair {model.repair}")  # type: ignore[attr-defined]
    names = {"start": "from"}
    for name in _UNCONDITIONAL:
        if getattr(trigger, name) is not None:
            raise _Refused(f"trigger.{names.get(name, name)}")
    for name, neutral in (("nth", 1), ("every", 1), ("probability", 1.0), ("event", "frame")):
        if getattr(trigger, name) != neutral:
            raise _Refused(f"trigger.{name}")
    for name, nothing in (("times", None), ("duration", None), ("repeat", 1)):
        if getattr(fault, name) != nothing:
            raise _Refused(name)


def _selections(trigger: Trigger) -> str:
    """Filter of a trigger; all its identifiers have to differ in bits that one mask leaves out."""
    if trigger.id is None:
        return ""
    extended = max(trigger.id) > STANDARD_MASK if trigger.extended is None else trigger.extended
    mask = (EXTENDED_MASK if extended else STANDARD_MASK) if trigger.mask is None else trigger.mask
    open_bits = 0
    for identifier in trigger.id:
        open_bits |= (identifier ^ trigger.id[0]) & mask
    if 2 ** open_bits.bit_count() != len({identifier & mask for identifier in trigger.id}):
        raise _Refused("trigger.id: several identifiers that no single mask selects")
    mask &= ~open_bits
    value = (trigger.id[0] & mask) | (_EXTENDED_FLAG if extended else 0)
    return f"{value:X}:{mask | _EXTENDED_FLAG | _REMOTE_FLAG:X}"


def _modifications(fault: Fault) -> tuple[str, ...]:
    model = fault.disturbance.model
    return () if isinstance(model, fl.Drop) else _MODIFICATIONS[type(model)](model)


def rules(faults: Iterable[Fault], bench_link: str, ecu_link: str) -> list[Rule]:
    """Rules that forward between two links in both directions with the faults in it.

    Raises
    ------
    InputError
        Naming every fault that can-gw cannot do, and what of it.
    """
    selected: tuple[list[tuple[str, Fault]], ...] = ([], [])
    refused = []
    for fault in faults:
        try:
            _check(fault)
            _modifications(fault)
            selection = _selections(fault.trigger)
        except _Refused as reason:
            refused.append(f"{fault.name or fault.disturbance.kind}: {reason}")
            continue
        for direction in _DIRECTIONS[fault.trigger.direction]:
            if selected[direction]:
                first = selected[direction][0][1]
                refused.append(
                    f"{fault.name or fault.disturbance.kind}: a second fault in this direction after "
                    f"{first.name or first.disturbance.kind}; the rule for all other frames has one filter"
                )
            selected[direction].append((selection, fault))
    if refused:
        raise InputError(
            "can-gw cannot do " + "; ".join(refused), allowed=_ORDER, mend="bench inject does all of it in a gateway"
        )
    links: tuple[Sequence[str], ...] = ((bench_link, ecu_link), (ecu_link, bench_link))
    return [rule for way, chosen in zip(links, selected, strict=True) for rule in _one_way(way[0], way[1], chosen)]


def _one_way(source: str, destination: str, chosen: Sequence[tuple[str, Fault]]) -> list[Rule]:
    if not chosen:
        return [Rule(source, destination)]
    selection, fault = chosen[0]
    result = []
    if not isinstance(fault.disturbance.model, fl.Drop):
        result.append(Rule(source, destination, selection, _modifications(fault)))
    if selection:
        result.append(Rule(source, destination, selection.replace(":", "~")))
    return result
