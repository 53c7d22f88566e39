"""What disturbances of frames and signals, and the device in series, make of a frame: none, one or several of them."""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from can_fault_injector.delay_model import windows_overlap
from can_fault_injector.faults import bit_level as bl
from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults import signal_level as sl
from can_fault_injector.faults.contents import Contents
from can_fault_injector.faults.levels import DisturbanceModel
from can_fault_injector.faults.running import NS_PER_S, RunningFault, Way
from can_fault_injector.faults.trigger import EXTENDED_MASK, STANDARD_MASK
from can_fault_injector.fields import FD_LENGTHS
from can_fault_injector.frame import Frame
from can_fault_injector.in_line import forward

LONGEST_HISTORY = 4096
_CLASSIC_BYTES = 8


class Release(NamedTuple):
    """A frame and the time at which it is handed on."""

    time_ns: int
    frame: Frame


class Passage:
    """A frame on its way through the injector.

    Attributes
    ----------
    history : deque of Release
        Frames of the same identifier that were handed on before, the newest last.
    """

    def __init__(
        self, fault: RunningFault, frame: Frame, way: Way, now_ns: int, contents: Contents, history: "deque[Release]"
    ) -> None:
        self.fault, self.frame, self.way, self.now_ns = fault, frame, way, now_ns
        self.contents, self.history = contents, history

    def now(self, frame: Frame) -> list[Release]:
        """Handed on at once."""
        return [Release(self.now_ns, frame)]

    def with_data(self, data: bytes) -> Frame:
        """The frame with another payload, filled up with zeros to a length that exists."""
        frame = self.frame
        if frame.fd:
            data = data.ljust(next(length for length in FD_LENGTHS if length >= len(data)), b"\0")
        return replace(frame, data=data, dlc=None, remote=False)

    def repaired(self, frame: Frame, repair: fl.Repair) -> Frame:
        """The frame with the protection that a fault wants it to have; the counter is that of the frame it replaces."""
        if repair == "none":
            return frame
        counter = self.contents.counter(self.frame) if repair == "crc_and_counter" else None
        return self.contents.protected(frame, counter)


Action = Callable[[Any, Passage], list[Release]]


def _drop(model: fl.Drop, on: Passage) -> list[Release]:
    return []


def _duplicate(model: fl.Duplicate, on: Passage) -> list[Release]:
    step = round(model.after * NS_PER_S)
    return [Release(on.now_ns + number * step, on.frame) for number in range(model.copies + 1)]


def _delay(model: fl.Delay, on: Passage) -> list[Release]:
    random = on.fault.generator.uniform(0.0, model.jitter) if model.jitter else 0.0
    return [Release(on.now_ns + round((model.by + random) * NS_PER_S), on.frame)]


def _reorder(model: fl.Reorder, on: Passage) -> list[Release]:
    waiting: list[Frame] = on.fault.memory.setdefault(("window", on.way), [])
    waiting.append(on.frame)
    if len(waiting) < model.window:
        return []
    frames = waiting[::-1]
    if model.order == "shuffled":
        frames = [waiting[number] for number in on.fault.generator.permutation(model.window)]
    waiting.clear()
    return [Release(on.now_ns, frame) for frame in frames]


def _replay(model: fl.Replay, on: Passage) -> list[Release]:
    before = on.now_ns - model.age * NS_PER_S
    old = next((release.frame for release in reversed(on.history) if release.time_ns <= before), None)
    if old is None:
        on.fault.note(on.now_ns, "cannot", f"no frame {on.frame.identifier:#x} of {model.age:g} s ago yet")
        return on.now(on.frame)
    return on.now(on.repaired(old, model.repair))


def _corrupt(model: fl.Corrupt, on: Passage) -> list[Release]:
    if model.mode == "raw":
        return on.now(on.frame)  # its bits change on the wire: see bit_actions
    data = changed_payload(model, on)
    return on.now(on.repaired(on.with_data(data), model.repair))


def changed_payload(model: fl.Corrupt, on: Passage) -> bytes:
    """Payload after the bits of a fault were inverted; random choices come from the fault's own generator."""
    if model.data is not None:
        return bytes.fromhex(model.data)
    data = bytearray(on.frame.data)
    if not data:
        return b""
    generator = on.fault.generator
    byte = int(generator.integers(len(data))) if model.byte is None else model.byte
    mask = 1 << int(generator.integers(8)) if model.mask is None else model.mask
    if byte >= len(data):
        on.fault.note(on.now_ns, "cannot", f"frame {on.frame.identifier:#x} has no byte {byte}")
    else:
        data[byte] ^= mask
    return bytes(data)


def _wrong_length(model: fl.WrongLength, on: Passage) -> list[Release]:
    if on.frame.remote:
        return on.now(replace(on.frame, dlc=model.length))
    return on.now(replace(on.frame, data=on.frame.data[: model.length].ljust(model.length, b"\0"), dlc=None))


def _rewrite_id(model: fl.RewriteId, on: Passage) -> list[Release]:
    if model.mode == "raw":
        return on.now(on.frame)
    limit = EXTENDED_MASK if on.frame.extended else STANDARD_MASK
    return on.now(replace(on.frame, identifier=model.to & limit))


def _to_remote(model: fl.ToRemote, on: Passage) -> list[Release]:
    if on.frame.fd:
        on.fault.note(on.now_ns, "cannot", "CAN FD has no remote frames")
        return on.now(on.frame)
    return on.now(replace(on.frame, remote=True, data=b"", dlc=min(len(on.frame.data), _CLASSIC_BYTES)))


def _masquerade(model: fl.Masquerade, on: Passage) -> list[Release]:
    return on.now(on.repaired(on.with_data(bytes.fromhex(model.data)), model.repair))


def _freeze(model: fl.Freeze, on: Passage) -> list[Release]:
    first: Frame = on.fault.memory.setdefault((on.way, on.frame.identifier), on.frame)
    return on.now(on.repaired(first, model.repair))


def _signal(change: Callable[[Any, Passage, str, float], float]) -> Action:
    """A disturbance of signals from the new value of one of them."""

    def act(model: sl.SignalDisturbance, on: Passage) -> list[Release]:
        values = on.contents.decode(on.frame)
        new = {name: change(model, on, name, values[name]) for name in model.signals if name in values}
        return on.now(on.repaired(on.contents.changed(on.frame, new), model.repair) if new else on.frame)

    return act


def _stuck(model: sl.Stuck, on: Passage, name: str, value: float) -> float:
    held: float = on.fault.memory.setdefault((on.way, name), value)
    return held if model.at is None else float(model.at)


def _ramp(model: sl.Ramp, on: Passage, name: str, value: float) -> float:
    began: int = on.fault.memory.setdefault("began", on.now_ns)
    amount = float(model.rate) * (on.now_ns - began) / NS_PER_S
    if model.limit is not None:
        amount = float(np.clip(amount, -abs(float(model.limit)), abs(float(model.limit))))
    return value + amount


def _noise(model: sl.SignalNoise, on: Passage, name: str, value: float) -> float:
    return value + on.fault.generator.normal(0.0, abs(float(model.standard_deviation)))


def _swap(model: sl.SwapWheels, on: Passage) -> list[Release]:
    values = on.contents.decode(on.frame)
    first, second = model.signals
    if first not in values or second not in values:
        return on.now(on.frame)
    new = {first: values[second], second: values[first]}
    return on.now(on.repaired(on.contents.changed(on.frame, new), model.repair))


def _in_line(model: bl.InLineDevice, on: Passage) -> list[Release]:
    forwarded = forward(on.frame, model.bit_rate, on.fault.generator)
    on.fault.figures |= {
        "delay": forwarded.delay_ns / NS_PER_S,
        "delay_share": forwarded.share,
        "window_overlap": float(windows_overlap(forwarded.share)),
        "passed_late": float(forwarded.passed_late),
        "passed_early": float(forwarded.passed_early),
        "frame_time": forwarded.frame_ns / NS_PER_S,
    }
    if not forwarded.passed_late:
        on.fault.note(on.now_ns, "cannot", f"at {model.bit_rate:g} bit/s the acknowledgement comes back too late")
        return []
    return [Release(on.now_ns + round(forwarded.delay_ns), on.frame)]


ACTIONS: dict[type[DisturbanceModel], Action] = {
    bl.InLineDevice: _in_line,
    fl.Drop: _drop,
    fl.Duplicate: _duplicate,
    fl.Delay: _delay,
    fl.Reorder: _reorder,
    fl.Replay: _replay,
    fl.Corrupt: _corrupt,
    fl.WrongLength: _wrong_length,
    fl.RewriteId: _rewrite_id,
    fl.ToRemote: _to_remote,
    fl.Masquerade: _masquerade,
    fl.Freeze: _freeze,
    sl.Offset: _signal(lambda model, on, name, value: value + float(model.by)),
    sl.Stuck: _signal(_stuck),
    sl.Ramp: _signal(_ramp),
    sl.SignalNoise: _signal(_noise),
    sl.UnitError: _signal(lambda model, on, name, value: value * model.factor + float(model.shift)),
    sl.SwapWheels: _swap,
}
"""Disturbances that make other frames of a frame."""


def spoofed(model: fl.Spoof, contents: Contents, counter: int | None) -> Frame:
    """The frame that a spoof sends; with ``crc_and_counter`` its alive counter is the one given."""
    frame = Frame(model.id, bytes.fromhex(model.data)[:_CLASSIC_BYTES], extended=model.extended)
    if model.repair == "none":
        return frame
    return contents.protected(frame, counter if model.repair == "crc_and_counter" else None)
