"""``bench estimators``: what there is, and how the members of a group compare."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json

app = typer.Typer(
    help="Estimators: what there is, how they compare.", no_args_is_help=True, rich_markup_mode="markdown"
)


@app.callback()
def estimators() -> None:
    """Estimators: what there is, how they compare."""


@app.command("list")
def list_estimators(as_json: JsonOption = False) -> None:
    """List the estimators by group, with what they give.

    Example: bench estimators list
    """
    from estimators import describe, groups

    if as_json:
        print_json(
            [
                {"name": name, "group": group, "summary": describe(name).summary, "source": describe(name).source}
                for group, members in groups().items()
                for name in members
            ]
        )
        return
    for group, members in groups().items():
        print(group)
        for name in members:
            print(f"  {name:<24} {describe(name).summary}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


@app.command("compare")
def compare(
    group: Annotated[str, typer.Option(metavar="NAME", help="Group of estimators.")] = "friction",
    plant: Annotated[
        str | None, typer.Option(metavar="NAME", help="mujoco or single_track, in place of the scenarios' own.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Default: comparison/estimators-GROUP.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare all estimators of a group on the same stops: error, time to ±10 %, jumps, cost of a step.

    Example: bench estimators compare --group friction
    """
    from bench.estimation.comparison import compare_group
    from bench.estimation.comparison_output import text_of, write_group_comparison
    from bench.estimation.groups import group_of

    result = compare_group(group, group_of(group), plant=plant, progress=_say)
    folder = out or Path("comparison") / f"estimators-{group}"
    write_group_comparison(folder, result)
    if as_json:
        print_json(result.as_json() | {"folder": str(folder)})
    else:
        print(text_of(result))
        print(f"files: {folder}")
