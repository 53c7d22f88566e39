"""The emulated ECU and the estimators of a scenario, compiled in a process of their own.

``python -m bench.loop.compile_apart`` reads a resolved scenario as JSON from its standard input and leaves compiled
code in the disk cache, while the process that started it compiles the car. Whatever goes wrong here is met, and told,
by that process too.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress

from bench.loop.scheduling import die_with_parent
from bench.scenario.schema import ScenarioFile

_ECU_IS_COMPILED = "ecu"


class Helper:
    """The process as its parent sees it.

    Parameters
    ----------
    scenario : ScenarioFile
    """

    def __init__(self, scenario: ScenarioFile) -> None:
        self._process: subprocess.Popen[str] | None = None
        if len(os.sched_getaffinity(0)) < 2:
            return  # nothing is gained on one processor
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        if self._process.stdin is not None:
            with suppress(BrokenPipeError), self._process.stdin as told:
                told.write(scenario.model_dump_json(by_alias=True))

    def wait_for_ecu(self) -> None:
        """Return once the ECU is compiled, or the process has ended without."""
        if self._process is not None and self._process.stdout is not None:
            self._process.stdout.readline()

    def wait(self) -> None:
        """Return once the process has ended."""
        if self._process is not None and self._process.stdout is not None:
            self._process.stdout.close()
            self._process.wait()


def main() -> None:
    """Compile what a tick of the scenario on standard input calls outside the car."""
    die_with_parent(signal.SIGKILL)
    scenario = ScenarioFile.model_validate_json(sys.stdin.read())
    from bench.codec.codec import Codec
    from bench.ecu.node import EcuNode
    from bench.links.frame import new_frames
    from bench.loop.estimation import EstimatorSlot
    from bench.loop.in_process_ecu import InProcessEcu
    from bench.loop.session import estimators_of
    from signals.vector import SignalVector

    ecu = scenario.ecu
    codec = Codec.load(ecu.dbc, ecu.mapping)
    if ecu.kind in ("emulated", "inprocess"):
        InProcessEcu(EcuNode(ecu.calibration, codec, protection=ecu.protection)).receive(0, new_frames(1))
    print(_ECU_IS_COMPILED, flush=True)
    estimators = estimators_of(scenario)
    vector = SignalVector([signal for named in estimators for signal in named.signals()])
    for named in estimators:
        EstimatorSlot(named, vector).tick()


if __name__ == "__main__":
    main()
