"""Stimuli: any parameter or signal changed while the run goes on, at a time or on a condition.

A parameter is set through the part that owns it. A signal is overridden right after the part that computes it, at one
of three places of the tick, so that everything downstream sees the changed value and nothing upstream does.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from bench.loop.waveforms import Waveform
from signals.catalogue import block_slice
from signals.errors import InputError
from signals.vector import SignalVector

SetParameter = Callable[[float], None]
GetParameter = Callable[[], float]


class Stage(Enum):
    """Place of the tick at which a signal is overridden."""

    COMMANDS = "after driver and stimuli"
    ACTUATION = "after hydraulics and powertrain"
    SENSED = "after the sensors"


_STAGE_OF_BLOCK = {
    "driver": Stage.COMMANDS,
    "hydraulics": Stage.ACTUATION,
    "powertrain": Stage.ACTUATION,
}
_FROM_ECU = ("valve_", "pump", "abs_", "ebd_", "ecu_")


@dataclass
class Stimulus:
    """One change of one target.

    Attributes
    ----------
    name : str
        Name in reports.
    target : str
        Dotted path of a parameter or name of a signal.
    begins : callable
        Condition on the vector; its argument is the time at which the stimulus was armed (start of the run).
    waveform : callable
        Value as a function of the time since it began.
    duration_s : float
        Infinity for one that never ends.
    restore : bool
        At its end a parameter gets back the value that it had.
    """

    name: str
    target: str
    begins: Callable[[float], bool]
    make_waveform: Callable[[float], Waveform]
    duration_s: float = float("inf")
    restore: bool = True
    relative: bool = False


@dataclass
class _Active:
    stimulus: Stimulus
    waveform: Waveform
    began_s: float
    before: float


class Stimuli:
    """Runs the stimuli of a scenario inside the tick.

    Parameters
    ----------
    vector : SignalVector
        Signals of the run.
    sensed : array
        What the bench is about to send, with the layout of block "bus".
    stimuli : sequence of Stimulus
        In file order; of two on one target the later one wins.
    parameters : mapping
        Dotted path to (get, set) of the part that owns the parameter.

    Raises
    ------
    InputError
        If a target is neither a parameter nor a signal that can be overridden.
    """

    def __init__(
        self,
        vector: SignalVector,
        sensed: NDArray[np.float64],
        stimuli: Sequence[Stimulus],
        parameters: Mapping[str, tuple[GetParameter, SetParameter]],
    ) -> None:
        self._vector = vector
        self._sensed = sensed
        self._parameters = parameters
        self._waiting = list(stimuli)
        self._parameter_stimuli: list[_Active] = []
        self._overrides: dict[Stage, list[tuple[_Active, int]]] = {stage: [] for stage in Stage}
        self._set_last: dict[str, float] = {}
        self._time_s = 0.0
        self.active_count = 0
        self.log: list[tuple[float, str, str]] = []
        for stimulus in stimuli:
            if stimulus.target not in parameters:
                self._stage(stimulus.target)

    def _stage(self, name: str) -> tuple[Stage, int]:
        """Stage and position of a signal that can be overridden."""
        try:
            position = self._vector.index(name)
        except KeyError:
            raise InputError(f"stimulus: {name!r} is neither a parameter nor a signal of this run") from None
        block = self._vector.signals[position].block
        if block in _STAGE_OF_BLOCK:
            return _STAGE_OF_BLOCK[block], position
        if block == "bus":
            stage = Stage.COMMANDS if name.startswith(_FROM_ECU) else Stage.SENSED
            return stage, position if stage is Stage.COMMANDS else position - block_slice("bus").start
        raise InputError(
            f"stimulus: {name!r} is an outcome of the simulated car and cannot be overridden; "
            "change a parameter, a driver, hydraulic or powertrain signal, or the signal that the bus carries"
        )

    @property
    def idle(self) -> bool:
        """True while none acts and none waits for its condition."""
        return not self.active_count and not self._waiting

    def tick(self, time_s: float) -> None:
        """Begin what is due, set the parameters of what is active, end what is over."""
        self._time_s = time_s
        if self._waiting:
            due = [stimulus for stimulus in self._waiting if stimulus.begins(0.0)]
            for stimulus in due:
                self._waiting.remove(stimulus)
                self._begin(stimulus)
        if not self.active_count:
            return
        for active in self._parameter_stimuli[:]:
            if self._over(active):
                self._end_parameter(active)
            else:
                self._set(active, active.waveform(time_s - active.began_s))
        for overrides in self._overrides.values():
            for entry in overrides[:]:
                if self._over(entry[0]):
                    overrides.remove(entry)
                    self._note(entry[0].stimulus, "ends")

    def _set(self, active: _Active, value: float) -> None:
        """Set a parameter, if it is not what was set last: filling a part's tables anew takes much of a tick."""
        target = active.stimulus.target
        wanted = active.before + value if active.stimulus.relative else value
        if self._set_last.get(target) != wanted:
            self._parameters[target][1](wanted)
            self._set_last[target] = wanted

    def _over(self, active: _Active) -> bool:
        # a microsecond less, so that rounding of the times does not add a tick
        return self._time_s - active.began_s >= active.stimulus.duration_s - 1e-6

    def _note(self, stimulus: Stimulus, event: str) -> None:
        self.active_count += 1 if event == "begins" else -1
        self.log.append((self._time_s, stimulus.name, event))

    def _begin(self, stimulus: Stimulus) -> None:
        self._note(stimulus, "begins")
        if stimulus.target in self._parameters:
            before = self._parameters[stimulus.target][0]()
            active = _Active(stimulus, stimulus.make_waveform(before), self._time_s, before)
            self._parameter_stimuli.append(active)
            return
        stage, position = self._stage(stimulus.target)
        source = self._sensed if stage is Stage.SENSED else self._vector.values
        before = float(source[position])
        active = _Active(stimulus, stimulus.make_waveform(before), self._time_s, before)
        self._overrides[stage].append((active, position))

    def _end_parameter(self, active: _Active) -> None:
        self._parameter_stimuli.remove(active)
        if active.stimulus.restore:
            self._parameters[active.stimulus.target][1](active.before)
            self._set_last.pop(active.stimulus.target, None)
        self._note(active.stimulus, "ends")

    def _override(self, stage: Stage, values: NDArray[np.float64]) -> None:
        for active, position in self._overrides[stage]:
            value = active.waveform(self._time_s - active.began_s)
            values[position] = values[position] + value if active.stimulus.relative else value

    def override_commands(self) -> None:
        """Override signals of the driver and what the ECU's frames said."""
        if self.active_count:
            self._override(Stage.COMMANDS, self._vector.values)

    def override_actuation(self) -> None:
        """Override pressures, brake torques and drive torques on their way to the plant."""
        if self.active_count:
            self._override(Stage.ACTUATION, self._vector.values)

    def override_sensed(self) -> None:
        """Override what the sensors put into the bench's frames."""
        if self.active_count:
            self._override(Stage.SENSED, self._sensed)
