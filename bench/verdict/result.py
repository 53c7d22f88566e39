"""What a judgement says: criteria with their margins, the worst verdict, and the contents of ``verdict.json``."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

PASS, INCONCLUSIVE, FAIL, ERROR = "pass", "inconclusive", "fail", "error"
ORDER = (PASS, INCONCLUSIVE, FAIL, ERROR)
EXIT_CODES = {PASS: 0, FAIL: 1, INCONCLUSIVE: 3, ERROR: 4}


def worst(verdicts: Iterable[str]) -> str:
    """Worst of several verdicts in the order pass < inconclusive < fail < error; pass of none."""
    return max(verdicts, key=ORDER.index, default=PASS)


@dataclass
class CriterionResult:
    """One line of the verdict table.

    Attributes
    ----------
    value : float or None
        Value in ``unit``; of a value per wheel the worst. None if the run has none; may be infinite.
    limits : tuple
        Lower and upper limit, None where there is none.
    margin : float or None
        Distance to the nearer limit over that limit's magnitude (over 1 in the value's unit where the limit is 0),
        negative on the wrong side. None without limits or value.
    values : list of float, optional
        The four values of a value per wheel.
    reason : str
        Why there is no verdict, or which condition did not hold.
    """

    id: str
    requirement: str
    description: str
    expression: str
    phase: str | None
    value: float | None
    unit: str
    limits: tuple[float | None, float | None]
    margin: float | None
    verdict: str
    values: list[float] | None = None
    reason: str = ""
    source: str = ""

    def as_json(self) -> dict[str, Any]:
        """Entry of ``verdict.json``; a value that is never reached (infinite) is null there and named in the reason."""
        entry: dict[str, Any] = {
            "id": self.id,
            "requirement": self.requirement,
            "value": finite(self.value),
            "unit": self.unit,
            "limits": list(self.limits),
            "margin": finite(self.margin),
            "verdict": self.verdict,
            "description": self.description,
            "expression": self.expression,
            "phase": self.phase,
            "reason": self.reason,
            "source": self.source,
        }
        if self.values is not None:
            entry["values"] = [finite(value) for value in self.values]
        return entry


@dataclass
class Verdict:
    """The judgement of one run.

    Attributes
    ----------
    errors : list of str
        What went wrong with the bench; any makes the verdict "error".
    remarks : list of str
        What a reader of the figures should know.
    """

    scenario: str
    criteria: list[CriterionResult] = field(default_factory=list)
    metrics: dict[str, Any] = field(default_factory=dict)
    estimators: dict[str, dict[str, Any]] = field(default_factory=dict)
    timing: dict[str, Any] = field(default_factory=dict)
    seed: int | None = None
    versions: dict[str, str] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    @property
    def verdict(self) -> str:
        """The worst of the criteria, or error if the bench failed."""
        return ERROR if self.errors else worst(criterion.verdict for criterion in self.criteria)

    @property
    def exit_code(self) -> int:
        """Exit code of a command that ends with this verdict."""
        return EXIT_CODES[self.verdict]

    def counts(self) -> dict[str, int]:
        """Number of criteria by verdict."""
        return {name: sum(criterion.verdict == name for criterion in self.criteria) for name in ORDER}

    def as_json(self) -> dict[str, Any]:
        """Contents of ``verdict.json``: plain data without infinities."""
        return {
            "scenario": self.scenario,
            "verdict": self.verdict,
            "criteria": [criterion.as_json() for criterion in self.criteria],
            "metrics": plain(self.metrics),
            "estimators": plain(self.estimators),
            "timing": plain(self.timing),
            "seed": self.seed,
            "versions": dict(self.versions),
            "errors": list(self.errors),
            "remarks": list(self.remarks),
        }


def finite(value: float | None) -> float | None:
    """The value, or None where JSON has no number for it."""
    return None if value is None or not math.isfinite(value) else float(value)


def plain(value: Any) -> Any:
    """Nested data with Python numbers, None for what is not finite."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return finite(value) if isinstance(value, float) else value
