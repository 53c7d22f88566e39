"""What a run does before its clock starts: compile, or load from the disk cache, everything that a tick calls."""

from collections.abc import Callable

from bench.loop.compile_apart import Helper
from bench.loop.connection import connect
from bench.loop.memory import MemoryRecorder
from bench.loop.scheduling import plan_cores
from bench.loop.session import Session, build_parts
from bench.scenario.schema import ScenarioFile
from signals.compile_cache import compile_folder

REHEARSED_TICKS = 60
MARK = "compiled.txt"
COMPILING = "compiling the models: about a minute, only after an installation or a change"


class Rehearsal:
    """A copy of the run in memory, with the controller in this process.

    Its first ticks compile. Gone on with just before the clock starts, it brings code and tables back into the
    processor's caches, so that the run's first tick costs what every tick costs.

    Parameters
    ----------
    scenario : ScenarioFile
    """

    def __init__(self, scenario: ScenarioFile) -> None:
        ecu = scenario.ecu.model_copy(update={"kind": "inprocess", "link": None, "kill": None})
        trial = scenario.model_copy(update={"ecu": ecu, "pacing": "lockstep"})
        parts = build_parts(trial)
        self._most_ticks = parts.ticks
        recorder = MemoryRecorder(parts.ticks, len(parts.vector.names))
        self._tick = Session(parts, connect(trial, parts.codec, plan_cores())).put_together(recorder)
        self._next = 0

    def go_on(self) -> None:
        """Run the next few ticks, if there are any left."""
        for _ in range(REHEARSED_TICKS):
            if self._next >= self._most_ticks or self._tick.finished:
                return
            self._tick.run(self._next)
            self._next += 1


def warm_up(scenario: ScenarioFile, say: Callable[[str], None]) -> Rehearsal:
    """Compile everything that the scenario needs; the emulated ECU's process then finds its code on disk."""
    mark = compile_folder() / MARK
    helper = None
    if not mark.exists():
        say(COMPILING)
        helper = Helper(scenario)
    rehearsal = Rehearsal(scenario)
    if helper is not None:
        helper.wait_for_ecu()
    rehearsal.go_on()
    if helper is not None:
        helper.wait()
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()
    return rehearsal
