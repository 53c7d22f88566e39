"""Scores of several runs as one: what a table over hundreds of cases needs days for is run in parts."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bench.challenge.scoring import CaseScore
from signals.errors import InputError


def read_score(file: Path) -> dict[str, Any]:
    """Content of a ``score.json``.

    Raises
    ------
    InputError
        Where it is none.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read as JSON", found=str(error)) from None
    lacking = {"seed", "n", "family", "generator", "code", "cases"} - set(content if isinstance(content, dict) else ())
    if lacking:
        raise InputError(f"{file}: no score of a challenge", found=f"no {', '.join(sorted(lacking))}")
    return dict(content)


class SeededCase(NamedTuple):
    """A scored case and the seed of its run."""

    seed: int
    score: CaseScore


def merged_cases(scores: Mapping[Path, Mapping[str, Any]]) -> list[SeededCase]:
    """Cases of all scores together, each once, by the first score that has it.

    A run of one family has the cases of that family that the mixture of its seed has under the same numbers.

    Raises
    ------
    InputError
        Where two scores are of the same seed, family and generator, or of different code, or a case is none.
    """
    runs: dict[tuple[object, ...], Path] = {}
    codes: dict[str, Path] = {}
    for file, score in scores.items():
        run = score["seed"], score["family"], score["generator"]
        if run in runs:
            raise InputError(f"{file}: the same run as {runs[run]}", mend="give each score once")
        runs[run] = file
        codes.setdefault(score["code"], file)
    if len(codes) > 1:
        found = ", ".join(f"{code} in {file}" for code, file in codes.items())
        raise InputError("scores of different code", found=found, mend="run the parts again with one version")
    cases: dict[tuple[object, ...], SeededCase] = {}
    for file, score in scores.items():
        for plain in score["cases"]:
            one = _case(file, plain)
            cases.setdefault((score["seed"], score["generator"], one.family, one.case), SeededCase(score["seed"], one))
    return list(cases.values())


def _case(file: Path, plain: Mapping[str, Any]) -> CaseScore:
    try:
        stated = [(float(probability), bool(right)) for probability, right in plain["stated"]]
        return CaseScore(**{**plain, "stated": stated})
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{file}: a case that no run of this version writes", found=str(error), mend="run it again"
        ) from None
