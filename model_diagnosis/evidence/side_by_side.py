"""Linear algebra of all manoeuvres side by side: it gives Python's lock free, and one thread leaves processors idle."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from model_diagnosis.processors import threads_here

Result = TypeVar("Result")


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads_here())


def side_by_side(function: Callable[[int], Result], count: int) -> list[Result]:
    """``function`` of 0 to ``count`` − 1, in order; it must not call this itself."""
    mapped = map if count < 2 or threads_here() == 1 else _pool().map
    return list(mapped(function, range(count)))
