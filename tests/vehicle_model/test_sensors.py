"""Inertial unit, pressure, pedal, steering and powertrain sensors."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from signals.catalogue import block_slice, catalogue, index_of
from signals.errors import InputError
from signals.vector import SignalVector
from vehicle_model.sensors import Sensors, low_pass_matrices
from vehicle_model.sensors_record import CHANNEL_SIGNALS
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

BUS = block_slice("bus")
GRAVITY = 9.81


def car(**changes: float) -> VehicleFile:
    """The car of Table 8 with ideal sensors but for what is given (``__`` for the dot)."""
    vehicle = load_vehicle("ekf_car")
    vehicle.sensors = type(vehicle.sensors)()
    for path, value in changes.items():
        set_parameter(vehicle, "sensors." + path.replace("__", "."), value)
    return vehicle


class Bench:
    """Sensors, a signal vector and what they put out."""

    def __init__(self, vehicle: VehicleFile, seed: int = 0) -> None:
        self.sensors = Sensors(vehicle, seed)
        self.vector = SignalVector()
        self.sensed = np.zeros(BUS.stop - BUS.start)
        self.time = 0.0

    def run(self, ticks: int, **values: float) -> None:
        for name, value in values.items():
            self.vector.values[index_of(name)] = value
        for _ in range(ticks):
            self.sensors.tick(self.vector.values, self.time, self.sensed)
            self.time += 1e-3

    def __getitem__(self, name: str) -> float:
        return float(self.sensed[index_of(name) - BUS.start])


def test_ideal_sensors_show_the_truth() -> None:
    bench = Bench(car())
    bench.run(
        1,
        true_longitudinal_acceleration=-8.0,
        true_lateral_acceleration=2.0,
        true_yaw_rate=0.3,
        true_master_pressure=1.2e7,
        true_brake_pressure_rl=5e6,
        driver_pedal_force=400.0,
        driver_steering_wheel_angle=0.8,
        driver_gear=3.0,
        true_engine_speed=300.0,
        true_engine_torque=120.0,
        drive_torque_demand_rl=250.0,
        drive_torque_demand_rr=240.0,
        true_wheel_speed_rl=50.0,
        true_wheel_speed_rr=60.0,
        true_road_wheel_angle_fl=0.051,
        true_road_wheel_angle_fr=0.047,
    )
    expected = {
        "longitudinal_acceleration": -8.0,
        "lateral_acceleration": 2.0,
        "vertical_acceleration": 0.0,
        "yaw_rate": 0.3,
        "master_pressure": 1.2e7,
        "brake_pressure_rl": 5e6,
        "brake_pressure_fl": 0.0,
        "pedal_force": 400.0,
        "brake_switch": 1.0,
        "steering_wheel_angle": 0.8,
        "steering_command": 0.05,  # ratio 16
        "road_wheel_angle": 0.049,
        "gear": 3.0,
        "engine_speed": 300.0,
        "engine_torque": 120.0,
        "gearbox_speed": 3.2 * 55.0,  # final drive times the mean of the driven wheels
        "drive_torque_f": 0.0,
        "drive_torque_r": 490.0,
        "ignition": 1.0,
    }
    for name, value in expected.items():
        assert bench[name] == pytest.approx(value, abs=1e-9), name


def test_the_gearbox_speed_follows_a_final_drive_that_changes_on_line() -> None:
    bench = Bench(car())
    bench.run(1, true_wheel_speed_rl=50.0, true_wheel_speed_rr=60.0)
    assert bench["gearbox_speed"] == pytest.approx(3.2 * 55.0)
    assert "driveline.final_drive" in bench.sensors.names()
    bench.sensors.set("driveline.final_drive", 4.1)
    assert bench.sensors.get("driveline.final_drive") == 4.1
    bench.run(1, true_wheel_speed_rl=50.0, true_wheel_speed_rr=60.0)
    assert bench["gearbox_speed"] == pytest.approx(4.1 * 55.0)
    with pytest.raises(InputError, match="out of range"):
        bench.sensors.set("driveline.final_drive", -1.0)


def test_what_comes_from_the_ecu_is_left_alone() -> None:
    bench = Bench(car())
    bench.sensed[:] = 7.0
    bench.run(3)
    from_ecu = [
        signal.name for signal in catalogue()[BUS] if signal.name.startswith(("valve_", "pump", "abs_", "ebd_", "ecu_"))
    ]
    assert all(bench[name] == 7.0 for name in from_ecu)
    assert sum(1 for value in bench.sensed if value == 7.0) == len(from_ecu)


def test_accelerometer_sees_gravity() -> None:
    bench = Bench(car())
    bench.run(1, pitch_angle=0.02)  # nose down: gravity has a part forwards, the sensor reads less
    assert bench["longitudinal_acceleration"] == pytest.approx(-GRAVITY * math.sin(0.02))
    assert bench["vertical_acceleration"] == pytest.approx(GRAVITY * (math.cos(0.02) - 1.0))
    bench = Bench(car())
    bench.run(1, roll_angle=0.03)  # right side down
    assert bench["lateral_acceleration"] == pytest.approx(GRAVITY * math.sin(0.03))
    bench = Bench(car())
    bench.run(1, road_grade=0.1, true_longitudinal_acceleration=-1.0)
    assert bench["longitudinal_acceleration"] == pytest.approx(-1.0 + GRAVITY * 0.1 / math.sqrt(1.01))
    bench = Bench(car())  # across a grade the car leans: uphill is to its right
    bench.run(1, road_grade=0.1, yaw_angle=math.pi / 2)
    assert bench["lateral_acceleration"] == pytest.approx(-GRAVITY * 0.1 / math.sqrt(1.01))
    bench = Bench(car())
    bench.run(1, road_bank=0.05)
    assert bench["lateral_acceleration"] == pytest.approx(GRAVITY * 0.05 / math.sqrt(1.0025))


def test_a_sensor_beside_the_centre_of_gravity_feels_the_turning() -> None:
    bench = Bench(car(inertial__position_x=1.0, inertial__position_y=-0.4))
    bench.run(1000, true_yaw_rate=0.5)
    assert bench["longitudinal_acceleration"] == pytest.approx(-0.25 * 1.0)
    assert bench["lateral_acceleration"] == pytest.approx(0.25 * 0.4)
    bench = Bench(car(inertial__position_x=1.0, inertial__position_y=-0.4))
    for tick in range(1000):
        bench.run(1, true_yaw_rate=2.0 * tick * 1e-3)  # 2 rad/s^2
    assert bench["lateral_acceleration"] == pytest.approx(2.0 * 1.0 + 2.0**2 * 0.4, rel=0.02)
    assert bench["longitudinal_acceleration"] == pytest.approx(2.0 * 0.4 - 2.0**2 * 1.0, rel=0.02)


@pytest.mark.parametrize("damping", [0.3, 1 / math.sqrt(2), 1.2])
def test_low_pass_has_its_cut_off_whatever_the_damping(damping: float) -> None:
    transition, entry = low_pass_matrices(20.0, damping)
    z = np.exp(2j * math.pi * 20.0 * 1e-3)
    response = np.linalg.solve(z * np.eye(2) - transition, entry)[0]
    # the input is held over a tick, which alone costs 0.07 % at 20 Hz
    assert abs(response) == pytest.approx(1 / math.sqrt(2), rel=0.01)
    steady = np.linalg.solve(np.eye(2) - transition, entry)
    assert steady == pytest.approx([1.0, 0.0], abs=1e-9)


def test_low_pass_in_the_loop() -> None:
    bench = Bench(car(inertial__cut_off_frequency=10.0))
    measured = []
    for tick in range(2000):
        bench.run(1, true_longitudinal_acceleration=math.sin(2 * math.pi * 10.0 * tick * 1e-3))
        measured.append(bench["longitudinal_acceleration"])
    assert max(measured[1000:]) == pytest.approx(1 / math.sqrt(2), rel=0.01)


@pytest.mark.parametrize(
    ("channel", "section", "noise"),
    [
        ("longitudinal_acceleration", "longitudinal_acceleration", 0.05),
        ("yaw_rate", "yaw_rate", 0.002),
        ("brake_pressure_rr", "brake_pressure", 2e4),
        ("pedal_force", "pedal_force", 3.0),
    ],
)
def test_noise_is_white_and_has_its_standard_deviation(channel: str, section: str, noise: float) -> None:
    bench = Bench(car(**{f"{section}__noise": noise}), seed=11)
    samples = np.empty(20_000)
    for tick in range(len(samples)):
        bench.run(1)
        samples[tick] = bench[channel]
    count = len(samples)
    assert abs(samples.mean()) < 4.0 * noise / math.sqrt(count)
    assert samples.std() == pytest.approx(noise, rel=4.0 / math.sqrt(2 * count))
    neighbours = np.corrcoef(samples[:-1], samples[1:])[0, 1]
    assert abs(neighbours) < 4.0 / math.sqrt(count)


def outputs(vehicle: VehicleFile, seed: int, ticks: int = 300) -> NDArray[np.float64]:
    bench = Bench(vehicle, seed)
    rows = []
    for _ in range(ticks):
        bench.run(1, true_longitudinal_acceleration=-5.0, true_wheel_speed_fl=50.0)
        rows.append(bench.sensed.copy())
    return np.array(rows)


def test_same_seed_same_numbers() -> None:
    vehicle = car(longitudinal_acceleration__noise=0.05, yaw_rate__noise=0.01)
    np.testing.assert_array_equal(outputs(vehicle, 5), outputs(vehicle, 5))
    assert not np.array_equal(outputs(vehicle, 5), outputs(vehicle, 6))
    sensors = Sensors(vehicle, 5)
    vector, first, second = SignalVector(), np.zeros(BUS.stop - BUS.start), np.zeros(BUS.stop - BUS.start)
    for tick in range(100):
        sensors.tick(vector.values, tick * 1e-3, first)
    sensors.reset()
    for tick in range(100):
        sensors.tick(vector.values, tick * 1e-3, second)
    np.testing.assert_array_equal(first, second)


def test_noise_on_one_channel_leaves_the_others_alone() -> None:
    one = outputs(car(longitudinal_acceleration__noise=0.05), 5)
    both = outputs(car(longitudinal_acceleration__noise=0.05, yaw_rate__noise=0.01), 5)
    column = index_of("longitudinal_acceleration") - BUS.start
    np.testing.assert_array_equal(one[:, column], both[:, column])
    assert np.std(both[:, index_of("yaw_rate") - BUS.start]) > 0.0


def test_noise_begins_with_the_tick_after_it_is_set() -> None:
    bench = Bench(car(), seed=3)
    bench.run(10)
    bench.sensors.set("sensors.longitudinal_acceleration.noise", 0.1)
    bench.run(1)
    assert bench["longitudinal_acceleration"] != 0.0


def test_offset_scale_and_resolution() -> None:
    bench = Bench(
        car(
            longitudinal_acceleration__offset=0.2,
            longitudinal_acceleration__scale=1.1,
            longitudinal_acceleration__resolution=0.25,
        )
    )
    bench.run(1, true_longitudinal_acceleration=-3.0)  # -3.1 becomes -3.0
    assert bench["longitudinal_acceleration"] == pytest.approx(-3.0)
    bench.run(2000, true_longitudinal_acceleration=-3.05)  # -3.155 becomes -3.25
    assert bench["longitudinal_acceleration"] == pytest.approx(-3.25)


@pytest.mark.parametrize(("delay", "expected"), [(0.0, 99.0), (0.010, 89.0), (0.0105, 88.5), (0.1, 0.0)])
def test_delay(delay: float, expected: float) -> None:
    bench = Bench(car(pedal_force__delay=delay))
    for tick in range(100):
        bench.run(1, driver_pedal_force=float(tick))
    assert bench["pedal_force"] == pytest.approx(expected)


@pytest.mark.acceptance("F-13")
def test_acceleration_source() -> None:
    errors = {
        "longitudinal_acceleration__offset": 0.5,
        "longitudinal_acceleration__noise": 0.1,
        "inertial__cut_off_frequency": 5.0,
    }
    seen = {}
    for source in ("cluster_can", "noise_free", "ideal"):
        vehicle = car(**errors)
        vehicle.sensors.acceleration_source = source  # type: ignore[assignment]
        bench = Bench(vehicle, seed=1)
        bench.run(10, pitch_angle=0.01)
        bench.run(2, true_longitudinal_acceleration=-6.0)
        seen[source] = bench["longitudinal_acceleration"]
    gravity = -GRAVITY * math.sin(0.01)
    assert seen["ideal"] == -6.0
    assert -1.0 < seen["noise_free"] < gravity  # it has just begun to follow
    assert seen["cluster_can"] != pytest.approx(seen["noise_free"] + 0.5, abs=1e-6)
    assert seen["cluster_can"] == pytest.approx(seen["noise_free"] + 0.5, abs=0.5)


@pytest.mark.acceptance("F-13")
def test_noisy_source_adds_its_noise_to_the_cluster_s(record: Any) -> None:
    """The two independent noises add as variances: sqrt(0.4^2 + 0.3^2) = 0.5 m/s^2."""
    vehicle = car(longitudinal_acceleration__noise=0.4)
    vehicle.sensors.acceleration_source = "noisy"
    bench = Bench(vehicle, seed=1)
    samples = []
    for _ in range(4000):
        bench.run(1)
        samples.append(bench["longitudinal_acceleration"])
    record("standard deviation of the noisy source, m/s^2", float(np.std(samples)), "0.5 +- 5 %")
    assert np.std(samples) == pytest.approx(0.5, rel=0.05)


def test_brake_switch_closes_at_its_force() -> None:
    bench = Bench(car(brake_switch_force=10.0))
    bench.run(1, driver_pedal_force=9.9)
    assert bench["brake_switch"] == 0.0
    bench.run(1, driver_pedal_force=10.0)
    assert bench["brake_switch"] == 1.0


def test_parameters_by_name() -> None:
    sensors = Sensors(car())
    names = set(sensors.names())
    assert {"sensors.yaw_rate.offset", "sensors.wheel_speed.pitch_error", "sensors.inertial.position_x"} <= names
    sensors.set("sensors.yaw_rate.offset", 0.01)
    assert sensors.get("sensors.yaw_rate.offset") == 0.01
    with pytest.raises(InputError, match="yaw_rate"):
        sensors.get("sensors.yaw_rat.offset")
    with pytest.raises(InputError):
        sensors.set("sensors.yaw_rate.delay", 5.0)


def test_every_channel_is_a_signal_of_the_bus() -> None:
    on_bus = {signal.name for signal in catalogue()[BUS]}
    assert set(CHANNEL_SIGNALS) <= on_bus
