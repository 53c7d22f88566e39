"""What a campaign has shown: shares with their intervals, latencies, coverage, what hurts, smallest sets."""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.campaign.adaptive import smallest_failing_sets
from bench.campaign.campaign_file import CampaignFile, CampaignLimit
from bench.campaign.fault_space import FaultSpace, Point
from bench.campaign.outcome_names import BENCH_ERROR, HAZARDOUS, OUTCOMES
from bench.campaign.statistics import Share, share
from bench.campaign.strategy import Result
from bench.execution.job import DONE

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Line:
    """Runs of one kind: how many, what became of them, how many were detected."""

    name: str
    outcomes: Mapping[str, Share]
    detected: Share
    undetected: Share
    latencies_s: tuple[float, ...]
    worst: Row

    @property
    def runs(self) -> int:
        """Number of runs."""
        return next(iter(self.outcomes.values())).total

    @property
    def hazardous(self) -> Share:
        """Share of hazardous runs."""
        return self.outcomes[HAZARDOUS]

    def latency_s(self, percent: float) -> float | None:
        """Latency of detection that so many per cent of the detected runs do not exceed; None without any."""
        if not self.latencies_s:
            return None
        return self.latencies_s[min(len(self.latencies_s) - 1, math.ceil(percent / 100 * len(self.latencies_s)) - 1)]


@dataclass(frozen=True)
class LimitResult:
    """A limit of the campaign and what was found."""

    limit: CampaignLimit
    value: float | None
    broken: bool


@dataclass
class Summary:
    """The figures of a campaign.

    Attributes
    ----------
    whole : Line
        All runs with faults.
    by_entry, by_class, by_variant : list of Line
        The same by entry of the campaign file, by class of E2E faults, by variant.
    by_class_and_variant : list of (class, variant, Line)
        The same for each class with each variant.
    fault_codes : Counter
        Runs in which each fault code was stored.
    covered : dict
        By axis (message, field and bit, step of the manoeuvre, time, fault): values run, values in the space.
    pareto : list of Line
        Entries with hazardous runs, the one with most first.
    smallest : list of Row
        Hazardous runs whose set of faults cannot lose one and still be hazardous, fewest faults first.
    """

    campaign: CampaignFile
    whole: Line
    by_entry: list[Line]
    by_class: list[Line]
    by_variant: list[Line]
    by_class_and_variant: list[tuple[str, str, Line]] = field(default_factory=list)
    fault_codes: Counter[int] = field(default_factory=Counter)
    covered: dict[str, tuple[int, int]] = field(default_factory=dict)
    pareto: list[Line] = field(default_factory=list)
    smallest: list[Row] = field(default_factory=list)
    limits: list[LimitResult] = field(default_factory=list)
    without_result: list[Row] = field(default_factory=list)

    @property
    def exit_code(self) -> int:
        """4 if a run has no result, 1 if a limit is broken, else 0."""
        if self.without_result:
            return 4
        return 1 if any(limit.broken for limit in self.limits) else 0


def summarise(campaign: CampaignFile, rows: Sequence[Row]) -> Summary:
    """Figures of a campaign from the rows of its store."""
    faulty = [row for row in rows if not row["fault_free"]]
    confidence = campaign.confidence
    space = FaultSpace(campaign)

    def lines(names: Callable[[Row], Iterable[str]]) -> list[Line]:
        groups: dict[str, list[Row]] = defaultdict(list)
        for row in faulty:
            for name in dict.fromkeys(names(row)):
                groups[name].append(row)
        return [line_of(name, group, confidence) for name, group in groups.items() if name]

    by_entry = lines(lambda row: row["entries"])
    summary = Summary(
        campaign,
        line_of("all", faulty, confidence),
        sorted(by_entry, key=lambda line: [entry.name for entry in campaign.faults].index(line.name)),
        lines(lambda row: row["e2e"]),
        lines(lambda row: [row["variant"]]),
        fault_codes=Counter(code for row in faulty for code in row["fault_codes"]),
        covered=coverage(space, faulty),
        pareto=sorted(
            (line for line in by_entry if line.hazardous.count), key=lambda line: (-line.hazardous.count, line.name)
        ),
        smallest=_smallest(space, faulty),
        without_result=[row for row in rows if row["run_outcome"] != DONE],
    )
    for class_line in summary.by_class:
        for variant_line in summary.by_variant:
            both = [r for r in faulty if class_line.name in r["e2e"] and r["variant"] == variant_line.name]
            line = line_of(f"{class_line.name}, {variant_line.name}", both, confidence)
            summary.by_class_and_variant.append((class_line.name, variant_line.name, line))
    summary.limits = [limit_result(limit, faulty, confidence) for limit in campaign.limits]
    return summary


def line_of(name: str, rows: Sequence[Row], confidence: float) -> Line:
    """Figures of some runs."""
    counts = Counter(row["outcome"] for row in rows)
    acted = [row for row in rows if row["outcome"] != BENCH_ERROR]
    noticed = sum(bool(row["noticed"]) for row in acted)
    silent = sum(not row["noticed"] and row["outcome"] in ("silent_harmless", HAZARDOUS) for row in acted)
    return Line(
        name,
        {outcome: share(counts[outcome], len(rows), confidence) for outcome in OUTCOMES},
        share(noticed, len(acted), confidence),
        share(silent, len(acted), confidence),
        tuple(sorted(row["latency_s"] for row in acted if row["latency_s"] is not None)),
        max(rows, key=lambda row: row["severity"], default={}),
    )


def limit_result(limit: CampaignLimit, rows: Sequence[Row], confidence: float) -> LimitResult:
    """Whether the campaign keeps one of its limits; a quantity without a value breaks it."""
    meant = [
        row
        for row in rows
        if (limit.fault is None or limit.fault in row["entries"])
        and (limit.variant is None or limit.variant == row["variant"])
    ]
    value = _quantity(limit.quantity, line_of("", meant, confidence), meant)
    broken = value is None
    if value is not None:
        broken = (limit.at_most is not None and value > limit.at_most) or (
            limit.at_least is not None and value < limit.at_least
        )
    return LimitResult(limit, value, broken)


def _quantity(name: str, line: Line, rows: Sequence[Row]) -> float | None:
    outcome, _, what = name.rpartition("_")
    if outcome in line.outcomes:
        return float(line.outcomes[outcome].count) if what == "runs" else line.outcomes[outcome].value
    if name == "hazardous_undetected_runs":
        return float(sum(row["outcome"] == HAZARDOUS and not row["noticed"] for row in rows))
    if name == "largest_detection_latency":
        return max(line.latencies_s, default=0.0)
    return line.detected.value if name == "detected_share" else line.undetected.value


def coverage(space: FaultSpace, rows: Sequence[Row]) -> dict[str, tuple[int, int]]:
    """By axis of the fault space the number of its values that were run, and of all that there are."""
    single = [(item, item.place) for item in space.injections]
    steps = {time: row["phase"] for row in rows for time in row["times_s"][:1]}
    every: dict[str, set[Any]] = {
        "variants": {variant.name for variant in space.variants},
        "faults": {item.label for item, _ in single},
        "messages": {place.message for _, place in single if place.message},
        "fields": {place.field for _, place in single if place.field},
        "bits": {(place.message, place.field, place.bit) for _, place in single if place.bit is not None},
        "times": {item.time_s for item, _ in single if item.time_s is not None},
        "fields × bits × times": {
            (place.message, place.field, place.bit, item.time_s) for item, place in single if place.field
        },
        "fields × bits × steps of the manoeuvre": {
            (place.message, place.field, place.bit, steps.get(item.time_s, "not reached"))
            for item, place in single
            if place.field
        },
    }
    run: dict[str, set[Any]] = defaultdict(set)
    for row in rows:
        run["variants"].add(row["variant"])
        columns = zip(row["faults"], row["messages"], row["fields"], row["bits"], row["times_s"], strict=True)
        for label, message, place, bit, time_s in columns:
            run["faults"].add(label)
            run["messages"].add(message)
            run["fields"].add(place)
            run["bits"].add((message, place, bit))
            run["times"].add(time_s)
            run["fields × bits × times"].add((message, place, bit, time_s))
            run["fields × bits × steps of the manoeuvre"].add((message, place, bit, steps.get(time_s, "not reached")))
    return {axis: (len(values & run[axis]), len(values)) for axis, values in every.items() if values}


def _smallest(space: FaultSpace, rows: Sequence[Row]) -> list[Row]:
    """Rows of the smallest failing sets, where sets of faults were run at all."""
    if not any(len(row["faults"]) > 1 for row in rows):
        return []
    numbers = {(item.label, item.time_s): number for number, item in enumerate(space.injections)}
    variants = {variant.name: number for number, variant in enumerate(space.variants)}
    by_point: dict[Point, Row] = {}
    for row in rows:
        injections = sorted(numbers[place] for place in zip(row["faults"], row["times_s"], strict=True))
        by_point[variants[row["variant"]], tuple(injections), space.seeds.index(row["seed"])] = row
    known = {point: Result(row["severity"], row["outcome"] == HAZARDOUS) for point, row in by_point.items()}
    return [by_point[point] for point in smallest_failing_sets(known)]
