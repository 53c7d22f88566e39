"""Checks of time stamps: order, duplicates, jitter, lost samples and gaps.

Channels that share their stamps (the columns of a table, the signals of a CAN message) share their faults: one fault
names the logger or message. A few lost frames are usual and only masked.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from model_diagnosis.data.samples import FloatArray, Samples
from model_diagnosis.result import DataFault
from signals.errors import InputError

NAMED_LOSS = 0.01
"""Share of lost samples from which they are named."""
PAUSE_S = 2.0
"""A distance of two samples above which the recording paused: two drives, no fault."""
_NAMED_GAP_S = 0.25
_GAP_PERIODS = 10.0
_LARGEST_STEP_BACK_S = 0.5
_DUPLICATES = 3
_JITTER = 0.35


def check_timing(channels: Mapping[str, Samples]) -> tuple[dict[str, Samples], list[DataFault]]:
    """Put every channel's stamps in order and name what is wrong with them.

    Returns
    -------
    channels with rising stamps, and the faults

    Raises
    ------
    InputError
        If the time of a log jumps back by more than half a second.
    """
    repaired: dict[str, Samples] = {}
    faults: list[DataFault] = []
    for origin in dict.fromkeys(channel.origin for channel in channels.values()):
        members = {name: channel for name, channel in channels.items() if channel.origin == origin}
        label = next(iter(members)) if len(members) == 1 else next(iter(members.values())).message or "time"
        in_order, found = _order(members, label)
        repaired.update(in_order)
        faults += found + _irregular(in_order, label)
    return {name: repaired[name] for name in channels}, faults


def check_cut_frames(channels: Mapping[str, Samples]) -> list[DataFault]:
    """Name the messages whose frames an export had cut short by their zero bytes at the end."""
    faults = []
    for origin in dict.fromkeys(channel.origin for channel in channels.values() if channel.restored):
        channel = next(c for c in channels.values() if c.origin == origin and c.restored)
        count, label = channel.restored, channel.message or channel.name
        message = (
            f"{label}: {count} of {len(channel.time)} frames are shorter than the database says and none ends in a "
            "zero byte: the export cut those; put back"
        )
        faults.append(_fault("cut_frames", label, count, "1", message))
    return faults


def _order(members: Mapping[str, Samples], label: str) -> tuple[dict[str, Samples], list[DataFault]]:
    """Sorted stamps; of samples with equal stamps the first one that carries a number."""
    time = next(iter(members.values())).time
    steps = np.diff(time)
    back = float(-steps.min()) if len(steps) else 0.0
    if back > _LARGEST_STEP_BACK_S:
        row = int(np.argmin(steps))
        raise InputError(
            f"{label}: the time jumps back by {back:.3g} s after sample {row + 1} (at {time[row]:.6g} s)",
            mend="cut the log there: two recordings in one file",
        )
    faults = []
    if back > 0.0:
        share = int(np.sum(steps < 0.0))
        faults.append(
            _fault("time_backwards", label, share, "1", f"time runs backwards {share} times, by up to {back:.3g} s")
        )
    duplicates = int(np.sum(np.diff(np.sort(time)) == 0.0))
    if duplicates >= _DUPLICATES:
        faults.append(
            _fault("duplicate_samples", label, duplicates, "1", f"{duplicates} samples repeat the stamp before them")
        )
    return {name: _unique(channel) for name, channel in members.items()}, faults


def _unique(channel: Samples) -> Samples:
    order = np.lexsort((~channel.valid, channel.time))
    time = channel.time[order]
    keep = order[np.concatenate(([True], np.diff(time) > 0.0))]
    return replace(channel, time=channel.time[keep], values=channel.values[keep], valid=channel.valid[keep])


def _irregular(members: Mapping[str, Samples], label: str) -> list[DataFault]:
    """Losses of the whole table or message, and of single channels in it."""
    channels = list(members.values())
    common = _stamps(channels[0].time, label)
    if common or len(channels) == 1:
        return common or _single(channels[0])
    return [fault for channel in channels for fault in _single(channel)]


def _single(channel: Samples) -> list[DataFault]:
    """Losses in one channel whose row exists: blanks that do not follow a slower clock of their own."""
    present = channel.valid
    lost = float(np.mean(~present)) if len(present) else 0.0
    faults = _stamps(channel.time[present], channel.name)
    if not faults:
        return []
    if lost > 0.0:
        message = f"{channel.name}: {100.0 * lost:.1f} % of the samples hold no number"
        return [_fault("not_a_number", channel.name, lost, "1", message)]
    return faults


def _stamps(time: FloatArray, label: str) -> list[DataFault]:
    steps = np.diff(time)
    steps = steps[steps <= PAUSE_S]
    if len(steps) < 20:
        return []
    period = float(np.median(steps))
    regular = steps[steps < 1.5 * period]
    spread = 0.7413 * float(np.subtract(*np.percentile(regular, [75, 25])))
    # a late frame is followed by an early one: over some steps jitter averages out, losses do not
    over = 5 if spread < 0.2 * period else 25
    mean = period
    if len(steps) > over:
        # the quartile below which no frame is lost, and what jitter takes from it
        quartile = float(np.percentile(np.convolve(steps, np.full(over, 1.0 / over), "valid"), 25))
        mean = quartile + 0.674 * spread / over
    lost = max(0.0, 1.0 - len(steps) * mean / float(np.sum(steps)))
    longest = float(steps.max())
    faults = []
    if longest > max(_NAMED_GAP_S, _GAP_PERIODS * period):
        message = f"{label}: gaps of up to {longest:.3g} s, {100.0 * lost:.1f} % of the time is without samples"
        faults.append(_fault("gap", label, longest, "s", message))
    elif lost > NAMED_LOSS:
        message = f"{label}: {100.0 * lost:.1f} % of the samples are lost (period {1e3 * mean:.3g} ms)"
        faults.append(_fault("frame_drop_hold", label, lost, "1", message))
    if spread > _JITTER * period:
        message = f"{label}: stamps jitter by {1e3 * spread:.3g} ms around a period of {1e3 * period:.3g} ms"
        faults.append(_fault("can_jitter", label, spread, "s", message))
    return faults


def _fault(kind: str, channel: str, value: float, unit: str, message: str) -> DataFault:
    return DataFault(kind=kind, channel=channel, value=float(value), unit=unit, repaired=True, message=message)


SampleCheck = Callable[[Samples], tuple[Samples, list[DataFault]]]
"""A check of one channel's samples: the repaired channel and what was found."""
