"""``bench compare``: two runs beside each other."""

import json
from pathlib import Path
from typing import Annotated

import typer


def compare(
    a: Annotated[str, typer.Argument(help="Run folder, or its name under runs/.", metavar="RUN_A")],
    b: Annotated[str, typer.Argument(help="The run to compare it with.", metavar="RUN_B")],
    out: Annotated[
        Path | None,
        typer.Option(help="Page with the signals over each other; default: beside RUN_A.", metavar="FILE"),
    ] = None,
    open_page: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The comparison as JSON on standard output.")] = False,
) -> None:
    """Compare two runs: figures, criteria, settings, and a page that draws their signals over each other.

    Example: bench compare stops-dry-20260302-101112 stops-no_ecu-20260302-101530 --open
    """
    from bench.comparison.compare import compare as compare_runs
    from bench.comparison.compare import print_comparison
    from bench.comparison.overlay_page import build_page, default_page
    from bench.report.run_reading import load_run
    from bench.report.summary import output_console

    comparison = compare_runs(load_run(a), load_run(b))
    page = build_page(comparison, out or default_page(comparison))
    if as_json:
        typer.echo(json.dumps(comparison.as_json() | {"page": str(page)}, indent=2))
    else:
        print_comparison(comparison, output_console())
        typer.echo(f"\npage: {page}")
    if open_page:
        typer.launch(page.absolute().as_uri())
