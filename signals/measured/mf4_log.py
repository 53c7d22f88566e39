"""Channels of any MF4 file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from signals.errors import InputError
from signals.measured.raw_channels import RawChannels, missing_channel


def read_mf4_log(path: Path, sources: Sequence[str]) -> RawChannels:
    """Channels by name, each with its own time; ``NAME#GROUP`` where several groups have one of that name.

    Raises
    ------
    InputError
        If the file cannot be read, a channel is missing or its name is not unique.
    """
    with _open(path) as mdf:
        return {source: _channel(mdf, path, source) for source in sources}


def mf4_columns(path: Path) -> dict[str, str]:
    """Channel of an MF4 file -> unit as it writes it, "" too where several groups have one of that name.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    with _open(path) as mdf:
        return {
            str(name): str(mdf.get_channel_unit(group=places[0][0], index=places[0][1])) if len(places) == 1 else ""
            for name, places in mdf.channels_db.items()
        }


def _open(path: Path) -> Any:
    from asammdf import MDF

    try:
        return MDF(path)
    except Exception as error:
        raise InputError(f"{path}: not a readable MF4 file ({str(error).splitlines()[0]})") from error


def _channel(mdf: Any, path: Path, source: str) -> tuple[Any, Any]:
    name, _, group_text = source.rpartition("#") if "#" in source else (source, "", "")
    occurrences = mdf.channels_db.get(name)
    if occurrences is None:
        raise missing_channel(path, name, mdf.channels_db)
    groups = dict(occurrences)
    if group_text:
        if not group_text.isdigit() or int(group_text) not in groups:
            raise InputError(f"{path}: no channel {source!r}", allowed=", ".join(f"{name}#{g}" for g in groups))
        group = int(group_text)
    elif len(groups) > 1:
        raise InputError(f"{path}: several channels {name!r}", allowed=", ".join(f"{name}#{g}" for g in groups))
    else:
        group = next(iter(groups))
    # a channel with names for its values (gear "D") is wanted as numbers
    (signal,) = mdf.select([(name, group, groups[group])], ignore_value2text_conversions=True)
    try:
        values = np.asarray(signal.samples, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{path}: the channel {source!r} holds no numbers") from None
    if values.ndim != 1:
        raise InputError(f"{path}: the channel {source!r} holds arrays, not numbers")
    return np.asarray(signal.timestamps, np.float64), values
