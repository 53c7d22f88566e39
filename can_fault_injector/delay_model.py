"""Delay of an in-line error generator on a programmable gate array (friction-ekf-and-hil-bench.md, 5.2.5, Table 7)."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TABLE_7_NS = {1_000_000: 360, 800_000: 380, 500_000: 440, 250_000: 526, 125_000: 534, 50_000: 516, 20_000: 526}
TABLE_7_NS |= {10_000: 532}
"""Measured mean delay by bit rate, bit/s: ns."""
EARLIEST_SAMPLE, LATEST_SAMPLE = 0.5, 0.8
"""Where in a bit the controllers of both sides sample (5.2.5)."""
_PHASE_NS = 10.0
"""Half a period of the clock by which the device samples its input, 50 MHz: an edge waits up to one period."""
_RUNS = 10


@dataclass(frozen=True)
class DelayReport:
    """Delay over several runs at one bit rate, with both criteria of the source.

    Attributes
    ----------
    mean_ns, variation
        Mean, and standard deviation over mean.
    share : float
        Mean delay in bit times.
    below_one_bit : bool
        Delay shorter than a bit.
    window_overlap : bool
        Whether the sampling windows of both sides (50 % to 80 % of the bit) still overlap.
    """

    bit_rate: float
    mean_ns: float
    variation: float
    share: float
    below_one_bit: bool
    window_overlap: bool


def mean_delay_ns(bit_rate: float) -> float:
    """Mean delay at a bit rate, bit/s: Table 7, between its rows linear in the logarithm of the rate.

    Raises
    ------
    ValueError
        For rates outside the table.
    """
    rates = sorted(TABLE_7_NS)
    if not rates[0] <= bit_rate <= rates[-1]:
        raise ValueError(f"bit rate: found {bit_rate:g} bit/s, allowed: {rates[0]} to {rates[-1]} (Table 7)")
    return float(np.interp(math.log(bit_rate), np.log(rates), [TABLE_7_NS[rate] for rate in rates]))


def windows_overlap(share: float) -> bool:
    """Whether the sampling windows of both sides, 50 % to 80 % of a bit, overlap with a delay in bit times between."""
    return share < LATEST_SAMPLE - EARLIEST_SAMPLE


class DelayModel:
    """Delays with the scatter of a device that samples its input by a clock of its own.

    Parameters
    ----------
    generator : numpy.random.Generator
        Source of the phase between the edge and that clock.
    """

    def __init__(self, generator: np.random.Generator) -> None:
        self._generator = generator

    def delays_ns(self, bit_rate: float, count: int = 1) -> NDArray[np.float64]:
        """Delays of ``count`` forwarded edges."""
        return mean_delay_ns(bit_rate) + self._generator.uniform(-_PHASE_NS, _PHASE_NS, count)

    def report(self, bit_rate: float, runs: int = _RUNS) -> DelayReport:
        """Mean and scatter of several runs, and both criteria."""
        delays = self.delays_ns(bit_rate, runs)
        mean = float(delays.mean())
        share = mean * 1e-9 * bit_rate
        variation = float(delays.std(ddof=1)) / mean
        return DelayReport(bit_rate, mean, variation, share, share < 1.0, windows_overlap(share))

    def reports(self, bit_rates: Iterable[float] = tuple(TABLE_7_NS)) -> list[DelayReport]:
        """One report for each bit rate, by default those of Table 7."""
        return [self.report(bit_rate) for bit_rate in bit_rates]
