"""Delay of the in-line device against Table 7 of friction-ekf-and-hil-bench.md (5.2.5)."""

from collections.abc import Callable

import numpy as np
import pytest

from can_fault_injector.delay_model import DelayModel, mean_delay_ns

TABLE_7 = {1000: 360, 800: 380, 500: 440, 250: 526, 125: 534, 50: 516, 20: 526, 10: 532}
"""kbit/s: ns."""


@pytest.mark.acceptance("F-34", "F-A19")
@pytest.mark.parametrize("rate", TABLE_7)
def test_delay_is_the_table_within_three_percent_with_a_scatter_below_three_percent(
    rate: int, record: Callable[..., None]
) -> None:
    model = DelayModel(np.random.default_rng(rate))
    report = model.report(rate * 1000)
    deviation = report.mean_ns / TABLE_7[rate] - 1
    record("mean of 10 delays over Table 7, less 1", deviation, "-0.03 ... 0.03")
    record("coefficient of variation over 10 runs", report.variation, "above 0, below 0.03")
    assert abs(deviation) < 0.03
    assert 0.0 < report.variation < 0.03
    assert np.all(np.abs(model.delays_ns(rate * 1000, 1000) / TABLE_7[rate] - 1) < 0.03)


@pytest.mark.acceptance("F-34", "F-A19")
@pytest.mark.parametrize("rate", TABLE_7)
def test_both_criteria_are_told_apart(rate: int) -> None:
    """Below one bit everywhere; the windows 50 % to 80 % overlap up to 500 kbit/s only, 36 % and 30.4 % miss it."""
    report = DelayModel(np.random.default_rng(7)).report(rate * 1000)
    assert report.below_one_bit
    assert report.window_overlap == (rate <= 500)
    assert report.share == pytest.approx(TABLE_7[rate] * rate * 1e-6, rel=0.03)


def test_equal_seeds_give_equal_delays_and_others_do_not() -> None:
    first, second, other = (DelayModel(np.random.default_rng(seed)).delays_ns(500e3, 10) for seed in (1, 1, 2))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_rates_between_the_rows_lie_between_their_delays() -> None:
    assert 360 < mean_delay_ns(900e3) < 380
    with pytest.raises(ValueError, match="Table 7"):
        mean_delay_ns(5e6)
