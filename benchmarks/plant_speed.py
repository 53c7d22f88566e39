"""Speed of the plant alone: 20 s of driving with a hard stop, one call per tick from Python, best of five.

    python benchmarks/plant_speed.py [--vehicle ekf_car] [--ticks 20000]

Prints microseconds per tick and the real-time factor on one core.
"""

import argparse
import time

import numpy as np

from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import load_vehicle

GOAL = 140.0
REPEATS = 5


def one_run(car: Plant, ticks: int) -> float:
    """Wall-clock seconds of one run: cruise, brake to standstill, stand."""
    brake, drive = np.zeros(4), np.zeros(4)
    car.reset(speed_m_s=40.0)
    began = time.perf_counter()
    for tick in range(ticks):
        if tick == ticks // 4:
            brake[:] = 650.0
        car.tick(brake, drive, 0.02, tick * 1e-3)
    return time.perf_counter() - began


def best_time(vehicle: str, ticks: int) -> float:
    """Best time of ``REPEATS`` runs [s]; the first call compiles or loads the cache and does not count."""
    car = Plant(load_vehicle(vehicle))
    one_run(car, 100)
    return min(one_run(car, ticks) for _ in range(REPEATS))


def main() -> None:
    """Run the benchmark and print its figures."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    arguments.add_argument("--vehicle", default="ekf_car")
    arguments.add_argument("--ticks", type=int, default=20000)
    options = arguments.parse_args()
    seconds = best_time(options.vehicle, options.ticks)
    factor = options.ticks * 1e-3 / seconds
    print(f"plant alone: {seconds / options.ticks * 1e6:.2f} us per tick, {factor:.0f} x real time (goal {GOAL:.0f})")


if __name__ == "__main__":
    main()
