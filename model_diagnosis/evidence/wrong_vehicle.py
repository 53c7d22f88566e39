"""Wrong vehicle: several nominal parameters far off explain the data better than a few effects.

The hypothesis is one more: every nominal parameter's scatter is several times what the vehicle file states. It competes
with the selected effects by evidence, so that no count of suspicious parameters has to be chosen.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Effect, Group
from model_diagnosis.evidence.car_numbers import CarNumbers, nominal_columns
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.form_heat import own_direction
from model_diagnosis.evidence.priors import Priors, with_commons

FloatArray = NDArray[np.float64]

WIDENINGS = (3.0, 6.0, 12.0)
MARGIN = 3.0
"""Log evidence by which the wide scatter must beat the selected effects."""

FAR_OFF = 4.0
"""A nominal parameter is far off beyond this many times its scatter …"""

LEAST_SHARE = 0.1
"""… and this share of its value: less is no other car, however exactly it is known …"""

SURELY = 3.0
"""… and so many of its standard deviations in that car: where the data cannot tell numbers apart, all of them move."""

DATA_SHEET = (Group.TYRE, Group.BRAKE, Group.BODY, Group.AERODYNAMICS, Group.STEERING)
"""Groups whose numbers make a car another one."""

PARAMETERS_FAR_OFF = 3
"""Numbers of a data sheet that have to be far off; of a wheel on a rig, whose sheet has three, more than half."""

SUSPICIOUS_SHARE = 0.5
"""Share of being far off from which a number counts in the first fit."""

LATER_GAIN = 20.0
"""Log evidence that the fits after the first one may gain: 3 was the most in two tuning cases, and the freedom cost 60
to 85."""


@dataclass(frozen=True)
class WrongVehicle:
    """Outcome of the comparison.

    Attributes
    ----------
    evidence : log Bayes factor of the wide scatter against "nothing"
    cost : of the fit with the wide scatter that says most
    far_off : columns of nominal parameters surely beyond four times their scatter and a tenth of their value, farthest
        first
    deviations : how far, in units of the scatter
    numbers : that other car; None where the replay has no nominal numbers
    needed : numbers that have to be far off
    """

    evidence: float
    cost: float
    far_off: tuple[int, ...]
    deviations: tuple[float, ...]
    numbers: CarNumbers | None = None
    needed: int = PARAMETERS_FAR_OFF

    def beats(self, selected_evidence: float, selected_cost: float, is_incomplete: bool = False) -> bool:
        """True if the data speaks for another car rather than for the selected effects.

        ``is_incomplete`` says that the answer, full of numbers of the car, has no place for a further effect that the
        data asks for. So many are off that another car has to fit better than the answer only: widening every number's
        scatter costs 125 of log evidence, whatever is off, and four effects less.
        """
        says_more = self.evidence > selected_evidence + MARGIN
        fits_better = is_incomplete and self.cost < selected_cost
        return (says_more or fits_better) and len(self.far_off) >= self.needed


def are_of_the_car(effects: Sequence[Effect]) -> bool:
    """True where most of these effects are of what a data sheet describes: roads and sensors make no other car."""
    return 2 * sum(one.group in DATA_SHEET for one in effects) > len(effects)


def is_of_data_sheet(problem: Problem, column: int) -> bool:
    """True for a number that makes a car another one when it is far off."""
    group = problem.replay.effects[int(problem.replay.owner[column])].group
    return group in DATA_SHEET and (problem.replay.parameters[column].relative or group == Group.BODY)


def compare(
    problem: Problem,
    nothing: Fit,
    linearisations: Sequence[Linearisation],
    starts: Sequence[FloatArray],
    named: float = 0.0,
) -> WrongVehicle:
    """Evidence that all nominal parameters scatter more than stated, against ``nothing``.

    Another car is far from the vehicle file, and the chords of one point do not lead there: the best fit over all
    ``linearisations`` and ``starts`` counts, with sensitivities taken anew at it; every widening is fitted from there.
    That is left out where the first fit promises no other car: with too few numbers off, or far less evidence than
    ``named``, what the selected effects say.
    """
    columns = nominal_columns(problem)
    if not len(columns):
        return WrongVehicle(-np.inf, np.inf, (), ())
    # another car's numbers are counted from the file one by one, with nothing that two of them have in common
    parameters = problem.replay.parameters
    stated = Priors.of(parameters, in_common=False).nuisance
    starts = [with_commons(start, parameters) for start in starts]
    widths = {factor: stated.copy() for factor in WIDENINGS}
    for factor in WIDENINGS:
        widths[factor][columns] *= factor
    usual = widths[WIDENINGS[len(WIDENINGS) // 2]]
    near = min((problem.fit(one, usual, start) for one in linearisations for start in starts), key=_cost)
    off = (near.theta - problem.priors.centre)[columns]
    suspicious = (np.abs(off) > SUSPICIOUS_SHARE * FAR_OFF * stated[columns]) & (
        np.abs(off) > SUSPICIOUS_SHARE * LEAST_SHARE
    )
    sheet = np.array([is_of_data_sheet(problem, int(column)) for column in columns])
    needed = min(PARAMETERS_FAR_OFF, 1 + int(sheet.sum()) // 2)
    if np.count_nonzero(suspicious & sheet) < needed or 0.5 * (nothing.cost - near.cost) + LATER_GAIN < named + MARGIN:
        return WrongVehicle(-np.inf, np.inf, (), ())
    fresh = problem.linearise(near.theta)
    fits = [problem.fit(fresh, widths[factor], near.theta) for factor in WIDENINGS]
    directions = [
        own_direction(problem, fresh, fit.theta, columns, stated / problem.scale, widths[factor] / problem.scale)
        for fit, factor in zip(fits, WIDENINGS, strict=True)
    ]
    evidences = [direction.tempered(nothing.cost - fit.cost) for direction, fit in zip(directions, fits, strict=True)]
    best = int(np.argmax(evidences))
    evidence = float(np.logaddexp.reduce(evidences) - np.log(len(WIDENINGS)))
    deviation = fits[best].theta - problem.priors.centre
    off = deviation / stated
    std = np.zeros(len(deviation))
    std[columns] = np.sqrt(np.diag(directions[best].covariance)) * problem.scale[columns]
    least = np.maximum(np.maximum(FAR_OFF * stated, LEAST_SHARE), SURELY * std)
    order = [
        int(column)
        for column in columns[np.argsort(-np.abs(off[columns]))]
        if abs(deviation[column]) > least[column] and is_of_data_sheet(problem, column)
    ]
    return WrongVehicle(
        evidence,
        fits[best].cost,
        tuple(order),
        tuple(float(off[column]) for column in order),
        CarNumbers(fits[best].theta, columns.tolist(), std[columns].tolist()),
        needed,
    )


def _cost(fit: Fit) -> float:
    return fit.cost
