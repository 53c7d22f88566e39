"""Compile, or load from the disk cache, everything that a tick calls, before a clock runs."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from bench.loop.memory import MemoryRecorder
from bench.loop.pacing import LockstepPacer
from bench.scenario.schema import ScenarioFile

WARM_UP_TICKS = 60
MARK = "compiled.txt"


def warm_up(scenario: ScenarioFile, say: Callable[[str], None]) -> float:
    """Run a few ticks of the scenario in memory with the controller in this process; returns the seconds it took.

    The emulated ECU's process then finds its compiled code on disk.
    """
    from bench.loop.connection import connect
    from bench.loop.scheduling import plan_cores
    from bench.loop.session import Session, build_parts

    began = time.perf_counter()
    mark = Path(os.environ.get("NUMBA_CACHE_DIR", ".")) / MARK
    if not mark.exists():
        say("compiling the models: about a minute, only after an installation or a change")
    ecu = scenario.ecu.model_copy(update={"kind": "inprocess", "link": None, "kill": None})
    trial = scenario.model_copy(update={"ecu": ecu, "pacing": "lockstep"})
    parts = build_parts(trial)
    recorder = MemoryRecorder(WARM_UP_TICKS, len(parts.vector.names))
    connection = connect(trial, parts.codec, plan_cores())
    Session(parts, connection).run(recorder, LockstepPacer(WARM_UP_TICKS), most_ticks=WARM_UP_TICKS)
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()
    return time.perf_counter() - began
