"""python-can without its reader of MF4, which the bench does not use.

That one loads asammdf and with it sympy and pandas: a second of the start of every process that touches a frame.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _absent(name: str) -> Iterator[None]:
    """An optional package that another one does without while it is imported here."""
    if name in sys.modules:
        yield
        return
    sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules[name]


with _absent("asammdf"):
    import can as can
    from can.io import blf as blf
