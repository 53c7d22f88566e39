"""The mapping file: how an ECU's own CAN database stands for the bench's signal names.

.. code-block:: yaml

    format: 1
    dbc: my_car.dbc                # beside this file
    ecu: [ABS]                     # nodes of the database that the ECU under test plays
    signals:
      wheel_speed_fl: {signal: WHL_SPD.FL, unit: km/h, scale: 0.9}
      valve_inlet_fl: ABS_CMD.INLET_FL
    messages:
      ABS_CMD: {cycle: 10 ms, offset: 2 ms, data_ids: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]}

A value of ours is ``scale × (value of the database, in SI) + offset``. ``docs/bus.md`` tells it with an example.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, field_validator

from signals.catalogue import catalogue
from signals.errors import FieldError, nearest_name
from signals.quantities import FileModel, parameter

if TYPE_CHECKING:
    from signals.yaml_files import Document

BUS_NAMES: tuple[str, ...] = tuple(signal.name for signal in catalogue() if signal.block == "bus")
"""Names of block "bus", in the order of every array of decoded signals."""

Protection = Literal["full", "crc", "none"]
"""What a receiver checks of protected frames: CRC, alive counter and timeout; the CRC; nothing."""


def _known_name(name: str) -> str:
    if name not in BUS_NAMES:
        raise FieldError("no signal of the bus", nearest=nearest_name(name, BUS_NAMES))
    return name


class SignalSource(FileModel):
    """Where a signal of ours stands in the database."""

    signal: str = Field(pattern=r"^[^.\s]+\.[^.\s]+$", description="MESSAGE.SIGNAL of the database")
    unit: str | None = Field(
        default=None, description="unit of the database's value where it is no SI unit, e.g. km/h, bar, deg"
    )
    scale: float = Field(default=1.0, description="ours = scale × theirs + offset")
    offset: float = Field(default=0.0, description="ours = scale × theirs + offset")

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0.0:
            raise FieldError("a scale of 0 loses the value", allowed="any number but 0")
        return value


def _short_form(value: Any) -> Any:
    return {"signal": value} if isinstance(value, str) else value


class MessageSettings(FileModel):
    """What the database does not say of a message."""

    cycle: float | None = parameter("s", None, low=0.001, high=65.535, description="cycle time")
    offset: float | None = parameter("s", None, low=0.0, high=65.535, description="time of the first frame")
    data_ids: list[Annotated[int, Field(ge=0, le=255)]] | None = Field(
        None, min_length=16, max_length=16, description="data ids of AUTOSAR E2E Profile 2, one for each counter value"
    )


class MappingFile(FileModel):
    """Schema of a mapping file."""

    format: Literal[1] = 1
    dbc: str | None = Field(default=None, description="CAN database, path relative to this file")
    ecu: list[str] = Field(default_factory=lambda: ["ECU"], min_length=1, description="nodes that the ECU plays")
    signals: dict[
        Annotated[str, AfterValidator(_known_name)], Annotated[SignalSource, BeforeValidator(_short_form)]
    ] = Field(default_factory=dict, description="our signal name: MESSAGE.SIGNAL, or {signal, unit, scale, offset}")
    also_send: list[str] = Field(
        default_factory=list, description="messages that carry none of our signals and are sent with their start values"
    )
    messages: dict[str, MessageSettings] = Field(default_factory=dict, description="message: {cycle, offset, data_ids}")


def read_mapping(path: str | Path) -> "tuple[Document, MappingFile]":
    """Read a mapping file; the document knows the place of each value.

    Raises
    ------
    InputError
        With every fault of the file, its line and column.
    """
    from signals.yaml_files import load_yaml, validate

    document = load_yaml(path)
    return document, validate(document, MappingFile)
