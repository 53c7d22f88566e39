"""Versions that a run depends on, for verdict and report."""

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

DISTRIBUTIONS = ("brake-control-bench", "mujoco", "numba", "numpy", "python-can")


@cache
def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "not installed"


def versions() -> dict[str, str]:
    """Version of the bench and of what shapes its results."""
    found = {"python": platform.python_version(), "kernel": platform.release()}
    return found | {name: _version(name) for name in DISTRIBUTIONS}
