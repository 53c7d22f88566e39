"""Acceptance figures on the document's single-track car as the bench simulates it (A5 to A10, A12, A13).

Stops from 95 km/h, wheel locked or with a slip-threshold ABS, wheel speeds from tone rings, signals as on the
bus, both signs. The filter gets the
nominal numbers of the vehicle file and what the bus reports, nothing of the plant.
"""

from dataclasses import fields
from functools import cache

import friction_twin as twin
import numpy as np
import pytest
from friction_figures import HIGH, LOW, Estimate

from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.reference import SingleTrack
from vehicle_model.vehicle_file import load_vehicle

WHEELS = ("fl", "rl")
each_sign = pytest.mark.parametrize("sign", [1, -1])
STOPS = {"E6": (HIGH, False), "E7": (LOW, False), "E8": (HIGH, True), "E9": (LOW, True), "E10": (HIGH, True)}


@cache
def stop(name: str) -> twin.Run:
    """A stop of the single-track car from 97 km/h, brakes applied at 95 km/h."""
    limits, abs_on = STOPS[name]
    car = SingleTrack(load_vehicle("ekf_car"))
    set_limits(car, limits)
    car.reset(speed_m_s=97 / 3.6)
    at = {output: i for i, output in enumerate(PLANT_OUTPUTS)}
    rows: list[list[float]] = []
    pressure, valve, brake_time, current = np.zeros(2), np.zeros(2), 0.0, limits
    for tick in range(20000):
        out = car.outputs
        braking = out[at["speed"]] <= 95 / 3.6
        brake_time += 0.001 * braking
        if name == "E10" and brake_time > 1.5 and current == limits:
            current = (0.6 * limits[0], 0.6 * limits[1])
            set_limits(car, current)
        master = min(150e5, 400e5 * brake_time)
        for axle, wheel in enumerate(WHEELS):
            slip = out[at[f"slip_ratio_{wheel}"]]
            if not abs_on or out[at["speed"]] < 1.5:
                pressure[axle] = master
                continue
            valve[axle] = -1 if slip < -0.15 else 1 if slip > -0.10 else min(valve[axle], 0)
            target, constant = (master, 0.05) if valve[axle] > 0 else (5e5, 0.03)
            pressure[axle] += (target - pressure[axle]) * 0.001 / constant * (valve[axle] != 0)
        torque = np.array([13e-5 * pressure[0]] * 2 + [6.5e-5 * pressure[1]] * 2)
        car.tick(torque, np.zeros(4), 0.0, tick * 0.001)
        out = car.outputs
        rows.append(
            [
                out[at["speed"]],
                out[at["true_wheel_speed_fl"]],
                out[at["true_wheel_speed_rl"]],
                out[at["true_longitudinal_acceleration"]],
                0.0,
                0.0,
                *pressure,
                0.0,
                *(out[at[f"slip_ratio_{w}"]] for w in WHEELS),
                *(out[at[f"friction_used_{w}"]] for w in WHEELS),
                *current,
                *(2 * out[at[f"vertical_load_{w}"]] for w in WHEELS),
                float(braking),
            ]
        )
        if out[at["speed"]] < 0.3:
            break
    table = np.array(rows).T
    assert len(table) == len(fields(twin.Run))
    return twin.Run(*table)


def set_limits(car: SingleTrack, limits: tuple[float, float]) -> None:
    for axle, limit in zip(("front", "rear"), limits, strict=True):
        car.set(f"tyres.{axle}.longitudinal.peak_friction", limit)


def estimate_of(name: str, sign: int, **settings: object) -> Estimate:
    vehicle = load_vehicle("ekf_car").numbers()
    return Estimate(stop(name), path="tone_ring", vehicle=vehicle, slip_rate_sign=sign, **settings)


@pytest.mark.acceptance("F-A5", "F-A6", "F-A7", "F-A8", "F-A9", "F-A10")
@each_sign
@pytest.mark.parametrize("name", ["E6", "E7", "E8", "E9"])
def test_braking_figures(name, sign, record):
    truth, estimate = stop(name), estimate_of(name, sign)
    limits, abs_on = STOPS[name]
    speed = estimate.rmse("speed", truth.speed)
    slip = max(estimate.rmse("slip_front", truth.slip_front), estimate.rmse("slip_rear", truth.slip_rear))
    used = max(
        estimate.rmse("friction_used_front", truth.used_front), estimate.rmse("friction_used_rear", truth.used_rear)
    )
    record("speed RMSE m/s", speed, "0.3 (tuned twin 0.05)", id="F-A5")
    record("slip RMSE", slip, "0.02", id="F-A6")
    record("used friction RMSE", used, "0.05", id="F-A10")
    assert speed <= 0.05
    assert slip <= 0.02
    assert used <= 0.05
    identifier = "F-A9" if abs_on else "F-A7" if name == "E6" else "F-A8"
    for axle, limit in zip(("front", "rear"), limits, strict=True):
        ratio = estimate.mean(f"friction_limit_{axle}") / limit
        record(f"k0 {axle} / truth", ratio, "0.95 ... 1.10" if abs_on else "0.95 ... 1.05", id=identifier)
        assert 0.95 <= ratio <= (1.10 if abs_on else 1.05)


@pytest.mark.acceptance("F-A12")
@each_sign
def test_grip_jump(sign, record):
    truth, estimate = stop("E10"), estimate_of("E10", sign)
    jump = int(np.flatnonzero(np.diff(truth.limit_front))[0]) + 1
    for axle in ("front", "rear"):
        settled = estimate.settling_time(f"friction_limit_{axle}", getattr(truth, f"limit_{axle}"), jump, 0.10)
        record(f"time to +-10 % {axle} s", settled, "0.3 s")
        assert settled <= 0.3


@pytest.mark.acceptance("F-A13")
@pytest.mark.parametrize(("mode", "sign"), [("z2", 1), ("z2", -1), ("z1", -1)])
@pytest.mark.parametrize("name", list(STOPS))
def test_without_torques(name, mode, sign, record):
    truth, estimate = stop(name), estimate_of(name, sign, torque_mode=mode)
    ratio, speed = estimate.mean_limit_ratio(), estimate.rmse("speed", truth.speed)
    record("load-weighted k0 / truth", ratio, "0.95 ... 1.05")
    record("speed RMSE m/s", speed, "0.3")
    assert 0.95 <= ratio <= 1.05
    assert speed <= 0.3
