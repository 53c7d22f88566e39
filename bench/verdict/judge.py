"""Judging a run: the same engine for arrays in memory, a recording and a foreign log."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.recording.arrays import RunArrays
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.criteria_file import Criterion, PreparedCriterion, ValidIf, prepare
from bench.verdict.expression import ExpressionError, evaluate
from bench.verdict.result import ERROR, FAIL, INCONCLUSIVE, PASS, CriterionResult, Verdict
from bench.verdict.summary import estimator_summary, metric_summary
from bench.verdict.vocabulary import METRICS


def judge(
    data: RunArrays,
    criteria: Sequence[Criterion],
    *,
    valid_if: Sequence[ValidIf] = (),
    scenario: str = "",
    seed: int | None = None,
    versions: Mapping[str, str] | None = None,
    errors: Sequence[str] = (),
    remarks: Sequence[str] = (),
    wheel_radius_m: float | None = None,
) -> Verdict:
    """Judge a run by its criteria.

    Parameters
    ----------
    data : RunArrays
        The run; its ``timing`` becomes the timing block of the verdict.
    criteria : sequence of Criterion
        As the scenario declares them; they must have passed ``check_criteria``.
    valid_if : sequence of ValidIf
        Conditions without which every verdict of the run is inconclusive.
    errors : sequence of str
        Failures of the bench; any makes the verdict "error".
    wheel_radius_m : float, optional
        Rolling radius, needed where a foreign log has wheel speeds but no slip.
    """
    run = Assessment(data, wheel_radius_m=wheel_radius_m)
    results = [_judge_one(run, prepare(criterion, data.units), valid_if) for criterion in criteria]
    return Verdict(
        scenario=scenario,
        criteria=results,
        metrics=metric_summary(run),
        estimators=estimator_summary(run),
        timing=dict(data.timing),
        seed=seed,
        versions=dict(versions or {}),
        errors=list(errors),
        remarks=[*remarks, *run.notes],
    )


def _judge_one(run: Assessment, prepared: PreparedCriterion, common: Sequence[ValidIf]) -> CriterionResult:
    criterion = prepared.criterion
    metric = METRICS[prepared.metric] if prepared.metric else None
    result = CriterionResult(
        id=criterion.id,
        requirement=criterion.requirement,
        description=criterion.description or (metric.description if metric else ""),
        expression=criterion.value.strip(),
        phase=criterion.phase or (metric.phase if metric else None),
        value=None,
        unit=prepared.unit,
        limits=(prepared.low, prepared.high),
        margin=None,
        verdict=INCONCLUSIVE,
        source=metric.source if metric else "",
    )
    try:
        _take_value(run, prepared, result)
    except NoValueError as error:
        result.reason = str(error)
    except ExpressionError as error:
        result.verdict, result.reason = ERROR, str(error)
    if result.verdict in (PASS, FAIL):
        invalid = _invalid(run, [*common, *criterion.valid_if])
        if invalid:
            result.verdict, result.reason = INCONCLUSIVE, invalid
    return result


def _take_value(run: Assessment, prepared: PreparedCriterion, result: CriterionResult) -> None:
    criterion = prepared.criterion
    value: Any
    if prepared.metric:
        value = run.metric(prepared.metric, prepared.parameters, criterion.phase)
    else:
        value = evaluate(criterion.value, run, criterion.phase)
    values = np.atleast_1d(np.asarray(value))
    if values.shape not in ((1,), (4,)):
        raise NoValueError(f"the expression has {values.size} values, not one; take max(…), mean(…) or another of them")
    if np.isnan(values.astype(np.float64)).any():
        raise NoValueError("the signals hold no number (NaN) in this phase")
    if result.limits == (None, None) and values.dtype == np.bool_:
        result.limits = (1.0, None)
    numbers = values.astype(np.float64)
    margins = [_margin(float(number), result.limits) for number in numbers]
    worst = int(np.argmin([np.inf if margin is None else margin for margin in margins]))
    result.value, result.margin = float(numbers[worst]), margins[worst]
    result.values = [float(number) for number in numbers] if len(numbers) > 1 else None
    result.verdict = FAIL if result.margin is not None and result.margin < 0 else PASS
    if np.isinf(result.value):
        result.reason = "never reached"


def _margin(value: float, limits: tuple[float | None, float | None]) -> float | None:
    low, high = limits
    distances = []
    if low is not None:
        distances.append((value - low) / (abs(low) or 1.0))
    if high is not None:
        distances.append((high - value) / (abs(high) or 1.0))
    return min(distances) if distances else None


def _invalid(run: Assessment, conditions: Sequence[ValidIf]) -> str:
    """Why the verdict means nothing; an empty text if all conditions hold."""
    for condition in conditions:
        try:
            holds = bool(np.all(evaluate(condition.expression, run, condition.phase)))
        except (NoValueError, ExpressionError) as error:
            return f"{condition.reason or condition.expression}: {error}"
        if not holds:
            return condition.reason or f"{condition.expression} does not hold"
    return ""


def missing_signals(data: RunArrays, criteria: Sequence[Criterion], valid_if: Sequence[ValidIf]) -> list[str]:
    """Faults of criteria that name what this recording does not have, one line each."""
    from bench.verdict.criteria_file import check_criteria

    problems = check_criteria(criteria, data.units, data.phase_names, valid_if)
    return [f"{_place(criteria, problem.path)}: {problem.message}" for problem in problems]


def _place(criteria: Sequence[Criterion], path: tuple[str | int, ...]) -> str:
    head, *rest = path
    name = criteria[head].id if isinstance(head, int) else head
    return ".".join([str(name), *(str(part) for part in rest)])
