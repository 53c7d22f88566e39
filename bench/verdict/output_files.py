"""``verdict.json`` and ``junit.xml``, written so that a reader never sees half of one."""

import json
import os
from pathlib import Path
from typing import Any

from bench.verdict.result import ERROR, FAIL, INCONCLUSIVE, CriterionResult, Verdict


def write_verdict(folder: Path, verdict: Verdict) -> None:
    """Write ``verdict.json`` and ``junit.xml`` into a run's folder."""
    text = json.dumps(verdict.as_json(), indent=2, allow_nan=False)
    replace_file(folder / "verdict.json", (text + "\n").encode())
    replace_file(folder / "junit.xml", junit_xml(verdict))


def replace_file(path: Path, content: bytes) -> None:
    """Write a file beside its place and move it there in one step."""
    partial = path.with_name(f".{path.name}.partial")
    with partial.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    partial.replace(path)


def junit_xml(verdict: Verdict) -> bytes:
    """JUnit report: fail is ``<failure>``, error ``<error>``, inconclusive ``<skipped>`` with a property.

    Every criterion is a test case of the suite named after the scenario; errors of the bench are a case of their own.
    """
    from junitparser import JUnitXml, TestSuite

    suite = TestSuite(verdict.scenario)
    suite.add_property("verdict", verdict.verdict)
    if verdict.seed is not None:
        suite.add_property("seed", str(verdict.seed))
    for criterion in verdict.criteria:
        suite.add_testcase(_case(verdict.scenario, criterion))
    for position, error in enumerate(verdict.errors):
        suite.add_testcase(_error_case(verdict.scenario, position, error))
    suite.update_statistics()
    document = JUnitXml()
    document.add_testsuite(suite)
    document.update_statistics()
    xml: bytes = document.tostring()
    return xml


def _case(scenario: str, criterion: CriterionResult) -> Any:
    from junitparser import Error as JUnitError
    from junitparser import Failure, Properties, Property, Skipped, TestCase

    case = TestCase(criterion.id, classname=scenario)
    properties = Properties()
    for name, text in _property_texts(criterion).items():
        properties.append(Property(name, text))
    case.append(properties)
    if criterion.verdict == FAIL:
        case.result = [Failure(describe(criterion))]
    elif criterion.verdict == ERROR:
        case.result = [JUnitError(criterion.reason or describe(criterion))]
    elif criterion.verdict == INCONCLUSIVE:
        case.result = [Skipped(f"inconclusive: {criterion.reason}")]
    return case


def _error_case(scenario: str, position: int, error: str) -> Any:
    from junitparser import Error as JUnitError
    from junitparser import TestCase

    case = TestCase(f"bench-{position + 1}", classname=scenario)
    case.result = [JUnitError(error)]
    return case


def _property_texts(criterion: CriterionResult) -> dict[str, str]:
    texts = {"requirement": criterion.requirement, "unit": criterion.unit, "verdict": criterion.verdict}
    if criterion.value is not None:
        texts["value"] = f"{criterion.value:.6g}"
    if criterion.margin is not None:
        texts["margin"] = f"{criterion.margin:.6g}"
    low, high = criterion.limits
    texts["limits"] = f"[{'' if low is None else f'{low:.6g}'}, {'' if high is None else f'{high:.6g}'}]"
    return texts


def describe(criterion: CriterionResult) -> str:
    """One line: value, limits and unit, as in ``0.14 s, allowed at most 0.1 s``."""
    low, high = criterion.limits
    unit = "" if criterion.unit == "1" else f" {criterion.unit}"
    value = "no value" if criterion.value is None else f"{criterion.value:.4g}{unit}"
    bounds = [f"at least {low:.4g}{unit}"] if low is not None else []
    bounds += [f"at most {high:.4g}{unit}"] if high is not None else []
    return f"{value}, allowed {' and '.join(bounds)}" if bounds else value
