"""Suggested channel maps: by name and unit, by sign, by correlation where the name says nothing."""

import kinematic_car as car
import numpy as np

from model_diagnosis.data import suggest_channels

NAMES = {
    "wheel_speed_fl": "WheelSpeedFL [rad/s]",
    "wheel_speed_fr": "WheelSpeedFR [rad/s]",
    "wheel_speed_rl": "WheelSpeedRL [rad/s]",
    "wheel_speed_rr": "WheelSpeedRR [rad/s]",
    "speed": "vx(m/s)",
    "yaw_rate": "YawRate",
    "longitudinal_acceleration": "ax(m/s^2)",
    "lateral_acceleration": "channel_17",
    "steering_wheel_angle": "SteeringWheelAngle",
}


def test_names_units_signs_and_a_column_without_a_name(tmp_path, vehicle):
    random = np.random.default_rng(5)
    driven = car.drive("turn_brake", random, 14.0)
    log = car.logged(driven, car.sensed(driven, random), random)
    renamed = {NAMES[n]: (t, -57.29578 * y if n == "yaw_rate" else y) for n, (t, y) in log.items() if n in NAMES}
    path = car.write_csv(tmp_path / "foreign.csv", renamed)
    found = {s.name: s for s in suggest_channels(path, vehicle)}
    assert {name: s.source for name, s in found.items()} == NAMES
    assert found["speed"].unit == "m/s"
    assert found["yaw_rate"].sign == -1
    assert np.isclose(found["yaw_rate"].factor, 57.29578, rtol=1e-3)
    assert "correlation" in found["lateral_acceleration"].reason
