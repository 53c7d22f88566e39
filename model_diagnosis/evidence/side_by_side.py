"""Linear algebra of all manoeuvres side by side: it gives Python's lock free, and one thread leaves processors idle."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Result = TypeVar("Result")


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1)


def side_by_side(function: Callable[[int], Result], count: int) -> list[Result]:
    """``function`` of 0 to ``count`` − 1, in order; it must not call this itself."""
    return [function(number) for number in range(count)] if count < 2 else list(_pool().map(function, range(count)))
