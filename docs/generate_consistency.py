"""Write docs/estimators_consistency.md: ``python docs/generate_consistency.py``, some ten seconds."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "estimators")]

PAGE = ROOT / "docs" / "estimators_consistency.md"

HEAD = """# Consistency of the filters

Made by `python docs/generate_consistency.py`; `tests/estimators/test_consistency.py` asserts the first part. A filter
is consistent where its errors are as large as it says: the mean over independent runs of NEES (e' P⁻¹ e of the state)
and of NIS (the same of the innovation) then lies inside the band of 95 % of a chi-square distribution (Bar-Shalom, Li,
Kirubarajan 2001, 5.4). 60 runs each, one value per run.

## Where the noise model is true

Truth, process noise, sensor noise and initial error are drawn from the filter's own model. The core runs on a pendulum
of unknown stiffness, the force EKF as shipped through its own tick (inputs, start, correction).

"""

REPORTED = """
## Where it cannot be

A stop with ABS on the tests' own car, 1 s after the brake; NEES over speed and both friction limits.

"""

REASONS = """
Why these are outside:

- **NIS.** Of the eight rows of a friction filter three are sensors. Rows 4 and 5 demand that the slip equation holds,
  rows 6 and 7 repeat that k0 is 1, row 8 is the filter's own last speed plus the accelerometer: constants and echoes
  without a noise of their own. Eight degrees of freedom are counted, three are noisy; the mean stays below one.
- **NEES with torques.** The process noise stands for what any car does, while the limits of the tests' car are
  constant: the EKF says it is less sure than it is. The UKF's slip noise is four times smaller, and its bias of the
  limits (sigma points around the peak of the curve) is not in P.
- **NEES without torques.** The split of k0 between the axles is not observable (3.6.9); rows 6 and 7 set it and let P
  shrink although nothing has been learned. The load-weighted mean is right.
- **Row 8** feeds the speed back as if it were measured: `speed_std` says how well the filter agrees with itself.

The slip slope, the cornering stiffness and the simple evaluation have no covariance of a state; their `_std` is that of
a regression or a mean.
"""


def _row(name: str, found: object) -> list[str]:
    lines = []
    for label in ("nees", "nis"):
        statistic = getattr(found, label)
        inside = "yes" if statistic.inside else "no"
        band = f"{statistic.low:.2f} … {statistic.high:.2f}"
        lines.append(f"| {name} | {label.upper()} | {statistic.mean:.2f} | {band} | {inside} |")
    return lines


def page() -> str:
    """Text of the page."""
    import consistency_runs as runs

    table = ["| Filter | Statistic | Mean | Band of 95 % | Inside |", "|---|---|---:|---|---|"]
    names = {"ekf": "core, EKF", "ukf": "core, UKF", "ckf": "core, CKF"}
    true = [line for kind, name in names.items() for line in _row(name, runs.core(kind))]
    true += _row("`force_ekf`", runs.force_ekf())
    reported = _row("`friction_ekf`, torques known", runs.friction("friction_ekf"))
    reported += _row("`friction_ekf`, Z2", runs.friction("friction_ekf", {"torque_mode": "z2"}))
    reported += _row("`friction_ukf`, torques known", runs.friction("friction_ukf"))
    return HEAD + "\n".join([*table, *true]) + "\n" + REPORTED + "\n".join([*table, *reported]) + "\n" + REASONS


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
