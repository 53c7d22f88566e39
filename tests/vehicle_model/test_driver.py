"""The driver: pedals, gears, speed, steering profiles, paths."""

import math

import numpy as np
import pytest
from drive_bench import Drive, manoeuvre_of
from numpy.typing import NDArray

from signals.errors import InputError
from vehicle_model.plant import Plant
from vehicle_model.road_file import RoadFile, Side


def record(drive: Drive, duration_s: float, *names: str) -> NDArray[np.float64]:
    rows: list[list[float]] = []
    drive.run(duration_s, lambda d: rows.append([d[name] for name in names]))
    return np.array(rows)


def brake(fields: str) -> Drive:
    return Drive(f"steps: [{{name: brake, brake: {{{fields}}}}}]", speed_m_s=30.0)


def test_pedal_force_ramp_and_booster() -> None:
    rows = record(brake("pedal_force: 400 N, ramp: 2 kN/s"), 0.5, "driver_pedal_force", "driver_master_pressure")
    time = np.arange(len(rows)) * 1e-3
    np.testing.assert_allclose(rows[:, 0], np.minimum(2000.0 * time, 400.0), atol=1e-9)
    np.testing.assert_allclose(rows[:, 1], 3e4 * rows[:, 0])  # brakes.booster_gain


def test_master_pressure_ramp() -> None:
    drive = brake("master_pressure: 120 bar, ramp: 400 bar/s")
    rows = record(drive, 0.5, "driver_pedal_force", "driver_master_pressure")
    time = np.arange(len(rows)) * 1e-3
    np.testing.assert_allclose(rows[:, 1], np.minimum(4e7 * time, 1.2e7), atol=1e-3)
    np.testing.assert_allclose(rows[:, 0], rows[:, 1] / 3e4)


def test_human_ramp_is_smooth_and_nowhere_steeper() -> None:
    rows = record(brake("pedal_force: 400 N, ramp: 2 kN/s, shape: human"), 0.6, "driver_pedal_force")[:, 0]
    slope = np.diff(rows) / 1e-3
    assert slope.max() == pytest.approx(2000.0, rel=1e-3)
    assert slope[0] < 20.0
    assert rows[-1] == 400.0
    # a half cosine takes pi/2 as long as the line of the same steepest slope
    assert np.argmax(rows >= 400.0 - 1e-9) * 1e-3 == pytest.approx(0.5 * math.pi * 0.2, abs=2e-3)


def test_brake_is_released_and_built_up_from_where_it_is() -> None:
    drive = Drive(
        """
steps:
  - {name: hard, brake: {pedal_force: 300 N, ramp: 3 kN/s}, until: {after: 0.3 s}}
  - {name: softer, brake: {pedal_force: 100 N, ramp: 1 kN/s}, until: {after: 0.3 s}}
  - {name: off, coast: true}
""",
        speed_m_s=30.0,
    )
    rows = record(drive, 0.8, "driver_pedal_force")[:, 0]
    assert rows[299] == pytest.approx(300.0)
    assert rows[400] == pytest.approx(200.0)
    assert rows[599] == pytest.approx(100.0)
    assert rows[-1] == 0.0
    assert np.diff(rows).min() >= -5.0 - 1e-9  # 5 kN/s


def test_booster_gain_can_change_on_line() -> None:
    drive = brake("pedal_force: 100 N, ramp: 100 kN/s")
    drive.run(0.1)
    drive.driver.set("brakes.booster_gain", 1e4)
    assert drive.driver.get("brakes.booster_gain") == 1e4
    drive.run(0.01)
    assert drive["driver_master_pressure"] == pytest.approx(1e6)
    with pytest.raises(InputError):
        drive.driver.set("brakes.booster_gain", -1.0)
    with pytest.raises(InputError):
        drive.driver.get("brakes.front.pad_area")


def test_a_booster_out_of_vacuum_helps_less_above_its_knee() -> None:
    """Half of the gain lost above 80 bar: 400 N make 80 + (120 - 80)/2 = 100 bar, and 100 bar take 400 N."""
    drive = brake("pedal_force: 400 N, ramp: 100 kN/s")
    drive.driver.set("brakes.booster_slope_loss", 0.5)
    drive.run(0.1)
    assert drive["driver_master_pressure"] == pytest.approx(1e7)
    asked = brake("master_pressure: 100 bar, ramp: 10000 bar/s")
    asked.driver.set("brakes.booster_slope_loss", 0.5)
    asked.run(0.1)
    assert asked["driver_pedal_force"] == pytest.approx(400.0)


@pytest.mark.parametrize("grade", [0.0, 0.04])
def test_holds_a_speed(grade: float) -> None:
    drive = Drive("steps: [{name: hold, hold_speed: {speed: 80 km/h}}]", road=RoadFile(grade=grade), speed_m_s=80 / 3.6)
    speeds = record(drive, 15.0, "speed")[:, 0] * 3.6
    assert np.abs(speeds - 80.0).max() < (0.7 if grade == 0.0 else 2.5)
    assert np.abs(speeds[-2000:] - 80.0).max() < 0.2


def test_reaches_another_speed_without_much_overshoot() -> None:
    drive = Drive("steps: [{name: hold, hold_speed: {speed: 100 km/h}}]", speed_m_s=80 / 3.6)
    speeds = record(drive, 25.0, "speed")[:, 0] * 3.6
    assert speeds.max() < 103.0
    assert speeds[-1] == pytest.approx(100.0, abs=0.3)


def test_takes_the_gear_that_suits_the_speed() -> None:
    gears = {}
    for speed in (5.0, 10.0, 25.0):
        drive = Drive(f"steps: [{{name: hold, hold_speed: {{speed: {speed}}}}}]", speed_m_s=speed)
        drive.run(0.5)
        gears[speed] = drive["driver_gear"]
    # highest gear with the engine above twice its idle speed of 84 rad/s: ratios 3.6 2.1 1.45 1.1 0.9 times 3.2
    assert gears == {5.0: 1.0, 10.0: 2.0, 25.0: 5.0}
    drive = Drive("steps: [{name: hold, hold_speed: {speed: 25, gears: 3}}]", speed_m_s=25.0)
    drive.run(0.5)
    assert drive["driver_gear"] == 3.0


def test_initial_gear() -> None:
    from vehicle_model.manoeuvre import Manoeuvre
    from vehicle_model.vehicle_file import load_vehicle

    drive = Drive("steps: [{name: roll, release: true}]", speed_m_s=15.0)
    file = manoeuvre_of("steps: [{name: roll, release: true}]")
    drive.driver = Manoeuvre(file, drive.vector, load_vehicle("ekf_car"), initial_gear=2)
    drive.run(0.3)
    assert drive["driver_gear"] == 2.0
    assert drive["true_engine_speed"] == pytest.approx(drive["true_wheel_speed_rl"] * 2.1 * 3.2, rel=0.02)
    with pytest.raises(InputError, match="initial_gear"):
        Manoeuvre(file, drive.vector, load_vehicle("ekf_car"), initial_gear=6)


def test_a_shift_opens_the_clutch_and_lifts_the_accelerator() -> None:
    drive = Drive(
        "steps: [{name: go, accelerate: {gears: auto, highest_gear: 3, shift_up_engine_speed: 5000 rpm}}]",
        speed_m_s=5.0,
    )
    rows = record(drive, 8.0, "driver_gear", "driver_clutch", "driver_accelerator", "true_engine_speed")
    gear = rows[:, 0]
    shifts = np.flatnonzero(np.diff(gear))
    assert gear[shifts + 1].tolist()[-1] == 3.0
    for shift in shifts:
        assert rows[shift + 1, 1] < 0.05
        assert rows[shift + 1, 2] < 0.05
    assert rows[-1, 1] == 1.0
    assert rows[:, 3].max() < 1.2 * 5000 * math.pi / 30


def test_starts_from_rest_without_stalling() -> None:
    drive = Drive("steps: [{name: go, accelerate: {accelerator: 0.4, gears: 1}}]")
    rows = record(drive, 4.0, "speed", "true_engine_speed", "driver_clutch")
    assert rows[-1, 0] > 5.0
    assert rows[:, 1].min() > 40.0
    assert rows[-1, 2] == 1.0


def test_engine_is_not_stalled_when_the_car_stops_in_gear() -> None:
    drive = Drive(
        "steps: [{name: brake, brake: {pedal_force: 60 N, clutch: closed}, until: {signal: speed, below: 0.1 km/h}}]",
        speed_m_s=8.0,
    )
    rows = record(drive, 20.0, "speed", "true_engine_speed", "driver_clutch")
    assert drive.driver.finished
    assert rows[:, 1].min() > 50.0
    assert rows[-1, 2] < 0.2


def test_clutch_opens_for_braking_unless_told_otherwise() -> None:
    drive = brake("pedal_force: 50 N")
    drive.run(0.3)
    assert drive["driver_clutch"] == 0.0
    drive = brake("pedal_force: 50 N, clutch: closed")
    drive.run(0.3)
    assert drive["driver_clutch"] == 1.0
    assert drive["drive_torque_demand_rl"] < -10.0


def steer(text: str, speed_m_s: float = 20.0, plant: type | None = None) -> Drive:
    full = f"steps: [{{name: go, coast: true, steer: {{{text}}}}}]"
    return Drive(full, speed_m_s=speed_m_s) if plant is None else Drive(full, speed_m_s=speed_m_s, plant=plant)


STEERING = "driver_steering_wheel_angle"


def test_steering_sine() -> None:
    angle = record(steer("profile: {sine: {amplitude: 0.5, frequency: 1 Hz, periods: 2}}"), 2.5, STEERING)[:, 0]
    time = np.arange(len(angle)) * 1e-3
    np.testing.assert_allclose(angle, np.where(time < 2.0, 0.5 * np.sin(2 * np.pi * time), 0.0), atol=1e-9)


def test_sine_with_dwell_follows_fmvss_126() -> None:
    drive = steer("profile: {sine_with_dwell: {amplitude: -90 deg}}")
    angle = record(drive, 2.5, STEERING)[:, 0]
    amplitude, period = math.pi / 2, 1.0 / 0.7
    at = {
        0.25 * period: -amplitude,
        0.5 * period: 0.0,
        0.75 * period: amplitude,
        0.75 * period + 0.25: amplitude,
        0.75 * period + 0.5: amplitude,
        period + 0.5: 0.0,
        2.4: 0.0,
    }
    for time, expected in at.items():
        assert angle[round(time * 1000)] == pytest.approx(expected, abs=0.01), time
    assert np.count_nonzero(angle > amplitude - 1e-6) == pytest.approx(500, abs=2)


def test_steering_table_step_and_ramp() -> None:
    table = record(steer("profile: {table: {time: [0.1, 0.3, 0.4], angle: [0, 1, 0.5]}}"), 0.6, STEERING)[:, 0]
    time = np.arange(len(table)) * 1e-3
    np.testing.assert_allclose(table, np.interp(time, [0.1, 0.3, 0.4], [0, 1, 0.5]), atol=1e-9)
    step = record(steer("profile: {step: {angle: 0.5, rate: 5}}"), 0.3, STEERING)[:, 0]
    np.testing.assert_allclose(np.diff(step)[:99], 5e-3)
    assert step[-1] == pytest.approx(0.5)
    ramp = record(steer("profile: {ramp: {angle: 1.0, rate: 13.5 deg/s}}"), 1.0, STEERING)[:, 0]
    assert ramp[-1] == pytest.approx(13.5 * math.pi / 180, rel=1e-2)


def test_hands_lag_the_eyes_by_the_reaction_delay() -> None:
    angles = {}
    for delay in (0.0, 0.15):
        drive = steer(f"follow: straight, lateral_position: 1 m, reaction_delay: {delay}")
        angles[delay] = record(drive, 0.4, STEERING)[:, 0]
    # the single-track car does not turn: it sees the same offset all the time, so that only the delay differs
    assert np.argmax(angles[0.0] > 0.0) == 0
    assert np.argmax(angles[0.15] > 0.0) == 150
    np.testing.assert_allclose(angles[0.15][150:], angles[0.0][:-150], rtol=1e-9)


def test_steering_is_bounded_in_rate_and_angle() -> None:
    drive = steer("follow: straight, lateral_position: 30 m, maximum_rate: 5, maximum_angle: 0.8")
    angle = record(drive, 1.0, STEERING)[:, 0]
    assert np.abs(np.diff(angle)).max() <= 5e-3 + 1e-12
    assert angle.max() == pytest.approx(0.8)


def test_changes_to_a_parallel_line() -> None:
    drive = steer("follow: straight, lateral_position: 1 m", 25.0, Plant)
    y = record(drive, 8.0, "position_y")[:, 0]
    assert y.max() < 1.35
    assert y[-1] == pytest.approx(1.0, abs=0.1)
    assert abs(drive["true_yaw_rate"]) < 0.005


@pytest.mark.parametrize("radius", [80.0, -80.0])
def test_follows_a_circle(radius: float) -> None:
    drive = Drive(
        f"steps: [{{name: go, hold_speed: {{speed: 15}}, steer: {{follow: circle, radius: {radius}}}}}]",
        speed_m_s=15.0,
        plant=Plant,
    )
    place = record(drive, 15.0, "position_x", "position_y")[5000:]
    distance = np.hypot(place[:, 0], place[:, 1] - radius)
    assert np.abs(distance - abs(radius)).max() < 0.5
    assert abs(drive["true_yaw_rate"]) == pytest.approx(15.0 / 80.0, rel=0.02)
    assert math.copysign(1.0, drive["true_yaw_rate"]) == math.copysign(1.0, radius)


def test_straight_driving_is_stable_at_high_speed() -> None:
    drive = Drive(
        "steps: [{name: go, hold_speed: {speed: 180 km/h}, steer: {follow: straight, lateral_position: 0.3 m}}]",
        speed_m_s=50.0,
        plant=Plant,
    )
    rows = record(drive, 8.0, "true_yaw_rate")[:, 0]
    assert np.abs(rows[7000:]).max() < 0.1 * np.abs(rows[:2000]).max()


SPLIT = """
steps:
  - {name: go, hold_speed: {speed: 20}, steer: {follow: straight, countersteer: COUNTERSTEER}, until: {after: 0.5 s}}
  - {name: brake, brake: {pedal_force: 130 N}, until: {signal: speed, below: 1}}
"""


def test_countersteers_while_braking_on_split_friction() -> None:
    road = RoadFile(left=Side(friction=1.0), right=Side(friction=0.2))
    yaw, steering = {}, {}
    for countersteer in ("true", "false"):
        drive = Drive(SPLIT.replace("COUNTERSTEER", countersteer), road=road, speed_m_s=20.0, plant=Plant)
        rows = record(drive, 15.0, "true_yaw_rate", STEERING)
        yaw[countersteer] = np.abs(rows[:, 0]).max()
        steering[countersteer] = rows[:, 1]
    # the left side brakes more and turns the car to the left: the driver steers to the right
    assert steering["true"].min() < -0.01
    assert yaw["true"] < yaw["false"]


def test_follow_a_path_of_points() -> None:
    """A lane change of 3 m over 40 m at 72 km/h: the car is in the new lane and stays there."""
    drive = Drive(
        "steps:\n"
        "  - name: change\n"
        "    hold_speed: {speed: 72 km/h}\n"
        "    steer: {follow: path, path: {x: [0, 60, 100, 400], y: [0, 0, 3, 3]}}\n"
        "    until: {time: 12 s}\n",
        speed_m_s=20.0,
        plant=Plant,
    )
    track = []
    drive.run(12.0, lambda now: track.append((now["position_x"], now["position_y"])))
    x, y = np.array(track).T
    assert np.abs(y[x < 40.0]).max() < 0.1
    assert np.abs(y[(x > 150.0)] - 3.0).max() < 0.25
    assert abs(y[-1] - 3.0) < 0.1
    assert y.max() < 3.6
