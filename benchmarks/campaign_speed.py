"""Closed-loop stops of 4 s per hour through the campaign's workers, on one and on two of them.

python -m benchmarks.campaign_speed [--stops 300] [--repeat 2]
Goals: 40 000 stops per hour on 2 cores in lock-step, 1.8 times the rate of one worker on two. The rate is that of warm
workers, from the first row to the last: starting them costs some seconds once. One and two workers take turns, and the
best of the repeats counts: other load on the machine only ever slows a run down. Processor time per stop tells what two
cores of their own would do, also on a machine that is busy.
"""

import argparse
import time

import psutil

from bench.campaign.observation import observe
from bench.execution.job import DONE, Job, job_of
from bench.execution.pool import WorkerPool
from bench.scenario.resolution import resolve
from bench.scenario.schema import ScenarioFile

GOAL_PER_HOUR = 40_000.0
GOAL_GAIN = 1.8
LEAST_DURATION_S = 4.0


def stop_of_four_seconds() -> ScenarioFile:
    """A stop from 100 km/h with ABS on dry asphalt, judged by its distance and the locked wheels."""
    return resolve(
        "stops/dry",
        {
            "estimators": {},
            "manoeuvre.steps.0.until": {"time": 0.85},
            "criteria": [
                {"id": "distance", "value": "stopping_distance"},
                {"id": "lock", "value": "max(wheel_lock)", "at_most": "0.1 s"},
            ],
        },
    )


def rate(scenario: ScenarioFile, workers: int, stops: int) -> tuple[float, float]:
    """Stops per hour of warm workers, and their processor time per stop, s; checks that each one is a whole stop."""
    jobs = [job_of(scenario, key=str(seed), seed=seed) for seed in range(stops)]
    with WorkerPool(workers, job_of(scenario), observe=observe) as pool:
        list(pool.run(Job(f"warm {n}", jobs[0].scenario, n) for n in range(2 * workers)))
        processes = psutil.Process().children()
        before = processor_time_s(processes)
        began = time.perf_counter()
        rows = list(pool.run(jobs))
        wall_s = time.perf_counter() - began
        used_s = processor_time_s(processes) - before
    for row in rows:
        if row.outcome != DONE or row.observations["duration_s"] < LEAST_DURATION_S:
            raise SystemExit(f"run {row.key}: {row.outcome}, {row.observations.get('duration_s')} s {row.reason}")
    return 3600.0 * len(rows) / wall_s, used_s / len(rows)


def processor_time_s(processes: list[psutil.Process]) -> float:
    """Processor time of some processes, s."""
    return sum(process.cpu_times().user + process.cpu_times().system for process in processes)


def main() -> None:
    """Print the rates."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stops", type=int, default=300)
    parser.add_argument("--repeat", type=int, default=2)
    arguments = parser.parse_args()
    scenario = stop_of_four_seconds()
    rates: dict[int, list[float]] = {1: [], 2: []}
    least_s = float("inf")
    for _ in range(arguments.repeat):
        for workers, found in rates.items():
            per_hour, used_s = rate(scenario, workers, arguments.stops)
            found.append(per_hour)
            least_s = min(least_s, used_s)
            print(f"{workers} workers: {per_hour:.0f} stops of 4 s per hour, {used_s:.3f} s of processor time each")
    one, two = max(rates[1]), max(rates[2])
    print(f"best: {two:.0f} per hour on 2 workers: goal {GOAL_PER_HOUR:.0f} {_told(two >= GOAL_PER_HOUR)}")
    print(f"by processor time: {2 * 3600.0 / least_s:.0f} per hour on two cores of their own")
    print(f"gain from 1 to 2 workers: {two / one:.2f}: goal {GOAL_GAIN:g} {_told(two / one >= GOAL_GAIN)}")


def _told(reached: bool) -> str:
    return "reached" if reached else "missed"


if __name__ == "__main__":
    main()
