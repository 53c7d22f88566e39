"""``diagnosis.html``: one self-contained page, pictures first."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.diagnosis_report.bars import evidence_bars, gain_bars, interval_mark
from bench.diagnosis_report.house import house_of_equations, outside
from bench.diagnosis_report.residual_maps import residual_maps
from bench.diagnosis_report.signal_charts import add_signal_charts, ranked_signals, uncompared_signals
from bench.diagnosis_report.timeline import Timeline
from bench.diagnosis_report.words import (
    BADGES,
    DRIVEN,
    REPLAYS,
    SUBJECTS,
    gain_words,
    headline,
    parameter_texts,
    percent,
    plain,
    signal_words,
)
from bench.report.charts import ChartBook
from bench.report.formatting import number, quantity
from bench.report.page_rendering import render
from model_diagnosis.effects.catalogue import effect as find_effect
from model_diagnosis.findings import Findings
from model_diagnosis.rating import grade, ratings_of
from model_diagnosis.result import LIT_RATIO, Cause, DataFault, Diagnosis

_ICONS = {"pass": "%2312713f", "fail": "%23b3132f", "inconclusive": "%23b07a00"}
_SYMBOLS = {"pass": "✓", "fail": "≠", "inconclusive": "?"}
_COMPARED = 2
"""Signals whose charts stand at the top; the others are further down."""


def build(findings: Findings, folder: Path) -> Path:
    """Write ``diagnosis.html`` into a folder and return its path."""
    path = folder / "diagnosis.html"
    partial = folder / ".diagnosis.html.partial"
    partial.write_text(page_of(findings), encoding="utf-8")
    os.replace(partial, path)
    return path


def page_of(findings: Findings) -> str:
    """The page as text."""
    diagnosis = findings.diagnosis
    timeline = Timeline(findings.manoeuvres)
    book = ChartBook((0.0, float(timeline.time[-1])))
    add_signal_charts(book, timeline, findings)
    signals = ranked_signals(timeline, findings.sensor_std)
    badge, verdict = BADGES[diagnosis.verdict]
    contents: dict[str, Any] = {
        "title": f"{verdict}: diagnosis of {findings.vehicle}",
        "icon_colour": _ICONS[badge],
        "badge": badge,
        "symbol": _SYMBOLS[badge],
        "verdict": verdict,
        "headline": headline(diagnosis),
        "subject": SUBJECTS[diagnosis.subject],
        "driven": DRIVEN[diagnosis.subject],
        "replay": REPLAYS[diagnosis.subject],
        "findings": findings,
        "diagnosis": diagnosis,
        "facts": _facts(findings),
        "tiles": _tiles(diagnosis),
        "book": book,
        "first_charts": book.sections[:_COMPARED],
        "other_charts": book.sections[_COMPARED:],
        "ranges": _ranges(timeline),
        "maps": residual_maps(findings, signals),
        "house": house_of_equations(diagnosis.guilty_equations, diagnosis.guilty_by_innovations),
        "violated": _violated(diagnosis),
        "lit_from": number(LIT_RATIO, 3),
        "outside": [(plain(name), number(ratio, 3)) for name, ratio in outside(diagnosis.guilty_equations)],
        "causes": [_cause(cause) for cause in diagnosis.causes],
        "faults": [_fault(fault) for fault in diagnosis.data_faults],
        "gain": gain_bars(diagnosis.gain) if diagnosis.gain and diagnosis.gain.held_out else "",
        "gain_words": _gain_sentences(diagnosis),
        "figures": _user_figures(diagnosis),
        "terms": [_term(term) for term in diagnosis.discovered_terms],
        "evidence": evidence_bars(findings.evidence, diagnosis.threshold, diagnosis.causes),
        "ratings": [
            ("free runs from the first sample", rating_table(findings)),
            ("runs that restart each second at the measured speeds", rating_table(findings, restarted=True)),
        ],
        "uncompared": [signal_words(name) for name in uncompared_signals(timeline)],
        "insufficient": [plain(name) for name in diagnosis.insufficient],
        "separated": [plain(name) for name in diagnosis.next_manoeuvre.separates] if diagnosis.next_manoeuvre else [],
        "timing": [(plain(step), f"{seconds:.1f} s") for step, seconds in diagnosis.timing_s.items()],
        "versions": [(name, str(value)) for name, value in diagnosis.versions.items()],
        "extended": any(np.any(part.after != part.before) for part in findings.manoeuvres),
    }
    steps = [{"name": s.name, "start": s.start_s, "end": s.end_s} for s in timeline.stretches]
    return render("diagnosis.html.j2", book.inline(steps), contents)


def rating_table(findings: Findings, *, restarted: bool = False) -> dict[str, Any] | None:
    """Rating of every signal and manoeuvre before and after: heads, and rows of cells (texts and grade)."""
    if restarted and all(part.restarted_before is None for part in findings.manoeuvres):
        return None
    before = [ratings_of(part, restarted=restarted) for part in findings.manoeuvres]
    after = [ratings_of(part, extended=True, restarted=restarted) for part in findings.manoeuvres]
    signals = list(dict.fromkeys(name for rated in before for name in rated))
    if not signals:
        return None
    rows = []
    for part, first, second in zip(findings.manoeuvres, before, after, strict=True):
        cells = [
            {
                "before": f"{first[name].overall:.2f}",
                "after": f"{second[name].overall:.2f}",
                "grade": grade(second[name].overall),
                "same": abs(first[name].overall - second[name].overall) < 0.005,
            }
            if name in first and name in second
            else None
            for name in signals
        ]
        rows.append((plain(part.manoeuvre.name) + (" (held out)" if part.held_out else ""), cells))
    return {"signals": [signal_words(name) for name in signals], "rows": rows}


def _facts(findings: Findings) -> list[tuple[str, str]]:
    held_out = sum(part.held_out for part in findings.manoeuvres)
    seconds = sum(part.manoeuvre.duration_s for part in findings.manoeuvres)
    manoeuvres = f"{len(findings.manoeuvres)}" + (f", {held_out} held out" if held_out else "")
    facts = [("vehicle file", findings.vehicle), ("manoeuvres", manoeuvres), ("data", f"{seconds:.0f} s")]
    if findings.logs:
        facts.append(("logs", ", ".join(Path(log).name for log in findings.logs[:4])))
    return facts


def _tiles(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """Label, value and small print of the key figures."""
    tiles = []
    if diagnosis.causes:
        first = diagnosis.causes[0]
        tiles.append(("probability of the first cause", percent(first.probability), plain(first.effect)))
        for text in parameter_texts(first)[:2]:
            tiles.append((f"{plain(first.effect)}, {text.name}", text.value, text.change))
    elif diagnosis.probability_of_nothing is not None:
        tiles.append(("probability of nothing", percent(diagnosis.probability_of_nothing), ""))
    if diagnosis.gain is not None:
        overall = diagnosis.gain.overall
        interval = f"[{100 * overall.low:.0f}, {100 * overall.high:.0f}]"
        tiles.append(("error left on held-out data", f"{100 * overall.ratio:.0f} %", interval))
    if diagnosis.data_faults:
        repaired = sum(fault.repaired for fault in diagnosis.data_faults)
        tiles.append(("data faults", str(len(diagnosis.data_faults)), f"{repaired} repaired"))
    return tiles


def _ranges(timeline: Timeline) -> list[tuple[str, float, float]]:
    everything = [("all manoeuvres", 0.0, float(timeline.time[-1]))]
    return everything + [(s.name, s.start_s, s.end_s) for s in timeline.stretches[:24]]


def _violated(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Equations that the innovations show as violated, with the size of the error that each would need."""
    return [
        (plain(name), quantity(one.error, one.unit))
        for name, one in diagnosis.guilty_by_innovations.items()
        if one.likelihood_ratio > LIT_RATIO
    ]


def _cause(cause: Cause) -> dict[str, Any]:
    others = [plain(name) for name in cause.group if name != cause.effect]
    paths = {parameter.name: parameter.vehicle_path for parameter in find_effect(cause.effect).parameters}
    return {
        "name": plain(cause.effect),
        "effect": cause.effect,
        "probability": percent(cause.probability),
        "share": 100.0 * cause.probability,
        "equation": cause.equation,
        "evidence": number(cause.evidence, 3),
        "group": others,
        "remarks": cause.remarks,
        "parameters": [
            (text, interval_mark(estimate), paths.get(name, ""))
            for text, (name, estimate) in zip(parameter_texts(cause), cause.parameters.items(), strict=True)
        ],
    }


def _fault(fault: DataFault) -> dict[str, Any]:
    value = "" if fault.value is None else quantity(fault.value, fault.unit)
    return {
        "kind": plain(fault.kind),
        "channel": fault.channel,
        "value": value,
        "message": fault.message,
        "repaired": fault.repaired,
    }


def _term(term: Any) -> dict[str, Any]:
    numbers = zip(term.coefficients, term.low, term.high, term.units, strict=True)
    return {
        "formula": term.formula,
        "target": plain(term.target),
        "inclusion": percent(term.inclusion),
        "coefficients": [f"{number(c, 4)} [{number(a, 3)}, {number(b, 3)}] {unit}" for c, a, b, unit in numbers],
    }


def _gain_sentences(diagnosis: Diagnosis) -> list[str]:
    gain = diagnosis.gain
    if gain is None:
        return []
    kind = "in cross-validation, for want of a held-out log" if gain.cross_validated else "on held-out manoeuvres"
    overall = gain.overall
    words = gain_words(overall.ratio, overall.low, overall.high)
    sentences = [f"Error that is left {kind}, over all signals: {words}; 90 % interval in brackets."]
    if gain.against_refit is not None:
        refit = gain.against_refit
        words = gain_words(refit.ratio, refit.low, refit.high)
        sentences.append(f"Against a refit of all nominal parameters within two of their scatters: {words}.")
    return sentences


def _user_figures(diagnosis: Diagnosis) -> list[tuple[str, Sequence[tuple[str, str]]]]:
    if diagnosis.gain is None:
        return []
    return [
        (plain(name), [(plain(when), number(value, 4)) for when, value in values.items()])
        for name, values in diagnosis.gain.user_figures.items()
        if all(np.isfinite(value) for value in values.values())
    ]
