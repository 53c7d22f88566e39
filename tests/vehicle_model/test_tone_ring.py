"""Tone rings: edges in continuous time against closed forms."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from signals.catalogue import block_slice, index_of
from signals.vector import SignalVector
from vehicle_model.sensors import Sensors
from vehicle_model.tone_ring import TIMER_WRAP_S, TURN, edge_angles
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

BUS = block_slice("bus")
PITCH = TURN / 48


def car(**ring: float) -> VehicleFile:
    """The car of Table 8 with ideal rings of 48 teeth but for what is given."""
    vehicle = load_vehicle("ekf_car")
    ideal = {"pitch_error": 0.0, "eccentricity": 0.0, "edge_jitter": 0.0, "timer_resolution": 0.0}
    for name, value in (ideal | ring).items():
        set_parameter(vehicle, f"sensors.wheel_speed.{name}", value)
    return vehicle


class Bench:
    """Sensors and a signal vector; every wheel turns as told."""

    def __init__(self, vehicle: VehicleFile, seed: int = 0) -> None:
        self.sensors = Sensors(vehicle, seed)
        self.vector = SignalVector()
        self.sensed = np.zeros(BUS.stop - BUS.start)
        self.tick_number = 0

    def tick(self, omega: float) -> None:
        first = index_of("true_wheel_speed_fl")
        self.vector.values[first : first + 4] = omega
        self.sensors.tick(self.vector.values, self.tick_number * 1e-3, self.sensed)
        self.tick_number += 1

    def of(self, name: str) -> NDArray[np.float64]:
        start = index_of(f"{name}_fl") - BUS.start
        return self.sensed[start : start + 4].copy()

    def edges(self, omega: float, ticks: int) -> NDArray[np.float64]:
        """Times of the edges of the front left wheel at a speed so low that no tick has two."""
        times = []
        count = self.of("wheel_edge_count")[0]
        for _ in range(ticks):
            self.tick(omega)
            if self.of("wheel_edge_count")[0] != count:
                count = self.of("wheel_edge_count")[0]
                times.append(self.sensors._state[0]["edge_time"][0])
        return np.array(times)


@pytest.mark.parametrize("omega", [3.0, 20.0, 95.0, 250.0])
def test_speed_is_exact_at_constant_speed(omega: float) -> None:
    bench = Bench(car())
    for _ in range(400):
        bench.tick(omega)
    np.testing.assert_allclose(bench.of("wheel_speed"), omega, rtol=1e-9)


def test_speed_error_is_that_of_the_timer() -> None:
    bench = Bench(car(timer_resolution=1e-6))
    errors = []
    for _ in range(2000):
        bench.tick(95.0)
        if bench.tick_number > 20:
            errors.append(bench.of("wheel_speed") - 95.0)
    # edges of 5 ms, each read to 1 us, at least 4.1 ms apart
    assert np.max(np.abs(errors)) <= 95.0 * 1e-6 / 4.1e-3
    assert np.max(np.abs(errors)) > 1e-4


def test_edges_are_conserved_over_any_motion() -> None:
    bench = Bench(car())
    generator = np.random.default_rng(8)
    omega, way = 0.0, 0.0
    bench.tick(0.0)
    start = bench.sensors._state[0]["angle"].copy()
    for _ in range(5000):
        after = float(np.clip(omega + generator.normal(0.0, 2.0), 0.0, 300.0))
        bench.tick(after)
        way += 0.5 * (omega + after) * 1e-3
        omega = after
    # edges lie at whole pitches of the wheel's angle
    expected = np.floor((start + way) / PITCH) - np.floor(start / PITCH)
    assert way > 100.0
    np.testing.assert_array_equal(bench.of("wheel_edge_count"), expected % 65536)


def test_edge_times_of_an_accelerating_wheel() -> None:
    bench = Bench(car())
    bench.tick(0.0)
    angle = bench.sensors._state[0]["angle"][0]
    times = []
    for tick in range(1, 400):
        before = bench.of("wheel_edge_count")[0]
        bench.tick(100.0 * tick * 1e-3)  # 100 rad/s^2 from 1 ms on
        if bench.of("wheel_edge_count")[0] == before + 1:
            times.append(bench.sensors._state[0]["edge_time"][0])
    first = math.floor(angle / PITCH) + 1
    ways = (first + np.arange(len(times))) * PITCH - angle
    np.testing.assert_allclose(times, 1e-3 + np.sqrt(2.0 * ways / 100.0), atol=1e-12)


def test_direction_changes_within_a_tick() -> None:
    bench = Bench(car())
    for omega in (5.0, -5.0) * 50:
        bench.tick(omega)
    # the wheel swings by 5/4 mrad around one place: at most one edge is passed again and again
    assert np.all(bench.of("wheel_edge_count") <= 100)
    moved = bench.sensors._state[0]["angle"].copy()
    bench.tick(5.0)
    for _ in range(200):
        bench.tick(20.0)
    for _ in range(200):
        bench.tick(-20.0)
    bench.tick(-5.0)
    bench.tick(5.0)
    turned = (bench.sensors._state[0]["angle"] - moved + math.pi) % TURN - math.pi
    assert np.all(np.abs(turned) < 0.05)


def test_no_sense_of_direction() -> None:
    bench = Bench(car())
    for _ in range(500):
        bench.tick(-40.0)
    np.testing.assert_allclose(bench.of("wheel_speed"), 40.0, rtol=1e-9)
    assert np.all(np.abs(bench.of("wheel_edge_count") - 40.0 * 0.5 / PITCH) <= 1.0)


def test_timer_counts_in_steps_and_wraps() -> None:
    bench = Bench(car(timer_resolution=1e-6))
    seen = []
    for _ in range(2500):
        bench.tick(50.0)
        seen.append(bench.of("wheel_edge_time")[0])
    microseconds = np.array(seen) * 1e6
    np.testing.assert_allclose(microseconds, np.round(microseconds), atol=1e-3)
    assert max(seen) < TIMER_WRAP_S == 1.048576
    # two wraps in 2.5 s
    assert np.count_nonzero(np.diff(seen) < -0.5) == 2


def test_counter_wraps() -> None:
    bench = Bench(car())
    bench.sensors._state[0]["count"] = 65530
    for _ in range(50):
        bench.tick(95.0)
    assert np.all(bench.of("wheel_edge_count") < 40)
    np.testing.assert_allclose(bench.of("wheel_speed"), 95.0, rtol=1e-9)


def test_standstill() -> None:
    bench = Bench(car(standstill_timeout=0.3))
    for _ in range(300):
        bench.tick(30.0)
    speeds = []
    for _ in range(400):
        bench.tick(0.0)
        speeds.append(bench.of("wheel_speed")[0])
    now = bench.tick_number * 1e-3
    last = bench.sensors._state[0]["edge_time"][0]
    # without an edge the speed is at most a pitch over the time since the last one ...
    assert speeds[199] == pytest.approx(PITCH / (now - 0.2 - last), rel=1e-6)
    assert np.all(np.diff(speeds) <= 0.0)
    # ... and zero after the timeout
    assert speeds[int((last + 0.302 - (now - 0.4)) * 1000)] == 0.0
    assert speeds[-1] == 0.0
    for _ in range(100):
        bench.tick(30.0)
    assert bench.of("wheel_speed")[0] == pytest.approx(30.0, rel=1e-6)


def test_slow_wheel_between_edges() -> None:
    # an edge each 131 ms: speed holds between them
    bench = Bench(car())
    for _ in range(1000):
        bench.tick(1.0)
    np.testing.assert_allclose(bench.of("wheel_speed"), 1.0, rtol=1e-9)


def test_eccentricity_is_a_line_at_the_wheel_frequency() -> None:
    bench = Bench(car(eccentricity=0.01))
    omega = 20.0
    turns = 8
    times = bench.edges(omega, math.ceil((turns + 1) * TURN / omega * 1000))[: 48 * turns + 1]
    speed = PITCH / np.diff(times)
    spectrum = np.abs(np.fft.rfft(speed - speed.mean())) / (len(speed) / 2)
    line = np.argmax(spectrum)
    assert line == turns  # once per turn
    assert spectrum[line] == pytest.approx(0.01 * omega, rel=0.01)
    rest = np.delete(spectrum, line)
    assert rest.max() < 0.02 * spectrum[line]  # the second order is e^2


def test_pitch_errors_repeat_each_turn_and_add_up_to_nothing() -> None:
    bench = Bench(car(pitch_error=0.01), seed=4)
    omega = 20.0
    times = bench.edges(omega, math.ceil(3.2 * TURN / omega * 1000))
    intervals = np.diff(times)
    np.testing.assert_allclose(intervals[:48], intervals[48:96], atol=1e-9)
    assert intervals[:48].sum() == pytest.approx(TURN / omega, rel=1e-12)
    # the interval between two teeth has twice the variance of a tooth's place
    assert np.std(intervals[:48]) == pytest.approx(math.sqrt(2.0) * 0.01 * PITCH / omega, rel=0.3)


def test_edge_angles_without_errors_are_whole_pitches() -> None:
    angles = edge_angles(48, 0.0, 0.0, np.zeros(48), 0.3)
    np.testing.assert_allclose(angles, np.arange(48) * PITCH, atol=1e-12)
    eccentric = edge_angles(48, 0.0, 0.05, np.zeros(48), 0.3)
    np.testing.assert_allclose(
        np.sort((eccentric + 0.05 * np.sin(eccentric - 0.3)) % TURN), np.arange(48) * PITCH, atol=1e-12
    )


def test_rings_are_the_seed_s() -> None:
    def run(seed: int) -> NDArray[np.float64]:
        bench = Bench(car(pitch_error=0.01, eccentricity=0.005, edge_jitter=2e-6), seed)
        for _ in range(200):
            bench.tick(60.0)
        return bench.sensed.copy()

    np.testing.assert_array_equal(run(1), run(1))
    assert not np.array_equal(run(1), run(2))


def test_jitter_is_seen_in_the_times() -> None:
    bench = Bench(car(edge_jitter=1e-5), seed=2)
    omega = 20.0
    times = bench.edges(omega, 5000)
    intervals = np.diff(times)
    assert np.std(intervals) == pytest.approx(math.sqrt(2.0) * 1e-5, rel=0.15)


def test_teeth_can_change_on_line() -> None:
    bench = Bench(car())
    for _ in range(100):
        bench.tick(50.0)
    bench.sensors.set("sensors.wheel_speed.teeth", 96)
    before = bench.of("wheel_edge_count")[0]
    for _ in range(1000):
        bench.tick(50.0)
    assert bench.of("wheel_edge_count")[0] - before == pytest.approx(50.0 / (TURN / 96), abs=1.0)
    np.testing.assert_allclose(bench.of("wheel_speed"), 50.0, rtol=1e-9)
