"""Signals made small enough for a page: extremes per stretch of time, runs of equal states, spans of presence."""

import base64
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAX_POINTS = 2000
MAX_SEGMENTS = 4000

Segment = tuple[float, float, int]


@dataclass(frozen=True)
class Thinned:
    """Points of a signal.

    Attributes
    ----------
    start, step
        Without ``offsets``, value ``k`` belongs to the time ``start + k * step``. With them two values belong to each
        stretch of the length ``2 * step``, at ``start + (k // 2) * 2 * step + offset / 255 * 2 * step``.
    values : shape (m,)
    offsets : shape (m,), optional
    """

    start: float
    step: float
    values: NDArray[np.float32]
    offsets: NDArray[np.uint8] | None = None

    def times(self) -> NDArray[np.float64]:
        """Time of each point, shape (m,), in s."""
        k = np.arange(len(self.values))
        if self.offsets is None:
            return np.asarray(self.start + k * self.step, np.float64)
        shares = self.offsets.astype(np.float64) / 255.0
        return np.asarray(self.start + 2.0 * self.step * (k // 2 + shares), np.float64)

    def inline(self) -> dict[str, float | str]:
        """Form that the page's script decodes: little-endian float32 and bytes as base64."""
        content: dict[str, float | str] = {
            "start": round(self.start, 6),
            "step": round(self.step, 9),
            "data": base64.b64encode(self.values.astype("<f4").tobytes()).decode("ascii"),
        }
        if self.offsets is not None:
            content["offsets"] = base64.b64encode(self.offsets.tobytes()).decode("ascii")
        return content


def thin_about(
    time: NDArray[np.float64], values: NDArray[np.float64], focus: tuple[float, float] | None
) -> list[Thinned]:
    """At most ``MAX_POINTS`` points in pieces that follow each other, four of five of them within ``focus``."""
    if focus is None or len(values) <= MAX_POINTS:
        return [thin(time, values)]
    begin, end = np.searchsorted(time, focus)
    outside = (slice(0, begin), slice(end, len(time)))
    beside = MAX_POINTS // 5
    shares = [beside * (part.stop - part.start) // max(1, len(time) - (end - begin)) for part in outside]
    parts = ((outside[0], shares[0]), (slice(begin, end), MAX_POINTS - beside), (outside[1], shares[1]))
    return [thin(time[part], values[part], max(2, points)) for part, points in parts if part.stop > part.start]


def thin(time: NDArray[np.float64], values: NDArray[np.float64], max_points: int = MAX_POINTS) -> Thinned:
    """At most ``max_points`` points that keep every extreme.

    The samples are cut into stretches of equal length; of each stretch the smallest and the largest value stay, each at
    its time, so a spike of one sample is visible at any zoom. A signal that fits is kept whole.

    Parameters
    ----------
    time : shape (n,), s
        Equally spaced.
    values : shape (n,)
    """
    count = len(values)
    spacing = float(time[-1] - time[0]) / (count - 1) if count > 1 else 1e-3
    start = float(time[0]) if count else 0.0
    if count <= max_points:
        return Thinned(start, spacing, values.astype(np.float32))
    length = -(-count // (max_points // 2))
    stretches = -(-count // length)
    padded = np.concatenate((values, np.full(stretches * length - count, values[-1]))).reshape(stretches, length)
    rows = np.arange(stretches)
    safe = np.where(np.isfinite(padded), padded, np.nan)
    empty = np.isnan(safe).all(axis=1)
    low = np.where(np.isnan(safe), np.inf, safe).argmin(axis=1)
    high = np.where(np.isnan(safe), -np.inf, safe).argmax(axis=1)
    kept = np.sort(np.column_stack((low, high)), axis=1)
    pairs = safe[rows[:, None], kept]
    pairs[empty] = np.nan
    offsets = np.rint(kept * (255.0 / length)).astype(np.uint8)
    return Thinned(start, 0.5 * length * spacing, pairs.ravel().astype(np.float32), offsets.ravel())


def segments(time: NDArray[np.float64], states: NDArray[np.float64], max_segments: int = MAX_SEGMENTS) -> list[Segment]:
    """Stretches of equal state as (from, to, state); a state ends where the next begins.

    Where a signal chatters so much that more than ``max_segments`` would be needed, it is first sampled more coarsely.
    """
    if len(time) == 0:
        return []
    whole = np.rint(np.nan_to_num(states, nan=0.0)).astype(np.int64)
    changes = np.flatnonzero(np.diff(whole)) + 1
    if len(changes) >= max_segments:
        stride = -(-len(whole) // max_segments)
        return segments(time[::stride], states[::stride], max_segments)
    starts = np.concatenate(([0], changes))
    ends = np.concatenate((time[changes], [time[-1]]))
    return [
        (round(float(time[begin]), 4), round(float(end), 4), int(whole[begin]))
        for begin, end in zip(starts, ends, strict=True)
    ]


def presence(
    times: NDArray[np.float64], largest_gap: float, max_spans: int = MAX_SEGMENTS
) -> list[tuple[float, float]]:
    """Spans in which events follow each other within ``largest_gap``; a lone event is a span of no length."""
    if len(times) == 0:
        return []
    breaks = np.flatnonzero(np.diff(times) > largest_gap)
    if len(breaks) >= max_spans:
        return presence(times, largest_gap * 2, max_spans)
    starts = times[np.concatenate(([0], breaks + 1))]
    ends = times[np.concatenate((breaks, [len(times) - 1]))]
    return [(round(float(a), 4), round(float(b), 4)) for a, b in zip(starts, ends, strict=True)]
