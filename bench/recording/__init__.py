"""Recording of a run: the ring between the loop and its helpers, the recorder process, files, recovery and reading.

Nothing here needs the loop: a ring can be filled by any writer, and a recording can be read without one.
"""

from typing import Any

_EXPORTS = {
    "Recording": "bench.recording.reading",
    "RecordingSession": "bench.recording.session",
    "RunArrays": "bench.recording.arrays",
    "RunSchema": "bench.recording.schema",
}

__all__ = ["Recording", "RecordingSession", "RunArrays", "RunSchema"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'bench.recording' has no attribute {name!r}")
