"""CAN at bit level: frames to bits and back, as ISO 11898-1 puts them on the wire."""

from typing import Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

_EXPORTS = {"Frame": "can_fault_injector.frame", "ProtocolError": "can_fault_injector.frame"}

__all__ = ["Frame", "ProtocolError"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'can_fault_injector' has no attribute {name!r}")
