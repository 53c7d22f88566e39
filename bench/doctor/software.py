"""Browser and Python packages; nothing is imported, only looked for."""

import shutil
from collections.abc import Iterator
from importlib.util import find_spec

from bench.doctor.finding import Finding

_NEEDED = (
    "numpy",
    "numba",
    "mujoco",
    "scipy",
    "asammdf",
    "can",
    "cantools",
    "mcap",
    "rich",
    "pint",
    "pyarrow",
    "serial",
)
_OPTIONAL = {"selenium": "test", "e2e": "test", "hypothesis": "test", "filterpy": "test"}


def findings() -> Iterator[Finding]:
    """Everything about installed software."""
    yield browser()
    yield packages()
    yield optional_packages()


def browser() -> Finding:
    """A browser for the report page's test, and its driver."""
    found = [name for name in ("chromium", "chromium-browser", "google-chrome") if shutil.which(name)]
    if not found:
        return Finding("chromium", "info", "no chromium (only for testing reports)", "sudo apt-get install chromium")
    if shutil.which("chromedriver") is None:
        text = f"{found[0]} without chromedriver (only for testing reports)"
        return Finding("chromium", "info", text, "sudo apt-get install chromium-driver")
    return Finding("chromium", "ok", "chromium with driver")


def packages() -> Finding:
    """Packages that the bench cannot do without."""
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        return Finding("packages", "warn", f"missing: {', '.join(missing)}", "pip install --editable .")
    return Finding("packages", "ok", "all packages installed")


def optional_packages() -> Finding:
    """Packages that only some uses need."""
    missing = [f"{name} (bench[{extra}])" for name, extra in _OPTIONAL.items() if find_spec(name) is None]
    if missing:
        return Finding("optional", "info", f"not installed: {', '.join(missing)}", "pip install --editable '.[test]'")
    return Finding("optional", "ok", "all optional packages installed")
