"""CAN at bit level: frames to bits and back, and a bus of protocol nodes, as ISO 11898-1 has them on the wire."""

from typing import Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

_EXPORTS = {
    "Bus": "can_fault_injector.bus",
    "Disturbance": "can_fault_injector.disturbance",
    "Frame": "can_fault_injector.frame",
    "Node": "can_fault_injector.bus_records",
    "ProtocolError": "can_fault_injector.frame",
    "TimedBus": "can_fault_injector.timed_bus",
    "TimedNode": "can_fault_injector.timed_bus",
}

__all__ = ["Bus", "Disturbance", "Frame", "Node", "ProtocolError", "TimedBus", "TimedNode"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'can_fault_injector' has no attribute {name!r}")
