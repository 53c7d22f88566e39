"""The report of a run: one self-contained page, a picture for documents, and the summary a terminal prints.

``build(run_dir)`` writes ``report.html`` into the run's folder; ``draw_picture`` puts the main signals into a PNG or
SVG file.
"""

from typing import Any

_EXPORTS = {
    "build": "bench.report.run_report",
    "draw_picture": "bench.report.picture",
    "print_summary": "bench.report.summary",
}

__all__ = ["build", "draw_picture", "print_summary"]


def __getattr__(name: str) -> Any:
    if name in _EXPORTS:
        from importlib import import_module

        return getattr(import_module(_EXPORTS[name]), name)
    raise AttributeError(f"module 'bench.report' has no attribute {name!r}")
