"""Tables of the page's details: steps, metrics, estimators, frames, timing, parameters of the car."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.report.bus_charts import SENDERS, MessageStatistics
from bench.report.formatting import metric_label, number, quantity, seconds
from bench.report.run_data import RunData

_PERCENTILES = (("p50", "p50"), ("p99", "p99"), ("p999", "p99.9"), ("max", "largest"))
_DURATIONS = {
    "lateness_us": "start after the deadline",
    "tick_cpu_us": "processor time of a tick",
    "tick_duration_us": "wall-clock time of a tick",
}
_RECEIVED = "frames_from_ecu"
_INJECTOR = "injector"


@dataclass(frozen=True)
class Table:
    """A table of the details: heads, rows of texts, columns with numbers."""

    heads: list[str]
    rows: list[list[str]]
    numbers: list[bool]


def step_table(run: RunData) -> Table | None:
    """Steps of the manoeuvre with the speed at which each began."""
    rows = []
    for step in run.steps():
        row = min(int(np.searchsorted(run.time, step.start_s)), len(run.time) - 1)
        speed = f"{run.array('speed')[row] * 3.6:.1f} km/h" if run.has("speed") else ""
        length = seconds(step.end_s - step.start_s)
        rows.append([step.name, seconds(step.start_s), seconds(step.end_s), length, speed])
    return _table(["step", "from", "to", "duration", "speed at its start"], rows, first_number=1)


def estimator_table(run: RunData) -> Table | None:
    """Root mean square error and settling of every estimate with a true value."""
    units = run.signals.units if run.signals is not None else {}
    rows = []
    for estimator, block in (run.verdict.get("estimators") or {}).items():
        settling = block.get("settling") or {}
        for output, error in (block.get("rmse") or {}).items():
            unit = units.get(f"{estimator}.{output}", "1")
            text = f"{number(error)} rad/s" if output.startswith("wheel_speed") else quantity(error, unit)
            settled = f"{number(settling[output], 3)} s" if isinstance(settling.get(output), (int, float)) else ""
            rows.append([estimator, output.replace("_", " "), text, settled])
    return _table(["estimator", "output", "RMS error", "settling after the jump"], rows, first_number=2)


def message_table(statistics: Iterable[MessageStatistics]) -> Table | None:
    """Frames by identifier and sender."""
    rows = [
        [
            message.label,
            message.name,
            SENDERS[message.sender].label if message.sender in SENDERS else "",
            str(message.count),
            f"{message.nominal_ms:g} ms" if message.nominal_ms else "",
            f"{message.period_ms:.2f} ms",
            f"{message.period_p99_ms:.2f} ms",
            f"{message.largest_gap_ms:.2f} ms",
        ]
        for message in statistics
    ]
    heads = ["identifier", "message", "sender", "frames", "cycle", "mean distance", "p99", "largest"]
    return _table(heads, rows, first_number=3)


def _table(heads: list[str], rows: list[list[str]], *, first_number: int) -> Table | None:
    if not rows:
        return None
    return Table(heads, rows, [column >= first_number for column in range(len(heads))])


def pairs(mapping: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Nested figures as (words, text), in the order of the file."""
    found: list[tuple[str, str]] = []
    for key, value in mapping.items():
        label = f"{prefix} {str(key).replace('_', ' ')}".strip()
        if isinstance(value, Mapping):
            found += pairs(value, label)
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                found += pairs(item, label)
        elif isinstance(value, list):
            found.append((label, " · ".join(number(item) for item in value)))
        else:
            found.append((label, number(value)))
    return found


def metric_pairs(run: RunData) -> list[tuple[str, str]]:
    """All metrics with display units."""
    found = []
    for name, value in (run.verdict.get("metrics") or {}).items():
        if value is None or (isinstance(value, list) and all(item is None for item in value)):
            continue
        label, unit = metric_label(name)
        found.append((label, _list_text(value, unit) if isinstance(value, list) else quantity(value, unit)))
    return found


def _list_text(values: list[Any], unit: str) -> str:
    known = [quantity(value, unit) if value is not None else "–" for value in values]
    return " · ".join(known)


def percentile_table(run: RunData) -> Table | None:
    """Lateness, processor time and duration of the ticks of a real-time run."""
    rows = []
    for key, label in _DURATIONS.items():
        block = run.timing.get(key)
        if run.real_time and isinstance(block, Mapping):
            rows.append([label, *(f"{number(block.get(name), 3)} µs" for name, _ in _PERCENTILES)])
    return _table(["", *(head for _, head in _PERCENTILES)], rows, first_number=1)


def timing_pairs(run: RunData) -> list[tuple[str, str]]:
    """Timing block without what has a table of its own."""
    elsewhere = (*_DURATIONS, _RECEIVED, _INJECTOR)
    return pairs({key: value for key, value in run.timing.items() if key not in elsewhere})


def fault_table(run: RunData) -> Table | None:
    """What each fault on the bus did, and at which level it was realised."""
    faults = (run.timing.get(_INJECTOR) or {}).get("faults") or []
    rows = [
        [
            str(fault.get("name", "")),
            str(fault.get("kind", "")).replace("_", " "),
            str(fault.get("e2e", "")).replace("_", " "),
            str(fault.get("realised_as", "")).replace("_", " "),
            seconds(fault["first_s"]) if isinstance(fault.get("first_s"), (int, float)) else "never",
            number(fault.get("runs")),
            number(fault.get("frames")),
        ]
        for fault in faults
    ]
    heads = ["fault", "disturbance", "E2E class", "realised as", "first at", "runs", "frames"]
    return _table(heads, rows, first_number=4)


def injector_pairs(run: RunData) -> list[tuple[str, str]]:
    """Counts of the injector."""
    return pairs((run.timing.get(_INJECTOR) or {}).get("counts") or {})


def receiver_table(run: RunData) -> Table | None:
    """What the bench accepted and refused of each message of the ECU."""
    received = run.timing.get(_RECEIVED)
    blocks = {name: block for name, block in (received or {}).items() if isinstance(block, Mapping)}
    heads = list(dict.fromkeys(key for block in blocks.values() for key in block))
    rows = [[name, *(number(block.get(key)) for key in heads)] for name, block in blocks.items()]
    return _table(["message from the ECU", *(head.replace("_", " ") for head in heads)], rows, first_number=1)


def parameter_table(run: RunData) -> Table | None:
    """Every number of the car as it was driven; where the scenario changed it, the vehicle file's value beside it."""
    from bench.scenario.schema import ScenarioFile
    from bench.scenario.vehicle_choice import nominal_vehicle, vehicle_as_driven
    from signals.errors import BenchError
    from vehicle_model.vehicle_file import parameter_table as infos_of

    if not run.scenario:
        return None
    try:
        scenario = ScenarioFile.model_validate(run.scenario)
        nominal = {info.path: info.value for info in infos_of(nominal_vehicle(scenario))}
        driven = infos_of(vehicle_as_driven(scenario))
    except (BenchError, ValueError, OSError):
        return None  # the run's own files have moved, or an older bench made it: its scenario text still stands below
    rows = []
    for info in driven:
        before = nominal.get(info.path)
        changed = "" if before is None or before == info.value else f"{number(before)} in the vehicle file"
        unit = "" if info.unit == "1" else info.unit
        rows.append([info.path, number(info.value, 6), unit, changed, info.description])
    rows.sort(key=lambda row: not row[3])  # what the scenario changed stands first
    table = _table(["parameter", "value", "unit", "", ""], rows, first_number=1)
    return Table(table.heads, table.rows, [False, True, False, False, False]) if table is not None else None
