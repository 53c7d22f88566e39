"""Faults of the data as the checks state them."""

from collections.abc import Iterable, Sequence

from model_diagnosis.result import DataFault

_ROUTINE = ("missing_channel", "can_jitter", "duplicate_samples", "clock_offset", "clock_drift")
"""Kinds that are part of ordinary measuring once they are repaired or said."""
_BETWEEN = ", "


def decides(fault: DataFault) -> bool:
    """True where a fault is of the kind that makes 'data_fault' the answer if no cause is found."""
    return fault.kind not in _ROUTINE or (fault.kind != "missing_channel" and not fault.repaired)


def joined(channels: Sequence[str]) -> str:
    """Channels of one fault in one text."""
    return _BETWEEN.join(channels)


def parted(channels: str) -> list[str]:
    """Channels of a text by ``joined``."""
    return channels.split(_BETWEEN)


def distinct(faults: Iterable[DataFault]) -> list[DataFault]:
    """Faults without repetition; of one kind and channel the first, with the largest value."""
    kept: dict[tuple[str, str], DataFault] = {}
    for fault in faults:
        known = kept.get((fault.kind, fault.channel))
        if known is None or abs(fault.value or 0.0) > abs(known.value or 0.0):
            kept[(fault.kind, fault.channel)] = fault
    return list(kept.values())
