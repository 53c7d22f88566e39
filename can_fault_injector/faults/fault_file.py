"""Fault files, and the list of faults in a scenario: trigger × disturbance × duration and repetition.

format: 1
faults:
  - name: late_wheel_speeds
    trigger: {id: 0x120, mask: 0x7FE, direction: to_ecu, phase: brake}
    disturbance: {delay: {by: 20 ms}}
    duration: 1 s
  - name: flipped_crc
    trigger: {id: 0x130, state: {signal: speed, below: 60 km/h}, probability: 10 %}
    disturbance: {flip: {at: crc.3}}
    times: 20
    requires: bit_model
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from can_fault_injector.faults import bit_level, frame_level, node_level, signal_level, wire_level
from can_fault_injector.faults.levels import DisturbanceModel, Level
from can_fault_injector.faults.trigger import Trigger
from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from signals.yaml_files import load_yaml, validate


class Disturbance(FileModel):
    """What a fault does; exactly one of the fields."""

    flip: bit_level.Flip | None = Field(default=None, description="bits inverted")
    force: bit_level.Force | None = Field(default=None, description="bits forced to a level")
    glitch: bit_level.Glitch | None = Field(default=None, description="pulse shorter than a bit")
    stuff_error: bit_level.StuffError | None = Field(default=None, description="six equal bits at a receiver")
    crc_error: bit_level.CrcError | None = Field(default=None, description="wrong CRC at a receiver")
    form_error: bit_level.FormError | None = Field(default=None, description="dominant delimiter or EOF")
    ack_error: bit_level.AckError | None = Field(default=None, description="acknowledgement not seen by the sender")
    bit_error: bit_level.BitError | None = Field(default=None, description="sender reads back another level")
    error_flag: bit_level.ErrorFlag | None = Field(default=None, description="error flag of another node")
    overload: bit_level.Overload | None = Field(default=None, description="overload frames after the frame")
    endless_overload: bit_level.EndlessOverload | None = Field(default=None, description="overload without end")
    double_receive: bit_level.DoubleReceive | None = Field(default=None, description="dominant last bit of EOF")
    inconsistent_omission: bit_level.InconsistentOmission | None = Field(
        default=None, description="some receivers have the frame, one does not"
    )
    janus: bit_level.Janus | None = Field(default=None, description="one frame, two contents")
    in_line_device: bit_level.InLineDevice | None = Field(default=None, description="forwarded below a bit later")
    bus_off_attack: bit_level.BusOffAttack | None = Field(default=None, description="destroyed until bus-off")

    drop: frame_level.Drop | None = Field(default=None, description="frame not handed on")
    duplicate: frame_level.Duplicate | None = Field(default=None, description="frame handed on again")
    delay: frame_level.Delay | None = Field(default=None, description="frame handed on later")
    reorder: frame_level.Reorder | None = Field(default=None, description="frames change places")
    replay: frame_level.Replay | None = Field(default=None, description="older frame in place of the present one")
    corrupt: frame_level.Corrupt | None = Field(default=None, description="bits of the payload changed")
    wrong_length: frame_level.WrongLength | None = Field(default=None, description="other data length code")
    rewrite_id: frame_level.RewriteId | None = Field(default=None, description="other identifier")
    to_remote: frame_level.ToRemote | None = Field(default=None, description="data frame becomes a remote frame")
    masquerade: frame_level.Masquerade | None = Field(default=None, description="frame in another sender's name")
    spoof: frame_level.Spoof | None = Field(default=None, description="made-up frames inserted")
    spoof_error_passive: frame_level.SpoofErrorPassive | None = Field(
        default=None, description="frames of an error passive sender overwritten"
    )
    babbling_idiot: frame_level.BabblingIdiot | None = Field(default=None, description="a node that never stops")
    bus_load: frame_level.BusLoad | None = Field(default=None, description="bus filled up to a load")
    freeze: frame_level.Freeze | None = Field(default=None, description="contents stand still")

    offset: signal_level.Offset | None = Field(default=None, description="constant added to a signal")
    stuck: signal_level.Stuck | None = Field(default=None, description="signal stays at a value")
    ramp: signal_level.Ramp | None = Field(default=None, description="growing amount added to a signal")
    noise: signal_level.SignalNoise | None = Field(default=None, description="white noise added to a signal")
    swap_wheels: signal_level.SwapWheels | None = Field(default=None, description="two signals change places")
    unit_error: signal_level.UnitError | None = Field(default=None, description="signal in another unit")

    error_passive: node_level.ErrorPassive | None = Field(default=None, description="node driven error passive")
    bus_off: node_level.BusOff | None = Field(default=None, description="node driven bus-off")
    reset: node_level.Reset | None = Field(default=None, description="node restarts")
    off: node_level.Off | None = Field(default=None, description="node sends nothing")

    open: wire_level.Open | None = Field(default=None, description="conductor broken")
    short: wire_level.Short | None = Field(default=None, description="conductor shorted")
    stuck_dominant: wire_level.StuckDominant | None = Field(default=None, description="bus held dominant")

    @model_validator(mode="after")
    def _one_kind(self) -> "Disturbance":
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise FieldError("a fault has exactly one disturbance", found=found, allowed="one of the kinds")
        return self

    @property
    def kind(self) -> str:
        """Name of what it does."""
        return next(name for name in type(self).model_fields if getattr(self, name) is not None)

    @property
    def model(self) -> DisturbanceModel:
        """What it does, with its numbers."""
        model: DisturbanceModel = getattr(self, self.kind)
        return model


class Fault(FileModel):
    """One fault: which frames and when, what happens, how long and how often."""

    name: str = Field(
        default="", pattern=r"^[a-z0-9_]*$", description="name in reports; by default its disturbance and number"
    )
    trigger: Trigger = Field(default_factory=Trigger, description="which frames, when; by default every frame, always")
    disturbance: Disturbance = Field(description="what happens")
    times: int | None = Field(default=None, ge=1, description="ends after so many disturbed frames; by default never")
    duration: float | None = parameter(
        "s", None, low=0.0001, high=36000.0, description="ends this long after it first acted; by default never"
    )
    repeat: int = Field(default=1, ge=1, le=1_000_000, description="how often it runs, each with times and duration")
    pause: float = parameter("s", 0.0, low=0.0, high=36000.0, description="from its end to its next run")
    requires: Level | None = Field(
        default=None, description="the run is refused where the fault would be realised at a less real level"
    )

    @model_validator(mode="after")
    def _ends(self) -> "Fault":
        if self.times is not None and self.disturbance.model.lasts:
            raise FieldError("it lasts and does not count frames", at=("times",), allowed="duration and repeat")
        if self.repeat > 1 and self.times is None and self.duration is None:
            raise FieldError("it never ends, so it cannot be repeated", at=("repeat",), allowed="times or duration")
        return self


def name_faults(faults: Sequence[Fault]) -> None:
    """Give every fault a name of its own.

    Raises
    ------
    FieldError
        If two have the same.
    """
    seen: set[str] = set()
    for number, fault in enumerate(faults):
        name = fault.name or f"{fault.disturbance.kind}_{number + 1}"
        if name in seen:
            raise FieldError("two faults of one name", at=("faults", number, "name"), found=repr(name))
        seen.add(name)
        object.__setattr__(fault, "name", name)


class FaultsFile(FileModel):
    """A list of faults on one bus."""

    format: Literal[1] = Field(default=1, description="version of this format")
    title: str = Field(default="", description="one line")
    description: str = Field(default="", description="what the faults are for")
    requires: Level | None = Field(default=None, description="level for every fault that names none of its own")
    faults: list[Fault] = Field(min_length=1, description="in this order they act on a frame")

    @model_validator(mode="after")
    def _complete(self) -> "FaultsFile":
        name_faults(self.faults)
        for fault in self.faults:
            object.__setattr__(fault, "requires", fault.requires or self.requires)
        return self

    def __iter__(self) -> Iterator[Fault]:  # type: ignore[override]
        return iter(self.faults)


def load_faults(path: str | Path) -> FaultsFile:
    """Read a fault file.

    Raises
    ------
    InputError
        With every fault of the file, its line and field.
    """
    return validate(load_yaml(path), FaultsFile)
