"""Scenario and procedure files: schema, reading with includes and ``--set``, checking, variants.

``resolve`` gives what a run is made of, ``dump`` its YAML text for the run's folder.
"""

from typing import Any

_EXPORTS = {
    "ScenarioFile": "bench.scenario.schema",
    "dump": "bench.scenario.resolution",
    "resolve": "bench.scenario.resolution",
}

__all__ = ["ScenarioFile", "dump", "resolve"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'bench.scenario' has no attribute {name!r}")
