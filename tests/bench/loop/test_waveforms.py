"""Waveforms of stimuli against their closed forms."""

import math

import numpy as np
import pytest

from bench.loop import waveforms


def test_ramp_reaches_its_end_and_holds_it() -> None:
    wave = waveforms.ramp(2.0, 10.0, 4.0)
    assert [wave(t) for t in (0.0, 1.0, 4.0, 9.0)] == [2.0, 4.0, 10.0, 10.0]


def test_ramp_of_no_duration_is_a_step() -> None:
    assert waveforms.ramp(0.0, 3.0, 0.0)(0.0) == 3.0


def test_sine_has_its_frequency() -> None:
    wave = waveforms.sine(1.0, 2.0, 0.5)
    assert wave(0.5) == pytest.approx(3.0)  # a quarter of the 2 s period
    assert wave(2.0) == pytest.approx(1.0)


def test_sweep_counts_the_cycles_of_a_linear_chirp() -> None:
    """From 1 to 3 Hz in 2 s: (1 + 3)/2 × 2 = 4 whole cycles, so the value is back at the offset."""
    wave = waveforms.sweep(5.0, 1.0, 1.0, 3.0, 2.0)
    assert wave(2.0) == pytest.approx(5.0)
    # half way: 1 × 1 + 0.5 × 1 × 1² = 1.5 cycles
    assert wave(1.0) == pytest.approx(5.0 + math.sin(2 * math.pi * 1.5), abs=1e-12)
    assert wave(2.0 + 0.25 / 3.0) == pytest.approx(6.0)  # goes on at 3 Hz


def test_noise_has_its_moments_and_its_seed() -> None:
    wave = waveforms.noise(1.0, 0.5, np.random.default_rng(3))
    values = np.array([wave(0.0) for _ in range(20_000)])
    assert values.mean() == pytest.approx(1.0, abs=4 * 0.5 / math.sqrt(20_000))
    assert values.std() == pytest.approx(0.5, rel=0.03)
    again = waveforms.noise(1.0, 0.5, np.random.default_rng(3))
    assert [again(0.0) for _ in range(5)] == values[:5].tolist()


def test_table_interpolates_and_holds() -> None:
    wave = waveforms.table([0.0, 1.0, 3.0], [0.0, 10.0, 30.0])
    assert [wave(t) for t in (-1.0, 0.5, 2.0, 5.0)] == [0.0, 5.0, 20.0, 30.0]
