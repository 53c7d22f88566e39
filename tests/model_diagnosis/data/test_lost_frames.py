"""Lost frames that a log fills with the values before, by draws whose lost rows are known."""

import numpy as np
import pytest
from numpy.typing import NDArray

from model_diagnosis.data.grid import on_grid
from model_diagnosis.data.lost_frames import mask_lost_frames
from model_diagnosis.data.samples import Samples
from signals.wheels import WHEELS

NAMES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)
LOST = np.array([150, 213, 214, 301])
SAWTOOTH_FROM, COUNT = 100, 400
RESOLUTION_PA = 25_000.0


def _channels(*, late_s: float = 0.0) -> dict[str, Samples]:
    """Four pressures at rest, then sawtooth of 60 bar in 200 ms, with a series sensor's noise and resolution."""
    random = np.random.default_rng(5)
    time = 0.01 * np.arange(COUNT)
    found = {}
    for k, name in enumerate(NAMES):
        course = np.where(time >= 0.01 * SAWTOOTH_FROM, 6e6 * ((time / 0.2 + 0.17 * k) % 1.0), 0.0)
        values = RESOLUTION_PA * np.round((course + random.normal(0.0, 3e4, COUNT)) / RESOLUTION_PA)
        for row in LOST:
            values[row] = values[row - 1]
        stamps = time + late_s * k
        found[name] = Samples(name, "Pa", stamps, values, np.ones(COUNT, dtype=np.bool_), name, "log.csv")
    return found


def _masked(channels: dict[str, Samples]) -> list[NDArray[np.int64]]:
    return [np.flatnonzero(~one.valid) for one in mask_lost_frames(channels).values()]


def test_frames_that_only_repeat_are_no_measurement() -> None:
    """Each lost row in all four signals, and no other row of a frame whose signals move."""
    assert all(np.array_equal(rows, LOST) for rows in _masked(_channels()))


def test_a_lost_frame_is_bridged_by_its_neighbours() -> None:
    """Not held: the straight line between the samples before and after, where one frame was lost."""
    channels = mask_lost_frames(_channels())
    _, values, _ = on_grid(channels)
    for name in NAMES:
        raw = channels[name].values
        row = int(LOST[0])
        assert values[name][row] == pytest.approx(0.5 * (raw[row - 1] + raw[row + 1]), abs=1.0)


def test_one_signal_that_repeats_is_none() -> None:
    channels = _channels()
    other = channels[NAMES[2]]
    channels[NAMES[2]] = other.with_values(other.values + RESOLUTION_PA * (np.arange(COUNT) % 2))
    assert not any(len(rows) for rows in _masked(channels))


@pytest.mark.parametrize("channels", [_channels(late_s=0.001), {NAMES[0]: _channels()[NAMES[0]]}])
def test_signals_that_came_apart_are_no_frame(channels: dict[str, Samples]) -> None:
    assert not any(len(rows) for rows in _masked(channels))
