"""Speed of the bench on this machine: plant alone, closed loop in virtual time, closed loop in real time."""

import time
from collections.abc import Iterator, Mapping
from typing import Any

from bench.doctor.finding import Finding, State

_SIMULATED_S = 10.0
_PLANT_GOAL = 140.0
_LOOP_GOAL = 40.0
_LATENESS_GOAL_US = {True: 20.0, False: 200.0}
"""Of the 99 % point, with SCHED_FIFO and without the right to it."""
_CPU_GOALS_US = (150.0, 350.0)
"""Processor time of a tick: median and 99 % point."""
_SCENARIO = "friction/e4_abs_dry_95"


def findings() -> Iterator[Finding]:
    """The three figures; the first run compiles and is not counted."""
    yield plant_alone()
    yield closed_loop()
    yield real_time()


def plant_alone() -> Finding:
    """The car without anything around it."""
    from vehicle_model.plant import Plant
    from vehicle_model.vehicle_file import load_vehicle

    plant = Plant(load_vehicle("ekf_car"))
    plant.reset(speed_m_s=30.0)
    plant.step(10)
    ticks = int(_SIMULATED_S * 1000)
    began = time.perf_counter()
    plant.step(ticks, brake_torque=300.0)
    factor = _SIMULATED_S / (time.perf_counter() - began)
    return _judged("plant_speed", "plant alone", factor, _PLANT_GOAL)


def closed_loop() -> Finding:
    """Car, hydraulics, sensors, codec, emulated ECU and friction filter in one process."""
    from bench.api import run

    run(_SCENARIO, pacing="lockstep", ecu="inprocess", record=False)
    timing = run(_SCENARIO, pacing="lockstep", ecu="inprocess", record=False).verdict.timing
    return _judged("loop_speed", "closed loop in virtual time", float(timing["real_time_factor"]), _LOOP_GOAL)


def real_time() -> Finding:
    """Lateness and processor time of a stop in real time."""
    from bench.api import run

    return judge_timing(run(_SCENARIO, pacing="realtime", ecu="inprocess", record=False).verdict.timing)


def judge_timing(timing: Mapping[str, Any]) -> Finding:
    """Timing block of a run in real time against the goals.

    Parameters
    ----------
    timing : mapping
        As in ``verdict.json``.
    """
    late, cpu = timing["lateness_us"], timing["tick_cpu_us"]
    goal = _LATENESS_GOAL_US[str(timing["scheduler"]).startswith("fifo")]
    text = (
        f"real-time loop: lateness p50 {late['p50']:.1f}, p99 {late['p99']:.1f} (goal {goal:.0f}), "
        f"p99.9 {late['p999']:.1f}, max {late['max']:.0f} us\n"
        f"       late ticks {timing['late_ticks']} of {timing['ticks']}: ours {timing['late_ticks_ours']} (goal 0), "
        f"the machine's {timing['late_ticks_machine']}\n"
        f"       processor time of a tick p50 {cpu['p50']:.0f} (goal {_CPU_GOALS_US[0]:.0f}), "
        f"p99 {cpu['p99']:.0f} us (goal {_CPU_GOALS_US[1]:.0f})"
    )
    good = late["p99"] <= goal and timing["late_ticks_ours"] == 0
    good = good and cpu["p50"] <= _CPU_GOALS_US[0] and cpu["p99"] <= _CPU_GOALS_US[1]
    return Finding("real_time", "ok" if good else "warn", text, "the lines above say what would help")


def _judged(name: str, text: str, factor: float, goal: float) -> Finding:
    state: State = "ok" if factor >= goal else "warn"
    return Finding(name, state, f"{text}: {factor:.0f} x real time (goal {goal:.0f})", "end other programs")
