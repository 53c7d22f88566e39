"""Python interface behind ``bench run``.

>>> import bench
>>> run = bench.run("stops/dry", ecu="inprocess", pacing="lockstep", record=False)
>>> run.verdict.verdict, run.verdict.metrics["stopping_distance_m"]
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import RunArrays
from bench.scenario.schema import ScenarioFile
from bench.verdict.result import Verdict


@dataclass(frozen=True)
class Run:
    """A run that has ended.

    Attributes
    ----------
    scenario : ScenarioFile
        As run: all defaults and overrides resolved.
    verdict : Verdict
    data : RunArrays
        Signals by name.
    frames : structured array
        Frames of the run in the order in which the bench saw them (empty for a recorded run: see frames.blf).
    folder : Path or None
        Folder of a recorded run.
    """

    scenario: ScenarioFile
    verdict: Verdict
    data: RunArrays
    frames: NDArray[np.void]
    folder: Path | None = None

    @property
    def exit_code(self) -> int:
        """Exit code that ``bench run`` ends with."""
        return self.verdict.exit_code


def run(
    scenario: str | Path | ScenarioFile,
    *,
    pacing: str | None = None,
    ecu: str | None = None,
    link: str | None = None,
    vehicle: str | None = None,
    plant: str | None = None,
    seed: int | None = None,
    variant: str | None = None,
    sets: Sequence[str] | Mapping[str, Any] = (),
    out: str | Path | None = None,
    record: bool = True,
    dashboard: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Run:
    """Run a scenario to its verdict.

    Parameters
    ----------
    scenario
        Path or id of a scenario file, or a resolved scenario.
    pacing : {"realtime", "lockstep"}, optional
        By the wall clock or in virtual time; default: the scenario's.
    ecu, link, vehicle, plant, seed, variant, sets
        In place of what the scenario says; ``sets`` holds ``path=value`` texts or a mapping.
    out : path, optional
        Folder of the recording; by default ``runs/<scenario>-<time>``.
    record : bool
        False keeps everything in memory and writes nothing.
    dashboard : bool
        Draw the dashboard on this terminal, or print progress lines where there is none.
    progress : callable, optional
        Receives short texts such as "compiling".

    Raises
    ------
    InputError
        If the scenario has faults or asks for what cannot be combined.
    LinkError, RunError
        If the run could not begin; once it has begun, a failure is a verdict "error" and everything is kept.
    """
    resolved = _resolved(
        scenario,
        pacing=pacing,
        ecu=ecu,
        link=link,
        vehicle=vehicle,
        plant=plant,
        seed=seed,
        sets=sets,
        variant=variant,
    )
    from bench.loop.connection import check_combination, probe_link

    check_combination(resolved)
    probe_link(resolved)
    from bench.loop.runs import run_in_memory, run_recorded

    if not record:
        return run_in_memory(resolved)
    return run_recorded(resolved, None if out is None else Path(out), dashboard=dashboard, progress=progress)


def _resolved(
    scenario: str | Path | ScenarioFile,
    *,
    pacing: str | None,
    ecu: str | None,
    link: str | None,
    vehicle: str | None,
    plant: str | None,
    seed: int | None,
    sets: Sequence[str] | Mapping[str, Any],
    variant: str | None,
) -> ScenarioFile:
    from bench.scenario.documents import parse_sets
    from bench.scenario.resolution import resolve

    named = {"pacing": pacing, "ecu.kind": ecu, "ecu.link": link, "plant": plant}
    changes = {**parse_sets(sets), **{path: value for path, value in named.items() if value is not None}}
    if not isinstance(scenario, ScenarioFile):
        return resolve(scenario, changes, seed=seed, vehicle=vehicle, variant=variant)
    if changes or seed is not None or vehicle is not None or variant is not None:
        raise TypeError("a resolved scenario takes no changes; make them with bench.scenario.resolution.resolve")
    return scenario
