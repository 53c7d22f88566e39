"""Hydraulic control unit of an ABS/ESC: selection logic, wheel pressures, low-pressure accumulators, brake torque.

``HydraulicUnit`` turns the driver's master-cylinder pressure and the state of valves and pump into the pressure and
the torque capacity of four wheel brakes. Its model is told in docs/models/hydraulics.md.
"""

from typing import Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

_EXPORTS = {
    "HydraulicUnit": "hydraulics.unit",
    "PARAMETERS": "hydraulics.parameters",
    "SelectionLogic": "hydraulics.selection_logic",
    "abs_logic": "hydraulics.selection_logic",
    "esp_logic": "hydraulics.selection_logic",
}

__all__ = ["PARAMETERS", "HydraulicUnit", "SelectionLogic", "abs_logic", "esp_logic"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'hydraulics' has no attribute {name!r}")
