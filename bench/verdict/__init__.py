"""Verdicts: criteria over the signals of a run, judged live, from a recording or from a foreign log.

``vocabulary``, ``expression`` and ``criteria_file`` serve the checking of files and import neither numpy nor any reader
of recordings; the rest is imported when a run is judged.
"""

from typing import Any

_EXPORTS = {
    "Assessment": "bench.verdict.assessment",
    "Verdict": "bench.verdict.result",
    "judge_recording": "bench.verdict.rejudge",
}

__all__ = ["Assessment", "Verdict", "judge_recording"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'bench.verdict' has no attribute {name!r}")
