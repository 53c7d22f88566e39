"""Share of the held-out gain that the true model would give: (E_refit - E_answer) / (E_refit - E_true).

E is the squared error on held-out manoeuvres: of the nominal car refitted within its scatter, of the answer, and of the
same replay with the true effects or the true law fitted. Errors of signals with different units are pooled as in a
diagnosis.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bench.challenge.answering import logs_in
from bench.challenge.generator import torque_courses
from bench.challenge.hidden_law import LAW_NAME, Courses, with_hidden_law

if TYPE_CHECKING:
    from model_diagnosis.evidence.base import Base
    from model_diagnosis.evidence.fitting import Fit
    from model_diagnosis.replay import Replay

GAINING_FAMILIES = ("single", "pair", "unknown")
"""Families whose hidden effects or law data of all manoeuvres shows."""

WORTH_MEASURING = 0.02
"""Share of the squared error that the true model takes away below which there is nothing to gain."""


class HeldOutErrors(NamedTuple):
    """Squared errors on held-out manoeuvres over those of the vehicle as given: of the refit, and of what is hidden."""

    refit: float
    truth: float

    def share_reached(self, answered: float) -> float | None:
        """Share of the possible gain that an answer with such an error reaches; None where nothing is to be gained."""
        if 1.0 - self.truth / self.refit < WORTH_MEASURING:
            return None
        return (self.refit - answered) / (self.refit - self.truth)


def gain_share(
    case: Path, label: Mapping[str, Any], diagnosis: Mapping[str, Any], drawn_with: Mapping[str, Any]
) -> float | None:
    """Share reached by an answer to a case of ``GAINING_FAMILIES``; None where nothing is to be gained.

    ``drawn_with`` are seed, index, family and generator of the case. Answer and truth are compared with one refit; that
    of the diagnosis, with sensitivities taken at its answer, is another one and depends on the answer.
    """
    courses = torque_courses(**drawn_with) if label["unknown"] is not None else None
    errors = _held_out_errors(case, label, courses)
    if errors is None:
        return None
    gain = diagnosis.get("gain")
    return errors.share_reached(errors.refit if gain is None else gain["overall"]["ratio"] ** 2)


def _held_out_errors(case: Path, label: Mapping[str, Any], courses: Courses | None) -> HeldOutErrors | None:
    """What the nominal car and what is hidden leave once they are fitted; None if the search lacks it."""
    import numpy as np

    from model_diagnosis.evidence.car_numbers import refit_within_scatter
    from model_diagnosis.gain import held_out_residuals, measure_gain
    from model_diagnosis.held_out import noise_std
    from signals.errors import BenchError

    try:
        replay, held_out = replays_of(case, courses)
    except BenchError:
        return None
    found = fit_of_truth(replay, label)
    if found is None:
        return None
    base, fit = found
    refit = refit_within_scatter(base.problem, base.at_nothing, base.nothing.theta)
    # "nothing" may be many scatters off where an effect is: sensitivities from where the refit is
    refit = refit_within_scatter(base.problem, base.problem.linearise(refit), refit)
    as_given, noise = np.zeros(len(refit)), noise_std(held_out)
    ratios = (
        measure_gain(held_out_residuals(held_out, as_given, theta), noise).overall.ratio for theta in (refit, fit.theta)
    )
    return HeldOutErrors(*(float(ratio) ** 2 for ratio in ratios))


def fit_of_truth(replay: "Replay", label: Mapping[str, Any]) -> "tuple[Base, Fit] | None":
    """Fit of "nothing" and of what a label says is hidden; None if the search lacks it."""
    from model_diagnosis.evidence.base import fit_base
    from model_diagnosis.evidence.hypotheses import hypotheses_of
    from model_diagnosis.evidence.priors import Priors
    from model_diagnosis.evidence.search import Search

    base = fit_base(replay, Priors.of(replay.parameters))
    hypotheses = hypotheses_of(replay, [True] * len(replay.columns))
    true = []
    for name in [effect["name"] for effect in label["effects"]] or [LAW_NAME]:
        number = next((n for n, effect in enumerate(replay.effects) if effect.name == name), None)
        mine = [one for one in hypotheses if one.effect == number and one.value is None]
        if not mine:
            return None
        true.append(max(mine, key=lambda one: len(one.columns)))
    search = Search(base.problem, hypotheses)
    fit = search.fit_set(true, base.at_nothing, base.nothing.theta)
    fresh = base.problem.linearise(fit.theta)
    return base, search.fit_set(true, fresh, fit.theta)


def replays_of(case: Path, courses: Courses | None) -> "tuple[Replay, Replay]":
    """Replays of a case's logs and of its held-out ones, with the hidden law where its courses are given."""
    from model_diagnosis.data import check_data, read_manoeuvres
    from model_diagnosis.data.holding_out import check_held_out
    from model_diagnosis.replay import Replay
    from signals.measured import load_channel_map
    from vehicle_model import load_vehicle

    vehicle, channels = load_vehicle(case / "vehicle.yaml"), load_channel_map(case / "channels.yaml")
    searched, held_out = (read_manoeuvres(logs_in(case / folder), channels, vehicle) for folder in ("logs", "held_out"))
    faults, searched = check_data(searched, vehicle, Replay)
    both = Replay(vehicle, searched), Replay(vehicle, check_held_out(held_out, faults, vehicle, Replay))
    return both if courses is None else (with_hidden_law(both[0], courses), with_hidden_law(both[1], courses))
