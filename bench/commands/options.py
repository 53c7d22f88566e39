"""Options that several subcommands share, and what they print."""

import json
import sys
from typing import Annotated, Any

import typer

from signals.errors import INTERRUPTED, BenchError


class Interrupted(BenchError):
    """Ctrl-C during a run; ``folder`` holds what was recorded until then, if it had begun."""

    exit_code = INTERRUPTED

    def __init__(self, folder: str) -> None:
        super().__init__(f"interrupted; the recording is in {folder}" if folder else "interrupted")


JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON on standard output and nothing else there.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="A field of the scenario or a parameter of car or road; repeat."),
]


def print_json(data: Any) -> None:
    """Print plain data as JSON."""
    sys.stdout.write(json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False) + "\n")


def finish(code: int) -> None:
    """End the command with an exit code."""
    if code:
        raise typer.Exit(code)
