"""A fault while a run goes on: whether its trigger holds, since when it acts, when it is over, what it did."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from can_fault_injector.faults.contents import Contents
from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.trigger import EXTENDED_MASK, PayloadCondition
from can_fault_injector.frame import Frame

if TYPE_CHECKING:
    from signals.vector import SignalVector

Way = Literal["to_ecu", "to_bench"]
WAYS: tuple[Way, Way] = ("to_ecu", "to_bench")
NS_PER_S = 1e9
_TIME_TOLERANCE_NS = 1000
_EQUAL = 1e-9


@dataclass(frozen=True)
class FaultEvent:
    """One entry of the injector's log.

    Attributes
    ----------
    time_ns : int
        Since the start of the run.
    fault : str
        Name of the fault.
    what : str
        begins, acts, ends, cannot.
    detail : str
        Frame and what happened to it.
    """

    time_ns: int
    fault: str
    what: str
    detail: str = ""


class RunningFault:
    """Trigger and life of one fault.

    Parameters
    ----------
    vector : SignalVector, optional
        Signals of the run, only read; without it a trigger on the state or phase never holds.
    phases : sequence of str
        Steps of the manoeuvre, in the order of signal ``manoeuvre_phase``.
    generator : numpy.random.Generator
        Of this fault alone.
    """

    def __init__(
        self,
        fault: Fault,
        *,
        vector: "SignalVector | None",
        phases: Sequence[str],
        contents: Contents,
        generator: np.random.Generator,
        log: Callable[[FaultEvent], None],
    ) -> None:
        self.fault, self.model, self.kind = fault, fault.disturbance.model, fault.disturbance.kind
        self.generator = generator
        self.memory: dict[Any, Any] = {}
        """What the disturbance remembers from frame to frame while it acts."""
        self.figures = dict.fromkeys(self.model.figures, 0.0)
        """What the disturbance measured on the last frame, see `DisturbanceModel.figures`."""
        self.hits = 0
        self.runs = 0
        self.acting = False
        self._log = log
        self._contents = contents
        self._began_ns = self._resumes_ns = 0
        self._hits_of_run = 0
        self._matches = 0
        self._over = False
        self._error_seen = False
        self._compile(vector, phases)

    def _compile(self, vector: "SignalVector | None", phases: Sequence[str]) -> None:
        trigger = self.fault.trigger
        self._mask = EXTENDED_MASK if trigger.mask is None else trigger.mask
        self._identifiers = None if trigger.id is None else {number & self._mask for number in trigger.id}
        self._start_ns = round((trigger.start or 0.0) * NS_PER_S) - _TIME_TOLERANCE_NS
        self._until_ns = float("inf") if trigger.until is None else trigger.until * NS_PER_S - _TIME_TOLERANCE_NS
        self._state: Callable[[float], bool] | None = None
        self._phase: Callable[[], bool] | None = None
        if trigger.state is not None:
            self._state = _never if vector is None else trigger.state.compile(vector, phases)
        if trigger.phase is not None:
            if vector is None:
                self._phase = lambda: False
            else:
                wanted = {float(list(phases).index(name)) for name in trigger.phase}
                item, position = vector.values.item, vector.index("manoeuvre_phase")
                self._phase = lambda: item(position) in wanted

    def ways(self) -> tuple[Way, ...]:
        """Directions whose frames it acts on."""
        direction = self.fault.trigger.direction
        return WAYS if direction == "both" else (direction,)

    @property
    def over(self) -> bool:
        """True once it will never act again."""
        return self._over

    def gate(self, now_ns: int) -> bool:
        """Whether a frame may trigger it now; ends what is over. To be called once in every step of time."""
        if self._over:
            return False
        if self.acting and self._is_done(now_ns):
            self._end(now_ns)
        holds = self._start_ns <= now_ns < self._until_ns
        # each is asked every time: a condition with `lasting` has to see every step
        for condition in (self._phase, None if self._state is None else self._in_state):
            holds = (condition is None or condition()) and holds
        if now_ns >= self._until_ns and not self._over:
            self._finish(now_ns)
            return False
        if not holds and self.acting and self.model.lasts and self.fault.duration is None:
            self._end(now_ns)
        return holds and not self._over and now_ns >= self._resumes_ns

    def _in_state(self) -> bool:
        return self._state is not None and self._state(0.0)

    def _is_done(self, now_ns: int) -> bool:
        fault = self.fault
        if fault.duration is not None and now_ns - self._began_ns >= fault.duration * NS_PER_S - _TIME_TOLERANCE_NS:
            return True
        return fault.times is not None and self._hits_of_run >= fault.times

    def begin(self, now_ns: int, detail: str = "") -> None:
        """It acts from now on."""
        if not self.acting:
            self.acting, self._began_ns, self._hits_of_run = True, now_ns, 0
            self.runs += 1
            self.memory.clear()
            self._log(FaultEvent(now_ns, self.fault.name, "begins", detail))

    def _end(self, now_ns: int) -> None:
        self.acting = False
        self._log(FaultEvent(now_ns, self.fault.name, "ends", f"{self._hits_of_run} frames" if self.hits else ""))
        limited = self.fault.times is not None or self.fault.duration is not None
        if limited and self.runs >= self.fault.repeat:
            self._over = True
        elif limited:
            self._resumes_ns = now_ns + round(self.fault.pause * NS_PER_S)

    def _finish(self, now_ns: int) -> None:
        if self.acting:
            self._end(now_ns)
        self._over = True

    def error_seen(self) -> None:
        """An error frame was on the bus: the next matching frame may trigger."""
        self._error_seen = True

    def may_take(self, way: Way, identifier: int) -> bool:
        """Whether frames of an identifier can be meant at all."""
        direction = self.fault.trigger.direction
        if direction not in ("both", way):
            return False
        return self._identifiers is None or identifier & self._mask in self._identifiers

    def takes(self, frame: Frame, way: Way, now_ns: int) -> bool:
        """Whether it acts on this frame; to be asked only while :meth:`gate` holds. Counts the frame if it does."""
        fault = self.fault
        if self._over or (self.acting and self._is_done(now_ns)):
            return False
        if not self._matches_frame(frame, way):
            return False
        if fault.trigger.event == "error_frame" and not self._error_seen:
            return False
        self._error_seen = False
        self._matches += 1
        past = self._matches - fault.trigger.nth
        if past < 0 or past % fault.trigger.every:
            return False
        if fault.trigger.probability < 1.0 and self.generator.random() >= fault.trigger.probability:
            return False
        self.begin(now_ns)
        self.hits += 1
        self._hits_of_run += 1
        return True

    def _matches_frame(self, frame: Frame, way: Way) -> bool:
        trigger = self.fault.trigger
        if not self.may_take(way, frame.identifier):
            return False
        if trigger.extended is not None and frame.extended != trigger.extended:
            return False
        return trigger.payload is None or self._payload_holds(trigger.payload, frame)

    def _payload_holds(self, condition: PayloadCondition, frame: Frame) -> bool:
        if condition.byte is not None:
            in_range = condition.byte < len(frame.data)
            return in_range and frame.data[condition.byte] & condition.mask == condition.equals
        value = self._contents.decode(frame).get(condition.signal or "")
        if value is None:
            return False
        below, above, equals = condition.below, condition.above, condition.equals
        return (
            (below is None or value < float(below))
            and (above is None or value > float(above))
            and (equals is None or abs(value - float(equals)) <= _EQUAL)
        )

    def note(self, now_ns: int, what: str, detail: str) -> None:
        """Add to the log."""
        self._log(FaultEvent(now_ns, self.fault.name, what, detail))


def _never(armed_s: float) -> bool:
    return False
