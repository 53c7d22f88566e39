"""``bench check``: validate files of any kind."""

from typing import Annotated

import typer

from bench.commands.options import JsonOption, finish, print_json


def check(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE…",
            help="A file of any kind that the bench reads, or the id of a scenario.",
        ),
    ],
    as_json: JsonOption = False,
) -> None:
    """Check files: every fault with file, line, column, what was found and what is allowed.

    Examples: bench check my.yaml

    bench check stops/dry car.yaml road.yaml my.dbc
    """
    from bench.scenario.file_kinds import check_file
    from signals.errors import FileFaults, InputError

    results = []
    broken = []
    for file in files:
        try:
            checked = check_file(file)
            results.append({"file": file, "kind": checked.kind, "ok": True, "note": checked.note, "faults": []})
        except InputError as error:
            faults = error.faults if isinstance(error, FileFaults) else ()
            entries = [vars(fault) for fault in faults] or [{"file": file, "problem": error.message}]
            results.append({"file": file, "ok": False, "faults": entries})
            broken.append(error)
    if as_json:
        print_json(results)
        finish(2 if broken else 0)
        return
    for result in results:
        if result["ok"]:
            print(f"ok  {result['file']}: {result['kind']}{result['note']}")
    if broken:
        raise InputError("\n".join(_whole(error) for error in broken))


def _whole(error: Exception) -> str:
    from signals.errors import FileFaults

    return error.message if isinstance(error, FileFaults) else str(error)
