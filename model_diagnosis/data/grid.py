"""Samples of any rate on the common time base, with a weight that says which of them are measurements."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from model_diagnosis.data.sample_values import fresh_values
from model_diagnosis.data.samples import BoolArray, FloatArray, Samples
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from signals.errors import InputError
from signals.measured.measured_log import is_stepped

_FAST_PERIOD_S = 1.5 * SAMPLE_TIME_S
_FINE_PERIOD_S = 0.5 * SAMPLE_TIME_S
_SHORT_COVER = 0.5

_STEADY_SPREAD = 0.2
"""Jitter over period up to which stamps are those of a cyclic sender."""
_STEADY_SAMPLES = 51
_EARLY_SHARE = 0.2
"""Share of a cyclic sender's period by which a command may be stamped late and still hold at a sample."""


_SAME_PERIOD = 0.02
"""Share by which a cyclic sender's period may differ from whole steps of the time base for its samples to be kept."""

_LONGEST_STEPS = 10
_SAME_PHASE_S = 2e-4
_ONE_PHASE = 0.9
"""Length of the mean unit vector in direction of the phases from which all are the same: they scatter by 0.07 steps."""
_STEADY_PHASE_S = 5e-4
"""Largest difference of a sample's phase from the others' in a manoeuvre."""


@dataclass(frozen=True)
class OwnSamples:
    """A cyclic channel as its sender took it, not laid on the time base.

    Attributes
    ----------
    values, weights : (n,) each sample at the instant of the time base that is nearest to it
    offsets : (n,) how far behind that instant it was taken [s]; nan where there is none
    """

    values: FloatArray
    weights: FloatArray
    offsets: FloatArray

    def phase(self, begin: int, end: int) -> float | None:
        """Phase of its samples in a stretch [s]; None where they have no steady one, or that of the time base."""
        offsets = self.offsets[begin:end]
        offsets = offsets[np.isfinite(offsets)]
        if not len(offsets):
            return None
        middle, half = float(np.median(offsets)), 0.5 * SAMPLE_TIME_S
        if np.max(np.abs(offsets - middle)) >= _STEADY_PHASE_S:
            return None
        if not _SAME_PHASE_S < abs(middle) <= half + _SAME_PHASE_S:
            return None
        # the median of the jitter may lie beyond half a step where the mean does not
        return float(np.clip(middle, -half, half))


def _common_phase(places: FloatArray) -> float:
    """Phase that all samples at such places [steps] have, -0.5 to 0.5; 0 where it drifts.

    Half a step behind the time base, rounding alone would put one sample to the instant before it and the next one to
    the instant behind it.
    """
    mean = complex(np.mean(np.exp(2j * np.pi * places)))
    return float(np.angle(mean)) / (2.0 * np.pi) if abs(mean) > _ONE_PHASE else 0.0


def _own_samples(stamps: FloatArray, numbers: FloatArray, time: FloatArray, *, held: bool) -> OwnSamples | None:
    """Samples of a channel whose period is one or several steps of the time base; None for any other.

    Between them, and where frames were lost, the values go in straight lines, without weight; commands are held.
    """
    period = float(np.median(np.diff(stamps)))
    steps = round(period / SAMPLE_TIME_S)
    if not 1 <= steps <= _LONGEST_STEPS or abs(period / (steps * SAMPLE_TIME_S) - 1.0) > _SAME_PERIOD:
        return None
    places = (stamps - time[0]) / SAMPLE_TIME_S
    rows = np.round(places - _common_phase(places)).astype(np.int64)
    inside = (rows >= 0) & (rows < len(time))
    if not inside.any() or np.any(np.diff(rows) <= 0):
        return None
    offsets = np.full(len(time), np.nan)
    offsets[rows[inside]] = stamps[inside] - time[rows[inside]]
    if held:
        last = np.clip(np.searchsorted(rows, np.arange(len(time)), side="right") - 1, 0, len(rows) - 1)
        return OwnSamples(numbers[last], np.ones(len(time)), offsets)
    values = np.interp(time + float(np.nanmedian(offsets)), stamps, numbers)
    values[rows[inside]] = numbers[inside]
    return OwnSamples(values, np.isfinite(offsets).astype(np.float64), offsets)


def on_grid(
    channels: Mapping[str, Samples],
) -> tuple[FloatArray, dict[str, FloatArray], dict[str, FloatArray]]:
    """Every channel in equal steps of ``SAMPLE_TIME_S`` over the time that they share.

    Fast channels (period below 5 ms) are averaged over a step, others interpolated. A sample of the time base has
    weight 1 where it lies between neighbouring measurements of a channel of its own rate or faster, or within half a
    step of a measurement of a slower one.

    Returns
    -------
    time (n,) [s] on the logs' clock, values and weights by name, (n,) each

    Raises
    ------
    InputError
        If the channels share no time.
    """
    usable = {name: channel for name, channel in channels.items() if len(fresh_values(channel)[0]) > 1}
    if not usable:
        raise InputError("no channel of the map holds two numbers")
    begin, end = _shared_time(usable)
    begin += _most_common_phase(usable, begin)
    time: FloatArray = begin + SAMPLE_TIME_S * np.arange(
        int((end - begin) / SAMPLE_TIME_S + 1e-6) + 1, dtype=np.float64
    )
    values: dict[str, FloatArray] = {}
    weights: dict[str, FloatArray] = {}
    for name, channel in usable.items():
        stamps, numbers = fresh_values(channel)
        stamps = steady_stamps(stamps)
        values[name] = _values(name, stamps, numbers, time)
        weights[name] = _weights(stamps, channel.period_s(), time, stepped=is_stepped(name))
    return time, values, weights


def own_samples(channels: Mapping[str, Samples], time: FloatArray) -> dict[str, OwnSamples]:
    """Own samples of the cyclic channels among ``channels`` on a time base (n,), by name."""
    found = {}
    for name, channel in channels.items():
        stamps, numbers = fresh_values(channel)
        if len(stamps) > 1:
            kept = _own_samples(steady_stamps(stamps), numbers, time, held=is_stepped(name))
            if kept is not None:
                found[name] = kept
    return found


def _most_common_phase(channels: Mapping[str, Samples], begin: float) -> float:
    """How far behind ``begin`` [s] most channels of the time base's own rate are taken, as a table's all are."""
    phases = []
    for name, channel in channels.items():
        stamps = steady_stamps(fresh_values(channel)[0])
        if not is_stepped(name) and abs(float(np.median(np.diff(stamps))) / SAMPLE_TIME_S - 1.0) <= _SAME_PERIOD:
            phases.append(float(np.median((stamps - begin) % SAMPLE_TIME_S)))
    if not phases:
        return 0.0
    apart = np.abs((np.subtract.outer(phases, phases) + 0.5 * SAMPLE_TIME_S) % SAMPLE_TIME_S - 0.5 * SAMPLE_TIME_S)
    return phases[int(np.argmax(np.sum(apart < _SAME_PHASE_S, axis=1)))]


def _shared_time(channels: Mapping[str, Samples]) -> tuple[float, float]:
    """Time covered by all channels but those that cover less than half of what the longest covers."""
    spans = {name: _span(channel) for name, channel in channels.items() if not is_stepped(name)}
    spans = spans or {name: _span(channel) for name, channel in channels.items()}
    longest = max(float(span[1] - span[0]) for span in spans.values())
    long_ones = {name: span for name, span in spans.items() if span[1] - span[0] >= _SHORT_COVER * longest}
    latest = max(long_ones, key=lambda name: float(long_ones[name][0]))
    earliest = min(long_ones, key=lambda name: float(long_ones[name][1]))
    begin, end = float(spans[latest][0]), float(spans[earliest][1])
    if 0.0 <= end - begin < 2.0 * SAMPLE_TIME_S:
        raise InputError(
            f"all channels together cover {end - begin:.3f} s only", allowed=f"{2.0 * SAMPLE_TIME_S:g} s at least"
        )
    if end < begin:
        raise InputError(
            f"no time is covered by all channels: {channels[earliest].source!r} of {channels[earliest].logger} ends at "
            f"{end:.3f} s, {channels[latest].source!r} of {channels[latest].logger} begins at {begin:.3f} s"
        )
    return begin, end


def _span(channel: Samples) -> FloatArray:
    """First and last stamp with a number; one that stays the same to the end (a torque of 0) counts too."""
    known: FloatArray = channel.time[np.isfinite(channel.values)]
    return known[[0, -1]]


def steady_stamps(stamps: FloatArray) -> FloatArray:
    """Stamps (n,) [s] of a cyclic sender without their jitter; those of any other as they are.

    Values are taken in a cyclic task, stamps are set when the frame has won its bus and reached the logger. Each stamp
    becomes a whole number of periods behind the first one, plus the running median of what that leaves: clocks drift.
    """
    steps = np.diff(stamps)
    if len(steps) < _STEADY_SAMPLES:
        return stamps
    period = float(np.median(steps))
    regular = steps[steps < 1.5 * period]
    spread = 0.7413 * float(np.subtract(*np.percentile(regular, [75, 25])))
    if not 0.0 < spread < _STEADY_SPREAD * period:
        return stamps
    nominal = period * np.concatenate(([0.0], np.cumsum(np.round(steps / period))))
    steady = nominal + median_filter(stamps - nominal, _STEADY_SAMPLES, mode="nearest")
    # frames that a logger stored late in one burst would fall on each other
    return steady if np.all(np.diff(steady) > 0.0) else stamps


def _values(name: str, stamps: FloatArray, numbers: FloatArray, time: FloatArray) -> FloatArray:
    if is_stepped(name):
        late = _EARLY_SHARE * float(np.median(np.diff(stamps)))
        row = np.searchsorted(stamps, time + min(late, _EARLY_SHARE * SAMPLE_TIME_S), side="right") - 1
        held: FloatArray = numbers[np.maximum(row, 0)]
        return held
    interpolated = np.interp(time, stamps, numbers)
    if float(np.median(np.diff(stamps))) > _FINE_PERIOD_S:
        return interpolated
    edges = np.searchsorted(stamps, np.concatenate((time - 0.5 * SAMPLE_TIME_S, time[-1:] + 0.5 * SAMPLE_TIME_S)))
    counts = np.diff(edges)
    sums = np.add.reduceat(np.concatenate((numbers, [0.0])), np.minimum(edges, len(numbers)))[:-1]
    return np.where(counts > 0, sums / np.maximum(counts, 1), interpolated)


def _weights(stamps: FloatArray, period: float, time: FloatArray, *, stepped: bool) -> FloatArray:
    row = np.clip(np.searchsorted(stamps, time), 1, len(stamps) - 1)
    before, after = stamps[row - 1], stamps[row]
    inside = (time >= stamps[0] - 0.5 * SAMPLE_TIME_S) & (time <= stamps[-1] + 0.5 * SAMPLE_TIME_S)
    if stepped:
        return np.where(inside, 1.0, 0.0)
    near: BoolArray = np.minimum(np.abs(time - before), np.abs(after - time)) <= 0.5 * SAMPLE_TIME_S - 1e-9
    if period > _FAST_PERIOD_S:
        return np.where(inside & near, 1.0, 0.0)
    between = after - before <= 2.2 * max(period, SAMPLE_TIME_S / 2.0)
    return np.where(inside & (between | near), 1.0, 0.0)
