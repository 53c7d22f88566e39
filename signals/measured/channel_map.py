"""Channel maps: which column or CAN signal of a foreign log is which of our signals, in which unit.

.. code-block:: yaml

    file_format: auto
    clock: {column: Time, unit: s}
    channels:
      speed: {source: Car.vx, unit: m/s}
      yaw_rate: {source: Car.YawRate, unit: rad/s, sign: -1}
      wheel_speed_fl: {source: WHEELS.FL, unit: km/h}      # a speed: divided by the vehicle's wheel radius
"""

from functools import cache
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from signals.catalogue import catalogue
from signals.errors import FieldError, FieldErrors, nearest_name
from signals.quantities import FileModel, QuantityError, parameter, to_si
from signals.units import parse_unit
from signals.wheels import WHEELS

FileFormat = Literal["auto", "mf4", "csv", "parquet", "blf", "asc", "candump"]

# measured quantities that no signal of a run is: name -> unit
_MEASURED_ONLY = {
    "road_wheel_angle": "rad",
    **{f"wheel_vertical_acceleration_{wheel}": "m/s^2" for wheel in WHEELS},
}


@cache
def channel_units() -> dict[str, str]:
    """Unit of every name that a channel map may give a value to."""
    return {signal.name: signal.unit for signal in catalogue()} | _MEASURED_ONLY


class Clock(FileModel):
    """Time of the log's rows; CAN logs and MF4 files bring their own."""

    column: str = Field(default="", description="column with the time; without it the first column")
    unit: str = Field(default="s", description="s, ms, us, ns, min or h")


class Channel(FileModel):
    """Where one of our signals stands in the log."""

    source: str = Field(min_length=1, description="column, MF4 channel (NAME or NAME#GROUP) or Message.Signal")
    unit: str | None = Field(default=None, description="unit in the log; by default ours")
    scale: float = Field(default=1.0, description="factor on the value in the log's unit")
    sign: Literal[1, -1] = Field(default=1, description="-1 where the log counts the other way (ours: ISO 8855)")
    delay_s: float = parameter("s", 0.0, low=-10.0, high=10.0, description="how much the log is late with it")
    teeth: int | None = Field(
        default=None,
        ge=4,
        le=512,
        description="of a wheel's tone ring: a diagnosis takes half a tooth off its times, and trusts no tooth of 5 ms",
    )


class ChannelMap(FileModel):
    """A channel map file."""

    format: Literal[1] = 1
    file_format: FileFormat = Field(
        default="auto", description="format of the log; auto goes by the file's name and content"
    )
    dbc: str | None = Field(default=None, description="CAN database of a CAN log, path relative to this file")
    clock: Clock = Field(default_factory=Clock)
    channels: dict[str, Channel] = Field(description="our signal name: where it stands in the log")

    @model_validator(mode="after")
    def _known(self) -> "ChannelMap":
        errors = [error for name, channel in self.channels.items() if (error := _fault(name, channel)) is not None]
        if parse_unit(self.clock.unit) is None or not _converts(self.clock.unit, "s"):
            errors.append(FieldError("no unit of time", at=("clock", "unit"), allowed="s, ms, us, ns, min, h"))
        if errors:
            raise FieldErrors(errors)
        return self


def _fault(name: str, channel: Channel) -> FieldError | None:
    units = channel_units()
    if name not in units:
        return FieldError("no signal of this name", at=("channels", name), nearest=nearest_name(name, list(units)))
    if channel.teeth is not None and not name.startswith("wheel_speed_"):
        return FieldError("no wheel's speed has teeth here", at=("channels", name, "teeth"), allowed="of wheel_speed_*")
    if channel.unit is None or _converts(channel.unit, units[name]) or is_rim_speed(name, channel):
        return None
    allowed = f"{units[name]} and its multiples" + (", or a speed" if name.startswith("wheel_speed_") else "")
    return FieldError("wrong unit", at=("channels", name, "unit"), found=channel.unit, allowed=allowed)


def _converts(unit: str, to: str) -> bool:
    try:
        to_si(f"1 {unit}", to)
    except QuantityError:
        return False
    return True


def is_rim_speed(name: str, channel: Channel) -> bool:
    """True for a wheel speed that the log has as a speed along the road, radius times rotation."""
    return name.startswith("wheel_speed_") and channel.unit is not None and _converts(channel.unit, "m/s")


def load_channel_map(path: str | Path) -> ChannelMap:
    """Read a channel map; its ``dbc`` becomes a path that can be opened from here.

    Raises
    ------
    InputError
        If the file is missing or wrong, with the place of every fault.
    """
    from signals.yaml_files import load_yaml, validate

    document = load_yaml(path)
    channel_map = validate(document, ChannelMap)
    if channel_map.dbc is not None:
        channel_map = channel_map.model_copy(update={"dbc": str(document.folder / channel_map.dbc)})
    return channel_map
