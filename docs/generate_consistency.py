"""Write docs/estimators_consistency.md: ``python docs/generate_consistency.py``, less than a minute."""

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "estimators"), str(ROOT / "tests" / "acceptance")]

PAGE = ROOT / "docs" / "estimators_consistency.md"

HEAD = """# Consistency of the filters

Made by `python docs/generate_consistency.py`; `tests/estimators/test_consistency.py` asserts the first part,
`tests/acceptance/test_filter_consistency.py` that the last one is what is measured. A filter is consistent where its
errors are as large as it says: the mean over independent runs of NEES (e' P⁻¹ e of the state) and of NIS (the same of
the innovation) then lies inside the band of 95 % of a chi-square distribution (Bar-Shalom, Li, Kirubarajan 2001, 5.4).
60 runs each, one value per run.

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


STATISTICS = {"nees": "NEES", "nis": "NIS"}

ATTITUDE = """
## Attitude and force

The attitude filters as shipped (form 2A) on the document's own two-wheeler: 60 random rides of 20 s over slopes, each
with its own turns and noise, judged at the last step; truth behind the sensors' low-pass. NEES of the roll angle alone,
and over all states: both angles, the speed and the offsets. NIS over four rows. The random-walk force filter on the
force document's car (15c): S1 with the document's noise, each run ending at another time from 5 to 20 s; and 3 s in
which forces and speeds are drawn from the filter's own model.

"""

ATTITUDE_REASONS = """
Why these are outside:

- **NIS of one filter.** R is chosen and not measured: the document sets it so that neighbouring virtual offsets differ
  by about 1.7 of what a filter takes for noise (3.5). Behind the low-pass the sensors leave half of it and less. The
  0.4 that stay with sensors without noise are the model: differences for derivatives, an elevation angle one step late.
- **Colour.** The low-pass of 8 Hz makes the noise of 500 Hz last for some 50 ms, five steps, and R takes each for new.
  With R as the sensors have it the told deviations shrink and the errors grow: a large R stands in for that. Over all
  states the two wrongs of `attitude_single` cancel, inside by chance; in the roll angle they do not.
- **Bank, no offset.** What it tells is the spread of filters that are told 150 mG apart, up to twenty times its errors
  in single states; NIS is the weighted mean, in which the filters with a wrong offset count. NEES over all states is
  near its band all the same: three filters spread along one line, across it P is as small as that of one filter.
- **100 mG on x.** One filter does not know that there is such an offset: P is that of a right model, and NIS comes
  inside only because the wrong model adds what R has too much. In the bank the roll angle is inside, and every state
  within 1.3 of its deviation; NEES over all is not, since the errors leave the line of the three filters. Weights (28)
  follow likelihoods averaged over 5 s, not the covariances of an estimate.
- **Extra state.** Straight ahead, as all rides are for 10 s, no row tells the offset of G_x from the pitch angle. The
  slope of g cos θ by θ seems to wherever the estimate is off the level: with H = ∂h/∂x as printed and the bank's R it
  drives 18 of 20 such rides out of the sensor's range, to 1 or 2 g, with 1.7 mG told. This filter takes that slope as
  on the level, where it is zero; on none of 20 does the offset leave, with either R. b_x is told within 36 mG, which is
  what start and G_x leave of pitch and offset together, until the first turn, and within 5 mG at the end of the ride.
  The filter has the states of form 2B and its R (0.5 m/s²): it tells two to five times its errors, and NEES and NIS lie
  below. With the bank's R, which only has to set virtual offsets apart, it tells half of its errors, and a quarter with
  100 mG on x: the first turn shakes the rows of G_z and of the balance by more than 0.1 m/s².
"""

FORCE_REASONS = """
The random-walk filter is inside both bands where forces walk at random, and its NIS is inside on S1 as well: R is the
noise that the document puts on. NEES on S1 is below: Q has 200 and 600 N per root second for any drive, while the
forces of S1 are smooth and its speeds are shaken by nothing. The filter tells 40 and 120 N and is off by 17 and 69 N,
most on the safe side in the lateral speed, which no row measures.
"""


def _row(name: str, found: object, labels: dict[str, str] = STATISTICS) -> list[str]:
    lines = []
    for key, label in labels.items():
        statistic = getattr(found, key)
        inside = "yes" if statistic.inside else "no"
        band = f"{statistic.low:.2f} … {statistic.high:.2f}"
        lines.append(f"| {name} | {label} | {statistic.mean:.2f} | {band} | {inside} |")
    return lines


def _behind(found: dict[str, Any]) -> str:
    """Errors of the states beside what is told of them, and innovations beside R."""
    import numpy as np
    from attitude_consistency import FILTERS, ROWS, correlation, innovations
    from attitude_rides import DEGREE, MILLI_G

    units = {
        "pitch [deg]": DEGREE,
        "roll [deg]": DEGREE,
        "speed [m/s]": 1.0,
        "offset of the roll gyroscope [deg/s]": DEGREE,
        "offset of the yaw gyroscope [deg/s]": DEGREE,
        "offset of the pitch gyroscope [deg/s]": DEGREE,
        "offset of G_z [mG]": MILLI_G,
    }
    lines = [
        "| RMS error / told, without offset | " + " | ".join(FILTERS) + " |",
        "|---|" + "---:|" * len(FILTERS),
    ]
    for place, (label, unit) in enumerate(units.items()):
        pairs = [
            [np.sqrt(np.mean(np.square(values[:, place]))) / unit for values in (of.errors, of.deviations)]
            for of in (found[name] for name in FILTERS)
        ]
        lines.append(f"| {label} | " + " | ".join(f"{error:.3g} / {own:.2g}" for error, own in pairs) + " |")
    values = innovations()
    rms, one, ten = np.sqrt(np.mean(np.square(values), axis=(0, 1))), correlation(values), correlation(values, 10)
    lines += ["", "| Innovation of `attitude_single` | RMS | √R | Correlation after 10 ms | after 0.1 s |"]
    lines.append("|---|---:|---:|---:|---:|")
    for row, of in enumerate(zip(rms, one, ten, strict=True)):
        lines.append(f"| {ROWS[row]} | {of[0]:.3f} | 0.1 | {of[1]:.2f} | {of[2]:.2f} |")
    return "\n".join(lines) + "\n"


def page() -> str:
    """Text of the page."""
    import consistency_runs as runs
    from attitude_consistency import attitude_filters
    from force_consistency import on_the_documents_drive, where_its_noise_is_true
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
    found, labels = attitude_filters(), {"roll": "NEES of roll", **STATISTICS}
    attitude = [line for name, of in found.items() for line in _row(name, of, labels)]
    attitude += _row("`random_walk_force_ekf`, S1", on_the_documents_drive())
    attitude += _row("`random_walk_force_ekf`, forces drawn from its model", where_its_noise_is_true())
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
        + ATTITUDE
        + "\n".join([*table, *attitude])
        + "\n\n"
        + _behind(found)
        + ATTITUDE_REASONS
        + FORCE_REASONS
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
