"""The injector as a process between two buses: what arrives on one side leaves on the other, with faults in between.

Each side has a controller of its own: acknowledgement is local, an error on one side is not seen on the other, and a
frame that goes over the modelled bus takes the time of its bits. Frames that no fault concerns are sent on at once.
"""

import select
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.codec.codec import Codec
from bench.injection.contents import BusContents
from bench.injection.records import frame_of, is_error, write_error_frame, write_frame
from bench.links.frame import new_frames
from bench.links.interface import Link
from can_fault_injector.faults.engine import Injector
from can_fault_injector.faults.fault_file import FaultsFile
from can_fault_injector.faults.running import WAYS, Way
from signals.catalogue import catalogue
from signals.errors import FieldError, InputError
from signals.vector import SignalVector

BATCH = 1024
BUSY_WAIT_S = 0.2e-3
"""Wait while frames are on the modelled bus: less than the shortest frame takes at 500 kbit/s."""
IDLE_WAIT_S = 20e-3
STEP_NS = 1_000_000
"""Triggers on time and state are asked anew after this time."""
_LATENCIES = 1_000_000
_REAL_LINKS = ("slcan",)


@dataclass(frozen=True)
class Latency:
    """Added latency of frames that were sent on, from the time stamp of reception to the end of the sending."""

    count: int
    p50_us: float
    p99_us: float
    max_us: float


class Gateway:
    """Frames between two links, through an injector.

    Parameters
    ----------
    bench_side, ecu_side : Link
        Open, in the role of the one on the other side: "ecu" on the bench's side, "bench" on the ECU's.
    faults : FaultsFile, optional
        Without it everything passes.
    codec : Codec
        Signals and protection of the messages.
    bit_rate : float [bit/s]
        Of the modelled bus; by default that of the database.

    Raises
    ------
    InputError
        If a fault asks for what only a scenario has, or for a level that it cannot have here.
    """

    def __init__(
        self,
        bench_side: Link,
        ecu_side: Link,
        faults: FaultsFile | None,
        codec: Codec,
        *,
        bit_rate: float | None = None,
        seed: int = 1,
    ) -> None:
        self._source: dict[Way, Link] = {"to_ecu": bench_side, "to_bench": ecu_side}
        self._target: dict[Way, Link] = {"to_ecu": ecu_side, "to_bench": bench_side}
        self._vector = SignalVector()
        self._time = self._vector.index("time")
        listed = [] if faults is None else faults.faults
        check_triggers(faults)
        self.engine = Injector(
            listed,
            bit_rate=bit_rate or codec.bit_rate,
            contents=BusContents(codec),
            vector=self._vector,
            seed=seed,
            real_bus=any(is_real(link) for link in (bench_side, ecu_side)),
        )
        needs_state = any(fault.trigger.state is not None for fault in listed)
        blocks = (self._vector.block("bus"), self._vector.block("bus_age"))
        self._receiver = codec.receiver("all", *blocks) if needs_state else None
        self._frames, self._out = new_frames(BATCH), new_frames(BATCH)
        self._stamps = self._frames["timestamp_ns"]
        self._start_ns = time.monotonic_ns()
        self._next_step_ns = 0
        self._latencies_ns = np.zeros(_LATENCIES, np.int64)
        self._latency_count = 0
        self.received = dict.fromkeys(WAYS, 0)
        self.sent = dict.fromkeys(WAYS, 0)
        self.error_frames_passed = 0
        both_tell = bench_side.descriptors and ecu_side.descriptors
        self._descriptors = (*bench_side.descriptors, *ecu_side.descriptors) if both_tell else ()

    @property
    def now_ns(self) -> int:
        """Time since the start."""
        return time.monotonic_ns() - self._start_ns

    def restart_clock(self) -> None:
        """Time is counted from now on; what arrived before is dropped."""
        for link in self._source.values():
            while link.receive(self._frames):
                pass
        self._start_ns, self._next_step_ns = time.monotonic_ns(), 0

    def step(self) -> int:
        """Move what has arrived and what is due; returns the number of frames that arrived."""
        now_ns = self.now_ns
        if now_ns >= self._next_step_ns:
            self._vector.values[self._time] = now_ns * 1e-9
            self.engine.begin_step(now_ns)
            self._next_step_ns = now_ns + STEP_NS
        arrived = 0
        for way in WAYS:
            count = self._source[way].receive(self._frames)
            if count:
                arrived += count
                self.received[way] += count
                self._take(way, count, now_ns)
        if not self.engine.empty:
            self._send_due()
        return arrived

    def _take(self, way: Way, count: int, now_ns: int) -> None:
        engine, frames = self.engine, self._frames
        if self._receiver is not None:
            self._receiver.accept(frames, count, now_ns // STEP_NS)
        if engine.passive or self._none_wanted(way, count):
            self._target[way].send(frames, count)
            self.sent[way] += count
            self._measure(self._stamps[:count])
            return
        for number in range(count):
            if is_error(frames, number):
                self._target[way].send(frames[number : number + 1], 1)
                self.error_frames_passed += 1
            else:
                engine.put(way, frame_of(frames[number]), now_ns)
        self._send_due(self._stamps[count - 1])

    def _none_wanted(self, way: Way, count: int) -> bool:
        wants = self.engine.wants
        return self.engine.empty and not any(wants(way, n) for n in set(self._frames["identifier"][:count].tolist()))

    def _send_due(self, stamp_ns: int = 0) -> None:
        now_ns = self.now_ns
        out = self._out
        delivered = self.engine.run(now_ns)
        for way in WAYS:
            frames = [item for item in delivered if item.way == way]
            for first in range(0, len(frames), BATCH):
                batch = frames[first : first + BATCH]
                for record, item in zip(out, batch, strict=False):
                    write_frame(record, item.frame, way, 0, item.time_ns)
                self._target[way].send(out, len(batch))
                self.sent[way] += len(batch)
                if stamp_ns:
                    self._measure(np.full(len(batch), stamp_ns))
        for published in self.engine.take_published():
            if published.node != "bystander":
                target: Way = "to_bench" if published.node == "bench" else "to_ecu"
                write_error_frame(out[0], published.frame, target, 0, published.time_ns)
                self._target[target].send(out, 1)

    def _measure(self, stamps_ns: NDArray[np.int64]) -> None:
        begin = self._latency_count % _LATENCIES
        end = min(begin + stamps_ns.size, _LATENCIES)
        self._latencies_ns[begin:end] = time.time_ns() - stamps_ns[: end - begin]
        self._latency_count += stamps_ns.size

    def wait(self) -> None:
        """Sleep until a frame arrives, or until something may be due."""
        timeout_s = (STEP_NS * 1e-9 if self.engine.faults else IDLE_WAIT_S) if self.engine.empty else BUSY_WAIT_S
        if self._descriptors:
            select.select(self._descriptors, (), (), timeout_s)
        else:
            time.sleep(BUSY_WAIT_S)

    def latency(self) -> Latency:
        """Latencies of the last million frames that were measured."""
        count = min(self._latency_count, _LATENCIES)
        if not count:
            return Latency(0, 0.0, 0.0, 0.0)
        values = self._latencies_ns[:count] * 1e-3
        p50, p99 = np.percentile(values, (50, 99))
        return Latency(self._latency_count, float(p50), float(p99), float(values.max()))

    def summary(self) -> dict[str, Any]:
        """Plain data: frames, added latency, what the links lost, what the faults did."""
        latency = self.latency()
        links = {
            name: {key: link.statistics()[key] for key in ("send_refused", "overflows")}
            for name, link in (("bench_side", self._source["to_ecu"]), ("ecu_side", self._source["to_bench"]))
        }
        return {
            "received": dict(self.received),
            "sent": dict(self.sent),
            "added_latency_us": {"frames": latency.count, "p50": latency.p50_us, "p99": latency.p99_us}
            | {"max": latency.max_us},
            "links": links,
            **self.engine.summary(),
        }


def is_real(link: Link) -> bool:
    """Whether a link is hardware, on which nothing below a frame can be done from here."""
    if link.kind == "socketcan":
        return not all(channel.startswith(("vcan", "vxcan")) for channel in link.channels)
    return link.kind in _REAL_LINKS or link.kind not in ("virtual", "udp", "udp_loopback", "udp_multicast")


def check_triggers(faults: FaultsFile | None) -> None:
    """Refuse triggers on what only a scenario knows.

    Raises
    ------
    InputError
        Naming fault and field.
    """
    units = {signal.name: signal.unit for signal in catalogue() if signal.block in ("bus", "bus_age")}
    for fault in () if faults is None else faults:
        errors: Sequence[FieldError] = fault.trigger.faults(units, ())
        for error in errors:
            raise InputError(
                f"fault {fault.name}: {'.'.join(map(str, error.at))}: {error.problem}",
                found=error.found,
                nearest=error.nearest,
                allowed=error.allowed or "signals that the bus carries",
                mend="a live injector sees the bus only; phases and the car's true state need a scenario",
            )
