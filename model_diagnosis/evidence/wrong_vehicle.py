"""Wrong vehicle: several nominal parameters far off explain the data better than a few effects.

The hypothesis is one more: every nominal parameter's scatter is several times what the vehicle file states. It competes
with the selected effects by evidence, so that no count of suspicious parameters has to be chosen.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Application, Group
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.priors import NUISANCE_FLOOR
from model_diagnosis.evidence.quadratic import Quadratic, widening

FloatArray = NDArray[np.float64]

WIDENINGS = (3.0, 6.0, 12.0)
MARGIN = 3.0
"""Log evidence by which the wide scatter must beat the selected effects."""

FAR_OFF = 4.0
"""A nominal parameter is far off beyond this many times its scatter …"""

LEAST_SHARE = 0.1
"""… and this share of its value: less is no other car, however exactly it is known."""

DATA_SHEET = (Group.TYRE, Group.BRAKE, Group.BODY, Group.AERODYNAMICS, Group.STEERING)
"""Groups whose numbers make a car another one."""

PARAMETERS_FAR_OFF = 3


@dataclass(frozen=True)
class WrongVehicle:
    """Outcome of the comparison.

    Attributes
    ----------
    evidence : log Bayes factor of the wide scatter against "nothing"
    far_off : columns of nominal parameters beyond four times their scatter and a tenth of their value, farthest first
    deviations : how far, in units of the scatter
    """

    evidence: float
    far_off: tuple[int, ...]
    deviations: tuple[float, ...]

    def beats(self, selected_evidence: float) -> bool:
        """True if the data speaks for another car rather than for the selected effects."""
        return self.evidence > selected_evidence + MARGIN and len(self.far_off) >= PARAMETERS_FAR_OFF


def nominal_columns(problem: Problem) -> NDArray[np.int64]:
    """Columns of parameters that stand in the vehicle file and scatter from car to car."""
    replay = problem.replay
    return np.array(
        [
            column
            for column, parameter in enumerate(replay.parameters)
            if parameter.vehicle_path
            and replay.effects[int(replay.owner[column])].group in DATA_SHEET
            and (parameter.relative or replay.effects[int(replay.owner[column])].group == Group.BODY)
            and parameter.nuisance_std > NUISANCE_FLOOR * parameter.effect_std
            and replay.effects[int(replay.owner[column])].application == Application.PLANT
        ],
        dtype=np.int64,
    )


def compare(problem: Problem, nothing: Fit, linearisation: Linearisation, start: FloatArray) -> WrongVehicle:
    """Evidence that all nominal parameters scatter more than stated; fits by chords from ``start``."""
    columns = nominal_columns(problem)
    if not len(columns):
        return WrongVehicle(-np.inf, (), ())
    nuisance = problem.priors.nuisance / problem.scale
    _, information = Quadratic(linearisation.information, np.zeros(len(nuisance))).projected(nuisance)
    block = information[np.ix_(columns, columns)]
    evidences, fits = [], []
    for factor in WIDENINGS:
        widths = problem.priors.nuisance.copy()
        widths[columns] *= factor
        fit = problem.fit(linearisation, widths, start)
        added = (factor**2 - 1.0) * nuisance[columns] ** 2
        occam = widening(np.zeros(len(columns)), block, added)
        evidences.append(-0.5 * (fit.cost - nothing.cost) + occam)
        fits.append(fit)
    best = int(np.argmax(evidences))
    evidence = float(np.logaddexp.reduce(evidences) - np.log(len(WIDENINGS)))
    deviation = (fits[best].theta - problem.priors.centre)[columns]
    off = deviation / problem.priors.nuisance[columns]
    order = [
        number
        for number in np.argsort(-np.abs(off))
        if abs(off[number]) > FAR_OFF and abs(deviation[number]) > LEAST_SHARE
    ]
    return WrongVehicle(
        evidence, tuple(int(columns[number]) for number in order), tuple(float(off[number]) for number in order)
    )
