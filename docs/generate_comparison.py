"""Write docs/estimators_comparison.md: ``python docs/generate_comparison.py``, some minutes for both cars."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

PAGE = ROOT / "docs" / "estimators_comparison.md"
IMAGES = ROOT / "docs" / "images" / "comparison"
PLANTS = {"mujoco": "The MuJoCo car", "single_track": "The document's single-track car"}

HEAD = """# The friction estimators on the same stops

Made by `python docs/generate_comparison.py`, which is `bench estimators compare --group friction` on both cars. Root
mean squared errors over the braking phase; times until the estimate stays within ±10 %; the documents' figures beside.
All estimators run over the decoded signals of the same run with the shipped settings, only `…_pitch_corrected` is told
how far the nose of the MuJoCo car dips (`pitch_gradient`).

What to read off it:

- On the document's car the filters meet its figures with known torques. On the MuJoCo car the body pitches into the
  accelerometer: 0.3 to 0.6 m/s of speed, which slip and limits inherit; the pitch correction takes most of it away
  ([reasons](acceptance.md#reasons)).
- Without torques the split between the axles is a guess, and under ABS on the pitching car the limits swing.
- The unscented filter gains little over the extended one and costs two to three times as much.
- The force EKF has no row that ties its speed: an accelerometer that reads too much deceleration is explained by drag,
  that is by a higher speed. Its forces stay right while wheels turn; with both axles locked only their sum is observed.
- The slip slope and the simple evaluation tell the friction in use nearly as well as the filters, but not the axles.
- Split friction: one value per axle cannot be right for both wheels.
"""


def page() -> str:
    """Text of the page; pictures are written on the way."""
    from bench.estimation.comparison import compare_group
    from bench.estimation.comparison_output import draw, text_of
    from bench.estimation.groups import group_of

    parts = [HEAD]
    for plant, title in PLANTS.items():
        result = compare_group("friction", group_of("friction"), plant=plant, progress=_say)
        IMAGES.mkdir(parents=True, exist_ok=True)
        draw(IMAGES / f"friction_{plant}.png", result)
        parts.append(f"## {title}\n\n![errors on {title.lower()}](images/comparison/friction_{plant}.png)\n")
        parts.append(f"```text\n{text_of(result)}\n```\n")
    return "\n".join(parts)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
