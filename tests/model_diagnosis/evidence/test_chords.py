"""Sensitivities that learn from steps: what the secant condition says, and a valley that constant ones crawl along."""

import numpy as np
import pytest
from numpy.typing import NDArray

from model_diagnosis.evidence.chords import Chords, ShortMatrix
from model_diagnosis.evidence.descent import Descent

FloatArray = NDArray[np.float64]
ROWS, COLUMNS = (40, 25), 5


def _chords(seed: int) -> tuple[Chords, list[FloatArray], list[FloatArray], FloatArray]:
    random = np.random.default_rng(seed)
    matrices = [random.standard_normal((rows, COLUMNS)) for rows in ROWS]
    weights = [random.uniform(0.3, 1.0, rows) for rows in ROWS]
    precision = random.uniform(0.5, 2.0, COLUMNS)
    information = sum((matrix * weight[:, None]).T @ matrix for matrix, weight in zip(matrices, weights, strict=True))
    short = [ShortMatrix.of(matrix) for matrix in matrices]
    return Chords(short, weights, information / 2.0, precision, 2.0), matrices, weights, precision


def test_columns_that_act_nowhere_are_left_out_of_slopes_and_changes() -> None:
    random = np.random.default_rng(9)
    matrix = random.standard_normal((30, COLUMNS)) * np.array([1.0, 0.0, 1.0, 1.0, 0.0])
    short, row, step = ShortMatrix.of(matrix), random.standard_normal(30), random.standard_normal(COLUMNS)
    assert short.values.shape == (30, 3)
    slope = np.zeros(COLUMNS)
    slope[short.columns] = short.slope(row)
    np.testing.assert_allclose(slope, matrix.T @ row, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(short.change(step), matrix @ step, rtol=1e-5, atol=1e-5)


def test_a_step_that_went_as_foreseen_teaches_nothing() -> None:
    chords, matrices, _, _ = _chords(1)
    step = np.linspace(-1.0, 1.0, COLUMNS)
    before = [np.ones(rows) for rows in ROWS]
    after = [row - 1.05 * matrix @ step for row, matrix in zip(before, matrices, strict=True)]
    assert not chords.learn(step, before, after)


def test_steps_that_were_missed_are_foreseen_afterwards_and_the_curvature_is_that_of_the_mended_matrices() -> None:
    """Broyden's conditions: J s is the change seen, nothing changes across s. Numpy's own products are the oracle."""
    chords, matrices, weights, precision = _chords(2)
    random = np.random.default_rng(3)
    true = [matrix.copy() for matrix in matrices]
    for _ in range(3):
        step = random.standard_normal(COLUMNS)
        change = [3.0 * random.standard_normal(rows) for rows in ROWS]
        before = [random.standard_normal(rows) for rows in ROWS]
        assert chords.learn(step, before, [row - moved for row, moved in zip(before, change, strict=True)])
        for matrix, moved in zip(true, change, strict=True):
            matrix += np.outer(moved - matrix @ step, step) / (step @ step)
    curvature = sum((matrix * weight[:, None]).T @ matrix for matrix, weight in zip(true, weights, strict=True)) / 2.0
    assert chords.curvature == pytest.approx(curvature + np.diag(precision), rel=1e-4, abs=1e-3)
    rows = [random.standard_normal(count) for count in ROWS]
    slope = sum(matrix.T @ row for matrix, row in zip(true, rows, strict=True)) / 2.0
    assert chords.slope(rows) == pytest.approx(slope, rel=1e-4, abs=1e-3)


def test_rows_that_are_no_numbers_teach_nothing() -> None:
    chords, _, _, _ = _chords(4)
    before = [np.ones(rows) for rows in ROWS]
    assert not chords.learn(np.ones(COLUMNS), before, [np.full(rows, np.nan) for rows in ROWS])


@pytest.mark.parametrize("learning", [True, False])
def test_a_reciprocal_is_found_from_far_off(learning: bool) -> None:
    """A compliance 1/k seen beside a slope: r = y - a/k - b, true k = 0.35 of the start's, which chords alone miss."""
    random = np.random.default_rng(5)
    first, second = random.standard_normal(80), 1.0 + 0.3 * random.standard_normal(80)
    first += 0.8 * second

    def rows(theta: FloatArray) -> list[FloatArray]:
        return [30.0 * (first * (1.0 / 0.35 - 1.0 / theta[0]) + second * (0.2 - theta[1]))]

    start = np.array([1.0, 0.0])
    matrix = 30.0 * np.stack([-first, second], axis=1)  # d(prediction)/d(theta) at the start
    chords = Chords([ShortMatrix.of(matrix)], [np.ones(80)], matrix.T @ matrix, np.full(2, 1e-9), 1.0)
    descent = Descent(
        rows,
        lambda row, theta: float(row[0] @ row[0]),
        lambda row, theta: chords.slope(row),
        lambda: chords.curvature,
        chords.learn if learning else lambda *_: False,
        np.ones(2),
        np.array([0.1, -5.0]),
        np.array([5.0, 5.0]),
        (np.ones(2, dtype=np.bool_),),
        (),
        1e-3,
        0.0,
    )
    _, _, cost = descent.run(start, 12)
    assert (cost < 1.0) == learning
