"""``bench judge``: other criteria on a recording that is already there."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, finish, print_json


def judge(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or a log that another tool measured.")],
    criteria: Annotated[str, typer.Option(metavar="FILE", help="Criteria file, or a scenario with criteria.")],
    channels: Annotated[Path | None, typer.Option(metavar="FILE", help="Channel map of a foreign log.")] = None,
    vehicle: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="Car, for the wheel radius of a measured file.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write verdict.json and junit.xml there.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Judge a recording again, also one that another tool has measured.

    Examples: bench judge runs/stops-dry-20260302-101112 --criteria stricter.yaml

    bench judge drive.mf4 --criteria stop.yaml --channels channels.yaml --out judged
    """
    from bench.report import print_summary
    from bench.verdict import judge_recording

    verdict = judge_recording(run, criteria, channels=channels, vehicle=vehicle)
    if out is not None:
        from bench.verdict.output_files import write_verdict

        out.mkdir(parents=True, exist_ok=True)
        write_verdict(out, verdict)
    if as_json:
        print_json(verdict.as_json())
    else:
        print_summary(out or (run if run.is_dir() else run.parent), verdict.as_json())
    finish(verdict.exit_code)
