"""The fault space: scenario variants × faults × times × seeds, and the single points of it."""

import copy
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from bench.campaign.campaign_file import TIME_PATHS, CampaignFile, FaultEntry
from bench.campaign.fault_place import Place, place_of
from bench.scenario.variants import Variant, expand

KEY_LENGTH = 12


@dataclass(frozen=True)
class Injection:
    """A fault with all its values, at one time.

    Attributes
    ----------
    name : str
        Of the entry in the campaign file.
    kind : {"fault", "stimulus", "set"}
        What it is in a scenario.
    entry : mapping
        What stands in the scenario.
    position : tuple of int
        Places of its values on the axes of the entry's grid, and of its time.
    time_s : float or None
        None for what has no time of its own.
    """

    name: str
    kind: str
    entry: Mapping[str, Any]
    grid: Mapping[str, Any]
    position: tuple[int, ...]
    time_s: float | None
    place: Place

    @cached_property
    def label(self) -> str:
        """``name[by=20 ms,id=288]``, without the time."""
        values = ",".join(f"{path.rpartition('.')[2]}={value}" for path, value in self.grid.items())
        return f"{self.name}[{values}]" if values else self.name

    @property
    def text(self) -> str:
        """The label and its time."""
        return self.label if self.time_s is None else f"{self.label} at {self.time_s:g} s"


Point = tuple[int, tuple[int, ...], int]
"""Number of the variant, numbers of the injections in rising order, number of the seed."""


class FaultSpace:
    """Every run that a campaign could make.

    Parameters
    ----------
    campaign : CampaignFile

    Attributes
    ----------
    variants : sequence of Variant
        At least one; the scenario itself has no name and sets nothing.
    injections : sequence of Injection
        Faults with their times.
    """

    def __init__(self, campaign: CampaignFile) -> None:
        self.campaign = campaign
        self.variants = expand(campaign.variants) if campaign.variants is not None else [Variant("", {})]
        self.seeds = campaign.seed_values
        self.injections = [
            injection for entry in campaign.faults for injection in _injections(entry, campaign.instants)
        ]
        self._by_place = {(item.name, item.position): number for number, item in enumerate(self.injections)}

    @property
    def singles(self) -> int:
        """Number of runs with one fault each."""
        return len(self.variants) * len(self.injections) * len(self.seeds)

    def every_single(self) -> Iterator[Point]:
        """All runs with one fault, in the order of the file."""
        sizes = (len(self.variants), len(self.injections), len(self.seeds))
        for variant, injection, seed in product(*(range(size) for size in sizes)):
            yield variant, (injection,), seed

    def fault_free(self) -> Iterator[Point]:
        """The runs that all others are compared with: each variant with each seed."""
        for variant, seed in product(range(len(self.variants)), range(len(self.seeds))):
            yield variant, (), seed

    def draw(self, generator: np.random.Generator, faults_at_once: int = 1) -> Point:
        """A point drawn evenly; of several faults at once, their number is drawn first."""
        count = int(generator.integers(1, min(faults_at_once, len(self.injections)) + 1))
        chosen = generator.choice(len(self.injections), count, replace=False)
        return (
            int(generator.integers(len(self.variants))),
            tuple(sorted(int(number) for number in chosen)),
            int(generator.integers(len(self.seeds))),
        )

    def neighbours(self, number: int) -> list[int]:
        """Injections that differ from one in the place on a single axis, by one step."""
        injection = self.injections[number]
        found = []
        for axis in range(len(injection.position)):
            for step in (-1, 1):
                place = list(injection.position)
                place[axis] += step
                other = self._by_place.get((injection.name, tuple(place)))
                if other is not None:
                    found.append(other)
        return found

    def injections_of(self, point: Point) -> list[Injection]:
        """Faults of a point."""
        return [self.injections[number] for number in point[1]]

    def key(self, point: Point) -> str:
        """Name of a run, the same for the same variant, faults, times and seed, whatever else the file holds."""
        variant, injections, seed = point
        told = {
            "scenario": self.campaign.scenario,
            "set": self.campaign.set,
            "variant": dict(self.variants[variant].sets),
            "faults": [
                [item.kind, item.entry, item.time_s] for item in (self.injections[number] for number in injections)
            ],
            "seed": self.seeds[seed],
        }
        text = json.dumps(told, sort_keys=True, separators=(",", ":"), default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]


def _injections(entry: FaultEntry, instants: Sequence[float]) -> Iterator[Injection]:
    times: Sequence[float | None] = instants if entry.begins_at_times else (None,)
    sizes = [len(values) for values in entry.grid.values()]
    positions = product(*(range(size) for size in sizes))
    for grid, position in zip(entry.combinations(), positions, strict=True):
        base: Any = copy.deepcopy(entry.entry)
        for path, value in grid.items():
            if entry.kind == "set":
                base[path] = value
            else:
                put(base, path, value)
        for number, time_s in enumerate(times):
            timed = copy.deepcopy(base)
            if time_s is not None:
                put(timed, TIME_PATHS[entry.kind], time_s)
            yield Injection(entry.name, entry.kind, timed, grid, (*position, number), time_s, place_of(entry, timed))


def put(data: Any, path: str, value: Any) -> None:
    """Put a value at a dotted path of nested mappings and lists, making the mappings that are missing."""
    *heads, last = path.split(".")
    for head in heads:
        data = data[int(head)] if isinstance(data, list) else data.setdefault(head, {})
    if isinstance(data, list):
        data[int(last)] = value
    else:
        data[last] = value
