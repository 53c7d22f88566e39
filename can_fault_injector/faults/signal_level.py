"""Disturbances of a signal inside its frame, as a faulty sensor or sender would make them."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from pydantic import Field, model_validator

from can_fault_injector.faults.frame_level import Repair
from can_fault_injector.faults.levels import DisturbanceModel, E2EClass, Group, Level
from can_fault_injector.faults.trigger import Names
from signals.catalogue import catalogue
from signals.errors import FieldError, nearest_name
from signals.quantities import QuantityError, to_si

Value = float | str
_UNITS = {signal.name: signal.unit for signal in catalogue() if signal.block == "bus"}
_UNIT = "(number in SI, or a text with a unit)"
_REPAIR = "crc_and_counter: the message's protection is made anew, as if its sender were at fault; none: it tells"


def _check_names(names: Sequence[str]) -> None:
    for number, name in enumerate(names):
        if name not in _UNITS:
            near = nearest_name(name, list(_UNITS))
            allowed = "" if near else "a signal that the bus carries"
            raise FieldError("unknown signal", at=("signals", number), found=repr(name), nearest=near, allowed=allowed)


class SignalDisturbance(DisturbanceModel):
    """Base of the disturbances of signals: the signals of the frame that are changed."""

    group: ClassVar[Group] = "signal"
    e2e: ClassVar[E2EClass] = "corruption"
    realised_as: ClassVar[Level] = "frame_gateway"
    in_signal_unit: ClassVar[Mapping[str, str]] = {}
    """Fields that have the signal's unit, with what stands behind it."""

    signals: Names = Field(min_length=1, description="signal of the catalogue that the frames carry, or several")
    repair: Repair = Field(default="crc", description=_REPAIR)

    @model_validator(mode="after")
    def _known(self) -> "SignalDisturbance":
        _check_names(self.signals)
        self._values_in_si()
        return self

    def _values_in_si(self) -> None:
        unit = _UNITS[self.signals[0]]
        for name, per in self.in_signal_unit.items():
            value: Any = getattr(self, name)
            if value is None:
                continue
            try:
                object.__setattr__(self, name, to_si(value, unit + per))
            except QuantityError as error:
                raise FieldError(error.problem, at=(name,), allowed=error.allowed) from None


class Offset(SignalDisturbance):
    """A constant is added."""

    in_signal_unit: ClassVar[Mapping[str, str]] = {"by": ""}
    by: Value = Field(description=f"what is added {_UNIT}")


class Stuck(SignalDisturbance):
    """The signal stays at a value."""

    in_signal_unit: ClassVar[Mapping[str, str]] = {"at": ""}
    at: Value | None = Field(
        default=None, description=f"the value {_UNIT}; without it the one that it has when the fault begins"
    )


class Ramp(SignalDisturbance):
    """A growing amount is added."""

    in_signal_unit: ClassVar[Mapping[str, str]] = {"rate": "/s", "limit": ""}
    rate: Value = Field(description=f"growth per second {_UNIT}")
    limit: Value | None = Field(default=None, description=f"largest amount {_UNIT}; without it no limit")


class SignalNoise(SignalDisturbance):
    """White noise is added."""

    in_signal_unit: ClassVar[Mapping[str, str]] = {"standard_deviation": ""}
    standard_deviation: Value = Field(description=f"standard deviation {_UNIT}")


class UnitError(SignalDisturbance):
    """The sender means another unit: the value is multiplied, and shifted."""

    in_signal_unit: ClassVar[Mapping[str, str]] = {"shift": ""}
    factor: float = Field(description="e.g. 3.6 where km/h is sent in place of m/s")
    shift: Value = Field(default=0.0, description=f"added after the multiplication {_UNIT}")


class SwapWheels(DisturbanceModel):
    """Two signals of a frame change places, as after a mistake in the wiring."""

    group: ClassVar[Group] = "signal"
    e2e: ClassVar[E2EClass] = "incorrect_addressing"
    realised_as: ClassVar[Level] = "frame_gateway"

    signals: list[str] = Field(min_length=2, max_length=2, description="two signals that the same frame carries")
    repair: Repair = Field(default="crc", description=_REPAIR)

    @model_validator(mode="after")
    def _known(self) -> "SwapWheels":
        _check_names(self.signals)
        return self
