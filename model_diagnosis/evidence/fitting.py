"""Fits of the deviations: linearisations of the replay, damped Gauss-Newton with chord steps.

Source: model discrepancy anchor, sections 3.3 and 3.6. A Jacobian costs as much as a hundred replays, so it is computed
at few points, kept between steps and mended by what they do.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.chords import Chords, ShortMatrix
from model_diagnosis.evidence.descent import Descent, unsettled
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic, total
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.side_by_side import side_by_side
from model_diagnosis.evidence.whitening import Whitener
from model_diagnosis.huber import huber_loss, huber_weights
from model_diagnosis.replay.hydraulic import acts_on_pressures

FloatArray = NDArray[np.float64]

MAXIMUM_STEPS = 12

COST_TOLERANCE, ROUGH_TOLERANCE = 0.1, 0.5
"""A step that lowers the cost (twice the negative log posterior) by less, or promises less, ends a fit."""

ROUGH = 20.0
"""Cost whose forecast is not to be relied on, as kinks of the pressures make the residuals' slopes noisy: of a tuning
case's 1069 replays 591 lowered their fit by less than 3 together, after steps that had promised 5 to 15."""


@dataclass(frozen=True)
class Linearisation:
    """Whitened, scaled sensitivities at one point.

    Attributes
    ----------
    theta : (p,) the point
    matrices : (N_m, p) per manoeuvre, whitened, for deviations in units of their effect width
    weights : (N_m,) per manoeuvre, Huber's at the point
    informations : (p, p) per manoeuvre, J'WJ / T
    """

    theta: FloatArray
    matrices: tuple[FloatArray, ...]
    weights: tuple[FloatArray, ...]
    informations: tuple[FloatArray, ...]

    @cached_property
    def short(self) -> tuple[ShortMatrix, ...]:
        """The matrices for slopes, whose cost is to read them."""
        return tuple(ShortMatrix.of(matrix) for matrix in self.matrices)

    @property
    def information(self) -> FloatArray:
        """J'WJ / T of all manoeuvres together."""
        return np.sum(self.informations, axis=0)


@dataclass(frozen=True)
class Fit:
    """Minimum of the cost under one hypothesis.

    Attributes
    ----------
    theta : (p,) deviations in their own units
    cost : twice the negative log posterior, without constants
    misfit : the cost's part from the data
    widths : (p,) prior widths it was fitted with
    fixed : columns held at their value
    """

    theta: FloatArray
    cost: float
    misfit: float
    widths: FloatArray
    fixed: tuple[int, ...] = ()


@dataclass(frozen=True)
class Problem:
    """Replay, priors and whitening: everything that stays the same for all hypotheses."""

    replay: ReplayModel
    priors: Priors
    whitener: Whitener

    @cached_property
    def _parts(self) -> list[NDArray[np.bool_]]:
        """Columns (p,) of the car and those of its hydraulics, as far as there are any."""
        pressures = np.array([acts_on_pressures(column) for column in self.replay.columns])
        return [part for part in (~pressures, pressures) if part.any()]

    @property
    def scale(self) -> FloatArray:
        """Effect width (p,) of each deviation: the unit of z."""
        return self.priors.effect

    def scaled(self, theta: FloatArray) -> FloatArray:
        """Deviations in units of their effect width, from the prior's centre."""
        return (theta - self.priors.centre) / self.scale

    def rows(self, theta: FloatArray) -> list[FloatArray]:
        """Whitened residual (N_m,) per manoeuvre; one replay."""
        return self.whitener.residuals(self.replay.residuals(theta))

    def misfit(self, rows: Sequence[FloatArray]) -> float:
        """Huber's loss of all rows over the temperature."""
        return sum(huber_loss(row) for row in rows) / self.whitener.temperature

    def cost(self, rows: Sequence[FloatArray], theta: FloatArray, widths: FloatArray) -> float:
        """Twice the negative log posterior of theta, without constants."""
        return self.misfit(rows) + float(np.sum(((theta - self.priors.centre) / widths) ** 2))

    def linearise(self, theta: FloatArray, sensitivities: Sequence[FloatArray] | None = None) -> Linearisation:
        """Sensitivities of every column at theta, computed unless given (n, c, p) per manoeuvre."""
        residuals = self.rows(theta)
        raw = self.replay.sensitivities(theta) if sensitivities is None else sensitivities
        matrices = self.whitener.sensitivities([values * self.scale for values in raw])
        weights = tuple(huber_weights(row) for row in residuals)
        return Linearisation(theta.copy(), tuple(matrices), weights, self._informations(matrices, weights))

    def refreshed(self, linearisation: Linearisation, theta: FloatArray, columns: Sequence[int]) -> Linearisation:
        """The same with some columns computed anew at theta; the others stay as chords."""
        chosen = np.asarray(columns, dtype=np.int64)
        fresh = self.whitener.sensitivities(
            [values * self.scale[chosen] for values in self.replay.sensitivities(theta, columns)]
        )
        matrices, informations = [], []
        for matrix, part, weights, known in zip(
            linearisation.matrices, fresh, linearisation.weights, linearisation.informations, strict=True
        ):
            updated = matrix.copy()
            updated[:, chosen] = part
            information = known.copy()
            information[chosen] = (part * weights[:, None]).T @ updated / self.whitener.temperature
            information[:, chosen] = information[chosen].T
            matrices.append(updated)
            informations.append(information)
        return replace(linearisation, theta=theta.copy(), matrices=tuple(matrices), informations=tuple(informations))

    def quadratics(
        self, linearisation: Linearisation, rows: Sequence[FloatArray], theta: FloatArray
    ) -> list[Quadratic]:
        """Log likelihood of each manoeuvre around theta, with the sensitivities of ``linearisation``."""
        scaled, found = self.scaled(theta), []
        for information, matrix, row in zip(linearisation.informations, linearisation.short, rows, strict=True):
            slope = np.zeros(len(scaled))
            slope[matrix.columns] = matrix.slope(huber_weights(row) * row)
            found.append(Quadratic(information, slope / self.whitener.temperature + information @ scaled))
        return found

    def quadratic(self, linearisation: Linearisation, rows: Sequence[FloatArray], theta: FloatArray) -> Quadratic:
        """Log likelihood of all manoeuvres around theta."""
        return total(self.quadratics(linearisation, rows, theta))

    def quadratic_at(self, linearisation: Linearisation, theta: FloatArray) -> Quadratic:
        """The same with the residuals of theta; one replay."""
        return self.quadratic(linearisation, self.rows(theta), theta)

    def fit(
        self,
        linearisation: Linearisation,
        widths: FloatArray,
        start: FloatArray,
        fixed: Sequence[int] = (),
        steps: int = MAXIMUM_STEPS,
        is_rough: bool = False,
    ) -> Fit:
        """Minimise the cost from ``start`` within the bounds, with sensitivities that learn from the steps.

        A rough fit ends sooner: some units of cost above the minimum, with half of the replays.
        """
        precision = (widths / self.scale) ** -2.0

        chords = Chords(
            linearisation.short,
            linearisation.weights,
            linearisation.information,
            precision,
            self.whitener.temperature,
        )

        def gradient(rows: Sequence[FloatArray], theta: FloatArray) -> FloatArray:
            return chords.slope([huber_weights(row) * row for row in rows]) - precision * self.scaled(theta)

        descent = Descent(
            self.rows,
            lambda rows, theta: self.cost(rows, theta, widths),
            gradient,
            lambda: chords.curvature,
            chords.learn,
            self.scale,
            self.priors.low,
            self.priors.high,
            self._parts,
            fixed,
            ROUGH_TOLERANCE if is_rough else COST_TOLERANCE,
            ROUGH if is_rough else 0.0,
        )
        theta, rows, cost = descent.run(start, steps)
        return Fit(theta, cost, self.misfit(rows), widths, tuple(fixed))

    def without_settled(self, gradient: FloatArray, step: FloatArray) -> FloatArray:
        """A step (p,) of z without the columns, of car or hydraulics, that gain next to nothing by it."""
        return np.where(unsettled(gradient, step, self._parts, COST_TOLERANCE), step, 0.0)

    def _informations(self, matrices: Sequence[FloatArray], weights: Sequence[FloatArray]) -> tuple[FloatArray, ...]:
        def of(m: int) -> FloatArray:
            columns = np.flatnonzero(matrices[m].any(axis=0))
            acting = matrices[m][:, columns]
            information = np.zeros((matrices[m].shape[1],) * 2)
            information[np.ix_(columns, columns)] = (acting * weights[m][:, None]).T @ acting
            return information / self.whitener.temperature

        return tuple(side_by_side(of, len(matrices)))
