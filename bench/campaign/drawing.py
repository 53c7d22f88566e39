"""Heat maps and the Pareto chart of a campaign as SVG, drawn with the classes of the report's style."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

LABEL_WIDTH = 190
ROW_HEIGHT = 26
LETTER_HEIGHT = 5.7
"""Height that a letter of a slanting label takes."""
MOST_NUMBERS = 60
"""Columns up to which cells carry their number as text."""


@dataclass(frozen=True)
class HeatMap:
    """Counts over two axes.

    Attributes
    ----------
    rows, columns : sequence of str
        Labels; row 0 is drawn on top.
    counts : sequence of sequence of int
        One per row and column.
    colour : callable
        Class of the style for a row and column.
    """

    rows: Sequence[str]
    columns: Sequence[str]
    counts: Sequence[Sequence[int]]
    colour: Callable[[int, int], str]
    unit: str = "runs"

    def svg(self) -> Markup:
        """The drawing; a cell is as dark as its share of its column."""
        width = max(9, min(44, 1100 // max(len(self.columns), 1)))
        totals = [sum(row[number] for row in self.counts) for number in range(len(self.columns))]
        top = round(20 + LETTER_HEIGHT * max((len(label) for label in self.columns), default=0))
        height = top + ROW_HEIGHT * len(self.rows)
        parts = [
            f'<svg width="{LABEL_WIDTH + width * len(self.columns) + 30}" height="{height}" role="img" '
            f'aria-label="{escape(" by ".join((self.unit, "row and column")))}">'
        ]
        for number, label in enumerate(self.columns):
            x = LABEL_WIDTH + width * number + width / 2
            if number % max(1, round(14 / width)) == 0:
                parts.append(f'<text transform="translate({x + 4:.1f} {top - 6}) rotate(-60)">{escape(label)}</text>')
        for number, label in enumerate(self.rows):
            y = top + ROW_HEIGHT * number
            parts.append(f'<text x="{LABEL_WIDTH - 8}" y="{y + 17}" text-anchor="end">{escape(label)}</text>')
            parts += [self._cell(number, column, totals[column], width, y) for column in range(len(self.columns))]
        return Markup("".join([*parts, "</svg>"]))

    def _cell(self, row: int, column: int, total: int, width: int, y: int) -> str:
        count = self.counts[row][column]
        if not count:
            return ""
        x = LABEL_WIDTH + width * column
        title = escape(f"{self.columns[column]}, {self.rows[row]}: {count} of {total} {self.unit}")
        opacity = 0.25 + 0.75 * count / total
        cell = (
            f'<rect class="{self.colour(row, column)}" x="{x}" y="{y}" width="{width - 1}" height="{ROW_HEIGHT - 1}" '
            f'fill-opacity="{opacity:.2f}"><title>{title}</title></rect>'
        )
        if width >= 22 and len(self.columns) <= MOST_NUMBERS:
            cell += (
                f'<text class="cell-text" x="{x + width / 2 - 0.5}" y="{y + 17}" text-anchor="middle">{count}</text>'
            )
        return cell


def pareto(names: Sequence[str], counts: Sequence[int], everything: int) -> Markup:
    """Bars, the longest on top, and the share of all that the bars down to each one make."""
    width, length = 620, 420
    height = ROW_HEIGHT * len(names) + 30
    largest = max(counts, default=1)
    parts = [f'<svg width="{LABEL_WIDTH + width}" height="{height}" role="img" aria-label="hazardous runs by fault">']
    points, running = [], 0
    for number, (name, count) in enumerate(zip(names, counts, strict=True)):
        y = ROW_HEIGHT * number + 20
        running += count
        bar = length * count / largest
        points.append(f"{LABEL_WIDTH + length * running / everything:.1f},{y + 12}")
        parts.append(f'<text x="{LABEL_WIDTH - 8}" y="{y + 16}" text-anchor="end">{escape(name)}</text>')
        parts.append(f'<rect class="bar" x="{LABEL_WIDTH}" y="{y}" width="{bar:.1f}" height="{ROW_HEIGHT - 6}"/>')
        parts.append(
            f'<text x="{LABEL_WIDTH + length + 12}" y="{y + 16}">{count} '
            f"({100 * running / everything:.0f} % so far)</text>"
        )
    parts.append(f'<polyline class="cumulative" points="{" ".join(points)}"/>')
    return Markup("".join([*parts, "</svg>"]))
