"""Wheel speed from pulse counters: wrapping, missing frames, low speed, standstill."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.ecu.calibration import load_calibration
from bench.ecu.records import AGE_TICKS, PRESENT, SOURCES, STATE_RECORD, bus_position, calibration_record
from bench.ecu.wheel_speed import measure_wheels

PITCH = 2.0 * np.pi / 48
RADIUS = 0.278
COUNT, TIME = bus_position("wheel_edge_count_fl"), bus_position("wheel_edge_time_fl")


class Pulses:
    """A tone ring read every 5 ms, 1 µs resolution."""

    def __init__(self, start_count: int = 0, start_time: float = 0.0) -> None:
        self.calibration = calibration_record(load_calibration("sensitive"))
        self.state: NDArray[np.void] = np.zeros(1, STATE_RECORD)
        self.health = np.zeros((len(SOURCES), 4), np.int64)
        self.health[:, PRESENT] = 1
        self.values = np.zeros(200)
        self.angle, self.time = start_count * PITCH, start_time

    def run(self, seconds: float, speed: Any, fresh: Any = lambda n: True) -> NDArray[np.float64]:
        """Speed of the front left wheel after each task; ``speed`` in m/s, constant or a function of time."""
        found = []
        for n in range(round(seconds / 0.005)):
            omega = (speed(n * 0.005) if callable(speed) else speed) / RADIUS
            before = self.angle
            self.angle += omega * 0.005
            self.time += 0.005
            count = np.floor(self.angle / PITCH)
            if count > np.floor(before / PITCH) or n == 0:
                self.stamp = self.time - ((self.angle - count * PITCH) / omega if omega > 0 else 0.0)
            if fresh(n):
                self.values[COUNT : COUNT + 4] = count % 65536
                self.values[TIME : TIME + 4] = np.round(self.stamp % 1.048576, 6)
            self.health[:, AGE_TICKS] = 0 if fresh(n) else 7
            measure_wheels(self.calibration[0], self.state[0], self.values, self.health, True)
            found.append(float(self.state[0]["previous_speed"][0]))
        return np.array(found)


@pytest.mark.parametrize("speed", [1.0, 5.0, 27.0, 60.0])
def test_constant_speed_is_exact(speed: float) -> None:
    found = Pulses().run(1.0, speed)
    assert found[100:] == pytest.approx(speed, rel=2e-4)  # 1 µs in the 8 ms and more between used edges


def test_wrapping_of_counter_and_time_is_not_seen() -> None:
    # at 27 m/s some 740 edges/s: the counter wraps after 0.05 s, the time after 0.048 s and each 1.05 s
    found = Pulses(start_count=65500, start_time=1.0).run(3.0, 27.0)
    assert found[10:] == pytest.approx(27.0, rel=2e-4)


def test_missing_frames_hold_the_speed() -> None:
    found = Pulses().run(1.0, 27.0, fresh=lambda n: n % 40 < 36)
    assert found[10:] == pytest.approx(27.0, rel=2e-4)


def test_locking_wheel_is_seen_within_ten_milliseconds() -> None:
    found = Pulses().run(1.0, lambda t: 27.0 if t < 0.5 else 0.0)
    assert found[99] == pytest.approx(27.0, rel=1e-3)
    assert found[102] < 4.0  # no edge for 10 ms: at most a tooth in that time, 3.6 m/s
    assert found[-1] == 0.0


def test_speed_comes_back_after_a_long_standstill() -> None:
    pulses = Pulses()
    assert pulses.run(2.0, 0.0)[-1] == 0.0
    assert pulses.run(0.5, 3.0)[-1] == pytest.approx(3.0, rel=1e-3)


def test_deceleration_is_followed() -> None:
    found = Pulses().run(2.0, lambda t: 27.0 - 10.0 * t)
    truth = 27.0 - 10.0 * 0.005 * np.arange(400)
    # mean over the used edges: late by half their distance, plus the time since the last edge
    assert np.max(np.abs(found - truth)[20:360]) < 10.0 * 0.02


def test_path_speed_is_freed_of_the_yaw_rate() -> None:
    pulses = Pulses()
    pulses.state[0]["inertial_ok"] = 1
    pulses.values[bus_position("yaw_rate")] = 0.4
    pulses.run(0.5, 20.0)
    path = pulses.state[0]["path_speed"]
    assert path[0] - path[1] == pytest.approx(0.4 * 1.5)  # left wheels are slower in a left turn: corrected upwards
