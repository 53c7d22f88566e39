"""Reading a recording back: a run's folder, its MF4 file, or the MCAP file of a run that is not finished."""

import json
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import FRAME_DTYPE
from bench.recording.arrays import RunArrays
from bench.recording.frame_file import read_blf
from bench.recording.mf4_file import read_mf4
from bench.recording.run_folder import FRAME_FILE, MF4_FILE, STREAM_FILE, read_state
from bench.recording.stored_rows import read_stored
from signals.errors import InputError


class Recording(RunArrays):
    """Signals and frames of a recorded run. Open it with :meth:`open`.

    Attributes
    ----------
    path : Path
        What was opened.
    folder : Path
        Folder of the run, where its other files are looked for.
    """

    def __init__(self, path: Path, folder: Path, arrays: RunArrays, frames: NDArray[np.void] | None = None) -> None:
        super().__init__(
            arrays.time,
            {name: arrays.array(name) for name in arrays.names},
            arrays.units,
            phase_names=arrays.phase_names,
            timing=_timing(folder) or arrays.timing,
            information=arrays.information,
        )
        self.path = path
        self.folder = folder
        self._frames = frames

    @classmethod
    def open(cls, path: str | Path) -> "Recording":
        """Open a run's folder, an MF4 file of the bench or a ``signals.mcap``.

        Raises
        ------
        InputError
            If there is no recording there, or it is not the bench's.
        """
        path = Path(path)
        if path.is_dir():
            return cls._open_folder(path)
        if not path.is_file():
            raise InputError(f"{path}: no such recording", allowed="a run's folder, an .mf4 or an .mcap file")
        if path.suffix == ".mcap":
            stored = read_stored(path.parent)
            return cls(path, path.parent, stored.arrays(), stored.frames)
        if path.suffix != ".mf4":
            raise InputError(f"{path}: not recorded by the bench", mend="give a channel map: --channels MAP")
        return cls(path, path.parent, read_mf4(path))

    @classmethod
    def _open_folder(cls, folder: Path) -> "Recording":
        state = read_state(folder)
        if state is not None or (folder / STREAM_FILE).is_file():
            stored = read_stored(folder, Path(state.ring) if state is not None and state.ring else None)
            if stored.schema is not None:
                return cls(folder, folder, stored.arrays(), stored.frames)
        if not (folder / MF4_FILE).is_file():
            raise InputError(f"{folder}: holds no recording ({MF4_FILE} or {STREAM_FILE})")
        return cls(folder, folder, read_mf4(folder / MF4_FILE))

    @cached_property
    def frames(self) -> NDArray[np.void]:
        """Every frame of the run (``FRAME_DTYPE``), in the order recorded; empty without ``frames.blf``."""
        if self._frames is not None:
            return self._frames
        path = self.folder / FRAME_FILE
        return read_blf(path) if path.is_file() else np.zeros(0, FRAME_DTYPE)


def _timing(folder: Path) -> dict[str, Any] | None:
    """Timing block of the run's verdict, so that a judgement of the recording has it too."""
    try:
        content = json.loads((folder / "verdict.json").read_text("utf-8"))
    except (OSError, ValueError):
        return None
    timing: dict[str, Any] = content.get("timing", {})
    return timing
