"""Write docs/estimators_robustness.md and its charts: ``python docs/generate_robustness.py [NAME …]``.

About forty lock-step runs of a stop and two hundred estimates of them, some minutes. With names only these
perturbations are run, to look at them; the page is then left alone.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

PAGE = ROOT / "docs" / "estimators_robustness.md"
IMAGES = ROOT / "docs" / "images" / "robustness"

HEAD = """# Robustness of the friction estimators

Made by `python docs/generate_robustness.py`. Every run is the stop of `friction/e10_abs_grip_jump` (95 km/h, ABS, car
of Table 8 on the document's single-track plant) without its jump, with one thing other than the estimators assume.
Figures are taken over the braking phase. The estimators keep their shipped settings and the nominal car; nothing is
tuned to a case. What the settings mean: [estimators.md](estimators.md).
"""

REASONS = {
    "mass": (
        "With torques the wheel equations tell the true tyre force, which a heavier car needs more of, while "
        "the accelerometer times the believed mass tells less. The filter resolves the contradiction by a "
        "lower speed, hence less slip, and a higher limit. Without torques force and load scale alike and the "
        "ratio stays."
    ),
    "wheel_radius": (
        "Smaller wheels turn faster: while rolling the speed is too high by as much, and the error lasts "
        "through the stop. Speed and rim speed are wrong alike, so that slip and friction stay nearly right."
    ),
    "grade": (
        "An accelerometer on a slope feels g sin(grade), 0.49 m/s² at 5 %; the filter integrates it. Downhill "
        "its speed falls below that of the wheels, the slip that is left cannot make the force, and the limit "
        "rises to its guard (`largest_friction_limit`). The document assumes a level road (3.6.1); "
        "`road_grade` estimates the slope."
    ),
    "accelerometer_offset": (
        "Integrated by row 8 and read as force by row 1, as on a slope. Without torques nothing but the "
        "accelerometer tells the force, so that the error is twice as large."
    ),
    "sensor_noise": (
        "All noises times 2 and 5: accelerometer 0.25 m/s², pressures 0.5 bar, teeth of the rings misplaced "
        "by 1.5 %. The simple model passes the accelerometer's noise on, the filters average it."
    ),
    "latency": (
        "Everything late alike: speed and friction belong to the past, 0.2 m/s at 20 ms and 10 m/s². The "
        "limit does not move."
    ),
    "lost_frames": "Values are held and rows without a new sample are left out; single losses cost next to nothing.",
    "adaptive_damper": (
        "On the MuJoCo car the body pitches into the accelerometer and the loads swing: that is the step from "
        "the first to the second level ([reasons](acceptance.md#reasons)). Adaptive dampers take a little of "
        "the swing away."
    ),
    "unknown_torque": (
        "Rows 1 to 3 with `torque_mode: z2`: only the load-weighted mean is observable then (3.6.9), and it is as good."
    ),
    "other_car": "Mass, wheelbase, wheels and brakes of the other car are known to the estimators from its file.",
    "grip_jump": "The phase contains the time after the jump in which the estimate follows.",
    "rubber": (
        "k1 and k2 are believed (14.34 in the filter, front 20 and rear 10 in the column of two kinds). A "
        "softer curve needs more slip for the same force: the filter takes the road for a worse one, and a "
        "harder curve for a better."
    ),
    "abs_calibration": "A coarser control swings further; the simple regression follows the swings less well.",
}


def page(only: list[str]) -> str:
    """Text of the page; charts are written on the way."""
    from bench.estimation.robustness import try_all
    from bench.estimation.robustness_cases import plan_of
    from bench.estimation.robustness_output import draw, table

    plan = plan_of("friction")
    parts = [HEAD]
    for result in try_all(plan, only, lambda text: print(text, file=sys.stderr, flush=True)):
        name = result.perturbation.name
        draw(IMAGES / f"{name}.png", plan, result)
        title = result.perturbation.title
        parts.append(f"## {title[0].upper()}{title[1:]}\n\n{REASONS[name]}\n")
        parts.append(f"![{title}](images/robustness/{name}.png)\n\n{table(plan, result)}\n")
    return "\n".join(parts)


def main() -> int:
    """Write the page, or print what was asked for."""
    only = sys.argv[1:]
    text = page(only)
    if only:
        print(text)
    else:
        PAGE.write_text(text, encoding="utf-8")
        print(PAGE.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
