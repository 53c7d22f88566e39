"""A wrap is the range of what is counted, and not what noise leaves of one jump."""

import numpy as np
import pytest

from model_diagnosis.data.sample_values import check_wrap
from model_diagnosis.data.samples import Samples

TIME = np.arange(400) * 0.01


@pytest.mark.parametrize(
    ("name", "unit", "slope", "wrap", "noise"),
    [
        ("yaw_angle", "rad", 2.0, 2.0 * np.pi, 1e-4),
        ("yaw_angle", "deg", 110.0, 360.0, 1e-2),
        ("speed", "m/s", 7.0, 16.0, 0.02),
        ("speed", "m/s", 7.0, 10.24, 0.005),
        ("speed", "m/s", 7.0, 12.5, 0.01),
    ],
)
def test_the_range_is_told_to_the_last_digit(name: str, unit: str, slope: float, wrap: float, noise: float) -> None:
    """The course bends, so that its trend across a jump is a little off too."""
    random = np.random.default_rng(4)
    course = 0.4 * wrap + slope * TIME + 0.1 * slope * np.sin(TIME) + random.normal(0.0, noise, len(TIME))
    channel = Samples(name, unit, TIME, np.mod(course, wrap), np.ones(len(TIME), dtype=bool), "column", "logger")
    repaired, (fault,) = check_wrap(channel)
    assert fault.kind == "counter_wrap"
    assert fault.value == wrap
    turns = (repaired.values - course) / wrap
    assert turns == pytest.approx(np.round(turns[0]), abs=1e-9)


def test_a_slow_counter_is_unwrapped_though_noise_takes_it_over_its_end_and_back() -> None:
    """A speed of 16 m/s a turn that falls by 0.5 m/s in a second, less in 0.1 s than its noise of 0.06 m/s."""
    for seed in range(20):
        course = 34.0 - 0.5 * TIME + np.random.default_rng(seed).normal(0.0, 0.06, len(TIME))
        course -= course[150] - 32.0
        channel = Samples(
            "speed", "m/s", TIME, np.mod(course, 16.0), np.ones(len(TIME), dtype=bool), "column", "logger"
        )
        repaired, (fault,) = check_wrap(channel)
        assert fault.value == 16.0
        turns = (repaired.values - course) / 16.0
        assert turns == pytest.approx(np.round(turns[0]), abs=1e-9)


def test_what_is_switched_on_in_noise_is_no_counter() -> None:
    """A step of 200 noises between two levels passes where both sides slope the same way by three standard errors.

    By chance a line through 11 samples does by 0.0150 (t of 9), both the same way by 1.1e-4, and longer ones seldomer:
    more than one of 300 logs has a probability of 0.001.
    """
    found = 0
    for seed in range(300):
        switched = 16.0 * (TIME > 2.0) + np.random.default_rng(seed).normal(0.0, 0.08, len(TIME))
        channel = Samples("speed", "m/s", TIME, switched, np.ones(len(TIME), dtype=bool), "column", "logger")
        found += bool(check_wrap(channel)[1])
    assert found <= 1
