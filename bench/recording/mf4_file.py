"""``signals.mf4``: all signals of a run with units, finalised, written from rows in blocks and read back.

One channel group with one time base. The steps of the manoeuvre and what else is known of the run stand as JSON in an
attachment of the file, so that a recording can be judged without its folder.
"""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.recording.arrays import FloatArray, RunArrays
from bench.recording.schema import RunSchema
from bench.recording.signal_file import Rows
from signals.errors import InputError, RunError

INFORMATION_FILE = "run.json"
BLOCK_ROWS = 8192


def write_mf4(path: Path, schema: RunSchema, rows: Iterable[Rows]) -> int:
    """Write rows into a new MF4 file and read it again to see that it is whole.

    Returns
    -------
    int
        Number of rows.

    Raises
    ------
    RunError
        If the file does not hold what was written.
    OSError
        If there is no room for it.
    """
    from asammdf import MDF

    partial = path.with_name(f".{path.stem}.partial.mf4")
    count = 0
    try:
        with MDF(version="4.10") as mdf:
            for block in _blocks(rows, len(schema.signals)):
                _append(mdf, schema, block, first=count == 0)
                count += len(block)
            if count == 0:
                _append(mdf, schema, np.zeros((0, len(schema.signals))), first=True)
            mdf.attach(_information(schema).encode(), file_name=INFORMATION_FILE, mime="application/json")
            mdf.save(partial, overwrite=True, compression=2)
        _verify(partial, schema, count)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return count


def _blocks(rows: Iterable[Rows], columns: int) -> Iterable[FloatArray]:
    """Rows joined to blocks of some thousand, because the writer's cost is per block and signal."""
    waiting: list[FloatArray] = []
    for _, _, values in rows:
        waiting.append(values)
        if sum(map(len, waiting)) >= BLOCK_ROWS:
            yield np.concatenate(waiting)
            waiting = []
    if waiting:
        yield np.concatenate(waiting)


def _append(mdf: Any, schema: RunSchema, block: FloatArray, *, first: bool) -> None:
    from asammdf import Signal as Mf4Signal

    time = np.ascontiguousarray(block[:, schema.names.index("time")])
    columns = [np.ascontiguousarray(block[:, i]) for i, name in enumerate(schema.names) if name != "time"]
    if not first:
        mdf.extend(0, [(time, None), *((column, None) for column in columns)])
        return
    signals = [signal for signal in schema.signals if signal.name != "time"]
    mdf.append(
        [
            Mf4Signal(column, time, name=signal.name, unit=signal.unit, comment=signal.description)
            for signal, column in zip(signals, columns, strict=True)
        ],
        comment="signals of the run",
        common_timebase=True,
    )


def _information(schema: RunSchema) -> str:
    content = {"phase_names": list(schema.phase_names), "start_time_ns": schema.start_time_ns}
    return json.dumps(content | {"information": schema.information})


def _verify(path: Path, schema: RunSchema, count: int) -> None:
    """Open the file again: finalised, every signal there with its unit, every row there."""
    with path.open("rb") as file:
        if file.read(8) != b"MDF     ":
            raise RunError(f"{path}: the MF4 file is not finalised")
    arrays = read_mf4(path)
    missing = [s.name for s in schema.signals if s.name not in arrays or arrays.units[s.name] != s.unit]
    if missing or len(arrays) != count:
        raise RunError(f"{path}: the MF4 file lacks {missing[:3] or f'{count - len(arrays)} rows'}")


def read_mf4(path: Path) -> RunArrays:
    """A recording of the bench from its MF4 file.

    Raises
    ------
    InputError
        If the file cannot be read or is none of the bench's own (use a channel map for those).
    """
    from asammdf import MDF

    try:
        with MDF(path) as mdf:
            content = _read_information(mdf)
            if content is None:
                raise InputError(f"{path}: not recorded by the bench", mend="give a channel map: --channels MAP")
            names = _channel_names(mdf)
            signals = mdf.select(names, raw=True) if names else []
            time = signals[0].timestamps if signals else np.zeros(0)
            columns = {signal.name: np.asarray(signal.samples, np.float64) for signal in signals}
            units = {signal.name: str(signal.unit) for signal in signals}
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: not a readable MF4 file ({error})") from error
    return RunArrays(
        np.asarray(time, np.float64),
        {"time": np.asarray(time, np.float64)} | columns,
        {"time": "s"} | units,
        phase_names=content["phase_names"],
        information=content["information"] | {"start_time_ns": content["start_time_ns"]},
    )


def _channel_names(mdf: Any) -> list[str]:
    channels: Sequence[Any] = mdf.groups[0].channels if mdf.groups else []
    return [channel.name for channel in channels if channel.name != "time"]


def _read_information(mdf: Any) -> dict[str, Any] | None:
    for index, attachment in enumerate(mdf.attachments):
        if Path(str(attachment.file_name)).name == INFORMATION_FILE:
            data, _, _ = mdf.extract_attachment(index)
            content: dict[str, Any] = json.loads(bytes(data))
            return content
    return None
