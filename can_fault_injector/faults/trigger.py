"""Triggers: which frames, when, and in which state of the car a fault acts. All given fields have to hold together."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from signals.conditions import Condition
from signals.errors import FieldError, nearest_name
from signals.quantities import FileModel, parameter

Direction = Literal["to_ecu", "to_bench", "both"]
STANDARD_MASK, EXTENDED_MASK = 0x7FF, 0x1FFFFFFF


def _as_list(value: object) -> object:
    return [value] if isinstance(value, (int, str)) and not isinstance(value, bool) else value


Identifiers = Annotated[list[int], BeforeValidator(_as_list, json_schema_input_type=int | list[int])]
Names = Annotated[list[str], BeforeValidator(_as_list, json_schema_input_type=str | list[str])]


class PayloadCondition(FileModel):
    """A condition on the contents of the very frame that passes: a decoded signal, or bits of a byte."""

    signal: str | None = Field(default=None, description="signal that this frame carries, by its catalogue name")
    below: float | str | None = Field(default=None, description="the signal is below this value (its unit, or SI)")
    above: float | str | None = Field(default=None, description="the signal is above this value")
    byte: int | None = Field(default=None, ge=0, le=63, description="byte of the payload, counted from 0")
    mask: int = Field(default=0xFF, ge=0, le=0xFF, description="bits of the byte that are compared")
    equals: float | str | None = Field(default=None, description="value of the signal (to 1e-9) or of the masked byte")

    @model_validator(mode="after")
    def _complete(self) -> "PayloadCondition":
        if (self.signal is None) == (self.byte is None):
            raise FieldError("either a signal or a byte", allowed="signal: NAME or byte: N")
        if self.byte is not None:
            if not isinstance(self.equals, (int, float)) or self.below is not None or self.above is not None:
                raise FieldError("a byte is compared with a number", at=("byte",), allowed="equals: 0…255 beside it")
            return self
        # the condition's own validator knows the unit of each signal
        condition = Condition(signal=self.signal, below=self.below, above=self.above, equals=self.equals)
        for name in ("below", "above", "equals"):
            object.__setattr__(self, name, getattr(condition, name))
        return self


class Trigger(FileModel):
    """Which frames a fault acts on, and when; what is left out is not asked for."""

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, validate_default=False, populate_by_name=True, serialize_by_alias=True
    )

    id: Identifiers | None = Field(
        default=None, min_length=1, description="identifier of the frames, or several; without it every frame"
    )
    mask: int | None = Field(
        default=None, ge=0, le=EXTENDED_MASK, description="bits of the identifier that are compared; by default all"
    )
    extended: bool | None = Field(default=None, description="only frames with 29 (true) or 11 bits (false)")
    direction: Direction = Field(
        default="both", description="frames on their way to the ECU, to the bench, or both; the injector is between"
    )
    payload: PayloadCondition | None = Field(default=None, description="condition on the frame's contents")
    nth: int = Field(default=1, ge=1, description="first frame of those that match everything else, counted from 1")
    every: int = Field(default=1, ge=1, description="from there on each frame (1), each second one (2), …")
    start: float | None = Field(
        default=None,
        alias="from",
        ge=0.0,
        description="from this time after the start of the run on",
        json_schema_extra={"unit": "s"},
    )
    until: float | None = parameter("s", None, low=0.0, description="up to this time after the start of the run")
    probability: float = parameter("1", 1.0, low=0.0, high=1.0, description="share of the matching frames, drawn")
    phase: Names | None = Field(
        default=None, min_length=1, description="while one of these steps of the manoeuvre is active"
    )
    state: Condition | None = Field(default=None, description="while this holds of the car, as in stimuli")
    event: Literal["frame", "error_frame"] = Field(
        default="frame", description="frame: a matching frame; error_frame: the first matching frame after an error"
    )

    @model_validator(mode="after")
    def _consistent(self) -> "Trigger":
        for number, identifier in enumerate(self.id or ()):
            limit = STANDARD_MASK if self.extended is False else EXTENDED_MASK
            if not 0 <= identifier <= limit:
                raise FieldError("no identifier", at=("id", number), found=f"{identifier:#x}", allowed=f"0…{limit:#x}")
        if self.start is not None and self.until is not None and self.until <= self.start:
            raise FieldError("ends before it begins", at=("until",), allowed="a time after `from`")
        return self

    def faults(self, units: Mapping[str, str], phases: Sequence[str]) -> list[FieldError]:
        """What does not fit a run: signals by name with their unit, and the phases of its manoeuvre."""
        faults = []
        for number, phase in enumerate(self.phase or ()):
            if phase not in phases:
                near, allowed = nearest_name(phase, phases), ", ".join(phases) or "none: there is no manoeuvre"
                at = ("trigger", "phase", number)
                faults.append(FieldError("no such phase", at=at, nearest=near, allowed=allowed))
        for error in self.state.faults(units, phases) if self.state is not None else ():
            where = ("trigger", "state", *error.at)
            faults.append(
                FieldError(error.problem, at=where, found=error.found, allowed=error.allowed, nearest=error.nearest)
            )
        return faults

    @property
    def selects_frames(self) -> bool:
        """Whether it asks for anything that only a frame can answer."""
        asked = (self.id, self.payload, self.extended)
        return any(item is not None for item in asked) or self.nth > 1 or self.every > 1 or self.event != "frame"
