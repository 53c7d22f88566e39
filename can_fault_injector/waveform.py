"""Bus levels as a value change dump (IEEE 1364), which logic analysers and their decoders read."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from can_fault_injector import fields as f
from can_fault_injector.frame import Frame

TICKS_PER_BIT = 20
_HEADER = """$timescale {timescale} ns $end
$scope module bus $end
$var wire 1 ! {name} $end
$upscope $end
$enddefinitions $end
"""
_FAST_FIELDS = (f.ESI, f.DLC, f.DATA, f.STUFF, f.STUFF_COUNT, f.CRC, f.FIXED_STUFF)


def bit_ticks(frame: Frame, data_bit_ratio: int = 1) -> NDArray[np.int64]:
    """Duration of each bit of a frame in ticks; with BRS the bits from ESI to the CRC are shorter by a whole ratio.

    Raises
    ------
    ValueError
        If the ratio does not divide TICKS_PER_BIT.
    """
    if data_bit_ratio < 1 or TICKS_PER_BIT % data_bit_ratio:
        raise ValueError(f"data_bit_ratio: found {data_bit_ratio}, allowed: a divisor of {TICKS_PER_BIT}")
    codes = frame.encoded()[1]
    ticks = np.full(codes.size, TICKS_PER_BIT, np.int64)
    if frame.bit_rate_switch:
        start = int(np.flatnonzero(codes == f.BRS)[0]) + 1
        fast = np.isin(codes, _FAST_FIELDS)
        fast[:start] = False
        ticks[fast] = TICKS_PER_BIT // data_bit_ratio
    return ticks


def value_change_dump(
    levels: Sequence[int] | NDArray[np.integer],
    ticks: Iterable[int] | None = None,
    bit_rate: float = 500e3,
    name: str = "can_rx",
) -> str:
    """Text of a dump of one wire.

    Parameters
    ----------
    levels
        One level per bit, 1 is recessive.
    ticks : optional
        Duration of each bit, TICKS_PER_BIT by default.
    bit_rate : float [bit/s]
        Rate of a bit of TICKS_PER_BIT ticks.
    """
    values = np.asarray(levels, np.int64)
    durations = np.full(values.size, TICKS_PER_BIT) if ticks is None else np.fromiter(ticks, np.int64)
    ends = np.cumsum(durations)
    starts = ends - durations
    changes = np.flatnonzero(np.diff(values, prepend=-1))
    lines = [f"#{starts[i]}\n{values[i]}!" for i in changes]
    timescale = round(1e9 / bit_rate / TICKS_PER_BIT)
    return _HEADER.format(timescale=timescale, name=name) + "\n".join(lines) + f"\n#{ends[-1] if ends.size else 0}\n"
