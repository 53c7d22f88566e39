"""Speed of the bench on this machine: plant alone, closed loop in virtual time, closed loop in real time."""

import time
from collections.abc import Iterator

from bench.doctor.finding import Finding, State

_SIMULATED_S = 10.0
_PLANT_GOAL = 140.0
_LOOP_GOAL = 40.0
_LATENESS_GOAL_US = 200.0
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
    """Lateness of a stop in real time."""
    from bench.api import run

    timing = run(_SCENARIO, pacing="realtime", ecu="inprocess", record=False).verdict.timing
    late = timing["lateness_us"]
    text = f"real-time loop: lateness p99 {late['p99']:.1f} us, max {late['max']:.0f} us, overruns {timing['overruns']}"
    state: State = "ok" if late["p99"] <= _LATENESS_GOAL_US else "warn"
    return Finding("real_time", state, text, "the lines above say what would help")


def _judged(name: str, text: str, factor: float, goal: float) -> Finding:
    state: State = "ok" if factor >= goal else "warn"
    return Finding(name, state, f"{text}: {factor:.0f} x real time (goal {goal:.0f})", "end other programs")
