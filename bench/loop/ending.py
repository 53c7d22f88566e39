"""Ends that a signal asks for, taken at the next turn of a loop."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def until_ended() -> Iterator[Callable[[], int]]:
    """A function that gives 0 until SIGINT or SIGTERM came, then the signal's number.

    An exception from a signal handler can be lost where the interpreter is in a callback of its own. A signal that the
    process ignores stays ignored.
    """
    came = 0

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = number

    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in numbers}
    try:
        yield lambda: came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
