"""What a terminal shows when a run has ended: the verdict table, where the files are, what to do next."""

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.report.criteria_table import CriterionRow, criterion_rows, has_values, tally
from bench.report.formatting import VERDICT_SYMBOLS
from bench.report.run_data import read_json

VERDICT_STYLES = {"pass": "green", "fail": "red", "inconclusive": "yellow", "error": "magenta"}
PIPED_WIDTH = 140
NARROW = 90


def output_console() -> Console:
    """Console of standard output; wide enough for whole lines where nobody looks."""
    piped = not sys.stdout.isatty()
    return Console(width=PIPED_WIDTH if piped else None, highlight=False, soft_wrap=False)


def print_summary(
    run_dir: str | Path, verdict: Mapping[str, Any] | None = None, console: Console | None = None
) -> None:
    """Print the verdict of a run.

    Parameters
    ----------
    run_dir : path
        The run's folder.
    verdict : mapping, optional
        Contents of ``verdict.json``; read from the folder if left out.
    """
    folder = Path(run_dir)
    content = verdict if verdict is not None else read_json(folder / "verdict.json")
    console = console or output_console()
    outcome = str(content.get("verdict") or "error")
    style = VERDICT_STYLES.get(outcome, "magenta")
    head = Text.assemble(
        (f" {VERDICT_SYMBOLS.get(outcome, '!')} {outcome.upper()} ", f"bold reverse {style}"),
        (f"  {content.get('scenario', '')}", "bold"),
        (f"   {tally(content)}", "dim"),
    )
    console.print()
    console.print(head)
    errors = content.get("errors") or []
    for text in errors:
        console.print(Text(f"error: {text}", style="bold magenta"))
    rows = criterion_rows(content)
    if rows and not (errors and not has_values(content)):
        console.print(criteria_table(rows, console.width))
    for text in content.get("remarks") or []:
        console.print(Text(f"remark: {text}", style="yellow"))
    _print_files(console, folder)


def criteria_table(rows: list[CriterionRow], width: int) -> Table:
    """The criteria, the worst first; a narrow terminal leaves the requirement out."""
    wide = width >= NARROW
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column("", no_wrap=True)
    table.add_column("criterion", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column("limit", justify="right", no_wrap=True)
    table.add_column("margin", justify="right", no_wrap=True)
    if wide:
        table.add_column("requirement", overflow="fold")
    for row in rows:
        style = VERDICT_STYLES.get(row.verdict, "magenta")
        name = Text(row.name)
        if row.verdict != "pass" and row.reason:
            name.append(f"\n{row.reason}", style=style)
        if row.verdict == "fail" and row.wheels:
            name.append(f"\n{row.wheels}", style="dim")
        cells: list[Text | str] = [
            Text(f" {row.symbol}", style="dim" if row.informative else f"bold {style}"),
            name,
            Text(row.value, style=f"bold {style}" if row.verdict == "fail" else ""),
            row.limits,
            Text(row.margin, style=style),
        ]
        table.add_row(*cells, *([Text(row.requirement, style="dim")] if wide else []))
    return table


def _print_files(console: Console, folder: Path) -> None:
    shown = _shortest(folder)
    report = folder / "report.html"
    others = [name for name in ("signals.mf4", "frames.blf", "verdict.json", "junit.xml") if (folder / name).exists()]
    console.print()
    if report.exists():
        console.print(f"report: {shown}/report.html", soft_wrap=True, highlight=False)
    if others:
        console.print(f"files:  {shown}/ {' '.join(others)}", soft_wrap=True, highlight=False)
    if report.exists():
        console.print(f"next:   bench report {shown} --open", soft_wrap=True, highlight=False)
    elif (folder / "run.json").exists():
        console.print(f"next:   bench recover {shown}", soft_wrap=True, highlight=False)


def _shortest(folder: Path) -> str:
    """Path relative to the working directory where that is shorter."""
    relative = os.path.relpath(folder)
    return relative if len(relative) < len(str(folder)) else str(folder)
