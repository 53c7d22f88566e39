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
