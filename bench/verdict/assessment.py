"""One run under judgement: its phases, its metrics and what was noted on the way, each worked out once."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import FloatArray, RunArrays
from bench.verdict.vocabulary import METRICS, PHASES

STANDSTILL_M_S = 0.1
BRAKING_DELAY_S = 0.4
BRAKING_END_M_S = 5.0
DECELERATION_HALF_SPAN_S = 0.01
FALLBACK_DECELERATION_M_S2 = 1.0

# signals that show the driver's actuation and the value above which they count, in order of trust: the simulated
# driver's own signals are exact, measured ones carry noise
_ACTUATION: tuple[tuple[tuple[str, float], ...], ...] = (
    (("driver_pedal_force", 0.0), ("driver_master_pressure", 0.0)),
    (("pedal_force", 5.0),),
    (("master_pressure", 1e5),),
    (("brake_switch", 0.5),),
)


class NoValueError(Exception):
    """The run has no value for a quantity; the text says why, for the verdict "inconclusive"."""


class Assessment:
    """Phases and metrics of a run.

    Parameters
    ----------
    data : RunArrays
        The run.
    wheel_radius_m : float, optional
        Rolling radius, needed where a foreign log has wheel speeds but no slip.
    """

    def __init__(self, data: RunArrays, *, wheel_radius_m: float | None = None) -> None:
        self.data = data
        self.time = data.time
        self.wheel_radius_m = wheel_radius_m
        self.notes: list[str] = []
        self._windows: dict[str, slice | NoValueError] = {}
        self._steps = data.steps()
        self._metrics: dict[Any, Any] = {}

    def signal(self, *names: str) -> FloatArray:
        """First of the named signals that the run has.

        Raises
        ------
        NoValueError
            If it has none of them.
        """
        for name in names:
            if name in self.data:
                return self.data.array(name)
        raise NoValueError(f"the recording has no signal {' or '.join(names)}")

    def wheel_signal(self, *names: str) -> FloatArray:
        """The same for a signal of the four wheels, shape (n, 4)."""
        for name in names:
            if f"{name}_fl" in self.data:
                return self.data.wheels(name)
        raise NoValueError(f"the recording has no signal {' or '.join(f'{name}_fl' for name in names)}")

    @property
    def slip(self) -> FloatArray:
        """Longitudinal slip of the wheels, shape (n, 4): the car's own, else from wheel speed and speed."""
        if "slip" not in self._metrics:
            self._metrics["slip"] = self._slip()
        slip: FloatArray = self._metrics["slip"]
        return slip

    def _slip(self) -> FloatArray:
        if "slip_ratio_fl" in self.data:
            return self.data.wheels("slip_ratio")
        if self.wheel_radius_m is None:
            raise NoValueError("slip needs slip_ratio_fl … or the wheel radius (--vehicle)")
        rim = self.wheel_signal("true_wheel_speed", "wheel_speed") * self.wheel_radius_m
        speed = self.signal("speed")[:, None]
        return (rim - speed) / np.maximum(np.maximum(rim, speed), 1e-3)

    @property
    def step_time_s(self) -> float:
        """Usual distance of two rows."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else 1e-3

    def phase_names(self) -> tuple[str, ...]:
        """Built-in phases and steps of the manoeuvre."""
        return (*PHASES, *(name for name in self.data.phase_names if name not in PHASES))

    def window(self, phase: slice | str | None) -> slice:
        """Rows of a phase.

        Raises
        ------
        NoValueError
            If the phase does not occur in this run.
        KeyError
            If there is no phase of this name.
        """
        if phase is None:
            return slice(0, len(self.time))
        if isinstance(phase, slice):
            return phase
        if phase not in self._windows:
            try:
                self._windows[phase] = self._find(phase)
            except NoValueError as error:
                self._windows[phase] = error
        found = self._windows[phase]
        if isinstance(found, NoValueError):
            raise found
        return found

    def _find(self, phase: str) -> slice:
        if phase == "run":
            window = slice(0, len(self.time))
        elif phase == "brake":
            start = self._brake_start()
            stop = self._standstill(start)
            window = slice(start, len(self.time) if stop is None else stop)
        elif phase == "braking":
            window = self._braking()
        elif phase in self._steps:
            window = self._steps[phase]
        elif phase in self.data.phase_names:
            raise NoValueError(f"the step {phase!r} was not reached")
        else:
            raise KeyError(phase)
        if window.stop <= window.start:
            raise NoValueError(f"the phase {phase!r} is empty")
        return window

    @property
    def brake_row(self) -> int:
        """Row of the brake start; NoValueError if nobody braked."""
        return self.window("brake").start

    def _brake_start(self) -> int:
        speed = self.signal("speed")
        applied = self._actuation()
        if applied is None:
            applied = self.deceleration() > FALLBACK_DECELERATION_M_S2
            self._note("brake start taken from the deceleration: the recording has no pedal force, pressure or switch")
        begins, ends = intervals(applied)
        if len(begins) == 0:
            raise NoValueError("the brake was not actuated")
        loss = speed[begins] - speed[np.minimum(ends, len(speed) - 1)]
        return int(begins[int(np.argmax(loss))])

    def _actuation(self) -> NDArray[np.bool_] | None:
        for group in _ACTUATION:
            present = [(name, threshold) for name, threshold in group if name in self.data]
            if present:
                over = [self.data.array(name) > threshold for name, threshold in present]
                return np.logical_or.reduce(over)
        return None

    def stop_row(self) -> int | None:
        """First row after the brake start at which the car stands (below 0.1 m/s), None if there is none."""
        return self._standstill(self.brake_row)

    def _standstill(self, start: int) -> int | None:
        standing = np.flatnonzero(self.signal("speed")[start:] < STANDSTILL_M_S)
        return start + int(standing[0]) if standing.size else None

    def _braking(self) -> slice:
        start = self.brake_row
        begin = int(np.searchsorted(self.time, self.time[start] + BRAKING_DELAY_S - 1e-9))
        slow = self.signal("speed")[begin:] < BRAKING_END_M_S
        end = begin + int(np.argmax(slow)) if slow.any() else self.window("brake").stop
        return slice(begin, end)

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def deceleration(self) -> FloatArray:
        """Loss of speed per time, shape (n,): central difference of the speed over ± 10 ms."""
        if "deceleration" not in self._metrics:
            speed, n = self.signal("speed"), len(self.time)
            reach = max(1, round(DECELERATION_HALF_SPAN_S / self.step_time_s))
            rows = np.arange(n)
            before, after = np.maximum(rows - reach, 0), np.minimum(rows + reach, n - 1)
            span = np.maximum(self.time[after] - self.time[before], 1e-9)
            self._metrics["deceleration"] = (speed[before] - speed[after]) / span
        deceleration: FloatArray = self._metrics["deceleration"]
        return deceleration

    def travelled(self) -> FloatArray:
        """Integral of the speed over time from the first row, shape (n,), in m."""
        if "travelled" not in self._metrics:
            speed = self.signal("speed")
            steps = np.diff(self.time) * 0.5 * (speed[1:] + speed[:-1])
            self._metrics["travelled"] = np.concatenate(([0.0], np.cumsum(steps)))
        travelled: FloatArray = self._metrics["travelled"]
        return travelled

    def metric(
        self, name: str, parameters: Mapping[str, float] | None = None, window: slice | str | None = None
    ) -> float | FloatArray:
        """Value of a metric: a float, or shape (4,) for one per wheel.

        Parameters
        ----------
        parameters : mapping, optional
            Parameters that differ from the metric's defaults, in SI units.
        window : slice or str, optional
            Phase instead of the metric's own.

        Raises
        ------
        NoValueError
            If this run has no value for it.
        """
        from bench.verdict import metrics

        definition = METRICS[name]
        values = {key: default for key, (default, _) in definition.parameters.items()} | dict(parameters or {})
        if definition.phase is None:
            rows = slice(0, 0)
        else:
            rows = self.window(window if window is not None else definition.phase)
        key = (name, tuple(sorted(values.items())), rows.start, rows.stop)
        if key not in self._metrics:
            compute = getattr(metrics, name)
            arguments = () if definition.phase is None else (rows,)
            self._metrics[key] = compute(self, *arguments, **values)
        value: float | FloatArray = self._metrics[key]
        return value


def intervals(condition: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First rows and rows after the last of each stretch in which a condition holds."""
    padded = np.concatenate(([False], condition, [False])).astype(np.int8)
    change = np.diff(padded)
    return np.flatnonzero(change == 1), np.flatnonzero(change == -1)
