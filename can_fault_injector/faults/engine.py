"""The injector: frames of both directions in, faults applied, what the receivers get out, in step with a clock.

Time is given from outside in nanoseconds since the start of the run, so the same engine works in virtual time, bit for
bit reproducible, and by a wall clock. Frames that no fault concerns pass unchanged and take no time. As soon as bits,
nodes or wires are concerned, frames go over the modelled bus and take the time that their bits take.
"""

import heapq
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from can_fault_injector.error_frames import ErrorFrame, error_frame, wire_frame
from can_fault_injector.faults import frame_level as fl
from can_fault_injector.faults.bit_actions import BUILDERS, Marks, mark
from can_fault_injector.faults.bit_stage import BitStage, Delivered
from can_fault_injector.faults.contents import Contents, NoContents
from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.frame_actions import ACTIONS, LONGEST_HISTORY, Passage, Release, spoofed
from can_fault_injector.faults.lasting import BEGINNERS, Lasting
from can_fault_injector.faults.levels import NODES, NodeName, at_least, realised_level
from can_fault_injector.faults.running import NS_PER_S, WAYS, FaultEvent, RunningFault, Way
from can_fault_injector.frame import Frame
from can_fault_injector.notation import frame_text
from signals.errors import InputError

if TYPE_CHECKING:
    from signals.vector import SignalVector

FAULT_PURPOSE = 7101
"""Second word of the seeds of the faults' random generators, so that no other purpose draws the same numbers."""
MOST_LOGGED = 20_000


class Published(NamedTuple):
    """An error frame as the driver of a node's controller would report it."""

    time_ns: int
    node: NodeName
    frame: ErrorFrame


class _Scheduled(NamedTuple):
    """A frame that is handed on later; ``number`` keeps the order of frames of one instant."""

    time_ns: int
    number: int
    way: Way
    frame: Frame
    marks: Marks


class Injector:
    """All faults of a run at work.

    Parameters
    ----------
    faults : sequence of Fault
        In this order they act on a frame.
    bit_rate, data_bit_rate : float [bit/s]
    contents : Contents, optional
        Signals and protection of the messages.
    vector : SignalVector, optional
        Signals of the run by name, only read, for triggers on the state and the phase.
    phases : sequence of str
        Steps of the manoeuvre.
    seed : int
    real_bus : bool
        A side of the injector is hardware, see `levels.realised_level`.

    Raises
    ------
    InputError
        If a fault requires a level that it cannot have here.
    """

    def __init__(
        self,
        faults: Sequence[Fault],
        *,
        bit_rate: float = 500e3,
        data_bit_rate: float | None = None,
        contents: Contents | None = None,
        vector: "SignalVector | None" = None,
        phases: Sequence[str] = (),
        seed: int = 1,
        real_bus: bool = False,
    ) -> None:
        check_levels(faults, real_bus=real_bus)
        self._real_bus = real_bus
        self.log: list[FaultEvent] = []
        self.published: list[Published] = []
        self.counts: Counter[str] = Counter()
        self._contents = NoContents() if contents is None else contents
        self.faults = [
            RunningFault(
                fault,
                vector=vector,
                phases=phases,
                contents=self._contents,
                generator=np.random.default_rng([seed, FAULT_PURPOSE, number]),
                log=self._note,
            )
            for number, fault in enumerate(faults)
        ]
        needs_bits = any(running.model.realised_as == "bit_model" or _is_raw(running) for running in self.faults)
        self.stage = BitStage(bit_rate, data_bit_rate, self._lost) if needs_bits else None
        self._open: list[RunningFault] = []
        self._lasting: dict[int, Lasting] = {}
        self._cyclic: dict[int, float] = {}
        self._heap: list[_Scheduled] = []
        self._scheduled = 0
        self._not_before: dict[tuple[Way, int], int] = {}
        self._history: dict[tuple[Way, int], deque[Release]] = {}
        self._keeps_history = any(isinstance(running.model, fl.Replay) for running in self.faults)
        self._counters: dict[tuple[Way, int], int] = {}
        self._keeps_counters = any(isinstance(running.model, fl.Spoof) for running in self.faults)
        self._delivered: list[Delivered] = []
        self._now_ns = self._ran_until_ns = 0

    @property
    def passive(self) -> bool:
        """True while every frame passes as it is: nothing is armed, held back, or on the modelled bus."""
        return not self._open and self.empty

    @property
    def empty(self) -> bool:
        """True while no frame is held back, and the modelled bus is out of use."""
        held = bool(self._heap or self._keeps_history or self._keeps_counters or self._lasting or self._cyclic)
        return not (held or self._delivered) and (self.stage is None or self.stage.settled)

    def wants(self, way: Way, identifier: int) -> bool:
        """Whether a fault that may act now asks for frames of an identifier, or for a frame's successors."""
        return any(running.may_take(way, identifier) for running in self._open)

    def begin_step(self, now_ns: int) -> None:
        """Ask every trigger whether it may act in this step of time; to be called once in each."""
        self._now_ns = now_ns
        self._open = [running for running in self.faults if running.gate(now_ns)]
        for number, running in enumerate(self.faults):
            if running.model.lasts:
                self._keep_up(number, running, now_ns)

    def _keep_up(self, number: int, running: RunningFault, now_ns: int) -> None:
        """Begin or end a disturbance that lasts."""
        if not running.acting and running in self._open and not running.fault.trigger.selects_frames:
            running.begin(now_ns)
        begun = number in self._lasting or number in self._cyclic
        if running.acting and not begun:
            if isinstance(running.model, fl.Spoof):
                self._cyclic[number] = float(now_ns)
            elif self.stage is not None:
                self.stage.catch_up(now_ns)
                self._lasting[number] = BEGINNERS[type(running.model)](running.model, self.stage)
                self._tell_wire(running, now_ns)
        elif begun and not running.acting:
            self._cyclic.pop(number, None)
            lasting = self._lasting.pop(number, None)
            if lasting is not None:
                lasting.ends()

    def _tell_wire(self, running: RunningFault, now_ns: int) -> None:
        """The ECU's transceiver reports a fault of its wires."""
        fault = getattr(running.model, "wire_fault", None)
        if fault is not None:
            self.counts["error_frames"] += 1
            self.published.append(Published(now_ns, "ecu", wire_frame(fault, *self.error_counters("ecu"))))

    def put(self, way: Way, frame: Frame, now_ns: int) -> None:
        """A frame enters the injector."""
        self.counts["frames"] += 1
        key = (way, frame.identifier)
        not_before = self._not_before.get(key, 0)
        items = [(Release(now_ns, frame), Marks())]
        disturbed = False
        for running in self._open:
            if running.model.lasts and (running.acting or not running.fault.trigger.selects_frames):
                continue
            if not running.takes(frame, way, now_ns):
                continue
            disturbed = True
            items = [item for release, marks in items for item in self._act(running, release, marks, way, now_ns)]
            if items and isinstance(running.model, fl.Delay):
                self._not_before[key] = max(not_before, items[0][0].time_ns)
        if disturbed:
            self.counts["frames_disturbed"] += 1
            if not items:
                self.counts["frames_withheld"] += 1
        for release, marks in items:
            # frames of one identifier do not overtake those that a delay holds
            self._schedule(max(release.time_ns, not_before), way, release.frame, marks)

    def _act(
        self, running: RunningFault, release: Release, marks: Marks, way: Way, now_ns: int
    ) -> list[tuple[Release, Marks]]:
        model, frame = running.model, release.frame
        history = self._history.get((way, frame.identifier), deque())
        passage = Passage(running, frame, way, release.time_ns, self._contents, history)
        text = f"{way} {frame_text(frame)}"
        result = [(release, marks)]
        if type(model) in BUILDERS:
            mark(marks, model, passage)
        if type(model) in ACTIONS:
            releases = ACTIONS[type(model)](model, passage)
            result = [(made, marks if number == 0 else Marks()) for number, made in enumerate(releases)]
            text += f" -> {', '.join(_release_text(made, now_ns) for made in releases) or 'nothing'}"
        if isinstance(model, fl.Spoof):
            for target in WAYS if model.direction == "both" else (model.direction,):
                made = self._spoofed(model, target, frame)
                text += f", then {frame_text(made)}"
                if target == way:
                    result.append((Release(release.time_ns, made), Marks()))
                else:
                    self._schedule(release.time_ns, target, made, Marks())
        running.note(now_ns, "acts", text)
        return result

    def _spoofed(self, model: fl.Spoof, way: Way, after: Frame | None = None) -> Frame:
        last = self._contents.counter(after) if after is not None and after.identifier == model.id else None
        last = self._counters.get((way, model.id), 0) if last is None else last
        return spoofed(model, self._contents, (last + 1) % 16)

    def _schedule(self, time_ns: int, way: Way, frame: Frame, marks: Marks) -> None:
        self._scheduled += 1
        heapq.heappush(self._heap, _Scheduled(time_ns, self._scheduled, way, frame, marks))

    def run(self, until_ns: int) -> list[Delivered]:
        """Let time go on; returns what the receivers have got, in the order of time."""
        if self.stage is not None and until_ns > self._ran_until_ns:
            self.stage.catch_up(self._ran_until_ns)
        self._ran_until_ns = until_ns
        for number, next_ns in self._cyclic.items():
            self._cyclic[number] = self._send_cyclic(self.faults[number].model, next_ns, until_ns)
        while self._heap and self._heap[0].time_ns <= until_ns:
            self._hand_on(heapq.heappop(self._heap))
        if self.stage is not None and (self._lasting or not self.stage.settled):
            for lasting in self._lasting.values():
                lasting.goes_on(until_ns)
            self.stage.run(until_ns)
            self._collect(self.stage)
        delivered, self._delivered = self._delivered, []
        return sorted(delivered, key=lambda item: item.time_ns)

    def _send_cyclic(self, model: object, next_ns: float, until_ns: int) -> float:
        assert isinstance(model, fl.Spoof)
        assert model.cycle is not None
        while next_ns < until_ns:
            for way in WAYS if model.direction == "both" else (model.direction,):
                made = self._spoofed(model, way)
                self._schedule(round(next_ns), way, made, Marks())
            next_ns += model.cycle * NS_PER_S
        return next_ns

    def _hand_on(self, item: _Scheduled) -> None:
        key = (item.way, item.frame.identifier)
        if self._keeps_history:
            self._history.setdefault(key, deque(maxlen=LONGEST_HISTORY)).append(Release(item.time_ns, item.frame))
        if self._keeps_counters:
            counter = self._contents.counter(item.frame)
            if counter is not None:
                self._counters[key] = counter
        stage = self.stage
        if stage is not None and (item.marks or self._lasting or not stage.settled):
            stage.put(item.way, item.frame, item.marks, item.time_ns)
        else:
            self._delivered.append(Delivered(item.time_ns, item.way, item.frame))

    def _collect(self, stage: BitStage) -> None:
        self._delivered += stage.delivered
        stage.delivered.clear()
        last: tuple[int, str, ErrorFrame] | None = None
        for time_ns, event in stage.events:
            if event.kind == "error":
                self.counts[f"errors_{event.node}"] += 1
                for running in self.faults:
                    running.error_seen()
            told = error_frame(event) if event.node in NODES else None
            if told is not None and last != (event.bit, event.node, told):
                last = (event.bit, event.node, told)
                self.counts["error_frames"] += 1
                self.published.append(Published(time_ns, event.node, told))  # type: ignore[arg-type]
        stage.events.clear()

    def take_published(self) -> list[Published]:
        """Error frames since the last call."""
        published, self.published = self.published, []
        return published

    def error_counters(self, node: NodeName) -> tuple[int, int]:
        """Transmit and receive error counter of a node of the model."""
        if self.stage is None:
            return 0, 0
        view = self.stage.bus.nodes[node]
        return view.transmit_errors, view.receive_errors

    def _lost(self, way: Way, frame: Frame, reason: str) -> None:
        self.counts["frames_lost"] += 1
        self._note(FaultEvent(self._now_ns, "", "lost", f"{way} {frame_text(frame)}: {reason}"))

    def _note(self, event: FaultEvent) -> None:
        if len(self.log) < MOST_LOGGED:
            self.log.append(event)
        self.counts["events"] += 1

    def warm_up(self) -> None:
        """Compile what the modelled bus needs, on a bus of its own, before a clock runs."""
        if self.stage is not None:
            trial = BitStage(500e3, None, lambda way, frame, reason: None)
            trial.put("to_ecu", Frame(0x123, b"\x01"), Marks(), 0)
            trial.run(1_000_000)

    @property
    def acting(self) -> int:
        """Number of faults that act now."""
        return sum(running.acting for running in self.faults)

    def summary(self) -> dict[str, object]:
        """Plain data for the verdict and the report: what each fault did, at which level, and the counts."""
        return {
            "faults": [
                {
                    "name": running.fault.name,
                    "kind": running.kind,
                    "e2e": running.model.e2e,
                    "realised_as": realised_level(type(running.model), real_bus=self._real_bus),
                    "runs": running.runs,
                    "frames": running.hits,
                    "first_s": next((e.time_ns / NS_PER_S for e in self.log if e.fault == running.fault.name), None),
                }
                for running in self.faults
            ],
            "counts": dict(sorted(self.counts.items())),
        }


def _is_raw(running: RunningFault) -> bool:
    return getattr(running.model, "mode", "") == "raw"


def _release_text(release: Release, now_ns: int) -> str:
    late = release.time_ns - now_ns
    return frame_text(release.frame) + (f" after {late / 1e6:g} ms" if late > 0 else "")


def check_levels(faults: Iterable[Fault], *, real_bus: bool) -> None:
    """Refuse faults that would be realised at a less real level than they require.

    Raises
    ------
    InputError
        Naming the first of them.
    """
    for fault in faults:
        kind = type(fault.disturbance.model)
        level = realised_level(kind, real_bus=real_bus)
        if fault.requires is not None and not at_least(level, fault.requires):
            raise InputError(
                f"fault {fault.name}: {fault.disturbance.kind} requires {fault.requires}",
                found=f"here it is realised as {level}",
                mend="lower `requires`, or run it where that level exists (docs/can_faults.md)",
            )
