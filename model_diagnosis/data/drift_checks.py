"""Clocks that drift: the lag of a twin over the time of a drive, window by window, and the fewest drifts behind all.

t' = (1 + d) t for the channels of one logger or message, or for one channel: its lag against the others grows by d for
each second. The lags of windows of 10 s are regressed on time, and where the car has a lag of its own, on the speed
(slip makes a wheel lead by slip per acceleration times speed); Huber's weights for windows whose lag the driving makes.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_diagnosis.data.delay_checks import LagRelation, Late, candidates, explain_lags
from model_diagnosis.data.faults import joined
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import FINE_BAND_HZ, correlations
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import Motion, Twin, twins_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

WINDOW_S = 10.0
SHORTEST_DRIVE_S = 60.0
_FEWEST_WINDOWS = 5
_WIDEST_LAG_S = 0.5
_ENOUGH = 0.6
_SIGMAS = 5.0
_HUBER = 1.345
_ROUNDS = 10
_LEAST_STD_S = 0.003
"""What the lag over a whole drive is never known better than."""


def check_drift(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name clocks that drift by 15 ms or more over a drive, and take their samples where they belong.

    Samples are the nearest ones in time: interpolation would smooth the noise.
    """
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for drive in dict.fromkeys(m.drive for m in manoeuvres if m.drive):
        places = [k for k, m in enumerate(manoeuvres) if m.drive == drive]
        parts = [repaired[k] for k in places]
        begin, end = parts[0].start_s, max(m.start_s + m.duration_s for m in parts)
        if end - begin < SHORTEST_DRIVE_S:
            continue
        for late in explain_lags(_relations(parts, geometry, end - begin), candidates(parts)):
            if abs(late.delay_s) < _SIGMAS * late.std_s:
                continue
            drift = late.delay_s / (end - begin)
            faults.append(_fault(late, drift, late.std_s / (end - begin)))
            for k in places:
                repaired[k] = undrifted(repaired[k], late.channels, drift)
    return faults, repaired


def _relations(parts: Sequence[Manoeuvre], geometry: Geometry, span_s: float) -> list[LagRelation]:
    """Growth over the drive of the lags of all twins."""
    lags: dict[str, list[tuple[Twin, float, float, float]]] = {}
    for window, at in _windows(parts):
        speed = window.channels.get("speed", Motion(window, geometry).wheels_speed())
        for twin in twins_of([window], geometry):
            lag = _lag(twin)
            if lag is not None:
                pace = 0.0 if speed is None else float(np.mean(speed))
                lags.setdefault(twin.kind.name, []).append((twin, at / span_s, pace, lag))
    found = []
    for entries in lags.values():
        if len(entries) < _FEWEST_WINDOWS:
            continue
        kind, numbers = entries[0][0].kind, np.array([entry[1:] for entry in entries])
        share, speed, lag = numbers.T
        # twins that agree in every car have no lag of their own that goes with the speed
        growth, std = _growth(share, speed if kind.usual_lag_s else np.zeros_like(speed), lag)
        found.append(LagRelation(kind.late, kind.early, growth, float(np.hypot(std, _LEAST_STD_S))))
    return found


def _growth(share: FloatArray, speed: FloatArray, lag: FloatArray) -> tuple[float, float]:
    """Growth of the lag [s] over the whole drive and its standard deviation; ``share`` of the drive's time gone."""
    design = np.column_stack((share, np.ones_like(share), speed - np.mean(speed)))
    if np.ptp(speed) < 1.0:
        design = design[:, :2]
    weights, left = np.ones_like(lag), lag
    for _ in range(_ROUNDS):
        root = np.sqrt(weights)
        fitted, *_ = np.linalg.lstsq(design * root[:, None], lag * root, rcond=None)
        left = lag - design @ fitted
        scale = max(1.4826 * float(np.median(np.abs(left))), 1e-6)
        weights = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(left), 1e-12))
    freedom = max(float(weights.sum()) - design.shape[1], 1.0)
    variance = float(np.sum(weights * left**2)) / freedom
    covariance = variance * np.linalg.inv(design.T @ (design * weights[:, None]))
    return float(fitted[0]), float(np.sqrt(covariance[0, 0]))


def _windows(parts: Sequence[Manoeuvre]) -> list[tuple[Manoeuvre, float]]:
    """Windows of about 10 s and the times of their middles [s]."""
    found = []
    for part in parts:
        count = max(round(part.samples * SAMPLE_TIME_S / WINDOW_S), 1)
        for rows in np.array_split(np.arange(part.samples), count):
            if len(rows) < 0.5 * WINDOW_S / SAMPLE_TIME_S:
                continue
            window = part.part(int(rows[0]), int(rows[-1]) + 1)
            found.append((window, part.start_s + SAMPLE_TIME_S * float(np.mean(rows))))
    return found


def _lag(twin: Twin) -> float | None:
    """Lag [s] of the left series where it follows the right one."""
    total = correlations(twin.left, twin.right, twin.valid, _WIDEST_LAG_S, FINE_BAND_HZ).sum(axis=0)
    peak = int(np.argmax(total))
    if total[peak] < _ENOUGH or not 0 < peak < len(total) - 1:
        return None
    before, top, after = total[peak - 1 : peak + 2]
    return SAMPLE_TIME_S * float(peak - len(total) // 2 + 0.5 * (before - after) / (before - 2.0 * top + after))


def undrifted(manoeuvre: Manoeuvre, channels: Sequence[str], drift: float) -> Manoeuvre:
    """The manoeuvre with the samples of some channels taken where their clock should have put them."""
    rows = np.arange(manoeuvre.samples)
    late = np.round(drift * (manoeuvre.start_s / SAMPLE_TIME_S + rows)).astype(np.int64)
    inside = (rows + late >= 0) & (rows + late < manoeuvre.samples)
    taken = np.clip(rows + late, 0, manoeuvre.samples - 1)
    return replace(
        manoeuvre,
        channels={n: v[taken] if n in channels else v for n, v in manoeuvre.channels.items()},
        weights={n: np.where(inside, w[taken], 0.0) if n in channels else w for n, w in manoeuvre.weights.items()},
    )


def _fault(late: Late, drift: float, std: float) -> DataFault:
    word = "fast" if drift > 0.0 else "slow"
    message = (
        f"{joined(late.channels)}: the clock runs {word} by {1e6 * abs(drift):.0f} ppm (± {1e6 * std:.0f}) against the "
        f"other channels, {1e3 * abs(late.delay_s):.0f} ms over the drive; resampled to the nearest samples"
    )
    return DataFault(
        kind="clock_drift",
        channel=joined(late.channels),
        value=1e6 * drift,
        unit="ppm",
        evidence=late.gain,
        repaired=True,
        message=message,
    )
