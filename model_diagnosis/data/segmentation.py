"""Cuts a drive into manoeuvres: moving stretches, long ones split where the car is calm."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from signals.wheels import WHEELS

LOWEST_SPEED_M_S = 4.0
"""Below it slip is hardly defined and the replay would be of the tyre's standstill; stops are cut there."""
SHORTEST_S = 2.0
_LONGEST_S = 30.0
_USUAL_S = 20.0
_CALM_WITHIN_S = 5.0
_HARDEST_BRAKING_M_S2 = 12.0


def reference_speed(channels: Mapping[str, FloatArray], radii: Mapping[str, float]) -> FloatArray | None:
    """Speed that the car surely has [m/s], (n,): the larger of the speed channel and the fastest wheel.

    The wheels' value falls by at most 12 m/s², so that locked wheels do not end a stop. None without any speed.

    Parameters
    ----------
    radii : wheel -> rolling radius [m]
    """
    candidates = []
    if "speed" in channels:
        candidates.append(np.abs(channels["speed"]))
    rims = [radii[w] * np.abs(channels[f"wheel_speed_{w}"]) for w in WHEELS if f"wheel_speed_{w}" in channels]
    if rims:
        candidates.append(_falling_slowly(np.max(rims, axis=0)))
    if not candidates:
        return None
    fastest: FloatArray = np.max(candidates, axis=0)
    return fastest


def _falling_slowly(speed: FloatArray) -> FloatArray:
    """Running maximum that falls by at most 12 m/s²."""
    slope = _HARDEST_BRAKING_M_S2 * SAMPLE_TIME_S * np.arange(len(speed))
    held: FloatArray = np.maximum.accumulate(speed + slope) - slope
    return held


def cut(
    channels: Mapping[str, FloatArray], weights: Mapping[str, FloatArray], radii: Mapping[str, float]
) -> list[tuple[int, int]]:
    """Stretches [begin, end) of samples that are manoeuvres, at least 2 s each.

    A stretch ends where the car is slower than 4 m/s or no channel has a sample for a second; one longer than 30 s is
    split about every 20 s where accelerations are smallest.
    """
    speed = reference_speed(channels, radii)
    samples = len(next(iter(channels.values())))
    moving: BoolArray = np.ones(samples, dtype=bool) if speed is None else speed >= LOWEST_SPEED_M_S
    present = np.max([weights[name] for name in weights], axis=0) > 0.0
    moving &= _closed(present, round(1.0 / SAMPLE_TIME_S))
    activity = _activity(channels)
    return [
        piece
        for begin, end in _stretches(moving)
        for piece in _split(begin, end, activity)
        if (piece[1] - piece[0]) * SAMPLE_TIME_S >= SHORTEST_S
    ]


def _closed(present: BoolArray, longest_gap: int) -> BoolArray:
    """Gaps up to ``longest_gap`` samples filled."""
    filled = present.copy()
    for begin, end in _stretches(~present):
        filled[begin:end] |= end - begin <= longest_gap
    return filled


def _stretches(mask: BoolArray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _activity(channels: Mapping[str, FloatArray]) -> FloatArray:
    """How much the car is being driven: its accelerations [m/s²] over half a second."""
    samples = len(next(iter(channels.values())))
    activity = np.zeros(samples)
    for name, scale in (("longitudinal_acceleration", 1.0), ("lateral_acceleration", 1.0), ("yaw_rate", 10.0)):
        if name in channels:
            activity += scale * np.abs(channels[name])
    if not activity.any() and "speed" in channels:
        activity = np.abs(np.gradient(channels["speed"], SAMPLE_TIME_S))
    window = min(51, samples | 1)
    smooth: FloatArray = np.convolve(
        np.pad(activity, window // 2, mode="edge"), np.full(window, 1.0 / window), "valid"
    )[:samples]
    return smooth


def _split(begin: int, end: int, activity: FloatArray) -> list[tuple[int, int]]:
    if (end - begin) * SAMPLE_TIME_S <= _LONGEST_S:
        return [(begin, end)]
    pieces = round((end - begin) * SAMPLE_TIME_S / _USUAL_S)
    reach = round(_CALM_WITHIN_S / SAMPLE_TIME_S)
    cuts = [begin]
    for k in range(1, pieces):
        wanted = begin + round(k * (end - begin) / pieces)
        cuts.append(wanted - reach + int(np.argmin(activity[wanted - reach : wanted + reach])))
    return list(pairwise([*cuts, end]))
