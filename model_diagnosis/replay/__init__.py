"""Compact compiled car that replays measured manoeuvres; effects of the catalogue are deviations of its numbers."""

from typing import Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

_EXPORTS = {
    "Replay": "model_diagnosis.replay.replay",
    "ReplayBase": "model_diagnosis.replay.base",
    "RigReplay": "model_diagnosis.replay.rig",
    "equation_errors": "model_diagnosis.replay.equations",
}

__all__ = ["Replay", "ReplayBase", "RigReplay", "equation_errors"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'model_diagnosis.replay' has no attribute {name!r}")
