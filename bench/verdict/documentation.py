"""Tables of ``docs/verdicts.md``, made from the vocabulary: ``python -m bench.verdict.documentation``."""

import sys
from pathlib import Path

from bench.verdict.vocabulary import CONSTANTS, FUNCTIONS, METRICS, PHASES, Metric
from signals.units import parse_unit

BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"
PAGE = Path(__file__).resolve().parents[2] / "docs" / "verdicts.md"
_SHOWN_IN = {"m/s": "km/h", "1": "1"}


def tables() -> str:
    """Phases, functions, constants and metrics as Markdown."""
    lines = ["### Phases", "", "| Phase | From … to |", "|---|---|"]
    lines += [f"| `{name}` | {text} |" for name, text in PHASES.items()]
    lines += ["| a step of the manoeuvre | from its first tick to its last |", ""]
    lines += ["### Functions", "", "| Function | Value |", "|---|---|"]
    lines += [f"| `{f.name}({f.arguments})` | {f.description} |" for f in FUNCTIONS.values()]
    lines += ["", "Constants: " + ", ".join(f"`{name}` = {value:.6g}" for name, value in CONSTANTS.items()) + ".", ""]
    lines += [
        "### Metrics",
        "",
        "| Metric | Unit | Phase | What it is | Parameters | Source |",
        "|---|---|---|---|---|---|",
    ]
    lines += [_metric_row(metric) for metric in METRICS.values()]
    return "\n".join(lines)


def _metric_row(metric: Metric) -> str:
    parameters = ", ".join(f"`{name}`: {_quantity(*default)}" for name, default in metric.parameters.items())
    unit = metric.unit + (" × 4" if metric.per_wheel else "")
    phase = f"`{metric.phase}`" if metric.phase else ""
    return f"| `{metric.name}` | {unit} | {phase} | {metric.description} | {parameters} | {metric.source} |"


def _quantity(value: float, unit: str) -> str:
    shown = _SHOWN_IN.get(unit, unit)
    known = parse_unit(shown)
    number = f"{value / (known[0] if known else 1.0):.6g}"
    return number if shown == "1" else f"{number} {shown}"


def updated(page: str) -> str:
    """The page with its tables made anew."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n\n{tables()}\n\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(updated(PAGE.read_text("utf-8")), "utf-8")
    sys.stdout.write(f"{PAGE}\n")
