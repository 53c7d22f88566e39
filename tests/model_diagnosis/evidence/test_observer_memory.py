"""The noise of the measured speed comes into all wheels through the observer: whitened, they say it no more."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.whitening import LEAKS, Memory, SignalFilter, Whitener, fit_whitener
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from signals.wheels import WHEELS

SIGNALS = ("speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS))
GAIN, RADIUS = 0.05, 0.3
SPEED_STD, WHEEL_STD = 0.03, 0.04
SAMPLES = 6000


@dataclass
class Observed:
    """A car that the model describes exactly, seen through an observer: all that is left is noise."""

    manoeuvres: list[Manoeuvre]
    told: bool
    """True if the whitening is told what the observer corrects."""

    def signals(self, manoeuvre: int) -> tuple[str, ...]:
        return SIGNALS

    def weights(self) -> list[NDArray[np.float64]]:
        return [np.ones((SAMPLES, len(SIGNALS)))]

    def sensor_std(self, signal: str) -> float:
        return SPEED_STD if signal == "speed" else WHEEL_STD

    def corrections(self, manoeuvre: int) -> NDArray[np.float64]:
        return GAIN * np.eye(len(SIGNALS))[:, : int(self.told)]


def _residuals() -> NDArray[np.float64]:
    """Measured minus predicted where speed' = speed + GAIN (measured - speed), and wheels turn with the speed."""
    random = np.random.default_rng(3)
    noise = np.array([SPEED_STD, *[WHEEL_STD] * 4]) * random.standard_normal((SAMPLES, len(SIGNALS)))
    left, off = np.empty_like(noise), 0.0
    for k in range(SAMPLES):
        left[k] = noise[k] - off / np.array([1.0, *[RADIUS] * 4])
        off += GAIN * left[k, 0]
    return left


def _common_share(whitener: Whitener, left: NDArray[np.float64]) -> float:
    """Variance of the four wheels' sum over 1 s, over that of four independent white ones."""
    wheels = whitener.whitened(0, left).reshape(len(SIGNALS), -1)[1:]
    wheels = wheels / wheels.std(axis=1, keepdims=True)
    seconds = wheels.sum(axis=0)[: wheels.shape[1] // 100 * 100].reshape(-1, 100).sum(axis=1)
    return float(np.var(seconds) / 400.0)


def test_four_wheels_do_not_say_four_times_what_one_speed_sensor_said() -> None:
    time = np.arange(SAMPLES) * SAMPLE_TIME_S
    drive, left = Manoeuvre("m", time, {}, {}, "made for a test"), _residuals()
    one_by_one, told = (fit_whitener(Observed([drive], told), [left]) for told in (False, True))
    # 59 sums, standard error of their variance 0.18 of it. One by one: below 0.8 Hz the speed's noise, 0.1 rad/s, is
    # common to wheels with 0.04 rad/s of their own, a coherence of 0.86: 1 + 3 * 0.86 = 3.6
    assert _common_share(one_by_one, left) > 2.5
    # four standard errors above one: what a leak of 0.0008 does not see lies below 0.013 Hz
    assert _common_share(told, left) < 1.75
    assert told.memories[0].leak == min(LEAKS)


def test_the_memory_is_a_sum_of_past_corrections_that_begins_anew_behind_a_gap() -> None:
    samples = np.concatenate((np.arange(20), np.arange(40, 60)))
    one = SignalFilter("speed", 0, samples, np.zeros(4), 1.0, 1.0)
    sums = Memory(np.array([[0.5]]), 0.0, (40,)).of(np.ones((60, 1)), [one])[:, 0]
    np.testing.assert_allclose(sums[:20], 0.5 * np.arange(20))
    np.testing.assert_allclose(sums[40:], 0.5 * np.arange(20))
