"""Rows of the verdict table, the same for the page and for the terminal: what failed stands first."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bench.report.formatting import VERDICT_ORDER, VERDICT_SYMBOLS, limits_text, number, quantity
from signals.wheels import WHEELS

NEVER = "never reached"


@dataclass(frozen=True)
class CriterionRow:
    """One criterion as text.

    Attributes
    ----------
    verdict, symbol
        pass, inconclusive, fail or error, and the mark shown beside it.
    id, name, requirement, description, value, wheels, limits, margin, reason, source
        Texts of the columns; empty where the verdict has none. ``wheels`` are the four values of a value per wheel.
    used : float or None
        Share of the limit that is used, 0 to 1, for the gauge.
    informative : bool
        A figure without limits: it is told, not judged.
    """

    verdict: str
    symbol: str
    id: str
    name: str
    requirement: str
    description: str
    value: str
    wheels: str
    limits: str
    margin: str
    reason: str
    source: str
    used: float | None
    informative: bool


def criterion_rows(verdict: Mapping[str, Any]) -> list[CriterionRow]:
    """Rows of ``verdict.json``, the worst verdict first, figures without limits last, otherwise in the file's order."""
    rows = [_row(criterion) for criterion in verdict.get("criteria", [])]
    return sorted(rows, key=lambda row: (-_rank(row.verdict), row.informative))


def has_values(verdict: Mapping[str, Any]) -> bool:
    """False for a run that ended before any criterion had something to judge."""
    return any(criterion.get("value") is not None for criterion in verdict.get("criteria", []))


def tally(verdict: Mapping[str, Any]) -> str:
    """``12 criteria: 11 pass, 1 fail``."""
    judged = [row.verdict for row in criterion_rows(verdict) if not row.informative]
    if not judged:
        return "no criteria"
    counts = [f"{judged.count(name)} {name}" for name in VERDICT_ORDER if name in judged]
    return f"{len(judged)} {'criterion' if len(judged) == 1 else 'criteria'}: {', '.join(counts)}"


def _rank(verdict: str) -> int:
    return VERDICT_ORDER.index(verdict) if verdict in VERDICT_ORDER else len(VERDICT_ORDER)


def _row(criterion: Mapping[str, Any]) -> CriterionRow:
    unit = str(criterion.get("unit") or "1")
    verdict = str(criterion.get("verdict", "error"))
    values = criterion.get("values")
    reason = str(criterion.get("reason") or "")
    limits = limits_text(criterion.get("limits"), unit)
    informative = verdict == "pass" and not limits
    return CriterionRow(
        verdict=verdict,
        symbol="·" if informative else VERDICT_SYMBOLS.get(verdict, "!"),
        id=str(criterion.get("id", "")),
        name=str(criterion.get("id", "")).replace("_", " "),
        requirement=str(criterion.get("requirement") or ""),
        description=str(criterion.get("description") or ""),
        value=reason if criterion.get("value") is None and reason == NEVER else quantity(criterion.get("value"), unit),
        wheels=_wheels_text(values, unit) if isinstance(values, list) else "",
        limits=limits,
        margin=_margin_text(criterion.get("margin")),
        reason="" if reason == NEVER else reason,
        source=str(criterion.get("source") or ""),
        used=_share_of_limit(criterion),
        informative=informative,
    )


def _wheels_text(values: list[Any], unit: str) -> str:
    named = (f"{wheel.upper()} {quantity(value, unit)}" for wheel, value in zip(WHEELS, values, strict=False))
    return ", ".join(named)


def _margin_text(margin: Any) -> str:
    """The margin is a share of the limit; negative where the limit is broken."""
    if not isinstance(margin, (int, float)) or isinstance(margin, bool) or not math.isfinite(margin):
        return ""
    percent = 100.0 * margin
    sign = "+" if percent > 0 else ""
    return f"{sign}{number(round(percent, 1 if abs(percent) < 10 else 0))} %"


def _share_of_limit(criterion: Mapping[str, Any]) -> float | None:
    margin = criterion.get("margin")
    if not isinstance(margin, (int, float)) or isinstance(margin, bool) or not math.isfinite(margin):
        return None
    return min(1.0, max(0.03, 1.0 - float(margin)))
