"""Procedures: reading and checking them, making their runs, judging the results."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.scenario.locate import find_scenario, id_of
from bench.scenario.procedure_expression import check, evaluate, names_used
from bench.scenario.procedure_file import ProcedureCriterion, ProcedureFile, ProcedureRun
from signals.errors import Fault, FileFaults, InputError
from signals.quantities import QuantityError, to_si
from signals.yaml_files import Document, load_yaml, validate

if TYPE_CHECKING:
    from bench.scenario.schema import ScenarioFile
    from bench.verdict.result import CriterionResult, Verdict


_PATHS = {"ecu": "ecu.kind", "link": "ecu.link"}


def is_procedure(argument: str) -> bool:
    """Whether a scenario argument names a procedure; False for what cannot be read."""
    try:
        document = load_yaml(find_scenario(argument))
    except InputError:
        return False
    return isinstance(document.data, dict) and "runs" in document.data and "manoeuvre" not in document.data


def read_procedure(path: Path) -> ProcedureFile:
    """A procedure with everything checked that its files can tell.

    Raises
    ------
    InputError
        With every fault of the file, and of the scenarios that it runs.
    """
    document = load_yaml(path)
    procedure = validate(document, ProcedureFile)
    faults: list[Fault] = []
    quantities: dict[str, set[str]] = {}
    for number, entry in enumerate(procedure.runs):
        try:
            quantities[entry.name] = _quantities(_resolved(entry, path, procedure, 0, {}))
        except FileFaults as error:
            faults += error.faults
        except InputError as error:
            where = ("runs", number, "scenario")
            faults.append(document.fault(where, error.message, allowed=error.allowed, nearest=error.nearest))
    if not faults:
        for number, criterion in enumerate(procedure.criteria):
            faults += _criterion_faults(criterion, number, quantities, document)
    if faults:
        raise FileFaults(faults, document.file)
    return procedure.model_copy(update={"id": procedure.id or id_of(path)})


def _resolved(
    entry: ProcedureRun, path: Path, procedure: ProcedureFile, number: int, options: Mapping[str, Any]
) -> "ScenarioFile":
    from bench.scenario.documents import parse_sets
    from bench.scenario.resolution import resolve

    beside = path.parent / entry.scenario
    scenario = beside if entry.scenario.endswith((".yaml", ".yml")) else entry.scenario
    seed = entry.seed if entry.seed is not None else procedure.seed
    # what a run itself sets (locked wheels: ecu.kind: none) is what it is there for, and wins over the command line
    given = {
        key: value
        for key, value in options.items()
        if value is not None and key != "sets" and _PATHS.get(key, key) not in entry.set
    }
    sets = {**entry.set, **parse_sets(options.get("sets") or [])}
    first = given.pop("seed", seed)
    if entry.seed is not None:
        first = entry.seed
    return resolve(
        scenario,
        sets,
        variant=entry.variant,
        **{"pacing": procedure.pacing, **given, "seed": first + number},
    )


def _quantities(scenario: "ScenarioFile") -> set[str]:
    from bench.verdict.summary import METRIC_KEYS

    return {*METRIC_KEYS, *(criterion.id for criterion in scenario.criteria)}


def _criterion_faults(
    criterion: ProcedureCriterion, number: int, quantities: Mapping[str, set[str]], document: Document
) -> list[Fault]:
    place = ("criteria", number)
    faults = [
        document.fault((*place, "value"), p.message, nearest=p.nearest, allowed=p.allowed)
        for p in check(criterion.value, quantities)
    ]
    for name in ("at_least", "at_most"):
        limit = getattr(criterion, name)
        try:
            if limit is not None:
                to_si(limit, criterion.unit)
        except QuantityError as error:
            faults.append(document.fault((*place, name), error.problem, found=repr(limit), allowed=error.allowed))
    return faults


@dataclass(frozen=True)
class ProcedureResult:
    """What a procedure has shown.

    Attributes
    ----------
    verdict : Verdict
        Criteria over the results; its metrics hold the single runs.
    folder : Path
        ``verdict.json``, ``junit.xml`` and a folder for each run.
    """

    verdict: "Verdict"
    folder: Path

    @property
    def exit_code(self) -> int:
        """Exit code of the command."""
        return self.verdict.exit_code

    def as_json(self) -> dict[str, Any]:
        """Contents of ``verdict.json`` and the folder."""
        return {**self.verdict.as_json(), "folder": str(self.folder)}


def run_procedure(
    argument: str | Path,
    options: Mapping[str, Any] | None = None,
    out: Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> ProcedureResult:
    """Make the runs of a procedure and judge them together.

    Parameters
    ----------
    options : mapping, optional
        Arguments of `bench.scenario.resolve` for every run (ecu, link, vehicle, seed, sets, pacing).
    out : Path, optional
        Folder; by default ``runs/<procedure>-<time>``.
    progress : callable, optional
        Receives a line per run.

    Raises
    ------
    InputError
        If a file has faults.
    """
    from bench.api import run
    from bench.verdict.output_files import write_verdict

    path = find_scenario(argument)
    procedure = read_procedure(path)
    folder = out or Path("runs") / f"{procedure.id.replace('/', '-')}-{time.strftime('%Y%m%d-%H%M%S')}"
    say = progress or (lambda text: None)
    verdicts: dict[str, list[Verdict]] = {}
    for entry in procedure.runs:
        for number in range(entry.repeat):
            scenario = _resolved(entry, path, procedure, number, options or {})
            say(f"{entry.name} {number + 1}/{entry.repeat}: {scenario.id}, seed {scenario.seed}")
            name = entry.name if entry.repeat == 1 else f"{entry.name}-{number + 1}"
            done = run(scenario, out=folder / name if procedure.record else None, record=procedure.record)
            verdicts.setdefault(entry.name, []).append(done.verdict)
    verdict = judge_procedure(procedure, verdicts)
    folder.mkdir(parents=True, exist_ok=True)
    write_verdict(folder, verdict)
    return ProcedureResult(verdict, folder)


def judge_procedure(procedure: ProcedureFile, verdicts: "Mapping[str, list[Verdict]]") -> "Verdict":
    """The verdict over the verdicts of the runs."""
    from bench.verdict.result import Verdict

    results = {name: _table(runs) for name, runs in verdicts.items()}
    errors = [
        f"{name} {number + 1}: {text}"
        for name, runs in verdicts.items()
        for number, run in enumerate(runs)
        for text in run.errors
    ]
    criteria = [_judged(criterion, results, verdicts) for criterion in procedure.criteria]
    criteria += [_must_pass(entry, verdicts[entry.name]) for entry in procedure.runs if entry.must_pass]
    single = {
        name: [{"seed": run.seed, "verdict": run.verdict, **run.metrics} for run in runs]
        for name, runs in verdicts.items()
    }
    first = next(iter(verdicts.values()))[0]
    return Verdict(
        scenario=procedure.id,
        criteria=criteria,
        metrics={"runs": single},
        seed=procedure.seed,
        versions=first.versions,
        errors=errors,
    )


def _table(runs: "list[Verdict]") -> dict[str, list[float]]:
    """Every quantity of some runs, NaN where a run has no value; of a value per wheel the largest."""
    from bench.verdict.summary import METRIC_KEYS

    table: dict[str, list[float]] = {}
    for name, key in METRIC_KEYS.items():
        table[name] = [_number(run.metrics.get(key)) for run in runs]
    for criterion in runs[0].criteria:
        found = [next((c.value for c in run.criteria if c.id == criterion.id), None) for run in runs]
        table.setdefault(criterion.id, [_number(value) for value in found])
    return table


def _number(value: Any) -> float:
    if isinstance(value, (list, tuple)):
        numbers = [number for number in map(_number, value) if not math.isnan(number)]
        return max(numbers, default=math.nan)
    return math.nan if value is None else float(value)


def _judged(
    criterion: ProcedureCriterion, results: Mapping[str, Any], verdicts: "Mapping[str, list[Verdict]]"
) -> "CriterionResult":
    reason = ""
    try:
        value = evaluate(criterion.value, results)
        reason = "a run has no value for it" if math.isnan(value) else ""
    except (ValueError, KeyError, OverflowError) as error:
        value, reason = math.nan, f"no value: {error}"
    for name in sorted(names_used(criterion.value)):
        if any(_invalid(run) for run in verdicts[name]):
            reason = reason or f"a run of {name!r} is inconclusive"
    low, high = (
        None if limit is None else to_si(limit, criterion.unit) for limit in (criterion.at_least, criterion.at_most)
    )
    return _result(criterion, value, low, high, reason)


def _invalid(run: "Verdict") -> bool:
    """A condition of the whole run did not hold; one criterion without a verdict does not spoil a run's figures."""
    from bench.verdict.result import INCONCLUSIVE

    return bool(run.criteria) and all(criterion.verdict == INCONCLUSIVE for criterion in run.criteria)


def _result(
    criterion: ProcedureCriterion, value: float, low: float | None, high: float | None, reason: str
) -> "CriterionResult":
    from bench.verdict.result import FAIL, INCONCLUSIVE, PASS, CriterionResult

    margins = [(value - low) / (abs(low) or 1.0)] if low is not None else []
    margins += [(high - value) / (abs(high) or 1.0)] if high is not None else []
    margin = min(margins, default=None)
    verdict = INCONCLUSIVE if reason else FAIL if margin is not None and margin < 0 else PASS
    known = not math.isnan(value)
    return CriterionResult(
        id=criterion.id,
        requirement=criterion.requirement,
        description=criterion.description,
        expression=criterion.value,
        phase=None,
        value=value if known else None,
        unit=criterion.unit,
        limits=(low, high),
        margin=margin if known else None,
        verdict=verdict,
        reason=reason,
    )


def _must_pass(entry: ProcedureRun, runs: "list[Verdict]") -> "CriterionResult":
    from bench.verdict.result import worst

    passed = sum(run.verdict == "pass" for run in runs)
    criterion = ProcedureCriterion(id=f"{entry.name}_pass", value="share of the runs that pass")
    result = _result(criterion, passed / len(runs), 1.0, None, "")
    result.description, result.verdict = f"{passed} of {len(runs)} runs pass", worst(run.verdict for run in runs)
    return result


def print_result(result: ProcedureResult) -> None:
    """Print the verdict table of a procedure."""
    from bench.report import print_summary

    print_summary(result.folder, result.verdict.as_json())
