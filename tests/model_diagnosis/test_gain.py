"""Gain on held-out manoeuvres: figures with known truth, coverage of the intervals on coloured noise."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from model_diagnosis.gain import (
    HeldOut,
    block_samples,
    correlation_time_s,
    is_proven,
    is_worse_than_a_refit,
    measure_gain,
)

FloatArray = NDArray[np.float64]
SIGNAL = "yaw_rate"


def _coloured(random: np.random.Generator, samples: int, pole: float, std: float) -> FloatArray:
    """AR(1) noise of a given standard deviation, its start forgotten."""
    white = random.normal(size=samples + 300) * std * np.sqrt(1.0 - pole**2)
    filtered: FloatArray = lfilter([1.0], [1.0, -pole], white)[300:]
    return filtered


def _held_out(
    random: np.random.Generator, manoeuvres: int, samples: int, pole: float, removed: float, left: float = 1.0
) -> list[HeldOut]:
    """Errors of standard deviation ``left`` that stay and ``removed`` that the extension takes away."""
    result = []
    for m in range(manoeuvres):
        after = _coloured(random, samples, pole, left)[:, None]
        before = after + _coloured(random, samples, pole, removed)[:, None]
        result.append(HeldOut(f"m{m}", (SIGNAL,), before, after, np.ones((samples, 1))))
    return result


@pytest.mark.parametrize(("manoeuvres", "samples", "pole"), [(2, 1000, 0.9), (3, 900, 0.8), (6, 1000, 0.9)])
def test_intervals_hold_the_truth_of_coloured_errors(manoeuvres: int, samples: int, pole: float) -> None:
    """True root mean square 1 after and √1.36 before; of 150 intervals of 90 % within four standard errors (2.4 %)."""
    random, held, ratio_held, trials = np.random.default_rng(5), 0, 0, 150
    for trial in range(trials):
        gain = measure_gain(_held_out(random, manoeuvres, samples, pole, 0.6), {}, seed=trial)
        signal = gain.held_out[SIGNAL]
        held += signal.low <= 1.0 <= signal.high
        ratio_held += gain.overall.low <= 1.0 / np.sqrt(1.36) <= gain.overall.high
    assert 0.80 <= held / trials <= 0.99
    assert 0.80 <= ratio_held / trials <= 0.99


def test_share_of_the_possible_gain_counts_the_sensors_noise() -> None:
    """Before: error 3 and noise 1; after: half the error's variance is gone: g = (10 - 5.5) / (10 - 1) = 0.5."""
    random = np.random.default_rng(0)
    samples = 60_000
    noise, error = random.normal(size=samples), 3.0 * random.normal(size=samples)
    held_out = HeldOut(
        "one",
        (SIGNAL,),
        (noise + error)[:, None],
        (noise + error / np.sqrt(2.0))[:, None],
        np.ones((samples, 1)),
    )
    signal = measure_gain([held_out], {SIGNAL: 1.0}).held_out[SIGNAL]
    assert signal.before == pytest.approx(np.sqrt(10.0), rel=0.02)
    assert signal.share == pytest.approx(0.5, abs=0.02)
    assert signal.share_low is not None
    assert signal.share_high is not None
    assert signal.share_low < 0.5 < signal.share_high
    assert signal.unit == "rad/s"


def test_what_gains_nothing_is_proven_in_five_percent_at_most() -> None:
    """Errors of the same distribution before and after: the one-sided 95 % bound is crossed by chance only."""
    random, proven, trials = np.random.default_rng(11), 0, 200
    for trial in range(trials):
        held_out = []
        for m in range(2):
            before, after = (_coloured(random, 800, 0.9, 1.0)[:, None] for _ in range(2))
            held_out.append(HeldOut(f"m{m}", (SIGNAL,), before, after, np.ones((800, 1))))
        proven += is_proven(measure_gain(held_out, {}, seed=trial))
    # Wilson 95 % interval of 5 % at 200 trials ends at 9 %; bootstrap intervals are a little narrow
    assert proven / trials <= 0.10


def test_an_extension_that_removes_half_of_the_error_is_proven_and_a_worse_one_is_not() -> None:
    random = np.random.default_rng(2)
    better = _held_out(random, 2, 1000, 0.9, removed=1.0)
    assert is_proven(measure_gain(better, {}))
    worse = [HeldOut(one.name, one.signals, one.after, one.before, one.weights) for one in better]
    assert not is_proven(measure_gain(worse, {}))


def test_against_a_refit_of_the_nominals_only_what_the_effect_adds_counts() -> None:
    random = np.random.default_rng(3)
    after = _coloured(random, 2000, 0.5, 1.0)[:, None]
    before, refit = 2.0 * after, 1.1 * after
    gain = measure_gain([HeldOut("m", (SIGNAL,), before, after, np.ones((2000, 1)), refit)], {})
    assert gain.overall.ratio == pytest.approx(0.5)
    assert gain.against_refit is not None
    assert gain.against_refit.ratio == pytest.approx(1.0 / 1.1)
    assert not is_worse_than_a_refit(gain)


def test_an_extension_that_a_refit_beats_by_more_than_chance_is_worse() -> None:
    """Errors of 1 after and of 0.9 or of 1.0 by another draw with the refit."""
    random = np.random.default_rng(7)
    after = _coloured(random, 2000, 0.5, 1.0)[:, None]
    for refit, is_worse in ((0.9 * after, True), (_coloured(random, 2000, 0.5, 1.0)[:, None], False)):
        gain = measure_gain([HeldOut("m", (SIGNAL,), 2.0 * after, after, np.ones((2000, 1)), refit)], {})
        assert is_proven(gain)
        assert is_worse_than_a_refit(gain) == is_worse


def test_samples_without_weight_and_missing_signals_do_not_count() -> None:
    random = np.random.default_rng(4)
    first = _held_out(random, 1, 600, 0.3, 0.5)[0]
    spoilt_after, weights = first.after.copy(), first.weights.copy()
    spoilt_after[100:200], weights[100:200] = 1e6, 0.0
    spoilt = HeldOut("spoilt", (SIGNAL,), first.before, spoilt_after, weights)
    other = HeldOut("other", ("speed",), first.before, first.before, np.ones((600, 1)))
    gain = measure_gain([spoilt, other], {})
    assert gain.held_out[SIGNAL].after == pytest.approx(1.0, rel=0.15)
    assert set(gain.held_out) == {SIGNAL, "speed"}
    with pytest.raises(ValueError, match="at least one signal"):
        measure_gain([HeldOut("none", (SIGNAL,), first.before, first.after, np.zeros((600, 1)))], {})


def test_blocks_follow_the_correlation() -> None:
    """Integral time of AR(1): (1 + a) / (1 - a) samples, so 0.39 s for a = 0.95 at 10 ms and 1.99 s for a = 0.99."""
    random = np.random.default_rng(6)
    for pole in (0.95, 0.99):
        errors = _coloured(random, 40_000, pole, 1.0)
        expected = (1.0 + pole) / (1.0 - pole) * 0.01
        assert correlation_time_s(errors, np.ones(40_000)) == pytest.approx(expected, rel=0.25)
    white = HeldOut("white", (SIGNAL,), np.ones((1000, 1)), random.normal(size=(1000, 1)), np.ones((1000, 1)))
    assert block_samples(white) == 50
