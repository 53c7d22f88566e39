"""Search for the terms that a balance lacks: forward, each step proven before it is taken.

A step refines the best candidate of each family, takes the simplest within one standard error of the best (predicted
squared error), and keeps it only if it explains more than the best candidate of every disturbed copy of the residual
(circular shifts and random signs of blocks, which destroy any relation to the variables and keep the colour), and if it
is chosen in at least 80 % of 100 complementary half-samples of blocks (Shah & Samworth 2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from model_diagnosis.discovery.candidates import Candidate, Variables, columns_of
from model_diagnosis.discovery.dimension import coefficient_exponents, unit_text
from model_diagnosis.discovery.library import library, periodic
from model_diagnosis.discovery.quantities import Balance, smoothed, stacked
from model_diagnosis.discovery.refinement import refine, rounded_forms
from model_diagnosis.discovery.regression import Pool, fit, orthonormal, predicted_squared_error, without
from model_diagnosis.discovery.stability import Blocks, inclusion, interval_of
from model_diagnosis.gain import correlation_time_s
from model_diagnosis.manoeuvre import SAMPLE_TIME_S

FloatArray = NDArray[np.float64]

MOST_TERMS = 3
LEAST_INCLUSION = 0.8
SAME = 0.97
"""Correlation (after the forced columns) from which two terms are one and the simpler one is named."""
_ONE = 0.98
"""Correlation from which the simpler of two terms is named whatever their errors."""
LEAST_SHARE = 0.05
"""Share of the remaining squared error that a term takes at least; less is the last form that does not quite fit."""
_FAMILIES = 14
_DISTURBED = 100
_SHIFTED = 20
_CHANCE = 0.01


@dataclass(frozen=True)
class DiscoveredTerm:
    """A term of a balance.

    Attributes
    ----------
    coefficients, low, high : with the ends of the 90 % intervals; of a periodic term sine and cosine, with the mean
        amplitude of the manoeuvres and the phase of the one that shows it best
    unit : of the coefficients
    inclusion : share of half-samples in which its variables were chosen
    explained : share of the balance's squared error, less the forced columns, that it takes away
    same_as : other candidates that say the same on this data
    """

    balance: str
    candidate: Candidate
    coefficients: FloatArray
    low: FloatArray
    high: FloatArray
    unit: str
    inclusion: float
    explained: float
    same_as: tuple[str, ...]

    @property
    def amplitude(self) -> float:
        """The coefficient; of a periodic term its amplitude."""
        return float(self.coefficients[0] if len(self.coefficients) == 1 else np.hypot(*self.coefficients))

    @property
    def formula(self) -> str:
        """``longitudinal force += -2.1e-04 s^2/m^2 · brake force · speed^2``."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        sign = "±" if self.candidate.kind == "periodic" else ""
        return f"{self.balance} += {sign}{self.amplitude:.4g}{unit} · {self.candidate.text}"


class _Search:
    def __init__(self, balance: Balance, variables: Variables, seed: int, least_share: float) -> None:
        self.balance, self.least_share = balance, least_share
        self.variables = {name: smoothed(variable) for name, variable in variables.items()}
        self.random = np.random.default_rng(seed)
        self.root = np.sqrt(stacked(balance.weights))
        self.target = stacked(balance.error) * self.root
        self.forced = np.stack([stacked(one) * self.root for one in balance.forced.values()], axis=1)
        self.candidates = library(balance, self.variables)
        self.raw = Pool.of([self._columns(candidate) for candidate in self.candidates])
        self.chosen: list[Candidate] = []
        self._take(self.forced)
        used = int(np.count_nonzero(self.root))
        self.largest_variance = float(np.sum(self.residual**2)) / max(used, 1)
        self.blocks = Blocks.of(balance, self._correlation_s())
        self.effective = max(used * SAMPLE_TIME_S / max(self._correlation_s(), SAMPLE_TIME_S), 1.0)

    def _columns(self, candidate: Candidate) -> FloatArray:
        return columns_of(candidate, self.balance, self.variables) * self.root[:, None]

    def _take(self, columns: FloatArray) -> None:
        """From now on everything is orthogonal to these columns."""
        self.basis = orthonormal(columns)
        self.residual = without(self.basis, self.target)
        self.pool, self.usable = self.raw.project(self.basis)

    def _correlation_s(self) -> float:
        times, start = [], 0
        for error in self.balance.error:
            rows = slice(start, start + len(error))
            times.append(correlation_time_s(self.residual[rows], self.root[rows]))
            start += len(error)
        return float(np.median(times))

    def explained(self, candidate: Candidate) -> float:
        """Drop of the squared residual by a candidate."""
        raw = self._columns(candidate)
        columns = without(self.basis, raw)
        if np.any((columns**2).sum(axis=0) < 1e-3 * np.maximum((raw**2).sum(axis=0), 1e-300)):
            return 0.0
        return float(((orthonormal(columns).T @ self.residual) ** 2).sum())

    def penalty(self, candidate: Candidate, columns: int) -> float:
        """Drop that a candidate with that many columns reaches without being true."""
        one = predicted_squared_error(0.0, self.largest_variance, columns + candidate.numbers, 1.0, self.effective)
        return one * np.count_nonzero(self.root)

    def contenders(self) -> list[Candidate]:
        """The best families, each with its numbers refined, the worth most first."""
        drops = np.where(self.usable, self.pool.explained(self.residual), 0.0)
        waves = periodic(self.balance, self.variables, self.residual, self.root)
        everything = [*self.candidates, *waves]
        drops = np.concatenate([drops, [self.explained(wave) for wave in waves]])
        best: dict[tuple[str, ...], int] = {}
        for number in np.argsort(drops)[::-1]:
            best.setdefault(everything[number].family, int(number))
        leading = sorted(best.values(), key=lambda number: -drops[number])[:_FAMILIES]
        refined: list[Candidate] = []
        for number in leading:
            candidate = refine(everything[number], self.variables, self.explained)
            refined += [candidate, *rounded_forms(candidate)]
        return sorted(dict.fromkeys(refined), key=lambda one: -self.worth(one))

    def worth(self, candidate: Candidate) -> float:
        """Drop less its penalty."""
        return self.explained(candidate) - self.penalty(candidate, self._columns(candidate).shape[1])

    def simplest(self, contenders: Sequence[Candidate]) -> Candidate:
        """The simplest candidate whose squared error is within one standard error of the best one's."""
        best = contenders[0]
        best_squares = self._block_squares(best)
        ties = []
        for candidate in contenders:
            difference = self._block_squares(candidate) - best_squares
            error = np.sqrt(len(difference)) * np.std(difference)
            if self.worth(best) - self.worth(candidate) <= max(error, 1e-12) or candidate == best:
                ties.append(candidate)
        ties = [one for one in ties if self.correlation(one, best) > SAME or one.variables == best.variables]
        ties += [one for one in contenders if self.correlation(one, best) > _ONE]
        return min(ties or [best], key=lambda one: (one.complexity, -self.worth(one)))

    def _block_squares(self, candidate: Candidate) -> FloatArray:
        columns = without(self.basis, self._columns(candidate))
        _, residual = fit(columns, self.residual)
        return self.blocks.sums(residual**2)

    def correlation(self, one: Candidate, other: Candidate) -> float:
        """Largest canonical correlation of two candidates after the forced columns."""
        first, second = (orthonormal(without(self.basis, self._columns(candidate))) for candidate in (one, other))
        if not first.shape[1] or not second.shape[1]:
            return 0.0
        return float(np.linalg.svd(first.T @ second, compute_uv=False)[0])

    def is_beyond_chance(self, candidate: Candidate) -> bool:
        """True where it explains more than the best of the library does of any disturbed residual."""
        drop = self.explained(candidate)
        if candidate.kind == "periodic":
            freedom = self._columns(candidate).shape[1]
            variance = (float(np.sum(self.residual**2)) - drop) / self.effective
            trials = 200.0 * len(self.variables) * (1 + len(self.balance.forces))
            return bool(drop / variance > chi2.isf(_CHANCE / trials, freedom))
        # the noise alone: what the candidate explains would make the disturbed copies larger than they are by chance
        _, noise = fit(without(self.basis, self._columns(candidate)), self.residual)
        # the pool is orthogonal to the basis, so that the copies need not be
        in_blocks = self.blocks.inner_products(self.pool.columns, noise)
        signed = self.random.choice([-1.0, 1.0], size=(_DISTURBED, self.blocks.count)) @ in_blocks
        shifted = np.stack([self._shifted(noise) for _ in range(_SHIFTED)]) @ self.pool.columns
        squares = np.maximum((self.pool.columns**2).sum(axis=0), 1e-300)
        largest = max(float(((part**2 / squares) * self.usable).max()) for part in (signed, shifted))
        return drop > largest

    def _shifted(self, values: FloatArray) -> FloatArray:
        parts, start = [], 0
        for error in self.balance.error:
            count = len(error)
            parts.append(
                np.roll(values[start : start + count], int(self.random.integers(count // 10, count - count // 10)))
            )
            start += count
        return np.concatenate(parts)

    def _alike(self, candidate: Candidate, contenders: Sequence[Candidate]) -> list[int]:
        """Contenders of the same variables, or that say the same."""
        return [
            number
            for number, one in enumerate(contenders)
            if one.variables == candidate.variables or self.correlation(one, candidate) > SAME
        ]

    def inclusion(self, candidate: Candidate, contenders: Sequence[Candidate]) -> float:
        """Share of half-samples in which a contender, or one that says the same, is worth most."""
        columns = [self._columns(one) for one in contenders]
        penalties = np.array([self.penalty(one, part.shape[1]) for one, part in zip(contenders, columns, strict=True)])
        alike = self._alike(candidate, contenders)
        return inclusion(self.blocks, self.basis, columns, self.target, penalties, alike, self.random)

    def step(self) -> DiscoveredTerm | None:
        """The next term, or None where nothing more is proven."""
        contenders = self.contenders()
        if not contenders or self.worth(contenders[0]) <= 0.0:
            return None
        candidate = self.simplest(contenders)
        drop, before = self.explained(candidate), float(np.sum(self.residual**2))
        if drop < self.least_share * before or not self.is_beyond_chance(candidate):
            return None
        columns = [self._columns(one) for one in contenders]
        place, alike = contenders.index(candidate), self._alike(candidate, contenders)
        share = self.inclusion(candidate, contenders)
        if share < LEAST_INCLUSION:
            return None
        fixed = [self.forced, *[self._columns(one) for one in self.chosen]]
        coefficients, _ = fit(np.concatenate([columns[place], *fixed], axis=1), self.target)
        low, high = interval_of(self.blocks, columns[place], np.concatenate(fixed, axis=1), self.target, self.random)
        count = columns[place].shape[1]
        coefficients, low, high = _of_periods(columns[place], coefficients[:count], low, high)
        self.chosen.append(candidate)
        self._take(np.concatenate([*fixed, columns[place]], axis=1))
        others = tuple(contenders[n].text for n in alike if contenders[n].variables != candidate.variables)
        return DiscoveredTerm(
            self.balance.name,
            candidate,
            coefficients,
            low,
            high,
            unit_text(coefficient_exponents(candidate, self.balance, self.variables)),
            share,
            drop / before,
            tuple(dict.fromkeys(others)),
        )


def _of_periods(
    columns: FloatArray, coefficients: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sine and cosine of a periodic term from those of each manoeuvre, weighted by how well each shows it."""
    if len(coefficients) <= 2:
        return coefficients, low, high
    energy = (columns**2).sum(axis=0).reshape(-1, 2).sum(axis=1)
    amplitudes = np.hypot(coefficients[0::2], coefficients[1::2])
    best = int(np.argmax(energy))
    pair = slice(2 * best, 2 * best + 2)
    scale = float(energy @ amplitudes / energy.sum() / max(amplitudes[best], 1e-300))
    return scale * coefficients[pair], scale * low[pair], scale * high[pair]


def contenders_of(balance: Balance, variables: Variables, seed: int = 0) -> list[Candidate]:
    """Best candidates of a balance, one of a family with its numbers refined, the worth most first; none is proven."""
    search = _Search(balance, variables, seed, LEAST_SHARE)
    return [candidate for candidate in search.contenders() if search.worth(candidate) > 0.0]


def inclusion_of(candidate: Candidate, balance: Balance, variables: Variables, seed: int = 0) -> float:
    """Share of complementary half-samples in which a balance chooses a candidate, or one that says the same."""
    search = _Search(balance, variables, seed, LEAST_SHARE)
    contenders = list(dict.fromkeys([candidate, *search.contenders()]))
    return search.inclusion(candidate, contenders)


def discover(
    balance: Balance, variables: Variables, *, seed: int = 0, most: int = MOST_TERMS, least_share: float = LEAST_SHARE
) -> list[DiscoveredTerm]:
    """Terms that a balance lacks, the most telling first; empty where nothing is proven.

    Parameters
    ----------
    balance : Balance
        With the columns that no new term may explain in their place.
    variables
        By name.
    most : int
        Largest number of terms.
    least_share : float
        Share of the remaining squared error that each takes at least.
    """
    search = _Search(balance, variables, seed, least_share)
    found: list[DiscoveredTerm] = []
    while len(found) < most:
        term = search.step()
        if term is None:
            break
        found.append(term)
    return found
