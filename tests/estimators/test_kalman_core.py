"""Kalman core against an independent library and against its own definitions."""

import numpy as np
import pytest
from filterpy.kalman import (
    CubatureKalmanFilter,
    ExtendedKalmanFilter,
    KalmanFilter,
    MerweScaledSigmaPoints,
    UnscentedKalmanFilter,
)

from estimators.kalman.consistency import chi_square_band, normalised_estimation_error
from estimators.kalman.correction import ROW_GATED, ROW_MISSING, ROW_USED, correct_row
from estimators.kalman.covariance import cholesky, propagate_sparse
from estimators.kalman.filters import GaussianFilter, cubature_weights, unscented_weights
from estimators.kalman.floored_covariance import floor_covariance

TOLERANCE = 1e-9


def linear_problem(seed: int, n: int = 4, m: int = 3):
    """A stable random linear system with correlated process noise."""
    random = np.random.default_rng(seed)
    f = np.eye(n) + 0.1 * random.standard_normal((n, n))
    f /= max(1.0, np.abs(np.linalg.eigvals(f)).max())
    root = 0.1 * random.standard_normal((n, n))
    q = root @ root.T + 1e-4 * np.eye(n)
    h = random.standard_normal((m, n))
    r = np.diag(random.uniform(0.05, 0.5, m))
    x = random.standard_normal(n)
    states, measured = [], []
    for _ in range(200):
        x = f @ x + np.linalg.cholesky(q) @ random.standard_normal(n)
        states.append(x)
        measured.append(h @ x + np.sqrt(np.diag(r)) * random.standard_normal(m))
    return f, q, h, r, np.array(states), np.array(measured)


def rolling(x: np.ndarray) -> np.ndarray:
    """A nonlinear transition: a pendulum with an unknown stiffness."""
    return np.array([x[0] + 0.05 * x[1], x[1] - 0.05 * x[2] * np.sin(x[0]), x[2]])


def range_and_angle(x: np.ndarray) -> np.ndarray:
    return np.array([np.sqrt(1.0 + x[0] ** 2), x[1] * (1.0 + 0.1 * x[0])])


@pytest.mark.acceptance("F-16")
def test_linear_filter_equals_filterpy(record):
    f, q, h, r, _, measured = linear_problem(1)
    reference = KalmanFilter(dim_x=4, dim_z=3)
    reference.F, reference.Q, reference.H, reference.R = f, q, h, r
    reference.x, reference.P = np.zeros((4, 1)), 2.0 * np.eye(4)
    batch = GaussianFilter(np.zeros(4), 2.0 * np.eye(4))
    rows = GaussianFilter(np.zeros(4), 2.0 * np.eye(4))
    worst = 0.0
    for y in measured:
        reference.predict()
        reference.update(y.reshape(3, 1))
        for own in (batch, rows):
            own.predict(f, q)
        batch.correct(y, h, r)
        rows.correct_rows(y, h, np.diag(r))
        for own in (batch, rows):
            worst = max(worst, np.abs(own.state - reference.x[:, 0]).max(), np.abs(own.covariance - reference.P).max())
            assert own.innovation == pytest.approx(reference.mahalanobis**2, rel=1e-9)
    record("largest difference to filterpy", worst, "1e-9")
    assert worst < TOLERANCE


@pytest.mark.acceptance("F-16")
def test_extended_filter_equals_filterpy():
    def jacobian(x):
        return np.array([[1.0, 0.05, 0.0], [-0.05 * x[2] * np.cos(x[0]), 1.0, -0.05 * np.sin(x[0])], [0.0, 0.0, 1.0]])

    def design(x):
        return np.array([[x[0] / np.sqrt(1.0 + x[0] ** 2), 0.0, 0.0], [0.1 * x[1], 1.0 + 0.1 * x[0], 0.0]])

    reference = ExtendedKalmanFilter(dim_x=3, dim_z=2)
    start, q, r = np.array([0.5, 0.0, 4.0]), 1e-4 * np.eye(3), np.diag([0.01, 0.02])
    reference.x, reference.P, reference.Q, reference.R = start.copy(), 0.1 * np.eye(3), q, r
    own = GaussianFilter(start, 0.1 * np.eye(3))
    random = np.random.default_rng(2)
    truth = np.array([0.6, 0.1, 5.0])
    for _ in range(300):
        truth = rolling(truth)
        y = range_and_angle(truth) + np.sqrt(np.diag(r)) * random.standard_normal(2)
        reference.F = jacobian(reference.x)
        predicted = rolling(reference.x)
        reference.P = reference.F @ reference.P @ reference.F.T + q
        reference.x = predicted
        own.predict(jacobian(own.state), q, rolling(own.state))
        reference.update(y, design, range_and_angle)
        own.correct(y, design(own.state), r, range_and_angle(own.state))
        assert np.abs(own.state - reference.x).max() < TOLERANCE
        assert np.abs(own.covariance - reference.P).max() < TOLERANCE


@pytest.mark.parametrize("alpha", [1e-1, 1.0])
def test_unscented_filter_equals_filterpy(alpha):
    points = MerweScaledSigmaPoints(3, alpha=alpha, beta=2.0, kappa=0.5)
    reference = UnscentedKalmanFilter(3, 2, 0.05, lambda x: range_and_angle(x), lambda x, dt: rolling(x), points)
    start, q, r = np.array([0.5, 0.0, 4.0]), 1e-3 * np.eye(3), np.diag([0.01, 0.02])
    reference.x, reference.P, reference.Q, reference.R = start.copy(), 0.1 * np.eye(3), q, r
    own = GaussianFilter(start, 0.1 * np.eye(3), unscented_weights(3, alpha, 2.0, 0.5))
    _compare_sigma_filters(own, reference, q, r, redraw=True)


def test_cubature_filter_equals_filterpy():
    reference = CubatureKalmanFilter(3, 2, 0.05, lambda x: range_and_angle(x), lambda x, dt: rolling(x))
    start, q, r = np.array([0.5, 0.0, 4.0]), 1e-3 * np.eye(3), np.diag([0.01, 0.02])
    reference.x, reference.P, reference.Q, reference.R = start.reshape(3, 1), 0.1 * np.eye(3), q, r
    own = GaussianFilter(start, 0.1 * np.eye(3), cubature_weights(3))
    _compare_sigma_filters(own, reference, q, r, redraw=False)


def _compare_sigma_filters(own, reference, q, r, redraw):
    random = np.random.default_rng(3)
    truth = np.array([0.6, 0.1, 5.0])
    for _ in range(100):
        truth = rolling(truth)
        y = range_and_angle(truth) + np.sqrt(np.diag(r)) * random.standard_normal(2)
        reference.predict()
        reference.update(y if redraw else y.reshape(2, 1))
        own.predict_through(rolling, q)
        own.correct_through(y, range_and_angle, r, redraw=redraw)
        assert np.abs(own.state - np.ravel(reference.x)).max() < TOLERANCE
        assert np.abs(own.covariance - reference.P).max() < TOLERANCE


@pytest.mark.acceptance("F-16")
def test_covariance_stays_symmetric_and_positive_definite():
    f, q, h, _, _, measured = linear_problem(4)
    own = GaussianFilter(np.zeros(4), 1e6 * np.eye(4))
    for y in measured:
        own.predict(f, q)
        own.correct_rows(y, h, [1e-8, 1.0, 1e4])
        assert np.array_equal(own.covariance, own.covariance.T)
        assert np.linalg.eigvalsh(own.covariance).min() > 0.0


def test_joseph_form_holds_for_any_gain():
    """Eq. 50 with a gain that is not optimal: the covariance of (I - K H) e - K z, by definition."""
    from estimators.kalman.correction import joseph

    random = np.random.default_rng(5)
    root = random.standard_normal((4, 4))
    p = root @ root.T
    gain, design, noise = random.standard_normal((4, 2)), random.standard_normal((2, 4)), np.diag([0.3, 0.7])
    left = np.eye(4) - gain @ design
    expected = left @ p @ left.T + gain @ noise @ gain.T
    joseph(p, gain, design, noise, np.empty((2, 4, 4)), np.empty((4, 2)))
    assert np.abs(p - expected).max() < 1e-12


def test_missing_rows_are_left_out():
    _, _, h, r, _, measured = linear_problem(6)
    full, part = GaussianFilter(np.zeros(4), np.eye(4)), GaussianFilter(np.zeros(4), np.eye(4))
    part.correct(measured[0][[0, 2]], h[[0, 2]], r[np.ix_([0, 2], [0, 2])])
    y = measured[0].copy()
    y[1] = np.nan
    rows = np.full(3, ROW_USED)
    full.correct_rows(y, h, np.diag(r), rows=rows)
    assert list(rows) == [ROW_USED, ROW_MISSING, ROW_USED]
    assert np.abs(full.state - part.state).max() < 1e-12
    assert np.abs(full.covariance - part.covariance).max() < 1e-12

    through = GaussianFilter(np.zeros(4), np.eye(4))
    through.correct_through(y, lambda x: h @ x, r)
    assert np.abs(through.state - part.state).max() < 1e-9


def test_gate_leaves_out_an_implausible_row():
    own, reference = GaussianFilter(np.zeros(4), np.eye(4)), GaussianFilter(np.zeros(4), np.eye(4))
    _, _, h, r, _, _ = linear_problem(7)
    rows = np.full(3, ROW_USED)
    y = np.array([0.1, 1e4, -0.2])
    own.correct_rows(y, h, np.diag(r), rows=rows, gate=16.0)
    assert list(rows) == [ROW_USED, ROW_GATED, ROW_USED]
    reference.correct_rows(np.where(y > 1e3, np.nan, y), h, np.diag(r))
    assert np.array_equal(own.state, reference.state)


def test_sparse_propagation_equals_dense():
    random = np.random.default_rng(8)
    f = np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.3, 0.0, 0.5]])
    columns = np.array([[0, 1], [1, -1], [0, 2]])
    root = random.standard_normal((3, 3))
    p = root @ root.T
    expected = f @ p @ f.T + np.diag([0.1, 0.2, 0.3])
    propagate_sparse(p, f, columns, np.array([0.1, 0.2, 0.3]), np.empty((3, 3)))
    assert np.abs(p - expected).max() < 1e-12


def test_cholesky_refuses_what_is_not_positive_definite():
    assert not cholesky(np.array([[1.0, 2.0], [2.0, 1.0]]), np.empty((2, 2)))
    assert not cholesky(np.array([[np.nan, 0.0], [0.0, 1.0]]), np.empty((2, 2)))


def test_a_row_returns_its_innovation():
    p, moved = np.array([[4.0]]), np.zeros(1)
    squared = correct_row(moved, p, 2.0, np.array([1.0]), np.array([0]), 1.0, 0.0, np.empty((3, 1)))
    assert squared == pytest.approx(4.0 / 5.0)
    assert p[0, 0] == pytest.approx(4.0 / 5.0)
    assert moved[0] == pytest.approx(2.0 * 4.0 / 5.0)


def test_statistics_are_inside_their_band_over_200_runs():
    """NEES and NIS of a filter whose noise model is true, at the end of 200 independent runs."""
    nees, nis = [], []
    for seed in range(200):
        f, q, h, r, _, _ = linear_problem(11)
        random = np.random.default_rng(1000 + seed)
        own = GaussianFilter(random.standard_normal(4), np.eye(4))
        x = own.state + random.standard_normal(4)
        for _ in range(30):
            x = f @ x + np.linalg.cholesky(q) @ random.standard_normal(4)
            own.predict(f, q)
            own.correct_rows(h @ x + np.sqrt(np.diag(r)) * random.standard_normal(3), h, np.diag(r))
        nees.append(normalised_estimation_error(x - own.state, own.covariance))
        nis.append(own.innovation)
    assert chi_square_band(nees, 4).inside
    assert chi_square_band(nis, 3).inside
    assert not chi_square_band(np.array(nees) * 2.0, 4).inside


def test_a_covariance_that_lost_its_definiteness_is_raised_to_the_nearest_that_has_a_factor():
    """Against numpy's eigenvalues: those below the floor are raised to it, the others and all vectors stay."""
    random = np.random.default_rng(5)
    for _ in range(50):
        vectors = np.linalg.qr(random.standard_normal((6, 6)))[0]
        values = np.array([3.0, 1.0, 0.2, 1e-3, -1e-4, -0.05])
        covariance = (vectors * values) @ vectors.T
        factor, work = np.zeros((6, 6)), np.zeros((6, 6))
        expected = (vectors * np.maximum(values, 3e-9)) @ vectors.T
        floor_covariance(covariance, factor, work)
        assert np.allclose(covariance, expected, rtol=0.0, atol=1e-12)
        assert np.allclose(np.tril(factor) @ np.tril(factor).T, covariance, rtol=0.0, atol=1e-12)
