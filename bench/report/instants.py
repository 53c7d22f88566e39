"""Where in a run a criterion got its value: the instant and the chart that show it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.report.motion_charts import FAST_M_S
from bench.report.run_data import FloatArray, RunData
from signals.wheels import WHEELS

_WORDS = re.compile(r"[a-z_][a-z0-9_]*(?:\.[a-z_][a-z0-9_]*)?")


@dataclass(frozen=True)
class Instant:
    """Time of the run and id of the chart to look at."""

    time_s: float
    chart: str


# beginnings of signal names and the chart that shows them
_CHART_OF_SIGNAL = (
    ("slip_ratio", "slip"),
    ("speed", "speed"),
    ("true_wheel_speed", "speed"),
    ("wheel_speed", "speed"),
    ("true_longitudinal_acceleration", "deceleration"),
    ("longitudinal_acceleration", "deceleration"),
    ("true_yaw_rate", "yaw"),
    ("yaw_", "yaw"),
    ("side_slip_angle", "yaw"),
    ("true_lateral_acceleration", "lateral-acceleration"),
    ("lateral_acceleration", "lateral-acceleration"),
    ("position_y", "lateral"),
    ("driver_steering", "steering"),
    ("steering", "steering"),
    ("true_brake_pressure", "pressure-fl"),
    ("brake_pressure", "pressure-fl"),
    ("ecu_phase", "phases"),
    ("abs_", "phases"),
    ("ecu_fault_code", "phases"),
    ("pump", "phases"),
    ("bus_load", "load"),
    ("lateness", "lateness-time"),
    ("friction_limit", "friction-front"),
    ("friction_used", "friction-front"),
)

_METRIC_SIGNALS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "wheel_lock": (("slip_ratio",), "slip"),
    "lock_share": (("slip_ratio",), "slip"),
    "lock_speed_ratio": (("slip_ratio",), "slip"),
    "slip_mean": (("slip_ratio",), "slip"),
    "slip_mean_wheel": (("slip_ratio",), "slip"),
    "slip_high_share": (("slip_ratio",), "slip"),
    "slip_high_share_wheel": (("slip_ratio",), "slip"),
    "slip_band": (("slip_ratio",), "slip"),
    "max_abs_yaw_rate": (("true_yaw_rate", "yaw_rate"), "yaw"),
    "yaw": (("yaw_angle",), "yaw"),
    "max_abs_side_slip_angle": (("side_slip_angle",), "yaw"),
    "lateral_offset": (("position_y",), "lateral"),
    "steering_wheel_peak": (("driver_steering_wheel_angle",), "steering"),
    "steering_wheel_peak_2s": (("driver_steering_wheel_angle",), "steering"),
    "real_time_overruns": (("lateness",), "lateness-time"),
    "late_ticks": (("lateness",), "lateness-time"),
    "skipped_ticks": (("lateness",), "lateness-time"),
}

_AXLES: Mapping[str, tuple[str, str]] = {"front": ("fl", "fr"), "rear": ("rl", "rr")}

# output of an estimator without its axle: the simulated car's signal and the chart
_ESTIMATED: Mapping[str, tuple[str, str]] = {
    "friction_limit": ("friction_limit", "friction"),
    "friction_used": ("friction_used", "friction"),
    "slip": ("slip_ratio", "slip"),
    "wheel_speed": ("true_wheel_speed", "speed"),
}

_AT_BRAKE_START: Mapping[str, str] = {
    "brake_start_time": "speed",
    "brake_start_speed": "speed",
    "stopping_distance": "speed",
    "stopping_distance_corrected": "speed",
    "stopping_time": "speed",
    "braking_distance": "speed",
    "mean_deceleration": "deceleration",
    "mfdd": "deceleration",
    "max_deceleration": "deceleration",
    "abs_cycles": "phases",
}


def find_instant(run: RunData, criterion: Mapping[str, Any]) -> Instant | None:
    """Instant to look at for a criterion of ``verdict.json``; None where nothing in the recording shows it."""
    if run.signals is None or len(run.time) == 0:
        return None
    words = _WORDS.findall(str(criterion.get("expression") or ""))
    window = _window(run, criterion.get("phase"))
    finders: tuple[Callable[[], Instant | None], ...] = (
        lambda: _of_metric(run, words, window, criterion),
        lambda: _of_estimate(run, words, window),
        lambda: _of_signal(run, words, window),
    )
    return next((found for find in finders if (found := find()) is not None), None)


def _window(run: RunData, phase: Any) -> slice:
    """Rows of the criterion's phase; everything after the brake start for the built-in braking phases."""
    time = run.time
    for step in run.steps():
        if step.name == phase:
            return slice(int(np.searchsorted(time, step.start_s)), int(np.searchsorted(time, step.end_s)) + 1)
    start = run.brake_start_s() if phase in ("brake", "braking") else None
    return slice(int(np.searchsorted(time, start)) if start is not None else 0, len(time))


def _of_metric(run: RunData, words: list[str], window: slice, criterion: Mapping[str, Any]) -> Instant | None:
    for word in words:
        if word in _METRIC_SIGNALS:
            signals, chart = _METRIC_SIGNALS[word]
            if word == "steering_wheel_peak_2s":
                window = slice(window.start, min(window.stop, window.start + 2000))
            return _extreme(run, signals, window, chart, criterion.get("values"))
        if word in _AT_BRAKE_START:
            start = run.brake_start_s()
            return Instant(start, _AT_BRAKE_START[word]) if start is not None else None
    return None


def _extreme(run: RunData, signals: tuple[str, ...], window: slice, chart: str, values: Any) -> Instant | None:
    for name in signals:
        columns = [name] if run.has(name) else [f"{name}_{wheel}" for wheel in _wheels_to_search(values)]
        if all(run.has(column) for column in columns):
            largest = np.max([np.abs(_moving(run, column, window)) for column in columns], axis=0)
            return _at_largest(run, largest, window, chart)
    return None


def _wheels_to_search(values: Any) -> tuple[str, ...]:
    """The worst wheel of a value per wheel, else all."""
    if isinstance(values, list) and len(values) == len(WHEELS) and all(isinstance(v, (int, float)) for v in values):
        return (WHEELS[int(np.argmax(np.abs(values)))],)
    return WHEELS


def _moving(run: RunData, name: str, window: slice) -> FloatArray:
    """Values in the window, zero while the car crawls, where slip and angles mean nothing."""
    values = run.array(name)[window]
    return values if name == "lateness" else np.where(_fast(run)[window], values, 0.0)


def _fast(run: RunData) -> NDArray[np.bool_]:
    return run.array("speed") > FAST_M_S if run.has("speed") else np.ones(len(run.time), np.bool_)


def _of_estimate(run: RunData, words: list[str], window: slice) -> Instant | None:
    """Largest error of an estimate of an axle; the start of the phase for any other output of an estimator."""
    for word in words:
        if "." not in word or not run.has(word):
            continue
        quantity, _, axle = word.partition(".")[2].rpartition("_")
        truth, chart = _ESTIMATED.get(quantity, ("", "speed" if quantity == "" else "friction"))
        chart = f"friction-{axle if axle in _AXLES else 'front'}" if chart == "friction" else chart
        signals = [f"{truth}_{wheel}" for wheel in _AXLES.get(axle, ())]
        if signals and run.has(*signals):
            error = np.abs(run.array(word) - np.mean([run.array(name) for name in signals], axis=0))
            return _at_largest(run, np.where(_fast(run), error, 0.0)[window], window, chart)
        return Instant(float(run.time[window][0]), chart)
    return None


def _of_signal(run: RunData, words: list[str], window: slice) -> Instant | None:
    for word in words:
        for beginning, chart in _CHART_OF_SIGNAL:
            if word.startswith(beginning):
                return _extreme(run, (word,), window, chart, None)
    return None


def _at_largest(run: RunData, values: FloatArray, window: slice, chart: str) -> Instant | None:
    if len(values) == 0 or not np.isfinite(values).any():
        return None
    row = int(np.nanargmax(np.where(np.isfinite(values), values, -1.0)))
    return Instant(round(float(run.time[window][row]), 4), chart)
