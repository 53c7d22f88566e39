"""Signals of a CAN log (BLF, ASC, candump, MF4 bus logging) decoded with a DBC."""

import gzip
import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from signals.errors import InputError
from signals.measured.channel_map import FileFormat
from signals.measured.raw_channels import RawChannels, missing_channel


@dataclass
class _Message:
    """Frames of one identifier on their way into values.

    Attributes
    ----------
    signals : signal -> ``Message.Signal``
    short : (stamp, data) of the frames too short for the database
    ends_in_zero : True where the data of any frame ends in a zero byte
    """

    definition: Any
    signals: dict[str, str]
    short: list[tuple[float, bytes]] = field(default_factory=list)
    ends_in_zero: bool = False

    def restored(self) -> list[tuple[float, bytes]]:
        """Short frames whose missing bytes are surely zero: an export that cuts them leaves none at any end."""
        if self.ends_in_zero:
            return []
        return [(stamp, data.ljust(self.definition.length, b"\0")) for stamp, data in self.short]


def read_can_log(
    path: Path,
    kind: FileFormat,
    sources: Sequence[str],
    dbc: str | None,
    *,
    missing_ok: bool = False,
    restored: dict[str, int] | None = None,
) -> RawChannels:
    """Values of ``Message.Signal`` with the time stamps of their frames.

    Frames that the database does not know are passed over, and so are frames too short for it, unless an export has
    cut zero bytes off the ends of all frames of a message: those bytes are put back. With ``missing_ok`` signals
    without a frame are left out.

    Parameters
    ----------
    restored : filled with source -> number of frames that were cut short and completed

    Raises
    ------
    InputError
        If log or database cannot be read, a signal is not in the database, or never in the log.
    """
    if dbc is None:
        raise InputError(f"{path}: a CAN log needs a database", mend="name it in the channel map: dbc: FILE")
    wanted = _wanted_messages(path, sources, _load_database(dbc), dbc)
    times: dict[str, list[float]] = {source: [] for source in sources}
    values: dict[str, list[float]] = {source: [] for source in sources}
    for frame in _frames(path, kind):
        message = wanted.get((frame.arbitration_id, frame.is_extended_id))
        if message is None or frame.is_error_frame or frame.is_remote_frame:
            continue
        data = bytes(frame.data)
        message.ends_in_zero |= data.endswith(b"\0")
        if len(data) < message.definition.length:
            message.short.append((frame.timestamp, data))
        else:
            _decode(message, frame.timestamp, data, times, values)
    for message in wanted.values():
        _complete(message, times, values, {} if restored is None else restored)
    for source in sources:
        if not times[source] and not missing_ok:
            raise InputError(f"{path}: the signal {source!r} is in the database, but no frame of the log has it")
    return {source: (np.array(times[source]), np.array(values[source])) for source in sources if times[source]}


def can_columns(dbc: str) -> dict[str, str]:
    """``Message.Signal`` of everything in a database -> unit as it writes it; InputError if it cannot be read."""
    return {
        f"{message.name}.{signal.name}": signal.unit or ""
        for message in _load_database(dbc).messages
        for signal in message.signals
    }


def _load_database(dbc: str) -> Any:
    import cantools

    try:
        return cantools.database.load_file(dbc)
    except FileNotFoundError:
        raise InputError(f"{dbc}: no such file") from None
    except Exception as error:
        raise InputError(f"{dbc}: not a readable CAN database ({str(error).splitlines()[0]})") from error


def _wanted_messages(path: Path, sources: Sequence[str], database: Any, dbc: str) -> dict[tuple[int, bool], _Message]:
    """Message and sources that it carries, by identifier."""
    known = {f"{message.name}.{signal.name}": message for message in database.messages for signal in message.signals}
    wanted: dict[tuple[int, bool], _Message] = {}
    for source in sources:
        message = known.get(source)
        if message is None:
            raise missing_channel(dbc, source, known)
        entry = wanted.setdefault((message.frame_id, message.is_extended_frame), _Message(message, {}))
        entry.signals[source.split(".", 1)[1]] = source
    return wanted


def _frames(path: Path, kind: FileFormat) -> Iterator[Any]:
    reader = _mf4_reader() if kind == "mf4" else _reader(kind)
    try:
        with reader(_opened(path, kind)) as frames:
            yield from frames
    except Exception as error:
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError(f"{path}: not a readable CAN log ({reason})") from error


def _opened(path: Path, kind: FileFormat) -> Any:
    is_packed = path.suffix.lower() == ".gz"
    if kind in ("asc", "candump"):  # comments of an ASC file are of any code page
        return (gzip.open if is_packed else open)(path, "rt", encoding="utf-8", errors="replace")
    return gzip.open(path, "rb") if is_packed else path


def _reader(kind: FileFormat) -> Any:
    import can

    return {"blf": can.BLFReader, "asc": can.ASCReader, "candump": can.CanutilsLogReader}[kind]


def _mf4_reader() -> Any:
    """python-can's reader of MF4, which a process that wants python-can fast has imported without its asammdf."""
    import can.io.mf4

    if can.io.mf4.asammdf is None:
        importlib.reload(can.io.mf4)
    return can.io.mf4.MF4Reader


def _decode(
    message: _Message, stamp: float, data: bytes, times: dict[str, list[float]], values: dict[str, list[float]]
) -> None:
    from cantools.database import DecodeError

    try:
        decoded = message.definition.decode(data, decode_choices=False)
    except (DecodeError, ValueError):
        return
    for name, source in message.signals.items():
        if name in decoded:
            times[source].append(stamp)
            values[source].append(float(decoded[name]))


def _complete(
    message: _Message, times: dict[str, list[float]], values: dict[str, list[float]], restored: dict[str, int]
) -> None:
    """Decode the frames that were cut short, and put them between the others by their stamps."""
    frames = message.restored()
    for stamp, data in frames:
        _decode(message, stamp, data, times, values)
    for source in message.signals.values() if frames else ():
        restored[source] = len(frames)
        order = np.argsort(times[source], kind="stable")
        times[source] = [times[source][row] for row in order]
        values[source] = [values[source][row] for row in order]
