"""Write docs/challenge_limits.md: the size from which each effect is seen, theory beside measurement.

python docs/generate_challenge.py [SCORE.json ...]       # score.json of runs of `bench diagnose challenge --out DIR`
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/challenge_limits.md"

HEAD = """# Sizes from which effects are seen

Made by `python docs/generate_challenge.py`. Sizes are in nominal scatters. *Theory*: linear test on the generator's own
model in the six shipped manoeuvres, evidence of 8 needed, form errors counted as half of each sensor's noise correlated
over 0.2 s ([challenge.md](challenge.md)). Where only its scatter hides an effect the limit is √(2·8) = 4.0 scatters.
A steering linkage 55 % softer yields 2.2 times as much: its limit in small steps lies above the sizes that are drawn.
*Measured*: smallest size named (alone or in a justified group) and largest not named, over the scored cases.

| Effect | One scatter | Theory | Drawn from … to | Smallest named | Largest not named | Cases |
|---|---|---|---|---|---|---|
"""


def page(limits: Sequence[dict[str, Any]], scores: Sequence[dict[str, Any]]) -> str:
    """The page for a table of limits and the scored runs."""
    lines = []
    for row in limits:
        seen = [score["sizes"][row["effect"]] for score in scores if row["effect"] in score["sizes"]]
        smallest = min((s["smallest_seen"] for s in seen if s["smallest_seen"] is not None), default=None)
        largest = max((s["largest_unseen"] for s in seen if s["largest_unseen"] is not None), default=None)
        scatter = f"{100 * row['scatter']:g} %" if row["unit"] == "1" else f"{row['scatter']:g} {row['unit']}"
        lines.append(
            f"| `{row['effect']}` | {scatter} | {row['limit']:.1f} | {row['smallest']:g} … {row['largest']:g} "
            f"| {_text(smallest)} | {_text(largest)} | {sum(s['cases'] for s in seen)} |"
        )
    return HEAD + "\n".join(lines) + "\n"


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def main(score_files: Sequence[str]) -> None:
    """Ask the generator for the theory, read the scores, write the page."""
    words = [sys.executable, str(ROOT / "tests/blind/generate.py"), "limits"]
    limits = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    scores = [json.loads(Path(file).read_text(encoding="utf-8")) for file in score_files]
    PAGE.write_text(page(limits, scores), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
