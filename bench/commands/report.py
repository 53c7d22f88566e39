"""``bench report``: the page of a run."""

import json
from pathlib import Path
from typing import Annotated

import typer


def report(
    run: Annotated[str, typer.Argument(help="Run folder, or its name under runs/.")],
    open_page: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
    picture: Annotated[
        Path | None, typer.Option(help="Also draw the main signals into this file (.png, .svg, .pdf).", metavar="FILE")
    ] = None,
    render: Annotated[
        bool, typer.Option("--render", help="Show the car as MuJoCo renders it in the strip; takes some seconds.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Paths of the files on standard output, nothing else.")
    ] = False,
) -> None:
    """Make report.html of a run again, from its recording.

    Example: bench report runs/stops-dry-20260302-101112 --open
    """
    from bench.report import build, draw_picture

    page = build(run, render=render)
    drawn = draw_picture(run, picture) if picture is not None else None
    if as_json:
        typer.echo(json.dumps({"report": str(page), "picture": str(drawn) if drawn else None}))
    else:
        typer.echo(f"report: {page}")
        if drawn is not None:
            typer.echo(f"picture: {drawn}")
    if open_page:
        typer.launch(page.absolute().as_uri())
