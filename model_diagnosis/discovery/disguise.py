"""Is a discovered term an effect of the catalogue in disguise?

Each effect moves the same balance by some columns; after the forced columns are taken out of both, the largest
canonical correlation with the term says how far they are the same on this data.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.balances import problems_of
from model_diagnosis.discovery.candidates import columns_of
from model_diagnosis.discovery.quantities import Balance, Variable, smoothed, stacked
from model_diagnosis.discovery.regression import orthonormal, without
from model_diagnosis.discovery.search import DiscoveredTerm
from model_diagnosis.effects.catalogue import EFFECTS
from model_diagnosis.effects.conditions import only_in
from model_diagnosis.effects.effect import Application
from model_diagnosis.replay.replay import Replay

FloatArray = NDArray[np.float64]

SAME_EFFECT = 0.95
_STEP = 0.2
_NAMES = frozenset(effect.name for effect in EFFECTS)
"""Not those that only describe the replay's own form."""


def effect_columns(replay: Replay, theta: FloatArray, balance: Balance) -> dict[str, FloatArray]:
    """Change of a balance's error by each parameter of each effect of the car: effect -> (N, parameters)."""
    start = stacked(balance.error)
    result: dict[str, list[FloatArray]] = {}
    for place, parameter in enumerate(replay.parameters):
        effect = replay.effects[replay.owner[place]]
        if effect.application is not Application.PLANT or effect.discrete or effect.name not in _NAMES:
            continue
        if only_in(replay.columns[place]) is not None:
            continue
        step = _STEP * parameter.effect_std
        moved = theta.copy()
        moved[place] += step if theta[place] + step <= parameter.high else -step
        problems = problems_of(replay, moved, [balance.name])
        if problems:
            change = (stacked(problems[0].balance.error) - start) / (moved[place] - theta[place])
            result.setdefault(effect.name, []).append(change)
    return {name: np.stack(columns, axis=1) for name, columns in result.items()}


def disguised_as(
    term: DiscoveredTerm, balance: Balance, columns: FloatArray, effects: Mapping[str, FloatArray]
) -> dict[str, float]:
    """Effects that say the same as a term, with their canonical correlation, the closest first.

    Parameters
    ----------
    columns : (N, d) of the term, see `term_columns`
    effects : (N, k) of each effect, see `effect_columns`
    """
    root = np.sqrt(stacked(balance.weights))[:, None]
    forced = orthonormal(np.stack([stacked(one) for one in balance.forced.values()], axis=1) * root)
    own = orthonormal(without(forced, columns * root))
    found = {}
    for name, moved in effects.items():
        weighted = moved * root
        left = without(forced, weighted)
        shown = np.linalg.norm(left, axis=0) > 1e-2 * np.maximum(np.linalg.norm(weighted, axis=0), 1e-300)
        basis = orthonormal(left[:, shown]) if shown.any() else np.zeros((len(left), 0))
        if basis.shape[1] and own.shape[1]:
            correlation = float(np.linalg.svd(own.T @ basis, compute_uv=False)[0])
            if correlation > SAME_EFFECT:
                found[name] = correlation
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def term_columns(term: DiscoveredTerm, balance: Balance, variables: Mapping[str, Variable]) -> FloatArray:
    """Columns (N, d) of a term on the data of its balance."""
    return columns_of(term.candidate, balance, {name: smoothed(one) for name, one in variables.items()})
