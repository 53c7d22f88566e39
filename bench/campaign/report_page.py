"""The page of a campaign: figures, heat maps, what hurts, and the command of each run."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from bench.campaign.drawing import HeatMap, pareto
from bench.campaign.folders import campaign_of
from bench.campaign.outcome_names import HAZARDOUS, OUTCOME_TEXTS, OUTCOMES
from bench.campaign.printing import code_name, ms, show_command
from bench.campaign.store import read_rows
from bench.campaign.summary import Row, Summary, summarise
from bench.report.page_rendering import render

MOST_RUNS = 1000
MOST_COLUMNS = 140
DISTANCE_ROWS = 14
SAME_DISTANCE_M = 0.01
"""Stopping distances that differ by less stand in one row of the map."""
_FIELDS = (
    "sof",
    "id",
    "srr",
    "ide",
    "id_ext",
    "rtr",
    "r1",
    "r0",
    "dlc",
    "data",
    "crc",
    "crc_del",
    "ack_slot",
    "ack_del",
)


def build(folder: Path) -> Path:
    """Write ``report.html`` into a campaign's folder; returns its path."""
    rows = list(read_rows(folder))
    summary = summarise(campaign_of(folder), rows)
    page = folder / "report.html"
    partial = page.with_name(".report.html.partial")
    text = render("campaign.html.j2", {}, contents(summary, rows, folder), scripts=("campaign.js",))
    partial.write_text(text, encoding="utf-8")
    os.replace(partial, page)
    return page


def contents(summary: Summary, rows: Sequence[Row], folder: Path) -> dict[str, Any]:
    """Variables of the template."""
    faulty = sorted((row for row in rows if not row["fault_free"]), key=lambda row: (-row["severity"], row["key"]))
    state = {0: "pass", 1: "fail", 4: "error"}[summary.exit_code]
    hurting = summary.pareto[:20]
    hazardous = summary.whole.hazardous.count
    return {
        "title": summary.campaign.title or summary.campaign.id,
        "icon_colour": {"pass": "%2312713f", "fail": "%23b3132f", "error": "%237a1fa2"}[state],
        "campaign": summary.campaign,
        "state": state,
        "state_text": {0: "done", 1: "limit broken", 4: "runs without result"}[summary.exit_code],
        "outcomes": OUTCOME_TEXTS,
        "whole": summary.whole,
        "by_entry": summary.by_entry,
        "by_class": summary.by_class,
        "by_variant": summary.by_variant,
        "limits": summary.limits,
        "covered": summary.covered,
        "fault_codes": [(code, code_name(code), count) for code, count in summary.fault_codes.most_common()],
        "pareto": pareto([e.name for e in hurting], [e.hazardous.count for e in hurting], hazardous) if hurting else "",
        "maps": list(heat_maps(faulty)),
        "smallest": [_shown(row, folder) for row in summary.smallest[:50]],
        "runs": [_shown(row, folder) for row in faulty[:MOST_RUNS]],
        "folder": str(folder),
        "ms": ms,
    }


def _shown(row: Row, folder: Path) -> dict[str, Any]:
    faults = [
        name if time is None else f"{name} at {time:g} s"
        for name, time in zip(row["faults"], row["times_s"], strict=True)
    ]
    report = Path("show") / row["key"] / "report.html"
    return {
        **row,
        "text": "; ".join(faults),
        "command": show_command(row["key"], folder),
        "link": report.as_posix() if (folder / report).exists() else "",
    }


def heat_maps(rows: Sequence[Row]) -> list[tuple[str, str, Markup]]:
    """Title, explanation and drawing of every map that the rows fill."""
    maps = []
    bits = Counter[tuple[tuple[Any, ...], str]]()
    for row in rows:
        for message, field, bit in zip(row["messages"], row["fields"], row["bits"], strict=True):
            if field and bit is not None:
                bits[(message, _rank(field), field, bit), row["outcome"]] += 1
    places = sorted({place for place, _ in bits})[:MOST_COLUMNS]
    if places:
        several = len({place[0] for place in places}) > 1
        labels = [f"{f'{place[0]} ' if several else ''}{place[2]}.{place[3]}" for place in places]
        counts = [[bits[place, outcome] for place in places] for outcome in OUTCOMES]
        maps.append(
            (
                "Bit position × outcome",
                "Each column is a bit of the frame in the order of transmission; a cell is as dark as its share there.",
                _by_outcome(labels, counts),
            )
        )
    for title, column in (
        ("Step of the manoeuvre × outcome", "phase"),
        ("Kind of disturbance × outcome", "disturbances"),
    ):
        counted = _counted(rows, column)
        names = list(dict.fromkeys(name for name, _ in counted))[:MOST_COLUMNS]
        if len(names) > 1:
            counts = [[counted[name, outcome] for name in names] for outcome in OUTCOMES]
            maps.append((title, "Runs by outcome.", _by_outcome(names, counts)))
    return [*maps, *distance_map(rows)]


def _counted(rows: Sequence[Row], column: str) -> Counter[tuple[str, str]]:
    counted = Counter[tuple[str, str]]()
    for row in rows:
        values = row[column] if isinstance(row[column], list) else [row[column]]
        for value in dict.fromkeys(values):
            if value:
                counted[value, row["outcome"]] += 1
    return counted


def _rank(field: str) -> int:
    return _FIELDS.index(field) if field in _FIELDS else len(_FIELDS)


def _by_outcome(columns: Sequence[str], counts: Sequence[Sequence[int]]) -> Markup:
    names = list(OUTCOMES)
    return HeatMap([OUTCOME_TEXTS[name] for name in names], columns, counts, lambda row, _: f"h-{names[row]}").svg()


def distance_map(rows: Sequence[Row]) -> list[tuple[str, str, Markup]]:
    """Time of the first fault against the stopping distance."""
    timed: list[tuple[float, Mapping[str, Any]]] = []
    for row in rows:
        times = [time for time in row["times_s"] if time is not None]
        if times:
            timed.append((min(times), row))
    instants = sorted({time for time, _ in timed})[:MOST_COLUMNS]
    distances = [row["stopping_distance_m"] for _, row in timed if row["stopping_distance_m"] is not None]
    if not distances or not instants:
        return []
    low, high = min(distances), max(distances)
    bands = DISTANCE_ROWS if high - low > SAME_DISTANCE_M else 1
    step = (high - low) / bands
    counts = [[0] * len(instants) for _ in range(bands + 1)]
    hazardous = [[0] * len(instants) for _ in range(bands + 1)]
    for time, row in timed:
        if time not in instants:
            continue
        distance = row["stopping_distance_m"]
        # the longest on top; above it the runs that do not stop
        place = 0
        if distance is not None:
            place = 1 if bands == 1 else bands - min(int((distance - low) / step), bands - 1)
        counts[place][instants.index(time)] += 1
        hazardous[place][instants.index(time)] += row["outcome"] == HAZARDOUS
    labels = [
        "does not stop",
        *(f"{high - step * (n + 1):.1f} … {high - step * n:.1f} m" for n in range(bands)),
    ]

    def colour(row: int, column: int) -> str:
        return "h-hazardous" if 2 * hazardous[row][column] > counts[row][column] else "h-count"

    drawing = HeatMap(labels, [f"{time:g} s" for time in instants], counts, colour).svg()
    explanation = "Runs by the time of their first fault; red where most of them are hazardous."
    return [("Time of injection × stopping distance", explanation, drawing)]
