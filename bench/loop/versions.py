"""Versions that a run depends on, for verdict and report."""

import platform
from importlib.metadata import PackageNotFoundError, version

DISTRIBUTIONS = ("brake-control-bench", "mujoco", "numba", "numpy", "python-can")


def versions() -> dict[str, str]:
    """Version of the bench and of what shapes its results."""
    found = {"python": platform.python_version(), "kernel": platform.release()}
    for name in DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
