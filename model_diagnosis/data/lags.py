"""How late one series is against another: cross-correlation over all manoeuvres, its spread by block bootstrap."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twins import band
from model_diagnosis.manoeuvre import SAMPLE_TIME_S

WIDEST_LAG_S = 2.5
COARSE_BAND_HZ = (0.15, 3.0)
FINE_BAND_HZ = (0.5, 6.0)
COARSE_STEP = 4
"""Samples skipped where only slow motion counts."""
_BLOCK_S, _SHORTEST_BLOCK_S = 2.0, 1.0
_BLOCKS = 8
"""Blocks that short data is cut into at least, as long as they are not shorter than the shortest."""
_DRAWS = 60


@dataclass(frozen=True)
class Lag:
    """Estimate of a lag.

    Attributes
    ----------
    lag_s : positive where the left series is late
    std_s : of the estimate, by bootstrap over blocks of 2 s
    correlation : at that lag, negative where the series oppose each other
    at_zero : correlation without a shift
    """

    lag_s: float
    std_s: float
    correlation: float
    at_zero: float


def correlations(
    left: Sequence[FloatArray],
    right: Sequence[FloatArray],
    valid: Sequence[BoolArray],
    widest_lag_s: float,
    band_hz: tuple[float, float],
    step: int = 1,
) -> FloatArray:
    """(blocks, 2 K + 1) products of left with right, right taken K…−K samples earlier, and their norm divided out.

    With ``step`` only every so many samples are used, which a narrow band allows; the lags are then that far apart.
    The column of lag τ is the sum over a block of left(t) right(t − τ); the sum over blocks at the right lag is the
    correlation coefficient.
    """
    reach = round(widest_lag_s / SAMPLE_TIME_S / step)
    rows = []
    power_left = power_right = 0.0
    seconds = SAMPLE_TIME_S * sum(float(mask.sum()) for mask in valid)
    size = round(float(np.clip(seconds / _BLOCKS, _SHORTEST_BLOCK_S, _BLOCK_S)) / SAMPLE_TIME_S / step)
    for one, other, mask in zip(left, right, valid, strict=True):
        if len(one) < 30 or mask.sum() < 30:
            continue
        a, b = (band(one, *band_hz) * mask)[::step], (band(other, *band_hz) * mask)[::step]
        power_left += float(a @ a)
        power_right += float(b @ b)
        windows = np.lib.stride_tricks.sliding_window_view(np.pad(b, reach), 2 * reach + 1)
        for begin in range(0, len(a), size):
            rows.append(a[begin : begin + size] @ windows[begin : begin + size])
    norm = np.sqrt(power_left * power_right)
    if not rows or norm == 0.0:
        return np.zeros((1, 2 * reach + 1))
    # window column j holds right(t + j − K), which is lag K − j
    table: FloatArray = np.array(rows)[:, ::-1] / norm
    return table


def find_lag(
    left: Sequence[FloatArray],
    right: Sequence[FloatArray],
    valid: Sequence[BoolArray],
    *,
    around_s: float = 0.0,
    widest_lag_s: float = WIDEST_LAG_S,
    band_hz: tuple[float, float] = COARSE_BAND_HZ,
    sign: int = 0,
) -> Lag:
    """Lag with the strongest correlation, small ones preferred among equals.

    Parameters
    ----------
    left, right, valid : one array (n_m,) per manoeuvre
    around_s : centre of the search [s]
    sign : 1 or −1 to look for correlations of this sign only, 0 for both
    """
    reach_s = widest_lag_s + abs(around_s)
    step = COARSE_STEP if band_hz[1] <= COARSE_BAND_HZ[1] else 1
    table = correlations(left, right, valid, reach_s, band_hz, step)
    lags = step * SAMPLE_TIME_S * (np.arange(table.shape[1]) - table.shape[1] // 2)
    inside = np.abs(lags - around_s) <= widest_lag_s + 1e-9
    total = table.sum(axis=0)
    peak = _peak(total, lags, inside, sign)
    spread = 0.0
    if len(table) > 3:
        random = np.random.default_rng(0)
        draws = [table[random.integers(0, len(table), len(table))].sum(axis=0) for _ in range(_DRAWS)]
        near = np.abs(lags - peak[0]) <= 0.15
        spread = float(np.std([_peak(d, lags, near & inside, int(np.sign(peak[1])))[0] for d in draws]))
    return Lag(peak[0], spread, peak[1], float(total[table.shape[1] // 2]))


def _peak(total: FloatArray, lags: FloatArray, inside: BoolArray, sign: int) -> tuple[float, float]:
    """(lag, correlation) at the peak, refined by a parabola through three samples."""
    strength = np.abs(total) if sign == 0 else sign * total
    preferred = np.where(inside, strength - 0.02 * np.abs(lags), -np.inf)
    k = int(np.argmax(preferred))
    if not 0 < k < len(lags) - 1:
        return float(lags[k]), float(total[k])
    before, top, after = strength[k - 1], strength[k], strength[k + 1]
    bend = before - 2.0 * top + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(lags[k] + np.clip(shift, -0.5, 0.5) * (lags[1] - lags[0])), float(total[k])
