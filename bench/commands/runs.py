"""``bench runs``: what has been run."""

import json
from pathlib import Path
from typing import Annotated

import typer


def runs(
    folder: Annotated[Path, typer.Argument(help="Folder with run folders.")] = Path("runs"),
    as_json: Annotated[bool, typer.Option("--json", help="The table as JSON on standard output.")] = False,
) -> None:
    """List the runs of a folder with verdict and key figures, the newest last.

    Example: bench runs results
    """
    from bench.comparison.runs import list_runs, runs_table
    from bench.report.summary import output_console

    entries = list_runs(folder)
    if as_json:
        typer.echo(json.dumps([entry.as_json() for entry in entries], indent=2))
    elif entries:
        output_console().print(runs_table(entries, folder))
    else:
        typer.echo(f"{folder}: no runs yet; make one: bench run stops/dry")
