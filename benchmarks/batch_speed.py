"""Speed of a batch of different cars on one core and on all: ``python benchmarks/batch_speed.py``.

Goal: 64 cars on two cores at least 1.8 times as fast as on one. The machine has to be quiet: the load that others made
at the start is printed, and figures under load say nothing.
"""

import argparse
import os

from bench.batch import run_batch, varied_cars

SCATTER = {"body.mass": "5 %", "brakes.front.pad_friction": "10 %", "brakes.rear.pad_friction": "10 %"}
WANTED = 1.8


def main() -> None:
    """Run the same cars with one worker and with all, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenario", default="stops/dry")
    parser.add_argument("--cars", type=int, default=64)
    parser.add_argument("--repeat", type=int, default=3, help="the best of so many counts")
    arguments = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} on {cores} cores")
    cars = varied_cars(arguments.scenario, arguments.cars, SCATTER)
    best = {}
    for workers in (1, cores):
        results = [run_batch(cars, workers=workers) for _ in range(arguments.repeat)]
        fastest = min(results, key=lambda result: result.wall_s)
        best[workers] = fastest.wall_s
        print(
            f"{workers} workers: {fastest.wall_s:6.2f} s for {arguments.cars} cars, "
            f"{fastest.runs_per_hour:7.0f} runs/h, {fastest.real_time_factor:5.0f} x real time; "
            f"start {fastest.start_s:.1f} s"
        )
    speed_up = best[1] / best[cores]
    print(f"{cores} cores are {speed_up:.2f} x one core; wanted on two cores: at least {WANTED}")


if __name__ == "__main__":
    main()
