"""Verdict criteria as files declare them, and their checking against the signals of a run.

A criterion names a value (an expression over signals, phases and metrics), its limits and the requirement they stand
for. Without limits the value has to be a condition, or is only reported.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from bench.verdict.expression import ExpressionError, check, nearest
from bench.verdict.units import is_si, same_dimension, unit_of
from bench.verdict.vocabulary import METRICS, PHASES
from signals.quantities import FileModel, QuantityError, to_si

Path = tuple[str | int, ...]


class ValidIf(FileModel):
    """A condition without which a verdict means nothing: the criterion is then inconclusive."""

    expression: str = Field(description="condition over signals and metrics, e.g. max(abs_cycles) >= 3")
    phase: str | None = Field(default=None, description="phase over which it is taken; default: the whole run")
    reason: str = Field(default="", description="what to say when it does not hold")


def _condition_list(value: Any) -> Any:
    items = value if isinstance(value, list) else [value]
    return [{"expression": item} if isinstance(item, str) else item for item in items]


ValidIfList = Annotated[list[ValidIf], BeforeValidator(_condition_list, json_schema_input_type=Any)]


class Criterion(FileModel):
    """One line of the verdict table."""

    id: str = Field(pattern=r"^[\w.\-/]+$", description="name in the verdict table")
    requirement: str = Field(default="", description="requirement or clause that the limits stand for")
    description: str = Field(default="", description="one line for people")
    value: str = Field(description="expression over signals and metrics in SI units, or the name of a metric")
    phase: str | None = Field(default=None, description="run, brake, braking or a step of the manoeuvre")
    unit: str | None = Field(
        default=None, description="SI unit of the value, where it does not follow from the expression"
    )
    at_least: float | str | None = Field(default=None, description="lower limit, in SI units or with its unit")
    at_most: float | str | None = Field(default=None, description="upper limit, in SI units or with its unit")
    parameters: dict[str, float | str] = Field(
        default={}, description="parameters of the metric, e.g. above_speed: 15 km/h"
    )
    valid_if: ValidIfList = Field(default=[], description="conditions without which the verdict is inconclusive")


class CriteriaFile(FileModel):
    """File for ``bench judge RUN --criteria FILE``: the ``criteria`` section of a scenario by itself."""

    format: int = Field(default=1, ge=1, le=1)
    criteria: list[Criterion]
    valid_if: ValidIfList = Field(default=[], description="conditions that hold for all criteria")


@dataclass(frozen=True)
class CriterionProblem:
    """What is wrong with a criterion: path of the field inside the list, message with found and allowed."""

    path: Path
    message: str


@dataclass(frozen=True)
class PreparedCriterion:
    """A criterion with its unit worked out and its limits and parameters in SI units."""

    criterion: Criterion
    unit: str
    low: float | None
    high: float | None
    parameters: dict[str, float]

    @property
    def metric(self) -> str | None:
        """Name of the metric if the value is one metric and nothing else."""
        name = self.criterion.value.strip()
        return name if name in METRICS else None


def check_criteria(
    criteria: Sequence[Criterion],
    units: Mapping[str, str],
    phases: Sequence[str],
    valid_if: Sequence[ValidIf] = (),
) -> list[CriterionProblem]:
    """Everything that is wrong with criteria for a run with these signals and manoeuvre steps.

    Parameters
    ----------
    criteria : sequence of Criterion
        Paths of problems start with the index in it.
    units : mapping of str to str
        Unit of every signal of the run: the catalogue's and its estimators' outputs.
    phases : sequence of str
        Names of the manoeuvre's steps.
    valid_if : sequence of ValidIf
        Conditions for all criteria; paths of their problems start with "valid_if".
    """
    problems: list[CriterionProblem] = []
    seen: set[str] = set()
    for index, criterion in enumerate(criteria):
        if criterion.id in seen:
            problems.append(CriterionProblem((index, "id"), f"found {criterion.id!r} twice; allowed: one of each name"))
        seen.add(criterion.id)
        for problem in _criterion_problems(criterion, units, phases):
            problems.append(replace(problem, path=(index, *problem.path)))
    problems += _condition_problems(valid_if, units, phases)
    return problems


def _criterion_problems(
    criterion: Criterion, units: Mapping[str, str], phases: Sequence[str]
) -> Iterator[CriterionProblem]:
    broken = False
    for found in check(criterion.value, units, phases):
        broken = True
        yield CriterionProblem(("value",), f"column {found.column + 1}: {found.message}")
    yield from _phase_problems(criterion, phases)
    yield from _parameter_problems(criterion)
    if not broken:
        yield from _limit_problems(criterion, units)
    yield from _condition_problems(criterion.valid_if, units, phases)


def _phase_problems(criterion: Criterion, phases: Sequence[str]) -> Iterator[CriterionProblem]:
    yield from _phase_problem(criterion.phase, phases)
    metric = METRICS.get(criterion.value.strip())
    if criterion.phase is not None and metric is not None and metric.phase is None:
        yield CriterionProblem(("phase",), f"{metric.name} has its own instants; allowed: no phase")


def _phase_problem(phase: str | None, phases: Sequence[str]) -> Iterator[CriterionProblem]:
    if phase is not None and phase not in PHASES and phase not in phases:
        allowed = [*PHASES, *phases]
        yield CriterionProblem(
            ("phase",), f"no phase {phase!r}{nearest(phase, allowed)}; allowed: {', '.join(allowed)}"
        )


def _parameter_problems(criterion: Criterion) -> Iterator[CriterionProblem]:
    metric = METRICS.get(criterion.value.strip())
    allowed = metric.parameters if metric is not None else {}
    for name, value in criterion.parameters.items():
        if name not in allowed:
            known = ", ".join(allowed) or "none (only a metric by itself has parameters)"
            yield CriterionProblem(("parameters", name), f"unknown parameter{nearest(name, allowed)}; allowed: {known}")
            continue
        try:
            to_si(value, allowed[name][1])
        except QuantityError as error:
            yield CriterionProblem(("parameters", name), str(error))


def _limit_problems(criterion: Criterion, units: Mapping[str, str]) -> Iterator[CriterionProblem]:
    try:
        inferred = unit_of(criterion.value, units)
    except ExpressionError as error:
        for found in error.problems:
            yield CriterionProblem(("value",), f"column {found.column + 1}: {found.message}")
        return
    if inferred and criterion.unit and not same_dimension(inferred, criterion.unit):
        yield CriterionProblem(("unit",), f"found {criterion.unit!r}; allowed: {inferred}, the unit of the value")
        return
    unit = criterion.unit or inferred
    if not is_si(unit or "1"):
        yield CriterionProblem(("unit",), f"found {unit!r}; allowed: SI units as the signal catalogue writes them")
        return
    limits: dict[str, float] = {}
    for name in ("at_least", "at_most"):
        limit = getattr(criterion, name)
        if limit is None:
            continue
        if unit is None and isinstance(limit, str):
            yield CriterionProblem(
                (name,), f"found {limit!r}, but the unit of the value does not follow from it; write `unit:` beside it"
            )
            continue
        try:
            limits[name] = to_si(limit, unit or "1")
        except QuantityError as error:
            yield CriterionProblem((name,), str(error))
    if len(limits) == 2 and limits["at_least"] > limits["at_most"]:
        yield CriterionProblem(("at_least",), f"found {criterion.at_least}; allowed: at most {criterion.at_most}")


def _condition_problems(
    conditions: Sequence[ValidIf], units: Mapping[str, str], phases: Sequence[str]
) -> Iterator[CriterionProblem]:
    for index, condition in enumerate(conditions):
        path: Path = ("valid_if", index)
        for found in check(condition.expression, units, phases):
            yield CriterionProblem((*path, "expression"), f"column {found.column + 1}: {found.message}")
        for problem in _phase_problem(condition.phase, phases):
            yield replace(problem, path=(*path, *problem.path))


def prepare(criterion: Criterion, units: Mapping[str, str]) -> PreparedCriterion:
    """Criterion with unit, limits and parameters in SI units; it must have passed :func:`check_criteria`."""
    unit = criterion.unit or unit_of(criterion.value, units) or "1"
    metric = METRICS.get(criterion.value.strip())
    parameters = (
        {name: to_si(value, metric.parameters[name][1]) for name, value in criterion.parameters.items()}
        if metric is not None
        else {}
    )
    low, high = (None if limit is None else to_si(limit, unit) for limit in (criterion.at_least, criterion.at_most))
    return PreparedCriterion(criterion, unit, low, high, parameters)
