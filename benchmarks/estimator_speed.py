"""Processor time per step of every estimator, and of the friction EKF's problem in filterpy in the same run.

``python -m benchmarks.estimator_speed [--json]``; the figures are the best of repeated batches on one core: others that
use the machine only make it slower.
"""

import argparse
import json
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import estimators
from signals.catalogue import block_slice, index_of
from signals.errors import InputError

_BATCH = 2000
_REPEATS = 15

TICK_US = 1000.0
LIMITS_US = {"friction_ekf": 10.0, "vehicle_state_ukf": 40.0}
ALL_LIMIT = 0.25
"""Share of a tick that all estimators together may take."""


def car_for(name: str) -> dict[str, float]:
    """Numbers of a shipped car that has all that an estimator needs, Table 8 of the friction document first."""
    from vehicle_model.vehicle_file import load_vehicle, vehicle_names

    for car in ("ekf_car", *vehicle_names()):
        numbers = load_vehicle(car).numbers()
        try:
            estimators.create(name, numbers)
        except InputError:
            continue
        return numbers
    raise InputError(f"{name}: no shipped car has the numbers that it needs")


def microseconds(step: Callable[[], object], batch: int = _BATCH) -> float:
    """Processor time of one call in the quickest batch [us]."""
    for _ in range(batch):
        step()
    times = []
    for _ in range(_REPEATS):
        start = time.process_time()
        for _ in range(batch):
            step()
        times.append((time.process_time() - start) / batch * 1e6)
    return min(times)


def inputs_of_a_braking_car() -> NDArray[np.float64]:
    """Block "bus" of a car that brakes from 25 m/s with 10 % slip."""
    bus = block_slice("bus")
    values = np.zeros(bus.stop - bus.start)
    for wheel, speed in (("fl", 81.0), ("fr", 81.0), ("rl", 84.0), ("rr", 84.0)):
        values[index_of(f"wheel_speed_{wheel}") - bus.start] = speed
        values[index_of(f"brake_pressure_{wheel}") - bus.start] = 5e6
    values[index_of("longitudinal_acceleration") - bus.start] = -7.0
    values[index_of("ecu_reference_speed") - bus.start] = 25.0
    return values


def friction_ekf_in_filterpy() -> float:
    """The friction EKF's step, same model and Jacobians, with filterpy's dense update [us]."""
    from filterpy.kalman import ExtendedKalmanFilter  # type: ignore[import-untyped]

    from estimators.friction_jacobians import MEASUREMENTS, measure, predict
    from estimators.friction_settings import (
        FrictionEkfSettings,
        initial_deviations,
        measurement_deviations,
        process_deviations,
    )
    from estimators.friction_setup import model_parameters
    from estimators.vehicle_numbers import longitudinal_car

    settings = FrictionEkfSettings()
    parameters = model_parameters(longitudinal_car(car_for("friction_ekf")), settings)
    reference = ExtendedKalmanFilter(dim_x=9, dim_z=MEASUREMENTS)
    reference.x = np.array([25.0, 81.0, 84.0, -0.1, -0.07, 1.0, 0.0, 1.0, 0.0])
    reference.P = np.diag(np.square(initial_deviations(settings)))
    reference.Q = np.diag(np.square(process_deviations(settings)))
    reference.R = np.diag(np.square(measurement_deviations(settings)))
    forces, predicted, transition = np.zeros((4, 6)), np.zeros(9), np.zeros((9, 9))
    expected, design = np.zeros(MEASUREMENTS), np.zeros((MEASUREMENTS, 9))
    torques = np.array([0.0, 0.0, 1300.0, 650.0])
    measured = np.array([-7.0, 81.0, 84.0, 0.0, 0.0, 1.0, 1.0, 25.0])

    def h(x: NDArray[np.float64]) -> NDArray[np.float64]:
        measure(x, parameters, forces, expected, design)
        return expected

    def jacobian(x: NDArray[np.float64]) -> NDArray[np.float64]:
        measure(x, parameters, forces, expected, design)
        return design

    def step() -> None:
        predict(reference.x, torques, 0.001, parameters, False, forces, predicted, transition)
        reference.x = predicted.copy()
        reference.P = transition @ reference.P @ transition.T + reference.Q
        reference.update(measured, jacobian, h)

    return microseconds(step, 200)


def measure_all() -> dict[str, float]:
    """Microseconds per tick by estimator, all inputs new in every tick, and of the filterpy step."""
    inputs = inputs_of_a_braking_car()
    ages = np.zeros(block_slice("bus_age").stop - block_slice("bus_age").start)
    figures: dict[str, float] = {}
    for name in estimators.names():
        estimator = estimators.create(name, car_for(name))
        out = np.zeros(len(estimator.outputs))
        tick = estimator.tick

        def step(tick: Callable[..., object] = tick, out: NDArray[np.float64] = out) -> None:
            tick(inputs, ages, out)

        figures[name] = microseconds(step)
    figures["friction_ekf in filterpy"] = friction_ekf_in_filterpy()
    return figures


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="JSON on standard output")
    figures = measure_all()
    if parser.parse_args().json:
        print(json.dumps({f"{name} us": round(value, 2) for name, value in figures.items()}))
        return
    for name, value in figures.items():
        limit = f"   at most {LIMITS_US[name]:g}" if name in LIMITS_US else ""
        print(f"{name:28s} {value:8.2f} us per step{limit}")
    together = sum(value for name, value in figures.items() if name in estimators.names())
    share = together / TICK_US
    print(f"all together {together:.1f} us, {100 * share:.1f} % of a tick of 1 ms, at most {100 * ALL_LIMIT:.0f} %")
    ratio = figures["friction_ekf in filterpy"] / figures["friction_ekf"]
    print(f"friction_ekf is {ratio:.0f} times as fast as the same filter in filterpy")


if __name__ == "__main__":
    main()
