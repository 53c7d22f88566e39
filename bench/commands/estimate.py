"""``bench estimate``: estimators on a recording or a measured log."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json


def estimate(
    log: Annotated[str, typer.Argument(metavar="LOG", help="Folder of a run, its recording, or any measured log.")],
    estimator: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Estimator, or NAME_ANYTHING for a second one of its kind; repeat."),
    ] = None,
    vehicle: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="Car; without it that of the recording's scenario.")
    ] = None,
    channels: Annotated[Path | None, typer.Option(metavar="FILE", help="Channel map of a measured log.")] = None,
    sets: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Setting, as in a scenario; NAME.KEY for one of several."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Default: estimates/ in the run's folder, or estimates/LOG for another log."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Run estimators over a recording of the bench or a measured log.

    A recording brings its car and the settings of its scenario, and gives what the live estimators gave, bit for bit. A
    measured log needs a channel map and a car. Every estimator with its signals and keys: docs/estimators.md.

    Examples: bench estimate runs/stops-dry-20260302-101112 --estimator friction_ekf --set torque_mode=z2

    bench estimate drive.mf4 --channels map.yaml --vehicle asphalt_car --estimator simple_braking --out estimates
    """
    from bench.estimation.command import estimate_log

    result = estimate_log(log, estimator or [], vehicle=vehicle, channels=channels, sets=sets or [], out=out)
    if as_json:
        print_json(result.as_json())
    else:
        print(result.text())
