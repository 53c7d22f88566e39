"""Gain of discovered terms on data that took no part: the balance's error with and without them.

What is fitted along (mass, drag, scales of the forces) keeps the values of the search in both, so that only the terms
make the difference. The phase of a periodic term has no meaning in another drive and is fitted to it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.balances import LATERAL, LONGITUDINAL, YAW, Problem
from model_diagnosis.discovery.candidates import Candidate, columns_of
from model_diagnosis.discovery.quantities import smoothed, stacked
from model_diagnosis.discovery.regression import fit
from model_diagnosis.gain import HeldOut

FloatArray = NDArray[np.float64]

_SIGNALS = {LONGITUDINAL: "longitudinal_acceleration", LATERAL: "lateral_acceleration", YAW: "yaw_acceleration"}
"""Signal whose error a balance's error is, over the mass or the inertia."""


def signal_of(balance: str) -> str:
    """Name under which the gain of a balance stands."""
    return _SIGNALS.get(balance, balance)


def _forced(problem: Problem) -> FloatArray:
    return np.stack([stacked(one) for one in problem.balance.forced.values()], axis=1)


def _term_columns(problem: Problem, candidates: Sequence[Candidate], phases: Sequence[FloatArray | None]) -> FloatArray:
    """One column per term; a periodic one with the given coefficients of its sines and cosines."""
    variables = {name: smoothed(one) for name, one in problem.variables.items()}
    columns = []
    for candidate, phase in zip(candidates, phases, strict=True):
        own = columns_of(candidate, problem.balance, variables)
        columns.append(own[:, 0] if phase is None else own @ phase)
    return np.stack(columns, axis=1)


def _unit_phases(problem: Problem, candidates: Sequence[Candidate]) -> list[FloatArray | None]:
    """Sine and cosine of each drive for periodic terms, of amplitude 1; None for the others."""
    variables = {name: smoothed(one) for name, one in problem.variables.items()}
    root = np.sqrt(stacked(problem.balance.weights))
    _, error = fit(_forced(problem) * root[:, None], stacked(problem.balance.error) * root)
    phases: list[FloatArray | None] = []
    for candidate in candidates:
        if candidate.kind != "periodic":
            phases.append(None)
            continue
        coefficients, _ = fit(columns_of(candidate, problem.balance, variables) * root[:, None], error)
        amplitudes = np.maximum(np.repeat(np.hypot(coefficients[0::2], coefficients[1::2]), 2), 1e-300)
        phases.append(coefficients / amplitudes)
    return phases


def term_residuals(known: Problem, unseen: Problem, candidates: Sequence[Candidate], scale: float) -> list[HeldOut]:
    """Errors of the balance on unseen drives, without and with terms fitted on known ones.

    Parameters
    ----------
    known, unseen : Problem
        The same balance on the data of the search and on other data.
    scale : float
        Mass [kg] or inertia [kg m²] that makes a signal of the balance's error; 1 leaves it.
    """
    root = np.sqrt(stacked(known.balance.weights))[:, None]
    target = stacked(known.balance.error) * root[:, 0]
    forced = _forced(known) * root
    terms = _term_columns(known, candidates, _unit_phases(known, candidates)) * root
    without, _ = fit(forced, target)
    together, _ = fit(np.concatenate([forced, terms], axis=1), target)
    error, there = stacked(unseen.balance.error), _forced(unseen)
    added = _term_columns(unseen, candidates, _unit_phases(unseen, candidates))
    count = there.shape[1]
    before = (error - there @ without) / scale
    after = (error - there @ together[:count] - added @ together[count:]) / scale
    result, start = [], 0
    for m, part in enumerate(unseen.balance.error):
        rows = slice(start, start + len(part))
        start += len(part)
        weights = unseen.balance.weights[m][:, None]
        result.append(HeldOut(str(m), (signal_of(known.balance.name),), before[rows, None], after[rows, None], weights))
    return result
