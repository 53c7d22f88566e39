"""Channels of a log as they stand in it: name, own time stamps, values in the log's unit."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError, nearest_name

FloatArray = NDArray[np.float64]
RawChannels = dict[str, tuple[FloatArray, FloatArray]]
"""Source name to (time in s, values)."""

_SHOWN = 8


def missing_channel(path: object, source: str, available: Iterable[str]) -> InputError:
    """Error for a source that a log does not have, with the nearest one and some of those it has."""
    names = list(available)
    shown = ", ".join(names[:_SHOWN]) + (f" … ({len(names)} in all)" if len(names) > _SHOWN else "")
    return InputError(f"{path}: no channel {source!r}", allowed=shown, nearest=nearest_name(source, names))
