"""Leave-one-manoeuvre-out check: what it passes and what it refuses."""

import numpy as np

from model_diagnosis.evidence.checks import leave_one_out
from model_diagnosis.evidence.quadratic import Quadratic

NUISANCE = np.array([0.2])
"""Of the effect's width: a scatter of 0.03 beside a width of 0.15."""


def _manoeuvre(value: float, information: float) -> Quadratic:
    return Quadratic(np.array([[information]]), np.array([information * value]))


def test_an_effect_that_every_manoeuvre_proves_alone_is_not_refused_for_gaining_nothing_more() -> None:
    """The evidence of a deviation of 1.7 widths ends at (1.7 / 0.2)^2 / 2 - 1.7^2 / 2 - log 5, however long the log."""
    values = 1.7 + 0.02 * np.array([1.0, -1.0, 0.5, -0.5, 1.0, -1.0])
    check = leave_one_out([_manoeuvre(value, 3e4) for value in values], NUISANCE, [0], np.array([1.7]))
    assert abs(check.complete - (0.5 * 1.7**2 * (25.0 - 1.0) - np.log(5.0))) < 0.2
    assert check.differences.sum() < 0.1
    assert check.passed


def test_an_effect_that_gains_in_each_manoeuvre_passes() -> None:
    check = leave_one_out([_manoeuvre(0.7, 30.0)] * 6, NUISANCE, [0], np.array([0.7]))
    assert check.differences.min() > 0.0
    assert check.passed


def test_an_effect_that_one_manoeuvre_contradicts_is_refused() -> None:
    parts = [_manoeuvre(1.0, 60.0)] * 3 + [_manoeuvre(-1.0, 60.0)]
    check = leave_one_out(parts, NUISANCE, [0], np.array([0.5]))
    assert check.differences[-1] < -3.0
    assert not check.passed


def test_noise_of_one_manoeuvre_is_no_contradiction_where_the_scatter_is_narrow() -> None:
    """Scatter 0.06 widths: a few per cent of the size found are worth z dz / r^2, more than a manoeuvre adds."""
    narrow = np.array([0.06])
    passed = []
    for seed in range(50):
        values = 1.4 + np.random.default_rng(seed).standard_normal(6) / np.sqrt(12.0)
        parts = [_manoeuvre(value, 12.0) for value in values]
        check = leave_one_out(parts, narrow, [0], np.array([values.mean()]))
        passed.append(check.passed)
    assert all(passed)


def test_a_manoeuvre_that_wants_the_opposite_is_refused_with_a_narrow_scatter_too() -> None:
    parts = [_manoeuvre(1.4, 12.0)] * 5 + [_manoeuvre(-1.4, 12.0)]
    check = leave_one_out(parts, np.array([0.06]), [0], np.array([0.93]))
    assert check.differences[-1] < check.least[-1]
    assert not check.passed
