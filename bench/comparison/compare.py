"""Two runs beside each other: figures, criteria, what was set differently."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.report.formatting import limits_text, metric_label, number, quantity
from bench.report.run_data import RunData
from bench.report.summary import VERDICT_STYLES
from signals.wheels import WHEELS


@dataclass(frozen=True)
class Difference:
    """A figure of both runs; None where a run has none."""

    name: str
    unit: str
    a: float | None
    b: float | None

    @property
    def difference(self) -> float | None:
        """b - a."""
        return self.b - self.a if self.a is not None and self.b is not None else None

    @property
    def relative(self) -> float | None:
        """(b - a)/|a|, None where a is zero."""
        difference = self.difference
        return difference / abs(self.a) if difference is not None and self.a else None

    def as_json(self) -> dict[str, Any]:
        """The figure as plain data."""
        return asdict(self) | {"difference": self.difference, "relative": self.relative}


@dataclass(frozen=True)
class Setting:
    """A value of the resolved scenario that differs."""

    path: str
    a: str
    b: str


@dataclass(frozen=True)
class Comparison:
    """Everything that ``bench compare`` says."""

    a: RunData
    b: RunData
    figures: list[Difference]
    criteria: list[dict[str, Any]]
    settings: list[Setting]

    def as_json(self) -> dict[str, Any]:
        """The comparison as plain data."""
        return {
            "runs": [
                {"path": str(run.folder), "scenario": run.name, "verdict": run.outcome} for run in (self.a, self.b)
            ],
            "metrics": {figure.name: figure.as_json() for figure in self.figures},
            "criteria": self.criteria,
            "settings": [asdict(setting) for setting in self.settings],
        }


def compare(a: RunData, b: RunData) -> Comparison:
    """Compare two runs; metrics that neither has are left out."""
    first, second = dict(_figures(a)), dict(_figures(b))
    names = list(dict.fromkeys([*first, *second]))
    figures = [Difference(name, _unit_of(name), first.get(name), second.get(name)) for name in names]
    return Comparison(a, b, figures, _criteria(a, b), _settings(a, b))


def _figures(run: RunData) -> Iterator[tuple[str, float]]:
    yield from _numbers("", run.verdict.get("metrics") or {})
    for estimator, block in (run.verdict.get("estimators") or {}).items():
        yield from _numbers(f"{estimator} rmse ", block.get("rmse") or {})
    lateness = run.timing.get("lateness_us")
    if run.real_time and isinstance(lateness, Mapping):
        shown = {"p50": "p50_us", "p99": "p99_us", "p999": "p99.9_us", "max": "max_us"}
        yield from _numbers("lateness ", {shown[key]: value for key, value in lateness.items() if key in shown})
    yield from _numbers("", {key: run.timing.get(key) for key in ("overruns", "late_ticks", "real_time_factor")})


def _numbers(prefix: str, mapping: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    for key, value in mapping.items():
        if isinstance(value, list) and len(value) == len(WHEELS):
            yield from _numbers(f"{prefix}{key} ", dict(zip(WHEELS, value, strict=True)))
        elif isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value):
            yield f"{prefix}{key}", float(value)


def _unit_of(name: str) -> str:
    words = name.split(" ")
    return metric_label(words[-2] if words[-1] in WHEELS and len(words) > 1 else words[-1])[1]


def _criteria(a: RunData, b: RunData) -> list[dict[str, Any]]:
    tables = [{str(entry.get("id")): entry for entry in run.verdict.get("criteria") or []} for run in (a, b)]
    found = []
    for name in dict.fromkeys([*tables[0], *tables[1]]):
        left, right = tables[0].get(name, {}), tables[1].get(name, {})
        unit = left.get("unit") or right.get("unit") or "1"
        found.append(
            {
                "id": name,
                "a": {key: left.get(key) for key in ("value", "verdict")},
                "b": {key: right.get(key) for key in ("value", "verdict")},
                "unit": unit,
                "limits": limits_text(left.get("limits") or right.get("limits"), unit),
            }
        )
    return found


def _settings(a: RunData, b: RunData) -> list[Setting]:
    left, right = dict(_leaves(a.scenario)), dict(_leaves(b.scenario))
    return [
        Setting(path, left.get(path, "–"), right.get(path, "–"))
        for path in dict.fromkeys([*left, *right])
        if left.get(path) != right.get(path)
    ]


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        for position, item in enumerate(value):
            yield from _leaves(item, f"{path}[{position}]")
    else:
        yield path, "–" if value is None else str(value)


def figure_texts(figure: Difference) -> tuple[str, str, str, str, str]:
    """Name, both values, difference and relative difference as shown."""
    words, _ = metric_label(figure.name) if " " not in figure.name else (_spaced(figure.name), "")

    def shown(value: float | None) -> str:
        return quantity(value, figure.unit)

    difference = figure.difference
    sign = "+" if difference is not None and difference > 0 else ""
    relative = figure.relative
    percent = f"{sign}{number(round(100 * relative, 1))} %" if relative is not None and difference else ""
    change = "" if difference is None else "=" if difference == 0 else f"{sign}{shown(difference)}"
    return words, shown(figure.a), shown(figure.b), change, percent


def _spaced(name: str) -> str:
    words = name.split(" ")
    place = -2 if words[-1] in WHEELS else -1
    words[place] = metric_label(words[place])[0]
    return " ".join(word.upper() if word in WHEELS else word.replace("_", " ") for word in words)


def print_comparison(comparison: Comparison, console: Console) -> None:
    """The comparison for a terminal."""
    for letter, run in (("A", comparison.a), ("B", comparison.b)):
        style = VERDICT_STYLES.get(run.outcome, "magenta")
        console.print(
            Text.assemble((f"{letter} ", "bold"), (f"{run.outcome} ", style), f"{run.name}  ", (str(run.folder), "dim"))
        )
    if comparison.settings:
        console.print(_settings_table(comparison.settings))
    if comparison.criteria:
        console.print(_criteria_table(comparison.criteria))
    console.print(_figure_table(comparison.figures))


def _plain_table(*heads: str, numbers: int) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for position, head in enumerate(heads):
        right = position >= len(heads) - numbers
        table.add_column(head, justify="right" if right else "left", no_wrap=right)
    return table


def _settings_table(settings: list[Setting]) -> Table:
    table = _plain_table("\nset differently", "\nA", "\nB", numbers=0)
    for setting in settings:
        table.add_row(setting.path, setting.a, setting.b)
    return table


def _criteria_table(criteria: list[dict[str, Any]]) -> Table:
    table = _plain_table("\ncriterion", "\nA", "\nB", numbers=0)
    for entry in criteria:
        table.add_row(str(entry["id"]).replace("_", " "), *(_criterion_cell(entry, run) for run in ("a", "b")))
    return table


def _criterion_cell(entry: dict[str, Any], run: str) -> Text:
    """Value and verdict; only the value of a figure that has no limits."""
    value, verdict = quantity(entry[run]["value"], entry["unit"]), entry[run]["verdict"]
    if not entry["limits"] or verdict is None:
        return Text(value, style="dim")
    return Text.assemble((f"{verdict}  ", VERDICT_STYLES.get(str(verdict), "magenta")), value)


def _figure_table(figures: list[Difference]) -> Table:
    table = _plain_table("\nmetric", "\nA", "\nB", "\nB − A", "\n", numbers=4)
    for figure in figures:
        table.add_row(*figure_texts(figure))
    return table
