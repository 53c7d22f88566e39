"""What an extension gains on manoeuvres that it never saw: errors before and after, with block-bootstrap intervals.

For signal c with squared errors E0 before and E1 after, and the sensor's own variance N:
share of the possible gain g = (E0 - E1) / (E0 - N). Over signals of different units the pooled figure is the mean of
log(E0 / E1), the geometric mean of their ratios. An extension is written only if the lower end of its 90 % interval is
above zero.

Residuals of a replay are coloured, so that intervals come from a moving-block bootstrap (Künsch 1989): blocks of 0.5 s
or 1.5 correlation times, the same blocks before and after and in all signals; from four manoeuvres on, manoeuvres are
drawn first. Few blocks make a bootstrap interval too narrow: it is widened by Student's t over the normal quantile.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.result import Gain, OverallGain, SignalGain
from signals.catalogue import catalogue

FloatArray = NDArray[np.float64]

SHORTEST_BLOCK_S = 0.5
CORRELATION_TIMES = 1.5
DRAWS = 1000
MANOEUVRES_TO_DRAW = 4
LEVEL = 0.90
_SMALLEST_ERROR = 1e-30


@dataclass(frozen=True)
class HeldOut:
    """Residuals of one manoeuvre that took no part in the search; n samples, c signals.

    Attributes
    ----------
    signals : names of the columns
    before, after : (n, c) measured minus replayed, in the signals' units
    weights : (n, c), 0 where a sample counts for nothing
    refit : (n, c) with the nominal parameters fitted within two of their scatters and no effect; None where not made
    """

    name: str
    signals: tuple[str, ...]
    before: FloatArray
    after: FloatArray
    weights: FloatArray
    refit: FloatArray | None = None


class Replay(Protocol):
    """What is needed of a replay of the held-out manoeuvres."""

    @property
    def manoeuvres(self) -> Sequence[object]:
        """The manoeuvres."""

    def signals(self, m: int) -> tuple[str, ...]:
        """Compared signals of a manoeuvre."""

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        """Measured minus replayed, (n, c) per manoeuvre."""

    def weights(self) -> list[FloatArray]:
        """Weights, (n, c) per manoeuvre."""


def held_out_residuals(
    replay: Replay, before: FloatArray, after: FloatArray, refit: FloatArray | None = None
) -> list[HeldOut]:
    """Residuals of held-out manoeuvres at deviations ``before`` (the vehicle as given), ``after`` and ``refit``."""
    first, last, weights = replay.residuals(before), replay.residuals(after), replay.weights()
    fitted: Sequence[FloatArray | None] = [None] * len(first) if refit is None else replay.residuals(refit)
    return [
        HeldOut(str(getattr(manoeuvre, "name", m)), replay.signals(m), first[m], last[m], weights[m], fitted[m])
        for m, manoeuvre in enumerate(replay.manoeuvres)
    ]


def correlation_time_s(residual: FloatArray, weights: FloatArray) -> float:
    """Integral time [s] of a residual (n,): the sum of its autocorrelation over both sides up to its first zero."""
    used = weights > 0.0
    if np.count_nonzero(used) < 8:
        return 0.0
    centred = np.where(used, residual - np.mean(residual[used]), 0.0)
    spectrum = np.fft.rfft(centred, 2 * len(centred))
    correlation = np.fft.irfft(spectrum * np.conj(spectrum))[: len(centred)]
    if correlation[0] <= 0.0:
        return 0.0
    falling = np.flatnonzero(correlation <= 0.0)
    end = falling[0] if len(falling) else len(correlation)
    return float(2.0 * correlation[:end].sum() / correlation[0] - 1.0) * SAMPLE_TIME_S


def _longest_correlation_s(held_out: HeldOut) -> float:
    columns = range(len(held_out.signals))
    return max(correlation_time_s(held_out.after[:, c], held_out.weights[:, c]) for c in columns)


def block_samples(held_out: HeldOut) -> int:
    """Length of the blocks of a manoeuvre [samples]: 1.5 times the longest of its signals' correlation times, at least
    0.5 s and at most a quarter of the manoeuvre."""
    wanted = round(max(SHORTEST_BLOCK_S, CORRELATION_TIMES * _longest_correlation_s(held_out)) / SAMPLE_TIME_S)
    return int(max(1, min(wanted, len(held_out.before) // 4)))


@dataclass(frozen=True)
class _Draws:
    """Sums of squared errors of one manoeuvre, (draws + 1, signals): the first row is the data themselves.

    ``lost_variance`` is the share that blocks lose because they cut correlations: T / 2L for an integral time T of the
    squared errors, which is half that of the errors themselves.
    """

    squares: dict[str, FloatArray]
    counts: FloatArray
    blocks: int
    lost_variance: float


def _cumulated(values: FloatArray) -> FloatArray:
    return np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])


def _draw(held_out: HeldOut, names: Sequence[str], random: np.random.Generator, whole: bool) -> _Draws:
    """Sums over random blocks; signals that the manoeuvre lacks have no samples."""
    samples, length = len(held_out.before), block_samples(held_out)
    blocks = max(round(samples / length), 1)
    starts = random.integers(0, samples - length + 1, size=(DRAWS, blocks))

    def sums(values: FloatArray) -> FloatArray:
        cumulated = _cumulated(values)
        if whole:
            return np.repeat(cumulated[-1:], DRAWS + 1, axis=0)
        drawn = (cumulated[starts + length] - cumulated[starts]).sum(axis=1)
        return np.concatenate([cumulated[-1:], drawn])

    columns = [held_out.signals.index(name) if name in held_out.signals else -1 for name in names]
    here = np.array([column >= 0 for column in columns])
    weights = held_out.weights[:, columns] * here
    kinds = {"before": held_out.before, "after": held_out.after, "refit": held_out.refit}
    squares = {
        kind: sums(weights * residual[:, columns] ** 2) for kind, residual in kinds.items() if residual is not None
    }
    lost = 0.0 if whole else min(_longest_correlation_s(held_out) / (4.0 * length * SAMPLE_TIME_S), 0.5)
    return _Draws(squares, sums(weights), blocks, lost)


@dataclass(frozen=True)
class _Pooled:
    """Mean squared errors (draws + 1, signals) by kind, and the factor by which deviations are widened."""

    errors: dict[str, FloatArray]
    widening: float

    def interval(self, values: FloatArray) -> tuple[float, float]:
        """Ends of the 90 % interval of a figure (draws + 1,) whose first value is that of the data."""
        low, high = np.quantile(values[1:], [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0])
        centre = values[0]
        return float(centre + self.widening * (low - centre)), float(centre + self.widening * (high - centre))


def _pool(held_out: Sequence[HeldOut], names: Sequence[str], seed: int) -> _Pooled:
    random = np.random.default_rng(seed)
    many = len(held_out) >= MANOEUVRES_TO_DRAW
    draws = [_draw(one, names, random, whole=many) for one in held_out]
    kinds = [kind for kind in draws[0].squares if all(kind in one.squares for one in draws)]
    count = len(draws)
    if many:
        chosen = random.integers(0, count, size=(DRAWS, count))
        # how often each manoeuvre is drawn; the data themselves have each once
        shares = np.ones((DRAWS + 1, count))
        for m in range(count):
            shares[1:, m] = np.count_nonzero(chosen == m, axis=1)
        freedom = count - 1
    else:
        shares = np.ones((DRAWS + 1, count))
        freedom = max(sum(one.blocks for one in draws) - 1, 1)
    counts = sum(shares[:, m, None] * one.counts for m, one in enumerate(draws))
    errors = {}
    for kind in kinds:
        squares = sum(shares[:, m, None] * one.squares[kind] for m, one in enumerate(draws))
        with np.errstate(invalid="ignore", divide="ignore"):
            errors[kind] = np.where(counts > 0.0, squares / counts, np.nan)
    quantile = 0.5 + LEVEL / 2.0
    widening = float(t.ppf(quantile, freedom) / norm.ppf(quantile)) * np.sqrt((freedom + 1) / freedom)
    widening /= np.sqrt(1.0 - max(one.lost_variance for one in draws))
    return _Pooled(errors, widening)


def _mean_log_ratio(first: FloatArray, last: FloatArray) -> FloatArray:
    """Mean over signals of log(first / last), (draws + 1,); signals without samples in a draw are left out of it."""
    ratio = np.log(np.maximum(first, _SMALLEST_ERROR) / np.maximum(last, _SMALLEST_ERROR))
    return np.nanmean(ratio, axis=1)


def _overall(pooled: _Pooled, first: str) -> OverallGain:
    values = _mean_log_ratio(pooled.errors[first], pooled.errors["after"])
    low, high = pooled.interval(values)
    # a gain in squared errors; the ratio is of root mean squares, error after over error before
    return OverallGain(ratio=np.exp(-values[0] / 2.0), low=np.exp(-high / 2.0), high=np.exp(-low / 2.0))


def _signal_gain(pooled: _Pooled, column: int, unit: str, noise_std: float) -> SignalGain:
    before, after = pooled.errors["before"][:, column], pooled.errors["after"][:, column]
    logs = np.log(np.maximum(after, _SMALLEST_ERROR))
    low, high = pooled.interval(np.where(np.isfinite(logs), logs, logs[0]))
    possible = before - noise_std**2
    gain = SignalGain(
        before=np.sqrt(before[0]),
        after=np.sqrt(after[0]),
        low=np.exp(low / 2.0),
        high=np.exp(high / 2.0),
        unit=unit,
        noise_floor=noise_std,
    )
    if possible[0] <= 0.0:
        return gain
    share = np.where(possible > 0.0, (before - after) / np.where(possible > 0.0, possible, 1.0), np.nan)
    finite = share[np.isfinite(share)]
    share_low, share_high = pooled.interval(finite)
    return gain.model_copy(update={"share": float(share[0]), "share_low": share_low, "share_high": share_high})


def measure_gain(
    held_out: Sequence[HeldOut],
    noise_std: Mapping[str, float],
    *,
    seed: int = 0,
    user_figures: Mapping[str, Mapping[str, float]] | None = None,
    cross_validated: bool = False,
) -> Gain:
    """Errors before and after on held-out manoeuvres, with 90 % intervals.

    Parameters
    ----------
    held_out
        At least one manoeuvre.
    noise_std
        Signal to the sensor's own noise in the signal's unit; 0 where it is not known.
    user_figures
        Name of a figure to its values ``before`` and ``after``.
    cross_validated
        True where each manoeuvre was left out in turn.

    Raises
    ------
    ValueError
        If there is no manoeuvre, or no signal with a sample.
    """
    if not held_out:
        raise ValueError("found no held-out manoeuvre, allowed: at least one")
    present = dict.fromkeys(name for one in held_out for name in one.signals)
    weights = {
        name: sum(one.weights[:, one.signals.index(name)].sum() for one in held_out if name in one.signals)
        for name in present
    }
    names = [name for name in present if weights[name] > 0.0]
    if not names:
        raise ValueError("found no sample with a weight, allowed: at least one signal")
    pooled = _pool(held_out, names, seed)
    units = {signal.name: signal.unit for signal in catalogue()}
    return Gain(
        held_out={
            name: _signal_gain(pooled, column, units.get(name, ""), noise_std.get(name, 0.0))
            for column, name in enumerate(names)
        },
        overall=_overall(pooled, "before"),
        against_refit=_overall(pooled, "refit") if "refit" in pooled.errors else None,
        user_figures={name: dict(values) for name, values in (user_figures or {}).items()},
        cross_validated=cross_validated,
    )


def is_proven(gain: Gain) -> bool:
    """True where the error after is below the error before at the 90 % interval's far end: an extension may be kept."""
    return gain.overall.high < 1.0


def is_worse_than_a_refit(gain: Gain) -> bool:
    """True where the vehicle file's own numbers, moved within two of their scatters, leave less error for sure."""
    return gain.against_refit is not None and gain.against_refit.low > 1.0
