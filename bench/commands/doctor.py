"""``bench doctor``: what this machine can do, and the command that mends what it cannot."""

from typing import Annotated

import typer

from bench.commands.options import JsonOption, finish, print_json


def doctor(
    strict: Annotated[bool, typer.Option("--strict", help="Exit code 1 if a line says warn.")] = False,
    benchmark: Annotated[
        bool, typer.Option("--benchmark", help="Also measure the speed of the bench on this machine (a minute or two).")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Say what this machine can do, and the command that mends what it cannot: CAN, rights, timer, disk, browser.

    Examples: bench doctor

    bench doctor --strict --json
    """
    from bench.doctor import findings, line

    found = []
    for finding in findings(benchmark=benchmark):
        found.append(finding)
        if not as_json:
            print(line(finding), flush=True)
    if as_json:
        print_json([vars(finding) for finding in found])
    finish(1 if strict and any(finding.state == "warn" for finding in found) else 0)
