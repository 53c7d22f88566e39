"""Share of the held-out gain that the true model would give: (E_refit - E_answer) / (E_refit - E_true).

E is the squared error on held-out manoeuvres: of the nominal car refitted within its scatter, of the answer, and of the
same replay with the true effects fitted. Errors of signals with different units are pooled as in a diagnosis.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.challenge.answering import logs_in

GAINING_FAMILIES = ("single", "pair")
"""Families with hidden effects that the catalogue has and that data of all manoeuvres shows."""

WORTH_MEASURING = 0.02
"""Share of the squared error that the true model takes away below which there is nothing to gain."""


def gain_share(case: Path, label: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> float | None:
    """Share reached by an answer to a case of ``GAINING_FAMILIES``; None where nothing is to be gained."""
    names = [effect["name"] for effect in label["effects"]]
    true_ratio = _true_ratio(case, names)
    if true_ratio is None or 1.0 - true_ratio**2 < WORTH_MEASURING:
        return None
    gain = diagnosis.get("gain")
    reached = gain["against_refit"]["ratio"] if gain is not None and gain.get("against_refit") else 1.0
    return float((1.0 - reached**2) / (1.0 - true_ratio**2))


def _true_ratio(case: Path, names: Sequence[str]) -> float | None:
    """Held-out error with the true effects over that of the refitted nominal car; None if the search lacks one."""
    import numpy as np

    from model_diagnosis.data import check_data, read_manoeuvres
    from model_diagnosis.evidence.base import fit_base
    from model_diagnosis.evidence.hypotheses import hypotheses_of
    from model_diagnosis.evidence.priors import Priors
    from model_diagnosis.evidence.search import Search
    from model_diagnosis.gain import held_out_residuals, measure_gain
    from model_diagnosis.held_out import noise_std, refit_within_scatter
    from model_diagnosis.replay import Replay
    from signals.errors import BenchError
    from signals.measured import load_channel_map
    from vehicle_model import load_vehicle

    vehicle, channels = load_vehicle(case / "vehicle.yaml"), load_channel_map(case / "channels.yaml")
    try:
        _, manoeuvres = check_data(read_manoeuvres(logs_in(case / "logs"), channels, vehicle), vehicle, Replay)
        _, held_out = check_data(read_manoeuvres(logs_in(case / "held_out"), channels, vehicle), vehicle, Replay)
    except BenchError:
        return None
    replay, held_out_replay = Replay(vehicle, manoeuvres), Replay(vehicle, held_out)
    base = fit_base(replay, Priors.of(replay.parameters))
    hypotheses = hypotheses_of(replay, [True] * len(replay.columns))
    true = []
    for name in names:
        number = next((n for n, effect in enumerate(replay.effects) if effect.name == name), None)
        mine = [one for one in hypotheses if one.effect == number and one.value is None]
        if not mine:
            return None
        true.append(max(mine, key=lambda one: len(one.columns)))
    search = Search(base.problem, hypotheses)
    fit = search.fit_set(true, base.at_nothing, base.nothing.theta)
    fresh = base.problem.linearise(fit.theta)
    fit = search.fit_set(true, fresh, fit.theta)
    neutral = np.zeros(len(replay.columns))
    refit = refit_within_scatter(base.problem, base.at_nothing, base.nothing.theta)
    residuals = held_out_residuals(held_out_replay, neutral, fit.theta, refit)
    against_refit = measure_gain(residuals, noise_std(held_out_replay)).against_refit
    return None if against_refit is None else float(against_refit.ratio)
