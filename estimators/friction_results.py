"""Outputs of the friction filters from state and covariance: friction, deviations, confidence, post-filter.

Friction document, section 3.6.7.
"""

import math

from numba import njit

from estimators.friction_model import (
    AXLES,
    LIMIT_F,
    LIMIT_R,
    LOAD_F,
    LOAD_R,
    RATE_F,
    RATE_R,
    SHAPE_F,
    SHAPE_R,
    SLIP_F,
    SLIP_R,
    STIFFNESS_F,
    STIFFNESS_R,
    USED_F,
    USED_R,
    axle_forces,
)
from estimators.friction_outputs import POSITION
from estimators.friction_step import (
    ACTIVE,
    CONFIDENCE_RATIO,
    CONFIDENCE_TIME,
    CONFIDENT_F,
    CONFIDENT_M,
    CONFIDENT_R,
    INNOVATION,
    INPUT_STATE,
    POST_FILTER,
    POST_FILTER_WEIGHT,
    RESETS,
    SAMPLE_TIME,
)
from estimators.kalman.covariance import FloatArray
from estimators.post_filter import forget, post_filter

OUT_ACTIVE = POSITION["active"]
OUT_RESETS = POSITION["resets"]
OUT_INPUT_STATE = POSITION["input_state"]
OUT_SPEED = POSITION["speed"]
OUT_LIMIT_F = POSITION["friction_limit_front"]
OUT_LIMIT_R = POSITION["friction_limit_rear"]
OUT_RATE_F = POSITION["friction_limit_rate_front"]
OUT_RATE_R = POSITION["friction_limit_rate_rear"]
OUT_LIMIT_M = POSITION["friction_limit_mean"]
OUT_USED_F = POSITION["friction_used_front"]
OUT_USED_R = POSITION["friction_used_rear"]
OUT_USED_M = POSITION["friction_used_mean"]
OUT_FILTERED = POSITION["friction_limit_front_filtered"]
OUT_INNOVATION = POSITION["innovation"]


@njit(cache=True)
def write_outputs(
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    tuning: FloatArray,
    forces: FloatArray,
    filters: FloatArray,
    out: FloatArray,
) -> None:
    """Fill the outputs from state and covariance; update confidence and post-filters."""
    running = status[ACTIVE] > 0.0
    out[OUT_ACTIVE] = status[ACTIVE]
    out[OUT_RESETS] = status[RESETS]
    out[OUT_INPUT_STATE] = status[INPUT_STATE]
    for i in range(SLIP_R + 1):
        out[OUT_SPEED + 2 * i] = state[i]
        out[OUT_SPEED + 2 * i + 1] = _root(covariance[i, i])
    out[OUT_LIMIT_F], out[OUT_LIMIT_F + 1] = state[LIMIT_F], _root(covariance[LIMIT_F, LIMIT_F])
    out[OUT_LIMIT_R], out[OUT_LIMIT_R + 1] = state[LIMIT_R], _root(covariance[LIMIT_R, LIMIT_R])
    out[OUT_RATE_F], out[OUT_RATE_F + 1] = state[RATE_F], _root(covariance[RATE_F, RATE_F])
    out[OUT_RATE_R], out[OUT_RATE_R + 1] = state[RATE_R], _root(covariance[RATE_R, RATE_R])

    axle_forces(state, tuning, forces)
    used_f, used_r = forces[AXLES, USED_F], forces[AXLES, USED_R]
    share = forces[AXLES, LOAD_F] / (forces[AXLES, LOAD_F] + forces[AXLES, LOAD_R])
    limit = share * state[LIMIT_F] + (1.0 - share) * state[LIMIT_R]
    used = share * used_f + (1.0 - share) * used_r
    out[OUT_LIMIT_M] = limit
    out[OUT_LIMIT_M + 1] = _root(
        share * share * covariance[LIMIT_F, LIMIT_F]
        + 2.0 * share * (1.0 - share) * covariance[LIMIT_F, LIMIT_R]
        + (1.0 - share) * (1.0 - share) * covariance[LIMIT_R, LIMIT_R]
    )
    curve_f, slope_f = _curve(state[LIMIT_F], state[SLIP_F], tuning[SHAPE_F], tuning[STIFFNESS_F])
    curve_r, slope_r = _curve(state[LIMIT_R], state[SLIP_R], tuning[SHAPE_R], tuning[STIFFNESS_R])
    out[OUT_USED_F], out[OUT_USED_R], out[OUT_USED_M] = used_f, used_r, used
    out[OUT_USED_F + 1] = _used_deviation(covariance, curve_f, slope_f, 0.0, 0.0)
    out[OUT_USED_R + 1] = _used_deviation(covariance, 0.0, 0.0, curve_r, slope_r)
    out[OUT_USED_M + 1] = _used_deviation(
        covariance, share * curve_f, share * slope_f, (1.0 - share) * curve_r, (1.0 - share) * slope_r
    )
    out[OUT_LIMIT_F + 2] = _confident(status, CONFIDENT_F, running, used_f, state[LIMIT_F], tuning)
    out[OUT_LIMIT_R + 2] = _confident(status, CONFIDENT_R, running, used_r, state[LIMIT_R], tuning)
    out[OUT_LIMIT_M + 2] = _confident(status, CONFIDENT_M, running, used, limit, tuning)

    kind, weight = int(tuning[POST_FILTER]), tuning[POST_FILTER_WEIGHT]
    if not running:
        for k in range(3):
            forget(filters[k])
    out[OUT_FILTERED] = post_filter(filters[0], kind, weight, state[LIMIT_F])
    out[OUT_FILTERED + 1] = post_filter(filters[1], kind, weight, state[LIMIT_R])
    out[OUT_FILTERED + 2] = post_filter(filters[2], kind, weight, limit)
    out[OUT_INNOVATION] = status[INNOVATION] if running else 0.0


@njit(cache=True)
def _confident(status: FloatArray, timer: int, running: bool, used: float, limit: float, tuning: FloatArray) -> float:
    if running and limit > 0.0 and abs(used) > tuning[CONFIDENCE_RATIO] * limit:
        status[timer] += tuning[SAMPLE_TIME]
    else:
        status[timer] = 0.0
    return 1.0 if status[timer] >= tuning[CONFIDENCE_TIME] - 1e-9 and status[timer] > 0.0 else 0.0


@njit(cache=True)
def _curve(limit: float, slip: float, shape: float, stiffness: float) -> tuple[float, float]:
    """Derivatives of the friction in use by the friction limit and by the slip."""
    scaled = stiffness * slip
    angle = shape * math.atan(scaled)
    return math.sin(angle), limit * shape * stiffness * math.cos(angle) / (1.0 + scaled * scaled)


@njit(cache=True)
def _used_deviation(
    covariance: FloatArray, by_limit_f: float, by_slip_f: float, by_limit_r: float, by_slip_r: float
) -> float:
    """Standard deviation of a function of limits and slips with these derivatives."""
    p = covariance
    front = by_limit_f * by_limit_f * p[LIMIT_F, LIMIT_F] + by_slip_f * by_slip_f * p[SLIP_F, SLIP_F]
    front += 2.0 * by_limit_f * by_slip_f * p[LIMIT_F, SLIP_F]
    rear = by_limit_r * by_limit_r * p[LIMIT_R, LIMIT_R] + by_slip_r * by_slip_r * p[SLIP_R, SLIP_R]
    rear += 2.0 * by_limit_r * by_slip_r * p[LIMIT_R, SLIP_R]
    both = by_limit_f * (by_limit_r * p[LIMIT_F, LIMIT_R] + by_slip_r * p[LIMIT_F, SLIP_R])
    both += by_slip_f * (by_limit_r * p[SLIP_F, LIMIT_R] + by_slip_r * p[SLIP_F, SLIP_R])
    return _root(front + rear + 2.0 * both)


@njit(cache=True)
def _root(variance: float) -> float:
    return math.sqrt(max(variance, 0.0))
