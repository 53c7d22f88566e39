"""Conditions in files, evaluated inside the tick: when a step of the manoeuvre ends, when a stimulus begins.

``{signal: speed, below: 5 km/h}``, ``{time: 2 s}``, ``{after: 0.5 s}``, ``{distance: 50 m}``, ``{phase: brake}``, and
``{all: […]}``, ``{any: […]}``, ``{not: …}`` of them; ``lasting: 0.2 s`` beside any of them asks that it has held for
that long without a break.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict, Field, model_validator

from signals.catalogue import catalogue
from signals.errors import FieldError, FieldErrors, nearest_name
from signals.quantities import FileModel, QuantityError, parameter, to_si

if TYPE_CHECKING:
    from signals.vector import SignalVector

Holds = Callable[[float], bool]
"""True if the condition holds now; the argument is the time at which its owner was armed [s]."""

_KINDS = ("signal", "time", "after", "distance", "phase", "all", "any", "not")
_THRESHOLDS = ("below", "above", "equals")
# times are whole ticks of 1 ms in floating point: a difference of two may be short of a multiple by some ulp
_TIME_TOLERANCE_S = 1e-6


class Condition(FileModel):
    """A condition over the signals of a run; exactly one kind of it, see the fields."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, populate_by_name=True, serialize_by_alias=True)

    signal: str | None = Field(
        default=None, description="signal of the catalogue or output of an estimator; needs a threshold"
    )
    below: float | str | None = Field(
        default=None, description="holds while the signal is below this value (its unit, or SI)"
    )
    above: float | str | None = Field(default=None, description="holds while the signal is above this value")
    equals: float | str | None = Field(default=None, description="holds while the signal has this value (to 1e-9)")
    time: float | None = parameter("s", None, low=0.0, description="holds from this time after the start of the run on")
    after: float | None = parameter(
        "s", None, low=0.0, description="holds from this time on, since the step began or the stimulus was armed"
    )
    distance: float | None = parameter("m", None, low=0.0, description="holds after this path has been driven")
    phase: str | None = Field(default=None, description="holds while this step of the manoeuvre is active")
    all: "list[Condition] | None" = Field(default=None, min_length=1, description="all of these hold")
    any: "list[Condition] | None" = Field(default=None, min_length=1, description="at least one of these holds")
    not_: "Condition | None" = Field(default=None, alias="not", description="this does not hold")
    lasting: float | None = parameter("s", None, low=0.0, description="… and has held without a break for this time")

    @model_validator(mode="after")
    def _one_kind(self) -> "Condition":
        given = [kind for kind in _KINDS if self._field(kind) is not None]
        if len(given) != 1:
            found = f"{len(given)} kinds ({', '.join(given)})" if given else "none of them"
            raise FieldError("a condition has exactly one kind", found=found, allowed=", ".join(_KINDS))
        thresholds = [name for name in _THRESHOLDS if self._field(name) is not None]
        if self.signal is None and thresholds:
            raise FieldError("a threshold needs a signal", at=(thresholds[0],), allowed="signal: NAME beside it")
        if self.signal is not None:
            if not thresholds:
                raise FieldError("a signal needs a threshold", at=("signal",), allowed=", ".join(_THRESHOLDS))
            self._convert_thresholds(thresholds)
        return self

    def _field(self, kind: str) -> Any:
        return self.not_ if kind == "not" else getattr(self, kind)

    def _convert_thresholds(self, thresholds: Sequence[str]) -> None:
        """Thresholds in SI; for an estimator's output, whose unit is not known here, once it is compiled."""
        name = self.signal or ""
        unit = _UNITS.get(name)
        if unit is None:
            if "." not in name:
                raise FieldError("unknown signal", at=("signal",), nearest=nearest_name(name, list(_UNITS)))
            return
        for threshold in thresholds:
            object.__setattr__(self, threshold, _threshold(self._field(threshold), unit, threshold))

    def faults(self, units: Mapping[str, str], phases: Sequence[str]) -> list[FieldError]:
        """What does not fit a run.

        Parameters
        ----------
        units : mapping
            Unit of every signal of the run by name.
        phases : sequence of str
            Steps of its manoeuvre.
        """
        if self.signal is not None and self.signal not in units:
            return [FieldError("unknown signal", at=("signal",), nearest=nearest_name(self.signal, list(units)))]
        if self.signal is not None:
            return _threshold_faults(self, units[self.signal])
        if self.phase is not None and self.phase not in phases:
            near = nearest_name(self.phase, phases)
            return [FieldError("no such phase", at=("phase",), nearest=near, allowed=", ".join(phases))]
        return [
            FieldError(e.problem, at=(*where, *e.at), found=e.found, allowed=e.allowed, nearest=e.nearest)
            for where, inner in self._parts()
            for e in inner.faults(units, phases)
        ]

    def _parts(self) -> list[tuple[tuple[str | int, ...], "Condition"]]:
        parts: list[tuple[tuple[str | int, ...], Condition]] = []
        for kind, members in (("all", self.all), ("any", self.any)):
            parts += [((kind, number), member) for number, member in enumerate(members or ())]
        if self.not_ is not None:
            parts.append((("not",), self.not_))
        return parts

    def compile(self, vector: "SignalVector", phase_names: Sequence[str]) -> Holds:
        """Function that tells inside the tick whether the condition holds.

        It reads the vector as it is at the call. With ``lasting`` it remembers since when the condition holds, so every
        owner compiles its own.

        Raises
        ------
        FieldErrors
            If the run has no such signal or phase.
        """
        faults = self.faults({signal.name: signal.unit for signal in vector.signals}, phase_names)
        if faults:
            raise FieldErrors(faults)
        holds = self._compile_kind(vector, phase_names)
        return holds if self.lasting is None else _lasting(holds, self.lasting, vector)

    def _compile_kind(self, vector: "SignalVector", phase_names: Sequence[str]) -> Holds:
        if self.signal is not None:
            return _compile_thresholds(self, vector)
        item, now = vector.values.item, vector.index("time")
        if self.time is not None:
            start = self.time - _TIME_TOLERANCE_S
            return lambda armed_s: item(now) >= start
        if self.after is not None:
            wait = self.after - _TIME_TOLERANCE_S
            return lambda armed_s: item(now) - armed_s >= wait
        if self.distance is not None:
            way, driven = self.distance, vector.index("distance")
            return lambda armed_s: item(driven) >= way
        if self.phase is not None:
            active, number = vector.index("manoeuvre_phase"), float(list(phase_names).index(self.phase))
            return lambda armed_s: item(active) == number
        return self._compile_parts(vector, phase_names)

    def _compile_parts(self, vector: "SignalVector", phase_names: Sequence[str]) -> Holds:
        parts = [part.compile(vector, phase_names) for _, part in self._parts()]
        if self.not_ is not None:
            return lambda armed_s: not parts[0](armed_s)
        # lists, not generators: a part with `lasting` has to see every tick
        if self.any is not None:
            return lambda armed_s: any([part(armed_s) for part in parts])  # noqa: C419
        return lambda armed_s: all([part(armed_s) for part in parts])  # noqa: C419


_UNITS = {signal.name: signal.unit for signal in catalogue()}


def _threshold(value: float | str, unit: str, name: str) -> float:
    try:
        return to_si(value, unit)
    except QuantityError as error:
        raise FieldError(error.problem, at=(name,), allowed=error.allowed) from None


def _threshold_faults(condition: Condition, unit: str) -> list[FieldError]:
    faults = []
    for name in _THRESHOLDS:
        value = getattr(condition, name)
        if isinstance(value, str):
            try:
                _threshold(value, unit, name)
            except FieldError as error:
                faults.append(error)
    return faults


def _compile_thresholds(condition: Condition, vector: "SignalVector") -> Holds:
    position = vector.index(condition.signal or "")
    unit, item = vector.signals[position].unit, vector.values.item
    below, above, equals = (
        None if value is None else _threshold(value, unit, name)
        for name, value in zip(_THRESHOLDS, (condition.below, condition.above, condition.equals), strict=True)
    )
    if equals is not None:
        return lambda armed_s: abs(item(position) - equals) <= 1e-9
    low, high = float("-inf") if above is None else above, float("inf") if below is None else below
    return lambda armed_s: low < item(position) < high


def _lasting(holds: Holds, duration_s: float, vector: "SignalVector") -> Holds:
    item, now = vector.values.item, vector.index("time")
    since = float("inf")

    def value(armed_s: float) -> bool:
        nonlocal since
        if not holds(armed_s):
            since = float("inf")
            return False
        time_s: float = item(now)
        since = min(since, time_s)
        return time_s - since >= duration_s - _TIME_TOLERANCE_S

    return value
