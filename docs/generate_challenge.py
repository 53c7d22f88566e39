"""Write what the challenge's published scores say: ``python docs/generate_challenge.py``.

docs/challenge_scores/*.json are ``score.json`` of runs of `bench diagnose challenge --out DIR` at seeds of the table.
docs/challenge_figures.md: all figures over those of the first generator; docs/challenge_figures_second.md: over those
of the second; docs/challenge_limits.md: the size from which each effect is seen, by cases of the first.
"""

import json
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bench.challenge.figures import Sizes, figures_of  # noqa: E402
from bench.challenge.merging import merged_cases, read_score  # noqa: E402
from bench.challenge.misses import misses_of  # noqa: E402
from bench.challenge.printing import table_row  # noqa: E402

SCORES = ROOT / "docs/challenge_scores"
LIMITS = ROOT / "docs/challenge_limits.md"
FIGURES = {
    "first": ROOT / "docs/challenge_figures.md",
    "second": ROOT / "docs/challenge_figures_second.md",
}

LIMITS_HEAD = """# Sizes from which effects are seen

Made by `python docs/generate_challenge.py`. Sizes are in nominal scatters. *Theory*: linear test on the generator's own
model in the six shipped manoeuvres, evidence of 8 needed, form errors counted as half of each sensor's noise correlated
over 0.2 s ([challenge.md](challenge.md)). Where only its scatter hides an effect the limit is √(2·8) = 4.0 scatters.
A steering linkage 55 % softer yields 2.2 times as much: its limit in small steps lies above the sizes that are drawn.
*Measured*: smallest size named (alone or in a justified group) and largest not named, over the scored cases.

| Effect | One scatter | Theory | Drawn from … to | Smallest named | Largest not named | Cases |
|---|---|---|---|---|---|---|
"""


def limits_page(limits: Sequence[dict[str, Any]], scores: Mapping[Path, Mapping[str, Any]]) -> str:
    """The page for a table of limits and the scored runs."""
    sizes = figures_of([case.score for case in merged_cases(scores)]).sizes
    lines = []
    for row in limits:
        seen = sizes.get(row["effect"], Sizes(0, None, None))
        scatter = f"{100 * row['scatter']:g} %" if row["unit"] == "1" else f"{row['scatter']:g} {row['unit']}"
        lines.append(
            f"| `{row['effect']}` | {scatter} | {row['limit']:.1f} | {row['smallest']:g} … {row['largest']:g} "
            f"| {_text(seen.smallest_seen)} | {_text(seen.largest_unseen)} | {seen.cases} |"
        )
    return LIMITS_HEAD + "\n".join(lines) + "\n"


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


FIGURES_HEAD = """# Figures of the blind challenge

Made by `python docs/generate_challenge.py` from `docs/challenge_scores/`, all of code `{code}`; what each figure means:
[challenge.md](challenge.md). Seeds and looks: {looks}.

| Figure | Required | Found | 95 % interval | Cases | |
|---|---|---|---|---|---|
"""


MISSES_HEAD = """Size: scatters of the larger effect. *Surplus*: causes that are not hidden, more likely than not.

| Seed/case | Family | Hidden | Size | Answered | Wrong |
|---|---|---|---|---|---|
"""


def figures_page(scores: Mapping[Path, Mapping[str, Any]]) -> str:
    """The page of figures over these scores, by file."""
    seeded = merged_cases(scores)
    cases = [case.score for case in seeded]
    figures = figures_of(cases)
    looks = "; ".join(
        f"{score['seed']} ({score['family'] or 'mixture'}, {score['n']}, {score['generator']} generator)"
        for score in scores.values()
    )
    code = next(iter(scores.values()))["code"]
    lines = [FIGURES_HEAD.format(code=code, looks=f"{len(scores)}: {looks}").rstrip()]
    lines += [table_row(figure) for figure in figures.shares if figure.count]
    counted = Counter(case.family for case in cases)
    lines += ["", "Cases: " + ", ".join(f"{name} {count}" for name, count in sorted(counted.items())) + "."]
    lines += ["", "## Hidden and answered", "", "| Hidden | Answered |", "|---|---|"]
    for hidden, answers in figures.confusion.items():
        lines.append(f"| {hidden} | " + ", ".join(f"{name} {count}" for name, count in answers.items()) + " |")
    lines += ["", "## Reliability of stated probabilities", "", "| Stated | Right | Statements |", "|---|---|---|"]
    lines += [f"| {part.stated:.2f} | {part.right:.2f} | {part.count} |" for part in figures.bins]
    lines += ["", "## What went wrong", "", MISSES_HEAD.rstrip()]
    for seed, case in seeded:
        if wrong := misses_of(case):
            size = f"{case.units:.1f}" if case.units else "–"
            place = f"{seed}/{int(case.case.removeprefix('case_'))}"
            lines.append(f"| {place} | {case.family} | {case.hidden} | {size} | {case.answer} | {'; '.join(wrong)} |")
    return "\n".join(lines) + "\n"


def pages(limits: Sequence[dict[str, Any]], scores: Mapping[Path, Mapping[str, Any]]) -> dict[Path, str]:
    """All pages by their files, each generator's figures on its own."""
    of_generator = {
        name: {file: score for file, score in scores.items() if score["generator"] == name} for name in FIGURES
    }
    figures = {FIGURES[name]: figures_page(of_it) for name, of_it in of_generator.items() if of_it}
    return {LIMITS: limits_page(limits, of_generator["first"]), **figures}


def main() -> None:
    """Ask the generator for the theory, read the scores, write the pages."""
    scores = {file: read_score(file) for file in sorted(SCORES.glob("*.json"))}
    words = [sys.executable, str(ROOT / "tests/blind/generate.py"), "limits"]
    limits = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    for page, text in pages(limits, scores).items():
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
