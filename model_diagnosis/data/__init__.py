"""Measured data before any physics: logs into manoeuvres, faults of the data named and repaired.

from model_diagnosis.data import check_data, read_manoeuvres
"""

from typing import Any

_EXPORTS = {
    "check_data": "model_diagnosis.data.checks",
    "read_manoeuvres": "model_diagnosis.data.reading",
    "suggest_channels": "model_diagnosis.data.mapping",
}

__all__ = ["check_data", "read_manoeuvres", "suggest_channels"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'model_diagnosis.data' has no attribute {name!r}")
