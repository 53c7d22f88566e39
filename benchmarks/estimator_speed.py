"""Time per step of every estimator, and of the friction EKF's problem in filterpy in the same run.

``python -m benchmarks.estimator_speed [--json]``; the figures are medians of repeated batches on one core.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import estimators
from signals.catalogue import block_slice, index_of

_BATCH = 2000
_REPEATS = 15

# car of Table 8 of the friction document; brakes of 2.4.2
VEHICLE: dict[str, float] = {
    "body.mass": 1296.0,
    "body.wheelbase": 2.57,
    "body.centre_of_gravity_to_front_axle": 1.25,
    "body.centre_of_gravity_height": 0.535,
    "body.yaw_inertia": 1800.0,
    "axles.front.track": 1.5,
    "axles.rear.track": 1.5,
    "steering.ratio": 16.0,
    "aerodynamics.air_density": 1.2,
    "aerodynamics.drag_coefficient": 0.4,
    "aerodynamics.frontal_area": 2.0,
    "aerodynamics.drag_height": 0.535,
    "brakes.front.pad_area": 1.625e-3,
    "brakes.rear.pad_area": 0.8125e-3,
    **{f"brakes.{axle}.pad_friction": 0.4 for axle in ("front", "rear")},
    **{f"brakes.{axle}.effective_radius": 0.1 for axle in ("front", "rear")},
    **{f"wheels.{wheel}.radius": 0.278 for wheel in ("fl", "fr", "rl", "rr")},
    **{f"wheels.{wheel}.inertia": 0.8 for wheel in ("fl", "fr", "rl", "rr")},
    **{f"wheels.{wheel}.rolling_resistance": 0.015 for wheel in ("fl", "fr", "rl", "rr")},
}


def microseconds(step: Callable[[], object], batch: int = _BATCH) -> float:
    """Median time of one call [us]."""
    for _ in range(batch):
        step()
    times = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        for _ in range(batch):
            step()
        times.append((time.perf_counter() - start) / batch * 1e6)
    return statistics.median(times)


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
    parameters = model_parameters(longitudinal_car(VEHICLE), settings)
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
    """Microseconds per tick by estimator, and of the filterpy step."""
    inputs = inputs_of_a_braking_car()
    ages = np.zeros(block_slice("bus_age").stop - block_slice("bus_age").start)
    figures: dict[str, float] = {}
    for name in estimators.names():
        estimator = estimators.create(name, VEHICLE)
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
        print(f"{name:28s} {value:8.2f} us per step")
    ratio = figures["friction_ekf in filterpy"] / figures["friction_ekf"]
    print(f"friction_ekf is {ratio:.0f} times as fast as the same filter in filterpy")


if __name__ == "__main__":
    main()
