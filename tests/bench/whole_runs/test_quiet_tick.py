"""A tick in one compiled call and a tick part by part are the same tick."""

import gc
import weakref
from collections.abc import Callable

import pytest

import bench
from bench.loop.connection import connect
from bench.loop.memory import MemoryRecorder
from bench.loop.scheduling import plan_cores
from bench.loop.session import Session, build_parts
from bench.scenario.schema import ScenarioFile

NEVER = {"name": "never", "target": "driver_master_pressure", "when": {"time": "1000 s"}, "step": "10 bar"}
"""Waits during the whole run, so that the parts are called one by one."""


@pytest.mark.parametrize("plant", ["mujoco", "single_track"])
def test_a_stimulus_that_never_begins_changes_no_bit(plant: str, short_stop: Callable[..., ScenarioFile]) -> None:
    in_one_call = bench.run(short_stop(plant=plant), record=False)
    part_by_part = bench.run(short_stop(plant=plant, stimuli=[NEVER]), record=False)
    assert part_by_part.data.digest() == in_one_call.data.digest()
    assert part_by_part.frames.tobytes() == in_one_call.frames.tobytes()


def test_a_tick_keeps_the_memory_that_its_compiled_calls_work_on(short_stop: Callable[..., ScenarioFile]) -> None:
    scenario = short_stop(estimators=["friction_ekf"])
    parts = build_parts(scenario)
    session = Session(parts, connect(scenario, parts.codec, plan_cores()))
    tick = session.put_together(MemoryRecorder(parts.ticks, len(parts.vector.names)))
    owners = [parts.estimators[0].estimator, parts.hydraulic_unit, parts.manoeuvre, parts.powertrain, parts.plant]
    owners += [parts.sensors, parts.transmitter, parts.tap, parts.from_ecu]
    kept = [weakref.ref(owner) for owner in owners]
    del owners, parts, session
    gc.collect()
    assert all(reference() is not None for reference in kept)
    tick.run(0)
