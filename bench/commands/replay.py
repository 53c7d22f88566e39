"""``bench replay``: a recording through the dashboard."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json


def replay(
    run: Annotated[str, typer.Argument(help="Run folder, or its name under runs/.")],
    at: Annotated[float, typer.Option(help="Begin at this time of the run.", metavar="SECONDS")] = 0.0,
    speed: Annotated[float, typer.Option(help="1 is the pace at which it happened.", metavar="FACTOR")] = 1.0,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the dashboard at --at into this SVG file and end.", metavar="FILE")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Play a recording through the dashboard. With --json all signals at --at are printed instead.

    Example: bench replay runs/stops-dry-20260302-101112 --at 1.8 --speed 0.2
    """
    from bench.dashboard import replay as player

    if as_json:
        print_json(player.instant(run, at_s=at))
        return
    if picture is not None:
        typer.echo(f"picture: {player.replay_picture(run, picture, at_s=at)}")
        return
    player.replay(run, at_s=at, speed=speed)
