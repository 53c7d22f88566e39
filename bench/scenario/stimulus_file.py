"""Stimuli in scenario files: a parameter or a signal takes another value at a time or on a condition.

    stimuli:
      - target: brakes.front.pad_friction        # any parameter or signal by name
        when: {phase: brake}
        ramp: {to: 0.2, over: 1 s}
      - target: wheel_speed_fl
        when: {time: 3 s}
        step: 0
        duration: 0.5 s

Values have the target's unit: numbers are SI, texts carry a unit.
"""

from pathlib import Path
from typing import Any

from pydantic import ConfigDict, Field, model_validator

from signals.conditions import Condition
from signals.errors import FieldError
from signals.quantities import FileModel, parameter

SHAPES = ("step", "ramp", "sine", "sweep", "noise", "table")
Value = float | str


class _Shape(FileModel):
    """Part of a stimulus whose numbers named in ``in_target_unit`` have the unit of the target."""

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, populate_by_name=True, serialize_by_alias=True, validate_default=False
    )


class Ramp(_Shape):
    """Linear change, then held."""

    start: Value | None = Field(default=None, alias="from", description="first value; without it the value before")
    to: Value = Field(description="last value")
    over: float = parameter("s", low=0.0, high=36000.0, description="duration of the change")


class Sine(_Shape):
    """Sine around an offset."""

    amplitude: Value = Field(description="half of peak to peak")
    frequency: float = parameter("Hz", low=0.0, high=500.0, description="")
    offset: Value | None = Field(default=None, description="mean; without it the value before, 0 if relative")
    phase: float = parameter("rad", 0.0, low=-100.0, high=100.0, description="at the beginning")


class Sweep(_Shape):
    """Sine whose frequency rises linearly."""

    amplitude: Value = Field(description="half of peak to peak")
    start: float = Field(
        alias="from", ge=0.0, le=500.0, description="first frequency", json_schema_extra={"unit": "Hz"}
    )
    to: float = parameter("Hz", low=0.0, high=500.0, description="last frequency")
    over: float = parameter("s", low=1e-3, high=36000.0, description="duration of the sweep")
    offset: Value | None = Field(default=None, description="mean; without it the value before, 0 if relative")


class Noise(_Shape):
    """White Gaussian noise, a new value each tick."""

    standard_deviation: Value = Field(description="of the noise")
    offset: Value | None = Field(default=None, description="mean; without it the value before, 0 if relative")


class Table(_Shape):
    """Linear interpolation between points, held before the first and after the last; from a CSV file or from here."""

    times: list[float] = Field(default=[], description="since the beginning, rising", json_schema_extra={"unit": "s"})
    values: list[Value] = Field(default=[], description="at these times")
    file: str | None = Field(
        default=None, description="CSV file with a line of column names, path relative to this file"
    )
    time_column: str = Field(default="time", description="column of the file with the times in s")
    value_column: str = Field(default="value", description="column of the file with the values in the target's SI unit")

    @model_validator(mode="after")
    def _points(self) -> "Table":
        if (self.file is None) == (not self.times):
            raise FieldError("a table has its points from one place", allowed="times and values, or file")
        if len(self.times) != len(self.values):
            raise FieldError("as many values as times", at=("values",), allowed=f"{len(self.times)} values")
        for number in range(1, len(self.times)):
            if self.times[number] <= self.times[number - 1]:
                raise FieldError("not rising", at=("times", number), allowed=f"more than {self.times[number - 1]:g} s")
        return self


def _at_once() -> Condition:
    return Condition.model_validate({"time": 0.0})


class StimulusEntry(FileModel):
    """A change of one parameter or signal; exactly one shape."""

    name: str = Field(default="", description="name in reports; by default the target")
    target: str = Field(
        description="path of a parameter of car or road, or a signal of driver, hydraulics, powertrain or bus"
    )
    when: Condition = Field(default_factory=_at_once, description="begins when this holds; by default at once")
    step: Value | None = Field(default=None, description="constant value")
    ramp: Ramp | None = Field(default=None, description="linear change")
    sine: Sine | None = Field(default=None, description="sine")
    sweep: Sweep | None = Field(default=None, description="sine of rising frequency")
    noise: Noise | None = Field(default=None, description="white noise")
    table: Table | None = Field(default=None, description="points")
    relative: bool = Field(default=False, description="added to a signal's value instead of replacing it")
    duration: float | None = parameter(
        "s", None, low=0.001, high=36000.0, description="without it to the end of the run"
    )
    restore: bool = Field(default=True, description="a parameter gets its value back at the end of the duration")

    @model_validator(mode="after")
    def _one_shape(self) -> "StimulusEntry":
        given = [shape for shape in SHAPES if getattr(self, shape) is not None]
        if len(given) != 1:
            raise FieldError(
                "a stimulus has exactly one shape",
                found=" and ".join(given) or "none of them",
                allowed=", ".join(SHAPES),
            )
        return self

    @property
    def shape(self) -> str:
        """Name of its shape."""
        return next(shape for shape in SHAPES if getattr(self, shape) is not None)

    def values(self) -> list[tuple[tuple[str | int, ...], Any]]:
        """Every value that has the target's unit, with its path below the stimulus."""
        if self.step is not None:
            return [(("step",), self.step)]
        shape = getattr(self, self.shape)
        if isinstance(shape, Table):
            return [(("table", "values", number), value) for number, value in enumerate(shape.values)]
        found: list[tuple[tuple[str | int, ...], Any]] = []
        for name, in_file in (
            ("start", "from"),
            ("to", "to"),
            ("amplitude", "amplitude"),
            ("offset", "offset"),
            ("standard_deviation", "standard_deviation"),
        ):
            if isinstance(shape, Sweep) and name in ("start", "to"):
                continue
            value = getattr(shape, name, None)
            if value is not None:
                found.append(((self.shape, in_file), value))
        return found


def read_table(table: Table, folder: Path) -> Table:
    """The table with the points of its file in it.

    Raises
    ------
    FieldError
        If the file cannot be read or lacks a column.
    """
    import csv

    if table.file is None:
        return table
    path = folder / table.file
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a CSV file"
        raise FieldError(f"{path}: {reason}", at=("table", "file")) from None
    columns = list(rows[0]) if rows else []
    for field in ("time_column", "value_column"):
        if getattr(table, field) not in columns:
            raise FieldError(f"{path}: no such column", at=("table", field), allowed=", ".join(columns) or "none")
    try:
        times = [float(row[table.time_column]) for row in rows]
        values: list[Value] = [float(row[table.value_column]) for row in rows]
    except (TypeError, ValueError):
        raise FieldError(f"{path}: not a number in each line", at=("table", "file")) from None
    for number in range(1, len(times)):
        if times[number] <= times[number - 1]:
            raise FieldError(f"{path}:{number + 2}: times do not rise", at=("table", "file"))
    return Table.model_validate({"times": times, "values": values})
