"""The figures of a campaign for the terminal, and as JSON."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.campaign.outcome_names import OUTCOMES, SHORT_TEXTS
from bench.campaign.statistics import Share
from bench.campaign.summary import Line, Summary
from bench.ecu.faults import FAULTS

if TYPE_CHECKING:
    from bench.campaign.engine import Progress

MOST_LINES = 12


def print_summary(summary: Summary, folder: Path, progress: "Progress | None") -> None:
    """Print the figures."""
    from rich.table import Table

    from bench.report.summary import output_console

    console = output_console()
    table = Table(box=None, pad_edge=False)
    for head in ("fault", "runs", *SHORT_TEXTS.values(), "detected"):
        table.add_column(head, justify="left" if head == "fault" else "right", no_wrap=True)
    for line in [*summary.by_entry, summary.whole]:
        counts = [str(line.outcomes[outcome].count or "–") for outcome in OUTCOMES]
        table.add_row(line.name, str(line.runs), *counts, percent(line.detected))
    console.print(table)
    for text in texts(summary, folder):
        console.print(text, highlight=False, markup=False)
    if progress is not None and progress.made:
        console.print(
            f"rate: {progress.per_hour:.0f} runs per hour on {progress.workers} workers "
            f"({progress.made} runs in {progress.wall_s:.1f} s, {progress.known} known before)",
            highlight=False,
        )


def texts(summary: Summary, folder: Path) -> list[str]:
    """Lines below the table."""
    whole = summary.whole
    lines = [
        f"undetected, with an effect on the car: {whole.undetected}; hazardous: {whole.hazardous}",
        "covered: " + ", ".join(f"{axis} {run}/{every}" for axis, (run, every) in summary.covered.items()),
    ]
    if whole.latencies_s:
        lines.append(
            f"latency of the fault code: median {ms(whole.latency_s(50))}, 95 % {ms(whole.latency_s(95))}, "
            f"largest {ms(whole.latencies_s[-1])}"
        )
    if summary.fault_codes:
        codes = ", ".join(f"{code} {code_name(code)} ({n})" for code, n in summary.fault_codes.most_common(8))
        lines.append(f"fault codes (runs): {codes}")
    for row in summary.smallest[:3]:
        faults = " + ".join(f"{name} at {time}" for name, time in zip(row["faults"], row["times_s"], strict=True))
        lines.append(f"smallest failing set: {faults} ({row['key']})")
    if whole.worst:
        lines.append(f"worst run: {show_command(whole.worst['key'], folder)}")
    for result in summary.limits:
        limit = result.limit
        bound = f"at most {limit.at_most:g}" if limit.at_most is not None else f"at least {limit.at_least:g}"
        found = "no value" if result.value is None else f"{result.value:.4g}"
        of = "".join(f" of {name}" for name in (limit.fault, limit.variant) if name)
        lines.append(f"limit {limit.quantity}{of} {bound}: {found} {'BROKEN' if result.broken else 'kept'}")
    for row in summary.without_result[:MOST_LINES]:
        lines.append(f"no result: {row['key']} {row['reason']}")
    return lines


def show_command(key: str, folder: Path) -> str:
    """Command that repeats a run alone."""
    return f"bench campaign show {key} --campaign {folder}"


def code_name(code: int) -> str:
    """Name of a fault code of the emulated ECU."""
    return FAULTS[code].name if code in FAULTS else "unknown"


def percent(value: Share) -> str:
    """``97.2 % [95.1, 98.4]``."""
    if not value.total:
        return "–"
    return f"{100 * value.value:.1f} % [{100 * value.low:.1f}, {100 * value.high:.1f}]"


def ms(seconds: float | None) -> str:
    """Milliseconds."""
    return "–" if seconds is None else f"{1000 * seconds:.0f} ms"


def markdown(summary: Summary) -> list[str]:
    """Table of classes of communication faults and variants, or of entries, for a document."""
    heads = ["class", "variant"] if summary.by_class_and_variant else ["fault"]
    rows = [([name.replace("_", " "), variant], line) for name, variant, line in summary.by_class_and_variant]
    heads += ["runs", *SHORT_TEXTS.values(), "detected, Wilson interval", "latency median / 95 %"]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for names, line in rows or [([line.name], line) for line in summary.by_entry]:
        counts = [str(line.outcomes[outcome].count or "–") for outcome in OUTCOMES]
        latency = f"{ms(line.latency_s(50))} / {ms(line.latency_s(95))}"
        lines.append(f"| {' | '.join([*names, str(line.runs), *counts, percent(line.detected), latency])} |")
    return lines


def summary_json(summary: Summary, folder: Path, progress: "Progress | None") -> dict[str, Any]:
    """The figures as plain data."""
    data: dict[str, Any] = {
        "campaign": summary.campaign.id,
        "folder": str(folder),
        "exit_code": summary.exit_code,
        "whole": _line_json(summary.whole),
        "faults": [_line_json(line) for line in summary.by_entry],
        "e2e_classes": [_line_json(line) for line in summary.by_class],
        "variants": [_line_json(line) for line in summary.by_variant],
        "e2e_classes_by_variant": [_line_json(line) for _, _, line in summary.by_class_and_variant],
        "fault_codes": {str(code): count for code, count in sorted(summary.fault_codes.items())},
        "covered": {axis: {"run": run, "all": every} for axis, (run, every) in summary.covered.items()},
        "pareto": [line.name for line in summary.pareto],
        "smallest_failing_sets": [
            {"key": row["key"], "faults": row["faults"], "times_s": row["times_s"]} for row in summary.smallest
        ],
        "limits": [
            {**result.limit.model_dump(exclude_none=True), "value": result.value, "broken": result.broken}
            for result in summary.limits
        ],
        "without_result": [row["key"] for row in summary.without_result],
    }
    if progress is not None:
        data["progress"] = {
            "made": progress.made,
            "known": progress.known,
            "runs_per_hour": progress.per_hour,
            "workers": progress.workers,
        }
    return data


def _line_json(line: Line) -> dict[str, Any]:
    return {
        "name": line.name,
        "runs": line.runs,
        "outcomes": {name: _share_json(value) for name, value in line.outcomes.items()},
        "detected": _share_json(line.detected),
        "undetected": _share_json(line.undetected),
        "latency_s": {"median": line.latency_s(50), "p95": line.latency_s(95), "largest": line.latency_s(100)},
        "worst": line.worst.get("key"),
    }


def _share_json(value: Share) -> dict[str, float]:
    return {"count": value.count, "share": value.value, "low": value.low, "high": value.high}
