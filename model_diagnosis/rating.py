"""How well a replay follows a measurement: the rating of ISO/TS 18571, 1 for equal curves down to 0.

Four scores are weighted: corridor 0.4, phase 0.2, magnitude 0.2 and slope 0.2 (ISO/TS 18571:2024, clause 6). Grades of
the same document: above 0.94 excellent, above 0.80 good, above 0.58 fair, else poor. It was made for crash signals of
10 kHz; here it rates each signal of a manoeuvre at the sampling of the data, with slopes averaged over the same nine
samples. It is shown to people, nothing is decided by it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from model_diagnosis.findings import FloatArray, ManoeuvreFindings

CORRIDOR_WEIGHT, PHASE_WEIGHT, MAGNITUDE_WEIGHT, SLOPE_WEIGHT = 0.4, 0.2, 0.2, 0.2
# half widths of the corridors, relative to the largest measured value (6.2)
INNER_CORRIDOR, OUTER_CORRIDOR, CORRIDOR_EXPONENT = 0.05, 0.5, 2
# largest shift as a share of the signal, largest errors of magnitude and slope (6.3)
LARGEST_SHIFT, LARGEST_MAGNITUDE_ERROR, LARGEST_SLOPE_ERROR = 0.2, 0.5, 2.0
WARPING_WINDOW = 0.1
SLOPE_SAMPLES = 9
FEWEST_SAMPLES = 20

GRADES = ((0.94, "excellent"), (0.80, "good"), (0.58, "fair"))


@dataclass(frozen=True)
class Rating:
    """Scores of one curve, each from 0 to 1."""

    corridor: float
    phase: float
    magnitude: float
    slope: float

    @property
    def overall(self) -> float:
        """Weighted sum (6.1)."""
        return (
            CORRIDOR_WEIGHT * self.corridor
            + PHASE_WEIGHT * self.phase
            + MAGNITUDE_WEIGHT * self.magnitude
            + SLOPE_WEIGHT * self.slope
        )

    @property
    def grade(self) -> str:
        """Word for the overall rating."""
        return grade(self.overall)


def grade(overall: float) -> str:
    """Word of the document for an overall rating."""
    return next((word for above, word in GRADES if overall > above), "poor")


def rate(measured: ArrayLike, replayed: ArrayLike) -> Rating:
    """Rate a replayed curve against the measured one.

    Parameters
    ----------
    measured, replayed : (n,) arrays
        In the same unit, at the same equal steps.

    Raises
    ------
    ValueError
        If the shapes differ, values are not finite or there are fewer than 20 samples.

    Notes
    -----
    Source: ISO/TS 18571:2024, clause 6. A measured curve without any variation has no phase and no slope of its own;
    then there is no shift, and the slope score is 1 only for a replay without variation.
    """
    reference = np.ascontiguousarray(measured, dtype=np.float64)
    model = np.ascontiguousarray(replayed, dtype=np.float64)
    if reference.ndim != 1 or reference.shape != model.shape:
        raise ValueError(f"curves of shape {reference.shape} and {model.shape}; one of (n,) each is wanted")
    if len(reference) < FEWEST_SAMPLES:
        raise ValueError(f"{len(reference)} samples; a rating needs at least {FEWEST_SAMPLES}")
    if not (np.isfinite(reference).all() and np.isfinite(model).all()):
        raise ValueError("a curve has values that are not finite")
    shift = _best_shift(reference, model)
    steps = abs(shift)
    kept = len(reference) - steps
    # a positive shift moves the model to the left: its later samples meet the reference's earlier ones
    shifted_model = model[steps:] if shift > 0 else model[:kept]
    shifted_reference = reference[:kept] if shift > 0 else reference[steps:]
    return Rating(
        corridor=_corridor_score(reference, model),
        phase=max(0.0, 1.0 - steps / (LARGEST_SHIFT * len(reference))),
        magnitude=_magnitude_score(shifted_reference, shifted_model),
        slope=_slope_score(shifted_reference, shifted_model),
    )


def ratings_of(findings: ManoeuvreFindings, *, extended: bool = False, restarted: bool = False) -> Mapping[str, Rating]:
    """Rating of every signal of a manoeuvre that can be rated, by its name.

    The free run is rated, or ``restarted`` the one that starts again each second; where there is none the observer
    replay. With the vehicle as given or, ``extended``, with what was found. Samples of weight 0 are left out of both
    curves.
    """
    if restarted:
        run = findings.restarted_after if extended else findings.restarted_before
    else:
        run = findings.free_after if extended else findings.free_before
    replayed = run if run is not None else (findings.after if extended else findings.before)
    rated: dict[str, Rating] = {}
    for column, signal in enumerate(findings.signals):
        valid = (findings.weights[:, column] > 0) & np.isfinite(replayed[:, column])
        if np.count_nonzero(valid) >= FEWEST_SAMPLES:
            rated[signal] = rate(findings.measured[valid, column], replayed[valid, column])
    return rated


def _corridor_score(reference: FloatArray, model: FloatArray) -> float:
    """Mean over time of 1 in the inner corridor, 0 outside the outer one (6.2)."""
    norm = float(np.abs(reference).max())
    error = np.abs(reference - model)
    if norm == 0.0:
        return float(np.mean(error == 0.0))
    between = (OUTER_CORRIDOR - error / norm) / (OUTER_CORRIDOR - INNER_CORRIDOR)
    return float(np.mean(np.clip(between, 0.0, 1.0) ** CORRIDOR_EXPONENT))


def _best_shift(reference: FloatArray, model: FloatArray) -> int:
    """Samples to the left by which the model fits best, negative to the right; the smallest of equals (6.3)."""
    if np.ptp(reference) == 0.0 or np.ptp(model) == 0.0:
        return 0
    best, shift = _correlation(reference, model), 0
    for steps in range(1, int(LARGEST_SHIFT * len(reference)) + 1):
        left = _correlation(reference[:-steps], model[steps:])
        if left > best:
            best, shift = left, steps
        right = _correlation(reference[steps:], model[:-steps])
        if right > best:
            best, shift = right, -steps
    return shift


def _correlation(a: FloatArray, b: FloatArray) -> float:
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0.0 else -1.0


def _magnitude_score(reference: FloatArray, model: FloatArray) -> float:
    """Difference that is left after dynamic time warping, relative to the reference (6.3)."""
    half_window = int(np.ceil(WARPING_WINDOW * len(reference))) - 1
    path = _warping_path(reference, model, half_window)
    warped = reference[path[:, 0]]
    error = float(np.abs(warped - model[path[:, 1]]).sum())
    scale = float(np.abs(warped).sum())
    if error == 0.0:
        return 1.0
    return max(0.0, 1.0 - error / scale / LARGEST_MAGNITUDE_ERROR) if scale > 0.0 else 0.0


@njit(cache=True)
def _warping_path(a: NDArray[np.float64], b: NDArray[np.float64], half_window: int) -> NDArray[np.int64]:
    """(steps, 2) indices of the cheapest monotonous path inside a Sakoe-Chiba band, squared differences as cost."""
    count = len(a)
    width = 2 * half_window + 1
    cost = np.full((count + 1, width + 1), np.inf)  # row 0 and the last column stay infinite: outside the band
    came_from = np.zeros((count, width), np.int8)
    for i in range(count):
        for band in range(width):
            j = i + band - half_window
            if j < 0 or j >= count:
                continue
            # in band coordinates: the row above at the same j is one to the right, the diagonal straight above
            above, before, diagonal = cost[i, band + 1], np.inf, cost[i, band]
            if band > 0:
                before = cost[i + 1, band - 1]
            lowest, origin = above, 0
            if before < lowest:
                lowest, origin = before, 1
            if diagonal < lowest:
                lowest, origin = diagonal, 2
            if i == 0 and j == 0:
                lowest = 0.0
            cost[i + 1, band] = lowest + (a[i] - b[j]) ** 2
            came_from[i, band] = origin
    path = np.empty((2 * count, 2), np.int64)
    i, j, steps = count - 1, count - 1, 0
    while True:
        path[steps, 0], path[steps, 1] = i, j
        steps += 1
        if i == 0 and j == 0:
            break
        origin = came_from[i, j - i + half_window]
        if origin != 1:
            i -= 1
        if origin != 0:
            j -= 1
    return path[:steps]


def _slope_score(reference: FloatArray, model: FloatArray) -> float:
    """Difference of the smoothed derivatives, relative to the reference's (6.3)."""
    reference_slope, model_slope = _smoothed_slope(reference), _smoothed_slope(model)
    error = float(np.abs(model_slope - reference_slope).sum())
    scale = float(np.abs(reference_slope).sum())
    if error == 0.0:
        return 1.0
    return max(0.0, 1.0 - error / scale / LARGEST_SLOPE_ERROR) if scale > 0.0 else 0.0


def _smoothed_slope(values: FloatArray) -> FloatArray:
    """Central differences averaged over nine samples, over fewer towards the ends."""
    slope = np.gradient(values)
    half = SLOPE_SAMPLES // 2
    smoothed = slope.copy()
    smoothed[half:-half] = np.convolve(slope, np.full(SLOPE_SAMPLES, 1.0 / SLOPE_SAMPLES), mode="valid")
    for place in range(half):
        near = 2 * place + 1
        smoothed[place] = slope[:near].mean()
        smoothed[-1 - place] = slope[-near:].mean()
    return smoothed
