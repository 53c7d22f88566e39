"""Two causes in the place of one that has several deviations.

A forward selection takes the effect that says most at once: offsets of an accelerometer along and across stand for a
slope and a bank, which say less one by one. No swap of one for one comes back from there.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from model_diagnosis.evidence.fitting import Fit, Linearisation
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.stage import SWAP_GAIN, linear_evidence, ratios, smaller_than_named

if TYPE_CHECKING:
    from model_diagnosis.evidence.selection import Selector

TRIED = 2
"""Answers of each kind that are fitted, those that say most by sensitivities."""


@dataclass(frozen=True)
class Answer:
    """Effects that are present, with their fit and the sensitivities and the log evidence there."""

    chosen: list[Hypothesis]
    fit: Fit
    linearisation: Linearisation
    evidence: float


def split(
    selector: "Selector", chosen: Sequence[Hypothesis], fit: Fit, linearisation: Linearisation, needed: float
) -> Answer | None:
    """The answer with two causes for one, where it says more by what a further cause ``needed``; else None."""
    if not any(len(one.columns) > 1 for one in chosen):
        return None
    whole = Answer(list(chosen), fit, linearisation, selector.evidence_of(chosen, fit, linearisation))
    for trial in _best(_with_two_for_one(selector, whole)):
        parted = _settled(selector, _fitted(selector, whole, trial))
        gained = parted.evidence - whole.evidence
        if gained > needed and _stand(selector, parted, needed):
            one, other = (selector.name(hypothesis) for hypothesis in parted.chosen[-2:])
            selector.decisions.append(f"split into {one} and {other}: {gained:.1f} better than one cause")
            return parted
    return None


def _best(promising: Iterable[tuple[float, list[Hypothesis]]]) -> list[list[Hypothesis]]:
    """Those sets of effects that gain most by sensitivities."""
    order = sorted((one for one in promising if one[0] > 0.0), key=lambda one: -one[0])
    return [chosen for _, chosen in order[:TRIED]]


def _fitted(selector: "Selector", before: Answer, chosen: list[Hypothesis]) -> Answer:
    """Another set of effects fitted from where its sensitivities at an answer lead."""
    problem = selector.problem
    mean, _ = problem.quadratic_at(before.linearisation, before.fit.theta).posterior(ratios(problem, chosen))
    start = problem.priors.centre + problem.scale * mean
    fit, linearisation = selector.polish(selector.search.fit_set(chosen, before.linearisation, start))
    return Answer(chosen, fit, linearisation, selector.evidence_of(chosen, fit, linearisation))


def _settled(selector: "Selector", answer: Answer) -> Answer:
    """The answer with each of its last two effects in turn replaced by another that says more in its place."""
    for place in (-2, -1):
        for trial in _best(_with_another(selector, answer, place)):
            other = _fitted(selector, answer, trial)
            if other.evidence > answer.evidence + SWAP_GAIN:
                answer = other
                break
    return answer


def _stand(selector: "Selector", answer: Answer, needed: float) -> bool:
    """True where each of the last two effects passes the checks of a cause beside the others."""
    for one in answer.chosen[-2:]:
        # beside others "nothing" is not asked: any fit stands for it
        judged = selector.judged(answer.chosen, one, answer.fit, answer.linearisation, answer.fit)
        if judged.evidence <= needed or judged.bic_change >= 0.0 or not judged.held_out.passed:
            return False
        if smaller_than_named(selector.problem, one, answer.fit.theta):
            return False
    return True


def _with_two_for_one(selector: "Selector", answer: Answer) -> Iterator[tuple[float, list[Hypothesis]]]:
    """Each effect less some of its deviations, with the best other effect beside it; what that gains."""
    quadratic = selector.problem.quadratic_at(answer.linearisation, answer.fit.theta)
    others = _free(selector, answer.chosen)
    for cause in answer.chosen if others else ():
        rest = [one for one in answer.chosen if one is not cause]
        smaller = [
            one
            for one in selector.search.hypotheses
            if one.effect == cause.effect and set(one.columns) < set(cause.columns) and one.value is None
        ]
        own = linear_evidence(selector.problem, quadratic, [cause, *smaller], rest)
        for parted, value in zip(smaller, own[1:], strict=True):
            beside = linear_evidence(selector.problem, quadratic, others, [*rest, parted])
            best = int(beside.argmax())
            yield float(value + beside[best] - own[0]), [*rest, parted, others[best]]


def _with_another(selector: "Selector", answer: Answer, place: int) -> Iterator[tuple[float, list[Hypothesis]]]:
    """The answer with another effect in the place of one; what that gains."""
    quadratic = selector.problem.quadratic_at(answer.linearisation, answer.fit.theta)
    rest = [one for one in answer.chosen if one is not answer.chosen[place]]
    others = _free(selector, answer.chosen)
    own, *values = linear_evidence(selector.problem, quadratic, [answer.chosen[place], *others], rest)
    for other, value in zip(others, values, strict=True):
        trial = list(answer.chosen)
        trial[place] = other
        yield float(value - own), trial


def _free(selector: "Selector", chosen: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Hypotheses of effects that are not in the answer; none with stated values, whose pulses sensitivities miss."""
    taken = {one.effect for one in chosen}
    return [one for one in selector.search.hypotheses if one.effect not in taken and one.value is None]
