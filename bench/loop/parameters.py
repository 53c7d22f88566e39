"""Every parameter of a run by its dotted path, whoever owns it."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Protocol


class ParameterOwner(Protocol):
    """A part with parameters that can be changed while it runs."""

    def names(self) -> Sequence[str]:
        """Dotted paths."""

    def get(self, path: str) -> float:
        """Value in SI units."""

    def set(self, path: str, value: float) -> None:
        """Change a value from the next tick on."""


Accessors = tuple[Callable[[], float], Callable[[float], None]]


def accessors(owners: Iterable[ParameterOwner]) -> dict[str, Accessors]:
    """Dotted path to (get, set).

    Several parts may hold a copy of one parameter (the radius of a wheel, say): setting it sets all of them, so that
    no two parts of the simulated car disagree.
    """
    by_path: dict[str, list[ParameterOwner]] = {}
    for owner in owners:
        for path in owner.names():
            by_path.setdefault(path, []).append(owner)
    return {path: _accessors_of(path, holders) for path, holders in by_path.items()}


def _accessors_of(path: str, holders: list[ParameterOwner]) -> Accessors:
    if len(holders) == 1:
        return partial(holders[0].get, path), partial(holders[0].set, path)

    def set_all(value: float) -> None:
        for holder in holders:
            holder.set(path, value)

    return partial(holders[0].get, path), set_all
