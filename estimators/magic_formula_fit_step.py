"""Buffer, threshold and mode of one friction curve: when to fit, and what becomes of the result (3.4), compiled."""

from typing import Any

from numba import njit

from estimators.kalman.covariance import FloatArray
from estimators.magic_formula_fit_solver import best_limit, deviation, fit_curve, line_deviation, r_squared
from estimators.vehicle_state_record import BUFFER, CURVED, LINEAR, LOG_ROWS

_GROWTH = 1.02
"""Slip by which the data have to grow before a fit that was refused is tried again."""
_TOLERANCE = (0.95, 1.0)
"""Part of the slip that a curve asks for, from which on its fit is taken; lateral, longitudinal.

Lateral pairs are compared as they are, behind their low-pass, longitudinal ones with the slip of now.
"""
_STIFFNESS_STEP = 1.05
"""Ratio of neighbouring stiffnesses in the search for the stiffest curve that explains the data."""
_LEARNING = 0.3
"""Part of a new fit in the stiffness that the earlier fits of a wheel told, as a mean of 1 / B."""


@njit(cache=True)
def forget_curve(curve: Any, t: Any, direction: int) -> None:
    """A curve of which nothing is known."""
    curve.mode, curve.count, curve.sign, curve.stride, curve.skipped = LINEAR, 0, 0.0, 1, 0
    curve.b, curve.d = t.initial_b, 0.0
    curve.threshold = curve.start = t.start_threshold[direction]
    curve.known_b, curve.now, curve.reach, curve.early = 0.0, 0.0, 0.0, 0
    curve.next_try, curve.asked, curve.pending, curve.handed_over = 0.0, 0.0, 0, 0
    curve.attained, curve.objective, curve.r_squared, curve.share, curve.points = 0.0, 0.0, 0.0, 0.0, 0


@njit(cache=True)
def _store(curve: Any, x_row: FloatArray, mu_row: FloatArray, x: float, mu: float) -> None:
    """Keep a pair; a full buffer gives up every second pair and stores every second from then on."""
    curve.skipped += 1
    if curve.skipped < curve.stride:
        return
    curve.skipped = 0
    if curve.count == BUFFER:
        for k in range(BUFFER // 2):
            x_row[k], mu_row[k] = x_row[2 * k + 1], mu_row[2 * k + 1]
        curve.count = BUFFER // 2
        curve.stride *= 2
    x_row[curve.count], mu_row[curve.count] = x, mu
    curve.count += 1


@njit(cache=True)
def _explains(x_row: FloatArray, mu_row: FloatArray, count: int, b: float, allowed: float, scratch: FloatArray,
              t: Any) -> bool:  # fmt: skip
    """Whether a curve of stiffness ``b`` leaves no more than the deviation ``allowed``."""
    return best_limit(x_row, mu_row, count, b, t.curve_c, t.low_d, t.high_d, scratch)[1] <= allowed


@njit(cache=True)
def _wanted_reach(b: float, direction: int, t: Any) -> float:
    """Slip that the data of a curve have to reach, threshold_times_b / B within its bounds."""
    wanted = t.threshold_times_b[direction] / b
    return min(max(wanted, t.low_threshold[direction]), t.high_threshold[direction])


@njit(cache=True)
def _was_asked_for(curve: Any, x: float, wanted: float, direction: int) -> bool:
    """Whether the slip is beyond what the fit before this one asked for; notes what this one asks for.

    The document's threshold is that of the previous fit (3.4). A launch has one half-wave, so that the previous fit is
    the one that was refused a little earlier: a single soft or stiff curve in the noise decides nothing. Lateral curves
    have those of earlier half-waves (``known_b``, ``start``).
    """
    if direction == 0:
        return True
    asked, curve.asked = curve.asked, wanted
    return 0.0 < asked <= x


@njit(cache=True)
def _peak_may_be_near(curve: Any, x_row: FloatArray, mu_row: FloatArray, count: int, objective: float, x: float,
                      direction: int, scratch: FloatArray, t: Any) -> bool:  # fmt: skip
    """Whether waiting for more data has to end although the best curve asks for more.

    It has, where the data reach what the wheel's earlier curves ask for, and a curve whose peak is near explains them
    nearly as well as the best one.
    """
    if curve.known_b <= 0.0 or x < _TOLERANCE[direction] * _wanted_reach(curve.known_b, direction, t):
        return False
    b = t.doubtful_times_b[direction] / max(curve.now, x)
    return _explains(x_row, mu_row, count, b, (1.0 + t.doubt[direction]) * objective, scratch, t)


@njit(cache=True)
def _stiffest(x_row: FloatArray, mu_row: FloatArray, count: int, b: float, objective: float, direction: int,
              scratch: FloatArray, t: Any) -> float:  # fmt: skip
    """Stiffest curve that explains the data hardly worse than the best one: noise may have hidden its bend."""
    allowed = (1.0 + t.start_doubt) * objective
    while b < t.high_b[direction] and _explains(x_row, mu_row, count, _STIFFNESS_STEP * b, allowed, scratch, t):
        b *= _STIFFNESS_STEP
    return b


@njit(cache=True)
def _stiffness_of_earlier(curve: Any, x_row: FloatArray, mu_row: FloatArray, count: int, b: float, objective: float,
                          scratch: FloatArray, t: Any) -> float:  # fmt: skip
    """Stiffness that the wheel's earlier curves told, where it explains these data too; else their own, ``b``.

    Data that end before the peak tell the slope B D well, but hardly how it divides: noise moves B, and D against it.
    All or nothing: halfway to the curve of another road would be neither road's.
    """
    known = curve.known_b
    if known <= 0.0:
        return b
    d, j = best_limit(x_row, mu_row, count, known, t.curve_c, t.low_d, t.high_d, scratch)
    explains = j <= (1.0 + t.agreement) * objective
    return known if explains and r_squared(x_row, mu_row, count, d, known, t.curve_c) >= t.lowest_r_squared else b


@njit(cache=True)
def _claim(curve: Any, b: float, direction: int, t: Any) -> None:
    """Tell whether this fit can claim to have come before the latest share of the peak.

    Its own curve cannot tell: a bend that noise hides makes a fit late and its curve soft. So the stiffness that the
    earlier fits of this wheel told judges, at the slip angle of now, which the pairs' low-pass lags behind.
    """
    judge = curve.known_b if curve.known_b > 0.0 else b
    curve.early = 1 if judge * curve.now <= t.latest_times_b[direction] else 0
    curve.known_b = 1.0 / ((1.0 - _LEARNING) / judge + _LEARNING / b)


@njit(cache=True)
def conclude_fit(
    curve: Any,
    x_row: FloatArray,
    mu_row: FloatArray,
    scratch: FloatArray,
    log: FloatArray,
    logged: FloatArray,
    number: int,
    d: float,
    b: float,
    time: float,
    t: Any,
) -> None:
    """Accept a fit, or go on storing.

    With the automatic threshold the fit itself tells how far the data have to reach, threshold_times_b / B: a fit whose
    data do not reach it is refused, unless the peak may be near: to wait for more would be to wait for the peak. A
    curve at a bound of the search, or hardly better than a straight line, is none that the data tell.
    """
    direction = number // 4
    count = curve.count
    x = curve.reach
    quality = r_squared(x_row, mu_row, count, d, b, t.curve_c)
    curve.pending = 0
    # the next start of a fit from further out, whatever becomes of this one
    curve.next_try = _GROWTH * x
    inside = t.low_d * 1.01 < d < t.high_d * 0.99 and t.low_b[direction] * 1.01 < b < t.high_b[direction] * 0.99
    objective = deviation(x_row, mu_row, count, d, b, t.curve_c)
    bends = objective < t.largest_straightness * line_deviation(x_row, mu_row, count, scratch)
    told = inside and bends and quality >= t.lowest_r_squared
    if not told:
        curve.provisional += 1
        return
    if t.automatic[direction] == 1:
        wanted = _wanted_reach(b, direction, t)
        reached = x >= _TOLERANCE[direction] * wanted and _was_asked_for(curve, x, wanted, direction)
        if not reached and not _peak_may_be_near(curve, x_row, mu_row, count, objective, x, direction, scratch, t):
            curve.provisional += 1
            return
        curve.threshold = wanted if reached else x
        stiffest = _stiffest(x_row, mu_row, count, b, objective, direction, scratch, t)
        curve.start = _wanted_reach(stiffest, direction, t)
    # what starts and claims a fit is its own curve, so that errors do not hand themselves on
    told_b = _stiffness_of_earlier(curve, x_row, mu_row, count, b, objective, scratch, t)
    _claim(curve, b, direction, t)
    if told_b != b:
        b = told_b
        d, objective = best_limit(x_row, mu_row, count, b, t.curve_c, t.low_d, t.high_d, scratch)
        quality = r_squared(x_row, mu_row, count, d, b, t.curve_c)
    attained = 0.0
    for k in range(count):
        attained = max(attained, abs(mu_row[k]))
    curve.mode, curve.d, curve.b = CURVED, d, b
    curve.fits += 1
    curve.handed_over = 1
    curve.attained, curve.r_squared, curve.points = attained, quality, count
    curve.objective = objective
    curve.share = attained / d
    row = log[int(logged[0]) % LOG_ROWS]
    row[0], row[1], row[2], row[3] = time, number, curve.sign, count
    row[4], row[5], row[6] = curve.objective, quality, attained
    row[7], row[8], row[9], row[10] = d, b, curve.share, curve.early
    logged[0] += 1.0


@njit(cache=True)
def observe_pair(
    curve: Any,
    x_row: FloatArray,
    mu_row: FloatArray,
    scratch: FloatArray,
    log: FloatArray,
    logged: FloatArray,
    number: int,
    x: float,
    mu: float,
    now: float,
    time: float,
    t: Any,
) -> None:
    """Take a pair of slip and friction of curve ``number``; ``now`` is the slip that the pair's low-pass lags behind.

    The low-pass of the longitudinal pairs is so slow that thresholds are compared with ``now`` there.

    A change of the slip's sign clears the buffer; crossing the threshold starts the fit; slip below it by the
    hysteresis leads back to the linear law.
    """
    direction = number // 4
    sign = 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0
    if sign != curve.sign and sign != 0.0:
        curve.count, curve.sign, curve.stride, curve.skipped, curve.next_try = 0, sign, 1, 0, 0.0
        curve.pending, curve.asked = 0, 0.0
        if curve.mode == CURVED:
            curve.mode = LINEAR
    reach = abs(x) if direction == 0 else now
    if curve.mode == CURVED:
        # a smooth slip leads back: the one of now would do so in its noise
        if max(abs(x), reach) < curve.threshold * (1.0 - t.hysteresis):
            curve.mode = LINEAR
        return
    # a force against its slip is an error of the slip: it tells nothing of the curve
    if sign == 0.0 or mu * sign <= 0.0:
        return
    _store(curve, x_row, mu_row, x, mu)
    curve.now, curve.reach = max(abs(x), now), reach
    if t.fit[direction] == 0 or curve.pending == 1:
        return
    if reach <= max(curve.start, curve.next_try) or curve.count < t.fewest_points:
        return
    if t.outside_solver == 1:
        curve.pending = 1
        return
    d, b, _ = fit_curve(
        x_row,
        mu_row,
        curve.count,
        t.curve_c,
        t.low_d,
        t.high_d,
        t.low_b[direction],
        t.high_b[direction],
        scratch,
    )
    conclude_fit(curve, x_row, mu_row, scratch, log, logged, number, d, b, time, t)
