"""A filter object for notebooks, tests and slow loops; hot paths call the kernels directly."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from estimators.kalman.correction import ROW_USED, correct, correct_rows
from estimators.kalman.covariance import FloatArray, IntArray, propagate
from estimators.kalman.sigma_points import (
    correct_points,
    cubature_weights,
    draw_points,
    predict_points,
    unscented_weights,
)


class GaussianFilter:
    """Mean and covariance of a state, predicted and corrected by whichever Kalman filter.

    Linear and extended: :meth:`predict` and :meth:`correct` with matrices. Unscented and cubature:
    :meth:`predict_through` and :meth:`correct_through` with functions.

    Parameters
    ----------
    state, covariance : array_like, shape (n,) and (n, n)
        Initial estimate.
    rule : tuple, optional
        Weights and spread of the sigma points, of :func:`unscented_weights` or :func:`cubature_weights`; the unscented
        ones with their defaults if left out.

    Attributes
    ----------
    state, covariance : array
        Current estimate.
    innovation : float
        Normalised innovation squared of the last correction.
    """

    def __init__(
        self, state: ArrayLike, covariance: ArrayLike, rule: tuple[FloatArray, FloatArray, float] | None = None
    ) -> None:
        self.state = np.array(state, dtype=np.float64)
        self.covariance = np.array(covariance, dtype=np.float64)
        self.innovation = 0.0
        size = len(self.state)
        self._mean_weights, self._covariance_weights, self._spread = rule or unscented_weights(size)
        self._points = np.zeros((2 * size + 1, size))

    def predict(
        self, transition: ArrayLike, noise: ArrayLike, predicted: ArrayLike | None = None, control: ArrayLike = 0.0
    ) -> None:
        """Predict with x <- F x + G u, or x <- ``predicted`` where the model is not linear, and P <- F P F' + Q.

        Parameters
        ----------
        transition, noise : array_like, shape (n, n)
            F, or the Jacobian of the model at the present state, and Q.
        predicted : array_like, shape (n,), optional
            f(x).
        control : array_like, shape (n,)
            G u.
        """
        jacobian = np.asarray(transition, dtype=np.float64)
        self.state = (
            jacobian @ self.state + np.asarray(control, dtype=np.float64)
            if predicted is None
            else np.array(predicted, dtype=np.float64)
        )
        propagate(self.covariance, jacobian, np.asarray(noise, dtype=np.float64), np.empty_like(self.covariance))

    def correct(
        self, measured: ArrayLike, design: ArrayLike, noise: ArrayLike, expected: ArrayLike | None = None
    ) -> float:
        """Correct with a full noise covariance; returns the normalised innovation squared.

        Parameters
        ----------
        measured : array_like, shape (m,)
        design, noise : array_like, shape (m, n) and (m, m)
            H, or the Jacobian of the measurement model, and R.
        expected : array_like, shape (m,), optional
            h(x); H x if left out.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the innovation covariance is not positive definite.
        """
        jacobian = np.asarray(design, dtype=np.float64)
        m, n = jacobian.shape
        self.innovation = correct(
            self.state,
            self.covariance,
            self._residual(measured, jacobian, expected),
            jacobian,
            np.asarray(noise, dtype=np.float64),
            np.empty((n, m)),
            np.empty((2, n, n)),
            np.empty((n, m)),
            np.empty((3, m, m)),
        )
        return self._checked()

    def correct_rows(
        self,
        measured: ArrayLike,
        design: ArrayLike,
        variances: ArrayLike,
        expected: ArrayLike | None = None,
        *,
        rows: IntArray | None = None,
        gate: float = 0.0,
    ) -> float:
        """Correct row by row with independent noise; rows may be missing (NaN in ``measured``, or 0 in ``rows``).

        ``rows`` receives what became of each row; ``gate`` is the largest normalised innovation squared of one row.
        """
        jacobian = np.asarray(design, dtype=np.float64)
        m, n = jacobian.shape
        state = np.full(m, ROW_USED, dtype=np.int64) if rows is None else rows
        residual = self._residual(measured, jacobian, expected)
        state[np.isnan(residual)] = 0
        self.innovation = correct_rows(
            self.state,
            self.covariance,
            residual,
            jacobian,
            np.asarray(variances, dtype=np.float64),
            state,
            gate,
            np.tile(np.arange(n), (m, 1)),
            np.empty((4, n)),
        )
        return self.innovation

    def predict_through(self, model: Callable[[FloatArray], ArrayLike], noise: ArrayLike) -> None:
        """Predict with sigma points sent through ``model``, a function of a state."""
        self._draw()
        for k, point in enumerate(self._points):
            self._points[k] = model(point.copy())
        predict_points(
            self._points,
            self._mean_weights,
            self._covariance_weights,
            np.asarray(noise, dtype=np.float64),
            self.state,
            self.covariance,
        )

    def correct_through(
        self, measured: ArrayLike, model: Callable[[FloatArray], ArrayLike], noise: ArrayLike, *, redraw: bool = True
    ) -> float:
        """Correct with sigma points sent through the measurement ``model``; missing rows are NaN in ``measured``.

        ``redraw`` draws the points anew from the predicted covariance; otherwise the predicted points are used.
        """
        if redraw:
            self._draw()
        outputs = np.array([np.atleast_1d(model(point.copy())) for point in self._points], dtype=np.float64)
        m, n = outputs.shape[1], len(self.state)
        values = np.array(measured, dtype=np.float64).reshape(m)
        rows = np.where(np.isnan(values), 0, 1)
        self.innovation = correct_points(
            self.state,
            self.covariance,
            self._points,
            outputs,
            self._mean_weights,
            self._covariance_weights,
            np.asarray(noise, dtype=np.float64),
            values,
            rows,
            np.empty((2, m)),
            np.empty((2, m, m)),
            np.empty((n, m)),
            np.empty((n, m)),
        )
        return self._checked()

    def _draw(self) -> None:
        if not draw_points(self.state, self.covariance, self._spread, self._points, np.empty_like(self.covariance)):
            raise np.linalg.LinAlgError("the covariance is not positive definite")

    def _checked(self) -> float:
        if np.isnan(self.innovation):
            raise np.linalg.LinAlgError("the innovation covariance is not positive definite")
        return self.innovation

    def _residual(self, measured: ArrayLike, jacobian: FloatArray, expected: ArrayLike | None) -> FloatArray:
        h = jacobian @ self.state if expected is None else np.asarray(expected, dtype=np.float64)
        residual: FloatArray = np.asarray(measured, dtype=np.float64) - h
        return residual


__all__ = ["GaussianFilter", "cubature_weights", "unscented_weights"]
