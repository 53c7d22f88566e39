"""Which terms are worth a fit: a few offers of every target first, all of the best target's then, numbers refined last.

All are weighed by the replay's sensitivities, so that a term of the brakes competes with one of the body on equal
terms. A number inside a shape costs evidence: it was chosen by the data.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from model_diagnosis.discovery.candidates import Candidate
from model_diagnosis.discovery.courses import CourseMaker, WeighedTerm
from model_diagnosis.discovery.dimension import is_physical
from model_diagnosis.discovery.offers import first_offers, further_offers, neighbours
from model_diagnosis.discovery.screening import Screen
from model_diagnosis.replay.terms import TERM_TARGETS

PRICE = float(np.log(500.0))
"""Log evidence that a term pays for having been sought among some 500 candidates."""
NUMBER_PRICE = 3.0
"""Log evidence that each number inside a shape pays besides: about twenty places of it can be told apart."""

_ROUGH = 0.5
"""Share of a term's evidence that the nearest of the first offers has at least."""
_FAMILIES = 8
_REACHES = (1.0, 0.35, 0.12)


@dataclass(frozen=True)
class Proposal:
    """A term with its log Bayes factor against "nothing" by sensitivities, no price paid."""

    term: WeighedTerm
    evidence: float

    @property
    def worth(self) -> float:
        """Evidence less all prices."""
        return self.evidence - PRICE - NUMBER_PRICE * self.term.candidate.numbers


@dataclass
class Proposer:
    """Weighs candidates and remembers what it weighed."""

    screen: Screen
    maker: CourseMaker
    known: dict[tuple[str, Candidate], Proposal | None] = field(default_factory=dict)

    def best(self, needed: float) -> list[Proposal]:
        """One proposal of each of the best families, its numbers refined, the most worth first.

        Empty where the first offers show that no term will be worth ``needed``.
        """
        rough = self._weighed(
            (target, offer) for target in TERM_TARGETS for offer in first_offers(target, self.maker.variables)
        )
        if not rough or rough[0].evidence < _ROUGH * (needed + PRICE):
            return []
        targets = list(dict.fromkeys(one.term.target for one in rough))[:2]
        self._weighed((target, offer) for target in targets for offer in further_offers(target, self.maker.variables))
        for reach in _REACHES:
            self._weighed(
                (one.term.target, neighbour)
                for one in self._leading()
                for neighbour in neighbours(one.term.candidate, self.maker.variables, reach)
            )
        return self._leading()

    def _leading(self) -> list[Proposal]:
        """The best of each family that was ever weighed, the most worth first."""
        best: dict[tuple[object, ...], Proposal] = {}
        for one in _by_worth(self.known.values()):
            best.setdefault((one.term.target, *one.term.candidate.family), one)
        return list(best.values())[:_FAMILIES]

    def _weighed(self, offers: Iterable[tuple[str, Candidate]]) -> list[Proposal]:
        fresh = [key for key in dict.fromkeys(offers) if key not in self.known]
        made = {key: self._made(*key, number) for number, key in enumerate(fresh)}
        terms = [term for term in made.values() if term is not None]
        found = iter(self.screen.evidence(terms))
        for key, term in made.items():
            self.known[key] = None if term is None else Proposal(term, float(next(found)))
        return _by_worth(self.known[key] for key in fresh)

    def _made(self, target: str, candidate: Candidate, number: int) -> WeighedTerm | None:
        if not is_physical(candidate, target, self.maker.variables):
            return None
        return self.maker.of(f"discovered_term_{number + 1}", candidate, target)


def _by_worth(proposals: Iterable[Proposal | None]) -> list[Proposal]:
    return sorted((one for one in proposals if one is not None), key=lambda one: -one.worth)


def simplest_first(proposals: Sequence[Proposal]) -> Iterator[Proposal]:
    """The best ones, but where a simpler one of them is worth nearly as much, that one first."""
    left = list(proposals)
    while left:
        ties = [one for one in left if one.worth > left[0].worth - NUMBER_PRICE]
        chosen = min(ties, key=lambda one: (one.term.candidate.complexity, -one.worth))
        left.remove(chosen)
        yield chosen
