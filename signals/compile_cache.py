"""Folder of numba's disk cache, named after everything that compiled code depends on.

numba's own cache notices a change in the file of a compiled function, but not in a function that it calls in another
file. The folder's name is therefore a hash of all package sources and of the versions that shape machine code: any
change starts an empty cache, and an unchanged tree finds a warm one in every process.
"""

import os
import sys
from collections.abc import Sequence
from functools import cache
from importlib.abc import MetaPathFinder
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import hashlib

PACKAGES = (
    "signals",
    "vehicle_model",
    "hydraulics",
    "can_fault_injector",
    "estimators",
    "model_diagnosis",
    "bench",
)
COMPILERS = ("numba", "llvmlite", "numpy", "mujoco")


def hash_sources(digest: "hashlib._Hash", root: Path, packages: Sequence[str]) -> None:
    """Put names and contents of all Python sources of these packages under ``root`` into a digest."""
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())


def source_hash(root: Path) -> str:
    """Hash of all Python sources of the packages under ``root`` and of the compiler versions."""
    import hashlib
    from importlib.metadata import PackageNotFoundError, version

    digest = hashlib.sha256(sys.version.encode())
    for name in COMPILERS:
        try:
            digest.update(f"{name}={version(name)};".encode())
        except PackageNotFoundError:
            digest.update(f"{name}=absent;".encode())
    hash_sources(digest, root, PACKAGES)
    return digest.hexdigest()[:16]


def cache_root() -> Path:
    """User cache folder of the bench (``XDG_CACHE_HOME`` is honoured)."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "brake-control-bench"


def prepare_compile_cache() -> None:
    """Have ``NUMBA_CACHE_DIR`` set when numba is imported; packages with compiled code call this in their ``__init__``.

    Hashing the sources takes 50 ms, so it is left until something really imports numba: commands that compile nothing
    do not pay. A folder that is already set in the environment is where the hash's own folder is made; child processes
    share their parent's. Where somebody imported numba before, its setting is changed too: it reads the variable once,
    at its import.
    """
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(compile_folder())
    elif not any(isinstance(finder, _BeforeNumba) for finder in sys.meta_path):
        sys.meta_path.insert(0, _BeforeNumba())


class _BeforeNumba(MetaPathFinder):
    """Finds nothing itself; sees the import of numba first and sets its cache folder."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Called for every import that is not yet loaded."""
        if fullname == "numba":
            sys.meta_path.remove(self)
            compile_folder()


def compile_folder() -> Path:
    """Folder of the compiled code, set for this process and its children."""
    # an empty variable counts as none: numba would cache beside the sources, and reuse stale callees
    given = os.environ.get("NUMBA_CACHE_DIR")
    base, own = Path(given) if given else cache_root() / "compiled", _own_name()
    folder = base if own in base.parts else base / own
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    return folder


@cache
def _own_name() -> str:
    return source_hash(Path(__file__).resolve().parent.parent)
