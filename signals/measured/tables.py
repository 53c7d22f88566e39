"""Logs that are tables: CSV with any usual separator, comments and unit rows, gzipped or not; and Parquet."""

import csv
import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.measured.channel_map import Clock
from signals.measured.raw_channels import FloatArray, RawChannels, missing_channel
from signals.quantities import to_si
from signals.units import parse_unit

_SEPARATORS = ";\t,"
_HEADER_LINES = 20
_REMARK = "# \t"
_LEAST_UNITS = 2
"""One word that happens to be a unit makes no row of units."""


def read_csv(path: Path, sources: Sequence[str], clock: Clock) -> RawChannels:
    """Columns of a CSV file.

    The first line that is no plain remark names the columns, also behind a ``#``; further lines that are remarks or
    hold no number (types, units) are passed over. A comma as decimal sign is read where the separator is another one.
    """
    first_row, separator, names = _layout(path, _first_lines(path))
    time_name = clock.column or names[0]
    wanted = dict.fromkeys([time_name, *sources])
    for name in wanted:
        if name not in names:
            raise missing_channel(path, name, names)
    columns = _read_columns(path, first_row, separator, names, list(wanted))
    return _with_clock(path, columns, time_name, sources, clock)


def csv_columns(path: Path) -> dict[str, str]:
    """Column of a CSV file -> unit, out of a row of units between names and numbers; "" where there is none.

    A row of types is told from it by what it holds: at least two units that we know, and more than any other row.

    Raises
    ------
    InputError
        If the file has no header.
    """
    lines = _first_lines(path)
    first_row, separator, names = _layout(path, lines)
    rows = [_fields(line.lstrip(_REMARK), separator) for line in lines[:first_row]]
    rows = [row for row in rows if len(row) == len(names) and row != names]
    known = {place: sum(parse_unit(field) is not None for field in row) for place, row in enumerate(rows)}
    best = max(known, key=known.__getitem__, default=None)
    if best is None or known[best] < _LEAST_UNITS:
        return dict.fromkeys(names, "")
    return dict(zip(names, rows[best], strict=True))


def _first_lines(path: Path) -> list[str]:
    with _open_text(path) as file:
        return [line for line in (file.readline() for _ in range(_HEADER_LINES)) if line]


def _open_text(path: Path) -> IO[str]:
    if path.suffix == ".gz":
        return gzip.open(path, "rt", encoding="utf-8-sig", errors="replace", newline="")
    return path.open(encoding="utf-8-sig", errors="replace", newline="")


def _fields(line: str, separator: str) -> list[str]:
    return [field.strip() for field in next(csv.reader([line.strip()], delimiter=separator, skipinitialspace=True), [])]


def _layout(path: Path, lines: list[str]) -> tuple[int, str, list[str]]:
    """First row of numbers, separator, and names: the first line before it with as many different fields."""
    for row, line in enumerate(lines):
        separator = next((s for s in _SEPARATORS if _are_numbers(_fields(line, s), s)), None)
        if separator is None or line.startswith("#"):
            continue
        fields = _fields(line, separator)
        for before in lines[:row]:
            names = _fields(before.lstrip(_REMARK), separator)
            if len(names) == len(fields) and len(set(names)) == len(names):
                return row, separator, names
        break
    raise InputError(
        f"{path}: no header that names the columns of a row of numbers in the first {_HEADER_LINES} lines",
        allowed="names separated by comma, semicolon or tab",
    )


def _are_numbers(fields: list[str], separator: str) -> bool:
    """True if most of the fields are numbers; a row of units or types has none."""
    return len(fields) > 1 and sum(_is_number(field, separator) for field in fields) * 2 > len(fields)


def _is_number(text: str, separator: str) -> bool:
    try:
        float(text.replace(",", ".") if separator != "," else text)
    except ValueError:
        return False
    return True


def _read_columns(path: Path, skip: int, separator: str, names: list[str], wanted: list[str]) -> dict[str, FloatArray]:
    import pyarrow as pa
    import pyarrow.csv as arrow_csv

    try:
        table = arrow_csv.read_csv(
            str(path),
            read_options=arrow_csv.ReadOptions(skip_rows=skip, column_names=names),
            parse_options=arrow_csv.ParseOptions(delimiter=separator),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=wanted,
                column_types=dict.fromkeys(wanted, pa.float64()),
                decimal_point="," if separator != "," and _decimal_comma(path, skip) else ".",
                null_values=["", "nan", "NaN", "NAN", "NA", "null", "inf", "-inf"],
                strings_can_be_null=True,
            ),
        )
    except pa.ArrowInvalid as error:
        raise InputError(f"{path}: not a table of numbers ({str(error).splitlines()[0]})") from error
    return {name: table.column(name).to_numpy(zero_copy_only=False).astype(np.float64) for name in wanted}


def _decimal_comma(path: Path, row: int) -> bool:
    with _open_text(path) as file:
        for _ in range(row):
            file.readline()
        return "," in file.readline()


def parquet_columns(path: Path) -> dict[str, str]:
    """Columns of a Parquet file, which tell no unit; InputError if it cannot be read."""
    return dict.fromkeys(_open_parquet(path).schema_arrow.names, "")


def _open_parquet(path: Path) -> Any:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    try:
        return parquet.ParquetFile(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise InputError(f"{path}: not a readable Parquet file ({str(error).splitlines()[0]})") from error


def read_parquet(path: Path, sources: Sequence[str], clock: Clock) -> RawChannels:
    """Columns of a Parquet file."""
    file = _open_parquet(path)
    names = list(file.schema_arrow.names)
    time_name = clock.column or names[0]
    wanted = list(dict.fromkeys([time_name, *sources]))
    for name in wanted:
        if name not in names:
            raise missing_channel(path, name, names)
    table = file.read(columns=wanted)
    try:
        columns = {name: _floats(table.column(name).to_numpy(zero_copy_only=False)) for name in wanted}
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: a wanted column holds no numbers ({error})") from error
    return _with_clock(path, columns, time_name, sources, clock)


def _floats(values: NDArray[np.generic]) -> FloatArray:
    if np.issubdtype(values.dtype, np.datetime64):
        return values.astype("datetime64[ns]").astype(np.float64) * 1e-9
    return values.astype(np.float64)


def _with_clock(
    path: Path, columns: dict[str, FloatArray], time_name: str, sources: Sequence[str], clock: Clock
) -> RawChannels:
    time = columns[time_name] * to_si(f"1 {clock.unit}", "s")
    if len(time) == 0 or not np.isfinite(time).all():
        raise InputError(f"{path}: the time in column {time_name!r} has gaps or no values")
    return {source: (time, columns[source]) for source in sources}
