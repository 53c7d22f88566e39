"""Signals of a CAN log (BLF, ASC, candump, MF4 bus logging) decoded with a DBC."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from signals.errors import InputError
from signals.measured.raw_channels import RawChannels, missing_channel


def read_can_log(path: Path, sources: Sequence[str], dbc: str | None, *, missing_ok: bool = False) -> RawChannels:
    """Values of ``Message.Signal`` with the time stamps of their frames.

    Frames that the database does not know, and frames too short for it, are passed over. With ``missing_ok`` signals
    without a frame are left out.

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
    for frame in _frames(path):
        message = wanted.get((frame.arbitration_id, frame.is_extended_id))
        if message is None or frame.is_error_frame or frame.is_remote_frame:
            continue
        _decode(message[0], message[1], frame, times, values)
    for source in sources:
        if not times[source] and not missing_ok:
            raise InputError(f"{path}: the signal {source!r} is in the database, but no frame of the log has it")
    return {source: (np.array(times[source]), np.array(values[source])) for source in sources if times[source]}


def can_names(dbc: str) -> list[str]:
    """``Message.Signal`` of everything in a database; InputError if it cannot be read."""
    return [f"{message.name}.{signal.name}" for message in _load_database(dbc).messages for signal in message.signals]


def _load_database(dbc: str) -> Any:
    import cantools

    try:
        return cantools.database.load_file(dbc)
    except FileNotFoundError:
        raise InputError(f"{dbc}: no such file") from None
    except Exception as error:
        raise InputError(f"{dbc}: not a readable CAN database ({str(error).splitlines()[0]})") from error


def _wanted_messages(path: Path, sources: Sequence[str], database: Any, dbc: str) -> dict[tuple[int, bool], Any]:
    """Message and sources that it carries, by identifier."""
    known = {f"{message.name}.{signal.name}": message for message in database.messages for signal in message.signals}
    wanted: dict[tuple[int, bool], tuple[Any, dict[str, str]]] = {}
    for source in sources:
        message = known.get(source)
        if message is None:
            raise missing_channel(dbc, source, known)
        entry = wanted.setdefault((message.frame_id, message.is_extended_frame), (message, {}))
        entry[1][source.split(".", 1)[1]] = source
    return wanted


def _frames(path: Path) -> Any:
    import can

    try:
        with can.LogReader(path, **({"relative_timestamp": True} if path.suffix == ".asc" else {})) as reader:
            yield from reader
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: not a readable CAN log ({str(error).splitlines()[0]})") from error


def _decode(
    message: Any, signals: dict[str, str], frame: Any, times: dict[str, list[float]], values: dict[str, list[float]]
) -> None:
    from cantools.database import DecodeError

    try:
        decoded = message.decode(bytes(frame.data), decode_choices=False)
    except (DecodeError, ValueError):
        return
    for name, source in signals.items():
        if name in decoded:
            times[source].append(frame.timestamp)
            values[source].append(float(decoded[name]))
