"""Write docs/estimators_consistency.md: ``python docs/generate_consistency.py``, some ten seconds."""

import sys
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "estimators"), str(ROOT / "tests" / "acceptance")]

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

LATERAL = """
The lateral filter of the vehicle-state document in the dry slalom (`state/slalom_dry_asphalt`), one step while the car
turns in; NEES over lateral speed and yaw rate, five rows of the measurement in use.

"""

LATERAL_REASONS = """
Why these are outside:

- **NEES.** No row measures the lateral speed. Its error is 0.07 ± 0.016 m/s over the seeds: a shift that every run has,
  not noise, where P knows only the process noise and says 0.006 m/s. The document's semi-implicit step puts the lateral
  speed some 20 ms ahead ([why](models/vehicle_state.md#friction-curves)), 0.03 m/s at this tick; beside it stand limits
  of 0.69 in front where 0.95 is true, which P believes within 0.01. `lateral_speed_std` tells how closely the filter
  follows its model, not how far off that is.
- **NIS.** Four of the five rows are pseudo measurements: the friction in use divided by slip angle or curve of the
  filter's own last state. What is wrong with that state is in measurement and prediction alike; what the low-pass of
  accelerometer and slip angles leaves goes on from step to step. White noise, as R has it, is none of it.

The sliding-mode observers, the fits, the grade observer, the filters of loads with a fixed gain and the force observers
with a network have no covariance of a state. `vertical_load_ukf` is inside where its noise model is true (L-14 in
[traceability.csv](traceability.csv)).
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
    from state_consistency import lateral_filter

    table = ["| Filter | Statistic | Mean | Band of 95 % | Inside |", "|---|---|---:|---|---|"]
    names = {"ekf": "core, EKF", "ukf": "core, UKF", "ckf": "core, CKF"}
    true = [line for kind, name in names.items() for line in _row(name, runs.core(kind))]
    true += _row("`force_ekf`", runs.force_ekf())
    reported = _row("`friction_ekf`, torques known", runs.friction("friction_ekf"))
    reported += _row("`friction_ekf`, Z2", runs.friction("friction_ekf", {"torque_mode": "z2"}))
    reported += _row("`friction_ukf`, torques known", runs.friction("friction_ukf"))
    lateral = _row("`vehicle_state_ukf`", SimpleNamespace(**dict(zip(("nees", "nis"), lateral_filter(), strict=True))))
    friction = "\n".join([*table, *reported]) + "\n" + REASONS
    return (
        HEAD
        + "\n".join([*table, *true])
        + "\n"
        + REPORTED
        + friction
        + LATERAL
        + "\n".join([*table, *lateral])
        + "\n"
        + LATERAL_REASONS
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
