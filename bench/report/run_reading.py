"""Reading a run's folder, whatever state it was left in."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import RunArrays
from bench.report.run_data import RunData, find_run, read_json
from signals.errors import InputError


def load_run(
    run_dir: str | Path, *, signals: RunArrays | None = None, frames: NDArray[np.void] | None = None
) -> RunData:
    """Everything that a run's folder holds.

    Parameters
    ----------
    run_dir : path
        Folder of the run, or its name under ``runs/``.
    signals, frames : optional
        Taken instead of what the folder holds, where the caller still has them in memory.

    Raises
    ------
    InputError
        If the folder does not exist, is no run's, or ``verdict.json`` is no verdict.
    """
    folder = find_run(run_dir)
    if not any((folder / name).exists() for name in ("verdict.json", "run.json", "signals.mf4")):
        raise InputError(
            f"{folder}: not the folder of a run (no verdict.json, no run.json)", mend="see what there is: bench runs"
        )
    run = RunData(folder, read_json(folder / "verdict.json"), signals=signals, frames=frames)
    if not run.verdict:
        run.remarks.append(f"This run has no verdict; it goes on or was cut off (bench recover {folder.name}).")
    _add_scenario(run)
    if signals is None or frames is None:
        _add_recording(run)
    return run


def _add_scenario(run: RunData) -> None:
    path = run.folder / "scenario.yaml"
    if not path.exists():
        return
    run.scenario_text = path.read_text(encoding="utf-8", errors="replace")
    run.scenario = dict(_yaml(run.scenario_text))


def _yaml(text: str) -> Mapping[str, Any]:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        content = YAML(typ="safe").load(text)
    except YAMLError:
        return {}
    return content if isinstance(content, Mapping) else {}


def _add_recording(run: RunData) -> None:
    from bench.recording.reading import Recording

    try:
        recording = Recording.open(run.folder)
        run.signals = recording if run.signals is None else run.signals
        run.frames = recording.frames if run.frames is None else run.frames
    except InputError as error:
        run.remarks.append(f"The recording could not be read: {error.message}")
