"""Map of the time of injection against the stopping distance: each run stands in the row of its own distance."""

import re
from typing import Any

from bench.campaign.report_page import distance_map


def _cells(distances: list[float | None]) -> list[tuple[str, int]]:
    rows: list[dict[str, Any]] = [
        {"times_s": [1.0], "stopping_distance_m": distance, "outcome": "corrected"} for distance in distances
    ]
    ((_, _, drawing),) = distance_map(rows)
    texts = [(float(y), text) for y, text in re.findall(r'<text[^>]* y="([\d.]+)"[^>]*>([^<]*)</text>', str(drawing))]
    labels = [(y, text) for y, text in texts if text.endswith(" m")]
    counts = [(y, int(text)) for y, text in texts if text.isdigit()]
    return [(min(labels, key=lambda label: abs(label[0] - y))[1], count) for y, count in counts]


def test_equal_distances_stand_in_one_row_that_names_them() -> None:
    assert _cells([27.4437] * 90) == [("27.4 … 27.4 m", 90)]


def test_the_shortest_stands_below_and_the_longest_above() -> None:
    assert _cells([20.0, 34.0, 34.0]) == [("33.0 … 34.0 m", 2), ("20.0 … 21.0 m", 1)]
