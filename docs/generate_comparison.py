"""Write docs/estimators_comparison*.md: ``python docs/generate_comparison.py [GROUP]``, some minutes for each group."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

DOCS = ROOT / "docs"
IMAGES = DOCS / "images" / "comparison"


@dataclass(frozen=True)
class ComparisonPage:
    """A group's page: file, cars by the name that their pictures have (plant, title), text before the figures."""

    file: str
    cars: Mapping[str, tuple[str | None, str]]
    head: str


PAGES = {
    "friction": ComparisonPage(
        "estimators_comparison.md",
        {
            "friction_mujoco": ("mujoco", "The MuJoCo car"),
            "friction_single_track": ("single_track", "The document's single-track car"),
        },
        """# The friction estimators on the same stops

Made by `python docs/generate_comparison.py friction`, which is `bench estimators compare --group friction` on both
cars. Root mean squared errors over the braking phase; times until the estimate stays within ±10 %; the documents'
figures beside. All estimators run over the decoded signals of the same run with the shipped settings, only
`…_pitch_corrected` is told how far the nose of the MuJoCo car dips (`pitch_gradient`). Other groups:
[vehicle state](estimators_comparison_state.md).

What to read off it:

- On the document's car the filters meet its figures with known torques. On the MuJoCo car the body pitches into the
  accelerometer: 0.3 to 0.6 m/s of speed, which slip and limits inherit; the pitch correction takes most of it away
  ([reasons](acceptance.md#reasons)).
- Without torques the split between the axles is a guess, and under ABS on the pitching car the limits swing.
- The unscented filter gains little over the extended one and costs two to three times as much.
- The force EKF has its speed from the wheels that rolled before the brake: what the accelerometer of the pitching car
  reads too much moves it little, and `speed_confidence` says that both contradict each other. Its forces stay right
  while wheels turn; with both axles locked only their sum is observed.
- The slip slope and the simple evaluation tell the friction in use nearly as well as the filters, but not the axles.
- Split friction: one value per axle cannot be right for both wheels. Without an ABS the MuJoCo car turns by 117
  degrees, and a filter that knows one direction has nothing to follow: 1.4 to 1.8 m/s with every one of them.
- Without an ABS nothing hears the jump but the accelerometer: all filters see it, and share it wrongly between the
  axles, whose wheels stand alike.
- The cornering-stiffness method is for bends: straight stops give it the figures of a car that does not turn, without
  torques and with locked wheels it waits. Split friction turns the car by its brakes, which its side forces are not.
""",
    ),
    "state": ComparisonPage(
        "estimators_comparison_state.md",
        {"state": (None, "The document's planar car, and the stops on the MuJoCo car")},
        """# The vehicle-state observers on the same runs

Made by `python docs/generate_comparison.py state`, which is `bench estimators compare --group state`. Root mean squared
errors, over the braking phase where the driver brakes, else over the whole run; the document's figures beside. All
observers run over the decoded signals of the same run with the shipped settings. Other groups:
[friction](estimators_comparison.md).

What to read off it:

- Slaloms: the cascade is better than the lateral filter alone in speed and slip angles, least so on ice. The bend with
  friction jumps turns it round: there the filter alone keeps its slip angles within 0.3 degrees, the cascade is four
  times as far off.
- Friction limits start at 0.6 and are nobody's before the first fit (confidence 0): where hardly a wheel makes a side
  force, in launches, hills and stops, they stay there. Root mean squared errors over the whole run contain that time;
  what a fit is worth stands in [vehicle state](models/vehicle_state.md).
- Launches and hill: speed within 0.18 m/s, also for the lateral filter, which has only the odometer.
- Stops: the observers are defined for traction. Without the brakes' torque their wheel models run 5 to 16 m/s off and
  `traction_only` says so; the odometer of the lateral filter is 0.5 to 2.5 m/s off with an ABS, and nothing tells the
  speed with locked wheels, on any road. `..._known_torque` takes nominal gain times wheel pressures: no better than
  the odometer, since all four wheels slip, and what is missing in its speed it takes for a slope (0.16 to 0.23).
""",
    ),
}


def page(group: str) -> str:
    """Text of a group's page; pictures are written on the way."""
    from bench.estimation.comparison import compare_group
    from bench.estimation.comparison_output import draw, text_of
    from bench.estimation.groups import group_of

    parts = [PAGES[group].head]
    IMAGES.mkdir(parents=True, exist_ok=True)
    for picture, (plant, title) in PAGES[group].cars.items():
        result = compare_group(group, group_of(group), plant=plant, progress=_say)
        draw(IMAGES / f"{picture}.png", result)
        parts.append(f"## {title}\n\n![errors on {title.lower()}](images/comparison/{picture}.png)\n")
        parts.append(f"```text\n{text_of(result)}\n```\n")
    return "\n".join(parts)


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def main() -> int:
    """Write the pages of the groups that were named, or all."""
    groups = sys.argv[1:] or list(PAGES)
    if unknown := [group for group in groups if group not in PAGES]:
        print(f"{', '.join(unknown)}: no such page; there are {', '.join(PAGES)}")
        return 2
    for group in groups:
        file = DOCS / PAGES[group].file
        file.write_text(page(group), encoding="utf-8")
        print(file.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
