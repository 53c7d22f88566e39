"""``bench recover``: a finished folder out of what a killed run has left."""

from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json


def recover(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run that did not end in order.")],
    as_json: JsonOption = False,
) -> None:
    """Save what a killed run has recorded; its verdict becomes "error".

    Example: bench recover runs/stops-dry-20260302-101112
    """
    from bench.recording.recover import recover as recover_run

    saved = recover_run(run)
    if as_json:
        print_json({**vars(saved), "folder": str(saved.folder), "remarks": list(saved.remarks)})
    elif saved.already_finished:
        print(f"{run}: the run had ended in order, nothing to recover")
    else:
        print(f"{run}: {saved.rows} rows and {saved.frames} frames up to {saved.last_time_s:.3f} s")
        for remark in saved.remarks:
            print(f"  {remark}")
