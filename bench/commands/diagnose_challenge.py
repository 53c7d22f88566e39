"""``bench diagnose challenge``: how often the diagnosis is right on cases whose hidden effect nobody told it."""

import os
from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, finish, print_json

FIGURE_MISSED = 1


def challenge(
    seed: Annotated[
        int,
        typer.Option(min=0, help="Below 10000 for tuning; from 1000000 on for the published table, each once."),
    ],
    n: Annotated[int, typer.Option("--n", min=1, help="Number of cases.")] = 20,
    family: Annotated[
        str | None, typer.Option(help="One family only, such as single, pair, data_fault, unknown, clean.")
    ] = None,
    generator: Annotated[str, typer.Option(help="first, or second with another tyre curve.")] = "first",
    jobs: Annotated[int | None, typer.Option(min=1, help="Worker processes; default: one per core.")] = None,
    gain: Annotated[
        bool, typer.Option("--gain/--no-gain", help="Compare held-out gains with those of the true effect.")
    ] = True,
    plan: Annotated[
        bool, typer.Option("--plan/--no-plan", help="Record look-alikes again with what was proposed to separate them.")
    ] = True,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keep cases, answers and score here; a broken-off run goes on."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Let a generator that shares no code with the bench hide effects in logs, diagnose them, and score the answers.

    Labels are sealed until all answers are in. Prints the figures with their intervals, the confusion matrix and the
    reliability of the stated probabilities. Exit code 1 where a required figure is missed.

    Example: bench diagnose challenge --seed 7 --n 10 --family single
    """
    from bench.challenge import run_challenge
    from bench.challenge.printing import reliability_picture, text_of
    from bench.diagnosis.progress import SearchProgress

    with SearchProgress() as progress:
        result = run_challenge(
            seed=seed,
            count=n,
            family=family,
            generator=generator,
            jobs=jobs or os.cpu_count() or 1,
            out=out,
            measure_gain=gain,
            check_plans=plan,
            progress=progress,
        )
    if out is not None:
        reliability_picture(result.figures.bins, f"seed {seed}, {n} cases", out / "reliability.svg")
    if as_json:
        print_json(result.as_json())
    else:
        print(text_of(result))
    finish(FIGURE_MISSED if result.figures.missed else 0)
