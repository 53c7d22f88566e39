"""Forward selection of effects with dropping and swapping.

Source: model discrepancy anchor, section 3.6: accept the best effect above the threshold, at most three; after each try
to drop and to swap every accepted one; the effect must also lower BIC_eff and predict manoeuvres it was not fitted to.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.checks import LeaveOneOut, effective_bic, leave_one_out
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.form_heat import OwnDirection, own_direction
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.law_errors import LAW_SHARE, evidence_beside_laws
from model_diagnosis.evidence.quadratic import Quadratic, total
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.splitting import split
from model_diagnosis.evidence.stage import (
    SWAP_GAIN,
    Candidate,
    Refit,
    Stage,
    linear_evidence,
    ratios,
    smaller_than_named,
)

FloatArray = NDArray[np.float64]

MAXIMUM_EFFECTS = 3
SWAPS_TRIED = 2
LEAST_SEEN = 1.0
"""Log evidence by sensitivities below which they tell nothing."""

LATER_SHARE = 0.01
"""Share of the first cause's evidence that a further one needs: the law of an effect is right to a tenth of its size,
and evidence goes with the square of what it leaves."""

NEARLY = 0.9
"""Least share of an effect's evidence that fewer of its deviations have if they are to stand for it: below some fifty
the bar of a further effect alone would let them drop what is most of it."""


@dataclass
class Accepted:
    """An accepted effect with the evidence for it beside the other accepted ones.

    Attributes
    ----------
    evidence : log Bayes factor against the same answer without it
    bic_change : BIC_eff with it minus without
    direction : what the data says of its deviations, and how much more that scatters than noise
    """

    hypothesis: Hypothesis
    evidence: float
    bic_change: float
    held_out: LeaveOneOut
    direction: OwnDirection


@dataclass
class Selection:
    """What the forward selection ended with.

    Attributes
    ----------
    accepted : at most three
    fit, linearisation : at the answer
    nothing : "nothing is wrong", after it was restarted from every winner
    stages : linear evidence and refits of every step
    left : evidence of one more that would have been accepted if an answer held more than so many, 0 for none
    decisions : what was accepted, dropped, swapped or refused, in words
    """

    accepted: list[Accepted]
    fit: Fit
    linearisation: Linearisation
    nothing: Fit
    stages: list[Stage]
    left: float
    decisions: list[str] = field(default_factory=list)


class Selector:
    """Runs the forward selection of one search.

    ``is_exact`` is False for laws that are known to be approximate, as their variables are measured: neither the heat
    of their own direction nor a single manoeuvre refuses them, as long as those left out are predicted better in sum.
    """

    def __init__(
        self,
        search: Search,
        needed: float,
        tell: Callable[[str, float], None] | None = None,
        is_exact: bool = True,
    ) -> None:
        self.search = search
        self.problem: Problem = search.problem
        self.needed = needed
        self.is_exact = is_exact
        self.decisions: list[str] = []
        self.refused: set[Hypothesis] = set()
        self.tell = tell or (lambda _step, _share: None)

    def run(
        self,
        nothing: Fit,
        at_nothing: Linearisation,
        saturated: Linearisation | None = None,
        most: int = MAXIMUM_EFFECTS,
    ) -> Selection:
        """Select from the base fit on; ``saturated`` gives further candidates to the first step."""
        chosen: list[Hypothesis] = []
        fit, linearisation = nothing, at_nothing
        stages: list[Stage] = []
        left, needed = 0.0, self.needed
        for step in range(most + 1):
            self.tell(f"effect {len(chosen) + 1}", step / (most + 1))
            stage = self.search.stage(chosen, fit, linearisation)
            stage = self.search.refit(stage, self.search.starts.candidates(stage, saturated if step == 0 else None))
            stages.append(stage)
            found = self._acceptable(stage, needed)
            if step == 0:
                nothing = stage.nothing_more
            fit, linearisation = stage.nothing_more, stage.linearisation
            if found is None:
                break
            best, at_best = found
            if step == most or len(chosen) == most:
                left = best.evidence
                break
            fit, linearisation = best.fit, at_best
            needed = max(needed, LATER_SHARE * best.evidence) if step == 0 else needed
            chosen = [*chosen, best.hypothesis]
            self.decisions.append(f"accepted {self.name(best.hypothesis)}, log Bayes factor {best.evidence:.1f}")
            if len(chosen) < most and (parted := split(self, chosen, fit, linearisation, needed)):
                chosen, fit, linearisation = parted.chosen, parted.fit, parted.linearisation
            if len(chosen) > 1:
                chosen, fit, linearisation = self._drop_and_swap(chosen, fit, linearisation, stages)
        accepted = [self.judged(chosen, hypothesis, fit, linearisation, nothing) for hypothesis in chosen]
        return Selection(accepted, fit, linearisation, nothing, stages, left, self.decisions)

    def without(self, selection: Selection, improbable: Sequence[Accepted]) -> Selection:
        """The same answer without effects in whose place others say more, though those were refused."""
        dropped = [one.hypothesis for one in improbable]
        chosen = [one.hypothesis for one in selection.accepted if one.hypothesis not in dropped]
        told = [f"dropped {self.name(one)}: what was refused says more in its place" for one in dropped]
        return self._with(selection, chosen, selection.fit.theta, told)

    def led_by(self, selection: Selection, accepted: Accepted, other: Hypothesis, theta: FloatArray) -> Selection:
        """The same answer with another effect in an accepted one's place; ``theta`` (p,) is where its fit begins."""
        chosen = [other if one is accepted else one.hypothesis for one in selection.accepted]
        told = f"{self.name(other)} stands for {self.name(accepted.hypothesis)}: it is more probable in its place"
        return self._with(selection, chosen, theta, [told])

    def _with(
        self, selection: Selection, chosen: Sequence[Hypothesis], theta: FloatArray, told: Sequence[str]
    ) -> Selection:
        fit, linearisation = self.polish(self.search.fit_set(chosen, selection.linearisation, theta))
        accepted = [self.judged(chosen, one, fit, linearisation, selection.nothing) for one in chosen]
        decisions = [*selection.decisions, *told]
        return replace(selection, accepted=accepted, fit=fit, linearisation=linearisation, decisions=decisions)

    def name(self, hypothesis: Hypothesis) -> str:
        """Readable name: the effect's, with the parameter where only one of several is present."""
        effect = self.problem.replay.effects[hypothesis.effect]
        columns = [self.problem.replay.columns[column] for column in hypothesis.columns]
        return columns[0] if len(columns) == 1 and len(effect.parameters) > 1 else effect.name

    def _acceptable(self, stage: Stage, needed: float) -> tuple[Refit, Linearisation] | None:
        """Best refit that passes threshold, BIC_eff and the held-out check, and the sensitivities at it."""
        for rough in sorted(stage.refits, key=lambda one: -one.evidence):
            if rough.evidence <= needed:
                return None
            refit, linearisation = self.search.polished(stage, rough)
            why = self._why_not(stage, rough, refit, linearisation, needed)
            if why:
                refusal = f"refused {self.name(refit.hypothesis)}: "
                # of what is refused beside every set of others the last reason tells enough
                self.decisions = [one for one in self.decisions if not one.startswith(refusal)]
                self.decisions.append(refusal + why)
                self.refused.add(refit.hypothesis)
                continue
            self.refused.discard(refit.hypothesis)
            return self._simpler(stage, refit, linearisation, needed) or (refit, linearisation)
        return None

    def _simpler(
        self, stage: Stage, refit: Refit, linearisation: Linearisation, needed: float
    ) -> tuple[Refit, Linearisation] | None:
        """An accepted effect with fewer of its deviations, where the others say less than a further effect had to.

        They would make up for what its law gets wrong, and take a part of the value with them.
        """
        least = max(refit.evidence - max(needed, LATER_SHARE * refit.evidence), NEARLY * refit.evidence)
        for smaller in self._worth_as_much(stage, refit):
            left_out = sorted(set(refit.hypothesis.columns) - set(smaller.columns))
            start = refit.fit.theta.copy()
            start[left_out] = self.problem.priors.centre[left_out]
            fit = self.search.fit_set((*stage.accepted, smaller), linearisation, start)
            rough = self.search.judged(stage, smaller, fit, linearisation)
            if rough.evidence < least:
                continue
            stage.refits = [*(one for one in stage.refits if one.hypothesis != smaller), rough]
            again, at_again = self.search.polished(stage, rough)
            if again.evidence >= least and not self._why_not(stage, rough, again, at_again, needed):
                return again, at_again
        return None

    def _worth_as_much(self, stage: Stage, refit: Refit) -> list[Hypothesis]:
        """Hypotheses with fewer deviations of a refit's effect that by its sensitivities say nearly what it does."""
        own = refit.hypothesis
        smaller = [
            one
            for one in self.search.hypotheses
            if one.effect == own.effect and set(one.columns) < set(own.columns) and one.value is None
        ]
        evidence = linear_evidence(self.problem, total(refit.parts), [own, *smaller], stage.accepted)
        near = [(one, value) for one, value in zip(smaller, evidence[1:], strict=True) if value > NEARLY * evidence[0]]
        return [one for one, _ in sorted(near, key=lambda entry: (len(entry[0].columns), -entry[1]))]

    def _why_not(self, stage: Stage, rough: Refit, refit: Refit, linearisation: Linearisation, needed: float) -> str:
        """What speaks against accepting a refit, in words; "" for nothing."""
        if refit.evidence <= needed:
            return f"{refit.evidence:.1f} is left of {rough.evidence:.1f} once both fits have converged"
        if small := smaller_than_named(self.problem, refit.hypothesis, refit.fit.theta):
            return small
        if self._bic_change(refit.fit, stage.nothing_more, refit.hypothesis) >= 0.0:
            return "BIC_eff does not fall"
        if self.is_exact and (why := self._too_little_left(stage, refit, linearisation, needed)):
            return why
        check = leave_one_out(
            refit.parts,
            ratios(self.problem, stage.accepted),
            refit.hypothesis.columns,
            self.problem.scaled(refit.fit.theta),
        )
        if not (check.passed or (not self.is_exact and check.gained > 0.0)):
            return (
                f"it does not predict the manoeuvres left out (sum {check.differences.sum():.1f}, worst "
                f"{check.differences.min():.1f})"
            )
        return ""

    def _too_little_left(self, stage: Stage, refit: Refit, linearisation: Linearisation, needed: float) -> str:
        """Why heat of its own direction or errors of the other laws leave too little of an exact law, in words."""
        own = self._direction(refit.hypothesis, stage.accepted, refit.fit, linearisation)
        left = self._tempered(own, refit.hypothesis, stage.accepted, refit.fit, stage.nothing_more)
        if left <= needed:
            return (
                f"{left:.1f} is left of {refit.evidence:.1f}, for what it explains scatters {own.heat:.1f} times as "
                "much as noise"
            )
        left *= self._beside_laws(refit.hypothesis, stage.accepted, refit.fit, linearisation)
        if left <= needed:
            return (
                f"{left:.1f} is left of {refit.evidence:.1f} where the laws of what stands beside it may be off "
                f"by {100.0 * LAW_SHARE:.0f} % in any signal and manoeuvre"
            )
        return ""

    def _direction(
        self, hypothesis: Hypothesis, others: Sequence[Hypothesis], fit: Fit, linearisation: Linearisation
    ) -> OwnDirection:
        """What the data says of a hypothesis beside the others, and how far it can be trusted."""
        return own_direction(
            self.problem,
            linearisation,
            fit.theta,
            hypothesis.columns,
            ratios(self.problem, others),
            ratios(self.problem, (*others, hypothesis)),
        )

    def _beside_laws(
        self, hypothesis: Hypothesis, before: Sequence[Hypothesis], fit: Fit, linearisation: Linearisation
    ) -> float:
        """Share of its evidence that the laws of those accepted before leave; an approximate law stands for itself."""
        if not self.is_exact or not before or hypothesis.value is not None:
            return 1.0
        exact, left = evidence_beside_laws(self.problem, linearisation, fit.theta, hypothesis, before)
        # sensitivities see little of what acts in pulses: they cannot tell what the laws take of it
        return float(np.clip(left / exact, 0.0, 1.0)) if exact > LEAST_SEEN else 1.0

    def polish(self, fit: Fit) -> tuple[Fit, Linearisation]:
        """Fresh sensitivities at the accepted solution and the fit with them."""
        linearisation = self.problem.linearise(fit.theta)
        return self.problem.fit(linearisation, fit.widths, fit.theta, fit.fixed), linearisation

    def _drop_and_swap(
        self, chosen: list[Hypothesis], fit: Fit, linearisation: Linearisation, stages: Sequence[Stage]
    ) -> tuple[list[Hypothesis], Fit, Linearisation]:
        """Drop accepted effects that the others made needless; swap one for the best rejected ones."""
        for hypothesis in list(chosen):
            rest = [one for one in chosen if one is not hypothesis]
            without = self.search.fit_set(rest, linearisation, fit.theta)
            direction = self._direction(hypothesis, rest, fit, linearisation)
            evidence = self._tempered(direction, hypothesis, rest, fit, without)
            if len(rest) and evidence <= self.needed:
                self.decisions.append(f"dropped {self.name(hypothesis)}: only {evidence:.1f} beside the others")
                chosen = rest
                fit, linearisation = self.polish(without)
        for hypothesis in list(chosen):
            rest = [one for one in chosen if one is not hypothesis]
            for candidate in self._rejected(chosen, stages):
                trial = [*rest, candidate.hypothesis]
                swapped = min(
                    (self.search.fit_set(trial, linearisation, start) for start in (*candidate.starts, fit.theta)),
                    key=lambda one: one.cost,
                )
                gained = self.evidence_of(trial, swapped, linearisation) - self.evidence_of(chosen, fit, linearisation)
                if gained > SWAP_GAIN:
                    self.decisions.append(
                        f"swapped {self.name(hypothesis)} for {self.name(candidate.hypothesis)}: {gained:.1f} better"
                    )
                    chosen = trial
                    fit, linearisation = self.polish(swapped)
                    break
        return chosen, fit, linearisation

    def _rejected(self, chosen: Sequence[Hypothesis], stages: Sequence[Stage]) -> list[Candidate]:
        """Best refits of all steps that are not accepted; what was refused for other reasons does not come back."""
        taken = {hypothesis.effect for hypothesis in chosen}
        found: dict[int, Refit] = {}
        for stage in stages:
            for refit in stage.refits:
                effect = refit.hypothesis.effect
                if effect in taken or refit.hypothesis in self.refused:
                    continue
                if effect not in found or refit.evidence > found[effect].evidence:
                    found[effect] = refit
        best = sorted(found.values(), key=lambda refit: -refit.evidence)[:SWAPS_TRIED]
        return [Candidate(refit.hypothesis, (refit.fit.theta,)) for refit in best]

    def evidence_of(self, chosen: Sequence[Hypothesis], fit: Fit, linearisation: Linearisation) -> float:
        """Log evidence of a set of effects up to a constant, the Occam factors from one linearisation."""
        quadratic = Quadratic(linearisation.information, np.zeros(len(self.problem.scale)))
        factors = sum(
            self.search.occam(hypothesis, chosen[:number], quadratic) for number, hypothesis in enumerate(chosen)
        )
        return -0.5 * self.search.set_cost(chosen, fit) + factors

    def _bic_change(self, fit: Fit, without: Fit, hypothesis: Hypothesis) -> float:
        samples = self.effective_samples(fit.theta)
        free = 0 if hypothesis.value is not None else len(hypothesis.columns)
        # the nominal scatter is data too: without it "nothing" would fit as well as any effect
        return effective_bic(fit.cost, free, samples) - effective_bic(without.cost, 0, samples)

    def effective_samples(self, theta: FloatArray) -> float:
        """N_eff: rows over the temperature."""
        return sum(len(row) for row in self.problem.rows(theta)) / self.problem.whitener.temperature

    def judged(
        self, chosen: Sequence[Hypothesis], hypothesis: Hypothesis, fit: Fit, linearisation: Linearisation, nothing: Fit
    ) -> Accepted:
        """Evidence of one accepted effect beside the others, with its checks."""
        rest = [one for one in chosen if one is not hypothesis]
        without = self.search.fit_set(rest, linearisation, fit.theta)
        if not rest and nothing.cost < without.cost:
            without = nothing
        direction = self._direction(hypothesis, rest, fit, linearisation)
        parts = self.problem.quadratics(linearisation, self.problem.rows(fit.theta), fit.theta)
        scaled = self.problem.scaled(fit.theta)
        return Accepted(
            hypothesis,
            self._tempered(direction, hypothesis, rest, fit, without)
            * self._beside_laws(hypothesis, chosen[: chosen.index(hypothesis)], fit, linearisation),
            self._bic_change(fit, without, hypothesis),
            leave_one_out(parts, ratios(self.problem, rest), hypothesis.columns, scaled),
            direction,
        )

    def _tempered(
        self, direction: OwnDirection, hypothesis: Hypothesis, rest: Sequence[Hypothesis], fit: Fit, without: Fit
    ) -> float:
        """Log Bayes factor of a hypothesis beside the rest, its data worth less by its direction's heat."""
        gained = self.search.set_cost(rest, without) - self.search.set_cost((*rest, hypothesis), fit)
        # a stated value is not estimated: it has neither width nor size
        return 0.5 * gained / direction.heat if hypothesis.value is not None else direction.tempered(gained)
