"""Traceability: tests name the requirement they check and record what they measured; witnesses say what they saw.

``@pytest.mark.acceptance("F-A7")`` names one or more ids of ``docs/traceability.csv``; the fixture ``record`` keeps a
measured value with its limit. With ``--write-traceability`` the file is updated from the run. See docs/traceability.md.
The fixture ``witnessed`` puts a line into the summary of the run: what an independent program confirmed.
"""

import csv
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from alone_on_the_machine import AloneOnTheMachine
from order_of_modules import OrderOfModules

# Before anything imports numpy: threads of OpenBLAS wait for each other busily. On two cores shared with another worker
# the matrices of a diagnosis, a few hundred columns wide, take 2.7 times the processor time (test_small_delays, 72 s).
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

TRACEABILITY = Path(__file__).resolve().parent.parent / "docs" / "traceability.csv"
COLUMNS = ("id", "source_line", "test_node_id", "measured", "limit", "verdict")
_PROPERTY = "acceptance"
_WITNESS = "witness"
_CONFORMANCE = "conformance"
OPEN = "open"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--write-traceability", action="store_true", help="write measured values and verdicts to docs/traceability.csv"
    )


def pytest_configure(config: pytest.Config) -> None:
    # a shell without job control starts what runs in the background with the signal ignored
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    config.addinivalue_line("markers", "acceptance(*ids): ids of docs/traceability.csv that the test checks")
    config.pluginmanager.register(_TraceabilityWriter(config), "traceability-writer")
    config.pluginmanager.register(OrderOfModules(), "order-of-modules")
    if hasattr(config, "workerinput"):
        config.pluginmanager.register(AloneOnTheMachine(config.workerinput["testrunuid"]), "alone-on-the-machine")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    for mark in item.iter_markers("acceptance"):
        for identifier in mark.args:
            item.user_properties.append((_PROPERTY, {"id": identifier}))


@pytest.fixture(autouse=True)
def _signals_left_alone() -> Iterator[None]:
    """A signal that a test leaves ignored is ignored by every process that later tests start."""
    numbers = signal.SIGINT, signal.SIGTERM
    before = [signal.getsignal(number) for number in numbers]
    yield
    assert [signal.getsignal(number) for number in numbers] == before


@pytest.fixture
def record(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Keep a measured value: ``record("k0F mean", 1.118, "1.064 ... 1.176")``; ``id=`` picks one of several ids."""
    ids = [identifier for mark in request.node.iter_markers("acceptance") for identifier in mark.args]
    if not ids:
        raise pytest.UsageError(f"{request.node.nodeid} records a value but has no acceptance mark")

    def keep(quantity: str, value: float, limit: str, *, id: str = "") -> None:
        if id and id not in ids:
            raise pytest.UsageError(f"{request.node.nodeid} records for {id}, its mark names {', '.join(ids)}")
        for identifier in [id] if id else ids:
            kept = {"id": identifier, "quantity": quantity, "value": float(value), "limit": f"{quantity}: {limit}"}
            request.node.user_properties.append((_PROPERTY, kept))

    return keep


@pytest.fixture
def witnessed(request: pytest.FixtureRequest) -> Callable[[str], None]:
    """Say at the end of the run what an independent program confirmed: ``witnessed("2000 frames equal in …")``."""

    def keep(text: str) -> None:
        request.node.user_properties.append((_WITNESS, text))

    return keep


def pytest_terminal_summary(terminalreporter: Any) -> None:
    passed = terminalreporter.stats.get("passed", [])
    lines = [text for report in passed for name, text in report.user_properties if name == _WITNESS]
    if lines:
        terminalreporter.section("independent witnesses")
        for line in lines:
            terminalreporter.line(line)
    _tell_conformance(terminalreporter)


def _tell_conformance(terminalreporter: Any) -> None:
    """How many published names of ISO 16845-1 passed in all their tests, and what became of the others."""
    found: dict[str, dict[str, str]] = {}
    for outcome in ("passed", "skipped", "xfailed", "failed", "error"):
        for report in terminalreporter.stats.get(outcome, []):
            # what fails while it is collected has no properties
            properties = getattr(report, "user_properties", ())
            for name in (text for key, text in properties if key == _CONFORMANCE):
                found.setdefault(name, {})[outcome] = report.nodeid
    if found:
        others = {name: told for name, outcomes in found.items() if (told := outcomes.keys() - {"passed"})}
        terminalreporter.section("names of ISO 16845-1")
        terminalreporter.line(f"{len(found) - len(others)} of {len(found)} names passed")
        for name, told in sorted(others.items()):
            terminalreporter.line(f"{name}: " + ", ".join(f"{outcome} {found[name][outcome]}" for outcome in told))


class _TraceabilityWriter:
    """Collects what the tests recorded, in the process that reports, and merges it into the file at the end."""

    def __init__(self, config: pytest.Config) -> None:
        self._write = config.getoption("--write-traceability") and not hasattr(config, "workerinput")
        self._rows: dict[tuple[str, str], dict[str, Any]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not self._write or not (report.when == "call" or report.outcome != "passed"):
            return
        node = report.nodeid.split("[")[0]
        for name, kept in report.user_properties:
            if name != _PROPERTY or not isinstance(kept, dict):
                continue
            row = self._rows.setdefault((kept["id"], node), {"outcomes": set(), "measured": {}, "limit": []})
            # a miss that the test expects and gives the reason of is a miss all the same
            row["outcomes"].add("failed" if hasattr(report, "wasxfail") else report.outcome)
            if "quantity" in kept:
                row["measured"].setdefault(kept["quantity"], []).append(kept["value"])
                if kept["limit"] not in row["limit"]:
                    row["limit"].append(kept["limit"])

    def pytest_sessionfinish(self) -> None:
        if self._write and self._rows:
            write_rows(TRACEABILITY, merge(read_rows(TRACEABILITY), self._rows))


def read_rows(path: Path) -> list[dict[str, str]]:
    """Rows of the traceability file."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_rows(path: Path, rows: list[dict[str, str]]) -> None:
    """Write the traceability file."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def merge(rows: list[dict[str, str]], results: dict[tuple[str, str], dict[str, Any]]) -> list[dict[str, str]]:
    """Rows with the results of a run; order of the ids as in the file, one row per id and test."""
    sources: dict[str, str] = {}
    by_id: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        sources.setdefault(row["id"], row["source_line"])
        by_id.setdefault(row["id"], []).append(row)
    for (identifier, node), result in results.items():
        if identifier not in sources:
            raise pytest.UsageError(f"{node}: docs/traceability.csv has no id {identifier}")
        verdict = "fail" if "failed" in result["outcomes"] else "pass" if "passed" in result["outcomes"] else "skipped"
        updated = {
            "id": identifier,
            "source_line": sources[identifier],
            "test_node_id": node,
            "measured": "; ".join(_range(quantity, values) for quantity, values in result["measured"].items()),
            "limit": "; ".join(result["limit"]),
            "verdict": verdict,
        }
        kept = [row for row in by_id[identifier] if row["test_node_id"] not in ("", node)]
        by_id[identifier] = [*kept, updated]
    return [row for identifier in sources for row in sorted(by_id[identifier], key=lambda row: row["test_node_id"])]


def _range(quantity: str, values: list[float]) -> str:
    low, high = min(values), max(values)
    if low == high:
        return f"{quantity} = {low:.4g}"
    return f"{quantity} = {low:.4g} ... {high:.4g} ({len(values)} cases)"
