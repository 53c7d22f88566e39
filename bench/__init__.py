"""The application: scenario files, loop, ECU links, recording, verdicts and the command line.

``bench.run`` and ``bench.Run`` are the Python interface behind ``bench run``, ``bench.diagnose`` that behind ``bench
diagnose``; they are imported when first used.
"""

from typing import Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

_EXPORTS = {"run": "bench.api", "Run": "bench.api", "diagnose": "bench.diagnosis.diagnosing"}

__all__ = ["Run", "diagnose", "run"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'bench' has no attribute {name!r}")
