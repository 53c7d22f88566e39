"""Lock-step closed loop in one process on one core: car, hydraulics, codec, emulated ECU, friction EKF.

python -m benchmarks.closed_loop_speed [--repeat 5] [--scenario stops/dry]
Goal: at least 40 times real time (best of the repeats; the machine's noise only ever slows a run down). MuJoCo's own
step of the car is timed before and after: machines differ, and one machine by the hour.
"""

import argparse
import os
import time

from bench.loop.connection import connect
from bench.loop.memory import MemoryRecorder
from bench.loop.pacing import LockstepPacer
from bench.loop.scheduling import plan_cores
from bench.loop.session import Session, build_parts
from bench.loop.warm_up import warm_up
from bench.scenario.resolution import resolve
from benchmarks.plant_speed import STEP_OF_THE_GOALS_US, mujoco_step_us
from vehicle_model.vehicle_file import load_vehicle

GOAL = 40.0


def real_time_factor(scenario_id: str, repeat: int) -> list[float]:
    """Simulated over elapsed time of each repeat."""
    scenario = resolve(scenario_id, {"pacing": "lockstep", "ecu.kind": "inprocess"})
    warm_up(scenario, print)
    factors = []
    for _ in range(repeat):
        parts = build_parts(scenario)
        recorder = MemoryRecorder(parts.ticks, len(parts.vector.names))
        session = Session(parts, connect(scenario, parts.codec, plan_cores()))
        began = time.perf_counter()
        session.run(recorder, LockstepPacer(parts.ticks))
        factors.append(session.ticks_done * 1e-3 / (time.perf_counter() - began))
    return factors


def main() -> None:
    """Print the real-time factor."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--scenario", default="stops/dry")
    arguments = parser.parse_args()
    os.sched_setaffinity(0, plan_cores().loop)
    car = load_vehicle("ekf_car")
    before = mujoco_step_us(car, 10_000)
    factors = real_time_factor(arguments.scenario, arguments.repeat)
    after = mujoco_step_us(car, 10_000)
    best, median = max(factors), sorted(factors)[len(factors) // 2]
    reached = "reached" if best >= GOAL else "missed"
    print(f"closed loop, {arguments.scenario}: best {best:.1f} x, median {median:.1f} x real time")
    print(f"goal {GOAL:g} x {reached}")
    print(
        f"MuJoCo's own step of the car: {before:.2f} us before, {after:.2f} us after; {STEP_OF_THE_GOALS_US} us where "
        f"the goal was set: here it is {GOAL * STEP_OF_THE_GOALS_US / min(before, after):.0f} x"
    )


if __name__ == "__main__":
    main()
