"""The blocks ``metrics`` and ``estimators`` of ``verdict.json``: every figure the run has, judged or not."""

from typing import Any

from bench.verdict import metrics
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.truth import truth_of
from bench.verdict.vocabulary import METRICS

# metric -> key with its unit, in the order of the file
METRIC_KEYS: dict[str, str] = {
    "stopping_distance": "stopping_distance_m",
    "braking_distance": "braking_distance_m",
    "stopping_time": "stopping_time_s",
    "brake_start_time": "brake_start_time_s",
    "brake_start_speed": "brake_start_speed_m_s",
    "mean_deceleration": "mean_deceleration_m_s2",
    "mfdd": "mfdd_m_s2",
    "max_deceleration": "max_deceleration_m_s2",
    "wheel_lock": "lock_time_s",
    "lock_share": "lock_share",
    "slip_mean": "slip_mean",
    "slip_mean_wheel": "slip_mean_wheel",
    "slip_high_share": "slip_high_share",
    "slip_band": "slip_band_share",
    "abs_cycles": "abs_cycles",
    "max_abs_yaw_rate": "max_abs_yaw_rate_rad_s",
    "yaw": "yaw_rad",
    "lateral_offset": "lateral_offset_m",
    "steering_wheel_peak": "steering_wheel_peak_rad",
}


def metric_summary(run: Assessment) -> dict[str, Any]:
    """Every metric that the run has a value for, None where it has none."""
    summary: dict[str, Any] = {}
    for name, key in METRIC_KEYS.items():
        try:
            value = run.metric(name)
        except NoValueError:
            summary[key] = [None] * 4 if METRICS[name].per_wheel else None
            continue
        summary[key] = value.tolist() if hasattr(value, "tolist") else value
    return summary


def estimator_summary(run: Assessment) -> dict[str, dict[str, Any]]:
    """Error of every estimate that has a true value over the braking phase, and the settling after a jump in friction.

    ``settling_s`` is that of the friction limit and None where the road's friction does not jump or the estimate does
    not settle.
    """
    summary: dict[str, dict[str, Any]] = {}
    if len(run.time) == 0:
        return summary
    try:
        rows, phase = run.window("braking"), "braking"
    except NoValueError:
        rows, phase = run.window("run"), "run"
    for name in run.data.names:
        estimator, dot, output = name.partition(".")
        if not dot or truth_of(name) is None:
            continue
        entry = summary.setdefault(estimator, {"rmse": {}, "settling_s": None, "settling": {}, "phase": phase})
        try:
            entry["rmse"][output] = metrics.estimator_error(run, name, rows)
        except NoValueError:
            continue
        if output.startswith("friction_limit"):
            _add_settling(run, name, output, entry)
    return summary


def _add_settling(run: Assessment, name: str, output: str, entry: dict[str, Any]) -> None:
    try:
        settling = metrics.settling_time(run, name, run.window("brake"))
    except NoValueError:
        return
    entry["settling"][output] = settling
    slowest = max(entry["settling"].values())
    entry["settling_s"] = slowest
