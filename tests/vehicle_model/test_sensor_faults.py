"""Faults of sensors: tone rings, plugs, contacts, drift, mounting."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from signals.catalogue import block_slice, index_of
from signals.vector import SignalVector
from vehicle_model.sensors import Sensors
from vehicle_model.vehicle_file import load_vehicle, parameter_table

BUS = block_slice("bus")
WHEELS = ("fl", "fr", "rl", "rr")
SPEED = 60.0  # rad/s
PITCH = 2.0 * math.pi / 48  # 48 teeth


class Bench:
    """Ideal sensors, but for what is set, on a car whose wheels turn at a constant speed."""

    def __init__(self, *, ideal: bool = True, seed: int = 5) -> None:
        vehicle = load_vehicle("ekf_car")
        if ideal:
            vehicle.sensors = type(vehicle.sensors)()
        self.sensors = Sensors(vehicle, seed)
        self.vector = SignalVector()
        self.sensed = np.zeros(BUS.stop - BUS.start)
        self.time = 0.0

    def set(self, **values: float) -> "Bench":
        for path, value in values.items():
            self.sensors.set("sensors." + path.replace("__", "."), value)
        return self

    def run(self, ticks: int, **values: float) -> NDArray[np.float64]:
        """Everything that was reported, a row per tick."""
        for name, value in values.items():
            self.vector.values[index_of(name)] = value
        rows = np.empty((ticks, len(self.sensed)))
        for n in range(ticks):
            self.sensors.tick(self.vector.values, self.time, self.sensed)
            rows[n] = self.sensed
            self.time += 1e-3
        return rows


def wheels_at(*speeds: float) -> dict[str, float]:
    return {f"true_wheel_speed_{w}": v for w, v in zip(WHEELS, speeds, strict=True)}


def column(name: str) -> int:
    return index_of(name) - BUS.start


def test_neutral_values_leave_every_report_bit_for_bit() -> None:
    table = [info for info in parameter_table(load_vehicle("ekf_car")) if info.path.startswith("sensors.")]
    # what the shipped car sets to another value than the neutral one is no fault that was added
    neutral = {info.path: info.neutral for info in table if info.neutral is not None and info.value == info.neutral}
    assert len(neutral) > 100
    plain, explicit = Bench(ideal=False), Bench(ideal=False)
    for path, value in neutral.items():
        explicit.sensors.set(path, value)
    generator = np.random.default_rng(2)
    for _ in range(20):
        values = {
            **wheels_at(*generator.uniform(0.0, 90.0, 4)),
            "true_longitudinal_acceleration": generator.uniform(-9.0, 3.0),
            "true_brake_pressure_fl": generator.uniform(0.0, 1e7),
            "pitch_angle": generator.uniform(-0.05, 0.05),
        }
        assert np.array_equal(plain.run(30, **values), explicit.run(30, **values))


def test_missing_teeth_leave_a_gap_once_per_turn() -> None:
    bench = Bench().set(wheel_speed__missing_teeth_fl=2)
    rows = bench.run(2000, **wheels_at(SPEED, SPEED, SPEED, SPEED))
    speed = rows[500:, column("wheel_speed_fl")]
    # over the gap three pitches count as one: within the window of 5 ms the speed falls to a third
    assert speed.min() == pytest.approx(SPEED / 3.0, rel=0.02)
    assert np.median(speed) == pytest.approx(SPEED, rel=1e-3)
    counted = rows[-1, column("wheel_edge_count_fl")] - rows[500, column("wheel_edge_count_fl")]
    healthy = rows[-1, column("wheel_edge_count_fr")] - rows[500, column("wheel_edge_count_fr")]
    assert counted / healthy == pytest.approx(46 / 48, abs=0.004)
    dips = np.flatnonzero(np.diff((speed < 0.6 * SPEED).astype(int)) == 1)
    assert np.diff(dips).mean() * 1e-3 == pytest.approx(2 * math.pi / SPEED, rel=0.01)  # once per turn


def test_large_air_gap_hides_edges_below_a_speed_that_grows_exponentially() -> None:
    gap, threshold, radius = 2e-3, 2.0, 0.05
    limit = threshold * (math.exp(2.0 * math.pi * gap / (radius * PITCH)) - 1.0)
    assert 3.0 < limit < 30.0
    bench = Bench().set(wheel_speed__air_gap_fr=gap)
    above = bench.run(300, **wheels_at(*[1.02 * limit] * 4))[-1, column("wheel_speed_fr")]
    assert above == pytest.approx(1.02 * limit, rel=0.01)
    rows = bench.run(600, **wheels_at(*[0.98 * limit] * 4))
    assert rows[-1, column("wheel_speed_fr")] == 0.0
    assert rows[-1, column("wheel_speed_fl")] == pytest.approx(0.98 * limit, rel=0.01)


def test_swapped_plugs_report_the_other_wheel() -> None:
    bench = Bench().set(wheel_speed__connected_fl=1, wheel_speed__connected_fr=0)
    row = bench.run(400, **wheels_at(20.0, 40.0, 60.0, 80.0))[-1]
    reported = [row[column(f"wheel_speed_{w}")] for w in WHEELS]
    assert reported == pytest.approx([40.0, 20.0, 60.0, 80.0], rel=1e-3)
    counts = [row[column(f"wheel_edge_count_{w}")] for w in WHEELS]
    assert counts[0] > counts[1]


def test_ring_with_other_teeth_scales_the_speed() -> None:
    row = Bench().set(wheel_speed__scale_rl=44 / 48).run(400, **wheels_at(*[SPEED] * 4))[-1]
    assert row[column("wheel_speed_rl")] == pytest.approx(SPEED * 44 / 48, rel=1e-3)


def test_stuck_sensors_keep_what_they_reported_last() -> None:
    bench = Bench()
    before = bench.run(300, **wheels_at(*[SPEED] * 4), true_yaw_rate=0.2)[-1].copy()
    bench.set(wheel_speed__stuck_rr=1.0, yaw_rate__stuck=1.0)
    after = bench.run(300, **wheels_at(*[10.0] * 4), true_yaw_rate=-0.5)[-1]
    for name in ("wheel_speed_rr", "wheel_edge_count_rr", "wheel_edge_time_rr", "yaw_rate"):
        assert after[column(name)] == before[column(name)]
    assert after[column("wheel_speed_rl")] == pytest.approx(10.0, rel=0.01)
    bench.set(yaw_rate__stuck=0.0)
    assert bench.run(100)[-1, column("yaw_rate")] == pytest.approx(-0.5, abs=1e-6)


def test_drift_grows_from_when_it_is_set_and_stays() -> None:
    bench = Bench()
    bench.run(500)
    bench.set(longitudinal_acceleration__drift=0.2, brake_pressure__rl__drift=1e5)
    rows = bench.run(1000)
    assert rows[-1, column("longitudinal_acceleration")] == pytest.approx(0.2 * 1.0, abs=1e-9)
    assert rows[499, column("brake_pressure_rl")] == pytest.approx(1e5 * 0.5, abs=1e-3)
    assert rows[-1, column("brake_pressure_rr")] == 0.0
    bench.set(longitudinal_acceleration__drift=0.0)
    assert bench.run(100)[-1, column("longitudinal_acceleration")] == pytest.approx(0.2, abs=1e-9)


def test_wheel_pressure_sensor_faults_add_to_the_common_ones() -> None:
    bench = Bench().set(brake_pressure__scale=1.1, brake_pressure__offset=1e5, brake_pressure__fr__scale=0.5)
    bench.set(brake_pressure__fr__offset=2e5)
    row = bench.run(5, true_brake_pressure_fl=4e6, true_brake_pressure_fr=4e6)[-1]
    assert row[column("brake_pressure_fl")] == pytest.approx(1.1 * 4e6 + 1e5)
    assert row[column("brake_pressure_fr")] == pytest.approx(1.1 * 0.5 * 4e6 + 3e5)


def test_loose_contact_opens_as_often_and_as_long_as_told() -> None:
    bench = Bench().set(master_pressure__dropout_rate=5.0, master_pressure__dropout_duration=0.02)
    pressure = bench.run(40_000, true_master_pressure=6e6)[:, column("master_pressure")]
    is_open = pressure == 0.0
    starts = np.count_nonzero(np.diff(is_open.astype(int)) == 1)
    # begins at 5 1/s while closed, each 20 ms long: share 0.1/1.1; 40 s give 180 ± 14
    assert np.mean(is_open) == pytest.approx(0.1 / 1.1, rel=0.25)
    assert np.count_nonzero(is_open) / starts == pytest.approx(20.0, rel=0.1)
    assert set(np.unique(pressure)) == {0.0, 6e6}


def test_loose_contact_of_a_wheel_loses_edges_and_leaves_other_noise_alone() -> None:
    plain, loose = Bench(ideal=False), Bench(ideal=False)
    loose.set(wheel_speed__dropout_rate_fl=10.0, wheel_speed__dropout_duration=0.05)
    first = plain.run(4000, **wheels_at(*[SPEED] * 4))
    second = loose.run(4000, **wheels_at(*[SPEED] * 4))
    changed = [
        name
        for name in ("wheel_speed_fl", "wheel_speed_fr", "yaw_rate", "brake_pressure_fl")
        if not np.array_equal(first[:, column(name)], second[:, column(name)])
    ]
    assert changed == ["wheel_speed_fl"]
    lost = 1.0 - second[-1, column("wheel_edge_count_fl")] / first[-1, column("wheel_edge_count_fl")]
    assert lost == pytest.approx(0.5 / 1.5, abs=0.12)
    # without edges the speed is at most a pitch over the time since the last one
    assert second[:, column("wheel_speed_fl")].min() < 0.5 * SPEED


def test_unit_mounted_askew_mixes_its_axes() -> None:
    level = {"true_longitudinal_acceleration": -8.0, "true_yaw_rate": 0.4}
    yawed = Bench().set(inertial__mounting_yaw=math.radians(10.0)).run(1, **level)[-1]
    assert yawed[column("longitudinal_acceleration")] == pytest.approx(-8.0 * math.cos(math.radians(10.0)))
    assert yawed[column("lateral_acceleration")] == pytest.approx(8.0 * math.sin(math.radians(10.0)))
    assert yawed[column("yaw_rate")] == pytest.approx(0.4)
    # nose down by 3 degrees: gravity appears along x, the yaw rate partly as a roll rate
    pitched = Bench().set(inertial__mounting_pitch=math.radians(3.0)).run(1, true_yaw_rate=0.4)[-1]
    assert pitched[column("longitudinal_acceleration")] == pytest.approx(-9.81 * math.sin(math.radians(3.0)))
    assert pitched[column("vertical_acceleration")] == pytest.approx(9.81 * (math.cos(math.radians(3.0)) - 1.0))
    assert pitched[column("roll_rate")] == pytest.approx(-0.4 * math.sin(math.radians(3.0)))
    rolled = Bench().set(inertial__mounting_roll=math.radians(3.0)).run(1)[-1]
    assert rolled[column("lateral_acceleration")] == pytest.approx(9.81 * math.sin(math.radians(3.0)))
    # the length of the specific force does not change
    upside_down = Bench().set(inertial__mounting_roll=math.pi).run(1, true_longitudinal_acceleration=-8.0)[-1]
    assert upside_down[column("longitudinal_acceleration")] == pytest.approx(-8.0)
    assert upside_down[column("vertical_acceleration")] == pytest.approx(-2 * 9.81)
