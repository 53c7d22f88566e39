"""The injector inside a run, called by the tick: between the frames of the bench and those of the ECU.

In virtual time a frame that is sent in tick n is on the bus from n to n + 1 ms, from whichever side. The bus first runs
on the bench's frames, when they are sent, then on those of the ECU, when they are known, both up to the end of that
millisecond: so a frame that nothing concerns arrives in the same tick as without an injector.
"""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.codec.codec import Codec
from bench.injection.contents import BusContents
from bench.injection.records import frame_of, is_error, write_error_frame, write_frame
from bench.injection.signals import counter_name, figure_name
from bench.links.frame import OPAQUE_DTYPE, TICK_NS, new_frames
from can_fault_injector.faults.bit_stage import Delivered
from can_fault_injector.faults.engine import Injector, Published
from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.levels import NODES
from can_fault_injector.faults.running import Way
from signals.vector import SignalVector

ECU_CHANNEL = 1
"""Channel in recordings of what was on the ECU's side of the injector; 0 is the bench's side."""
MOST_PER_TICK = 60
"""Frames that leave the injector in a tick in one direction; more wait for the next tick."""
MOST_LOG_LINES = 2000
_MOST_RECORDED = 512
WriteFrames = Callable[[NDArray[np.void], int], None]


class InjectorInRun:
    """Faults of a scenario at work in its ticks.

    Parameters
    ----------
    faults : sequence of Fault
    codec : Codec
        The bus: bit rate, signals, protection.
    vector : SignalVector
        With the signals of `injector_signals`, which it writes; read by triggers.
    phases : sequence of str
        Steps of the manoeuvre.
    seed : int
        Of the scenario.
    """

    def __init__(
        self, faults: Sequence[Fault], codec: Codec, vector: SignalVector, phases: Sequence[str], seed: int
    ) -> None:
        self.engine = Injector(
            faults,
            bit_rate=codec.bit_rate,
            contents=BusContents(codec),
            vector=vector,
            phases=phases,
            seed=seed,
        )
        self._values = vector.values
        self._named = [(vector.index(f"injector.{running.fault.name}"), running) for running in self.engine.faults]
        self._counters = [
            (node, vector.index(counter_name(node, "transmit")), vector.index(counter_name(node, "receive")))
            for node in NODES
        ]
        self._figures = [
            (vector.index(figure_name(running.fault, figure)), running.figures, figure)
            for running in self.engine.faults
            for figure in running.figures
        ]
        self._totals = {
            vector.index(f"injector.{name}"): name for name in ("frames_disturbed", "frames_lost", "error_frames")
        }
        self._held: dict[Way, deque[Delivered]] = {"to_ecu": deque(), "to_bench": deque()}
        self._to_ecu = new_frames(64)
        self._to_ecu_bytes = self._to_ecu.view(OPAQUE_DTYPE)
        self._recorded = new_frames(_MOST_RECORDED)
        self._recorded_bytes = self._recorded.view(OPAQUE_DTYPE)
        self._recorded_count = 0

    @property
    def acting(self) -> int:
        """Number of faults that act."""
        return self.engine.acting

    def begin_tick(self, tick: int) -> None:
        """Ask the triggers; to be called first in each tick."""
        self.engine.begin_step(tick * TICK_NS)

    def to_bench(self, frames: NDArray[np.void], count: int, tick: int) -> int:
        """Replace what the ECU sent by what the bench receives; returns the number of frames."""
        if self._passes(frames, count, "to_bench"):
            return count
        self._keep(frames, count)
        sent_ns = max(tick - 1, 0) * TICK_NS
        self._put(frames, count, "to_bench", sent_ns)
        self._run(tick * TICK_NS)
        return self._release(frames, "to_bench", tick)

    def to_ecu(self, frames: NDArray[np.void], count: int, tick: int) -> tuple[NDArray[np.void], int]:
        """What the ECU's side of the injector sees of the frames that the bench sends."""
        if self._passes(frames, count, "to_ecu"):
            return frames, count
        self._put(frames, count, "to_ecu", tick * TICK_NS)
        self._run((tick + 1) * TICK_NS)
        released = self._release(self._to_ecu, "to_ecu", tick)
        self._keep(self._to_ecu, released)
        return self._to_ecu, released

    def _passes(self, frames: NDArray[np.void], count: int, way: Way) -> bool:
        """Whether all of these frames pass as they are: no fault wants them, nothing is on the modelled bus."""
        if self._held[way]:
            return False
        if self.engine.passive:
            return True
        wants = self.engine.wants
        return self.engine.empty and not any(wants(way, number) for number in frames["identifier"][:count].tolist())

    def _put(self, frames: NDArray[np.void], count: int, way: Way, now_ns: int) -> None:
        for number in range(count):
            if not is_error(frames, number):
                self.engine.put(way, frame_of(frames[number]), now_ns)

    def _run(self, until_ns: int) -> None:
        for delivered in self.engine.run(until_ns):
            self._held[delivered.way].append(delivered)
        for published in self.engine.take_published():
            self._record_error(published)

    def _release(self, into: NDArray[np.void], way: Way, tick: int) -> int:
        held, count = self._held[way], 0
        while held and count < MOST_PER_TICK:
            item = held.popleft()
            write_frame(into[count], item.frame, way, tick, tick * TICK_NS)
            count += 1
        return count

    def _keep(self, frames: NDArray[np.void], count: int) -> None:
        """Frames on the ECU's side for the recording."""
        count = min(count, _MOST_RECORDED - self._recorded_count)
        end = self._recorded_count + count
        self._recorded_bytes[self._recorded_count : end] = frames.view(OPAQUE_DTYPE)[:count]
        self._recorded["channel"][self._recorded_count : end] = ECU_CHANNEL
        self._recorded_count = end

    def _record_error(self, published: Published) -> None:
        if self._recorded_count < _MOST_RECORDED and published.node != "bystander":
            record = self._recorded[self._recorded_count]
            way: Way = "to_bench" if published.node == "bench" else "to_ecu"
            tick = published.time_ns // TICK_NS
            write_error_frame(record, published.frame, way, tick, published.time_ns)
            record["channel"] = 0 if published.node == "bench" else ECU_CHANNEL
            self._recorded_count += 1

    def end_tick(self) -> None:
        """Write the injector's signals."""
        values, engine = self._values, self.engine
        for position, running in self._named:
            values[position] = running.acting
        for position, name in self._totals.items():
            values[position] = engine.counts[name]
        for position, figures, name in self._figures:
            values[position] = figures[name]
        for node, transmit, receive in self._counters:
            values[transmit], values[receive] = engine.error_counters(node)

    def record(self, write: WriteFrames, origin_ns: int) -> None:
        """Hand what was on the ECU's side, and the error frames of both sides, to the recording."""
        if self._recorded_count:
            self._recorded["timestamp_ns"][: self._recorded_count] += origin_ns
            write(self._recorded, self._recorded_count)
            self._recorded_count = 0

    def log_lines(self) -> list[str]:
        """Every event of the faults as a line of the run's log; of very many the first ones, and their number."""
        engine = self.engine
        lines = [
            f"injector {event.time_ns * 1e-9:.4f} s {event.fault or '-'}: {event.what} {event.detail}".rstrip()
            for event in engine.log[:MOST_LOG_LINES]
        ]
        left_out = engine.counts["events"] - len(lines)
        return [*lines, f"injector: {left_out} further events"] if left_out > 0 else lines or ["injector: no event"]

    def summary(self) -> dict[str, Any]:
        """Plain data for the verdict and the report."""
        return self.engine.summary()
