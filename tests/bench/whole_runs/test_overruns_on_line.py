"""A tick that ends after the next deadline is counted at once: dashboard and recording show it during the run."""

import time
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.loop.connection import connect
from bench.loop.memory import MemoryRecorder
from bench.loop.pacing import RealtimePacer
from bench.loop.scheduling import plan_cores
from bench.loop.session import Session, build_parts
from bench.scenario.schema import ScenarioFile

HELD_UP = (300, 400, 500)
"""Ticks that the recorder holds up for longer than a period."""


class SlowRecorder(MemoryRecorder):
    """Takes 3 ms for some rows."""

    def write_row(self, values: NDArray[np.float64], tick: int) -> None:
        super().write_row(values, tick)
        if tick in HELD_UP:
            time.sleep(3e-3)


@pytest.mark.real_time
def test_overruns_are_counted_while_the_run_goes_on(short_stop: Callable[..., ScenarioFile]) -> None:
    scenario = short_stop(pacing="realtime")
    parts = build_parts(scenario)
    connection, pacer = connect(scenario, parts.codec, plan_cores()), RealtimePacer(parts.ticks)
    recorder = SlowRecorder(parts.ticks, len(parts.vector.names))
    Session(parts, connection).run(recorder, pacer)
    shown = recorder.rows[:, parts.vector.index("overruns")]
    for tick in HELD_UP:
        assert shown[tick + 1] > shown[tick]
    assert (np.diff(shown) >= 0).all()
    times, count = pacer.times, pacer.times.count
    ended_late = times.lateness_ns[:count] + times.duration_ns[:count] > 1_000_000
    assert np.array_equal(shown[1:], np.cumsum(ended_late)[:-1])
    assert times.overruns == ended_late.sum() >= len(HELD_UP)
