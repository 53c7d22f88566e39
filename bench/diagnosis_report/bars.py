"""Bars and intervals of the diagnosis as SVG, in the classes of the report's style."""

import math
from collections.abc import Mapping, Sequence

from markupsafe import Markup, escape

from bench.diagnosis_report.words import plain, shown, signal_words
from bench.report.formatting import number
from model_diagnosis.result import Cause, Gain, ParameterEstimate

LABEL_WIDTH, BAR_WIDTH, TEXT_WIDTH, ROW_HEIGHT = 190, 380, 200, 34
INTERVAL_WIDTH, INTERVAL_HEIGHT = 260, 34
MOST_EFFECTS = 14
EVIDENCE_LIMIT = 100.0


def gain_bars(gain: Gain) -> Markup:
    """Root mean squared error of every signal before (100 %) and after, with interval and noise floor."""
    rows = sorted(gain.held_out.items(), key=lambda entry: entry[1].after / max(entry[1].before, 1e-300))
    height = ROW_HEIGHT * len(rows) + 24
    parts = [_open(height, "error on held-out manoeuvres, before and after")]
    longest = max([1.0, *(entry.high / entry.before for _, entry in rows if entry.before > 0)])
    scale = BAR_WIDTH / longest
    for row, (signal, entry) in enumerate(rows):
        y = ROW_HEIGHT * row + 4
        if entry.before <= 0.0:
            continue
        before, after, low, high, floor = (
            value / entry.before * scale
            for value in (entry.before, entry.after, entry.low, entry.high, entry.noise_floor)
        )
        factor, unit = shown(signal, entry.unit)
        better = entry.high < entry.before
        parts += [
            _label(signal_words(signal), y + 18),
            f'<rect class="before" x="{LABEL_WIDTH}" y="{y}" width="{before:.1f}" height="11" rx="2"/>',
            f'<rect class="{"after" if better else "worse-bar"}" x="{LABEL_WIDTH}" y="{y + 13}" width="{after:.1f}" '
            'height="11" rx="2"/>',
            _whisker(LABEL_WIDTH + low, LABEL_WIDTH + high, y + 18.5),
            f'<path class="floor" d="M{LABEL_WIDTH + floor:.1f} {y - 2}V{y + 26}"/>',
            f'<text x="{LABEL_WIDTH + BAR_WIDTH + 12}" y="{y + 18}">{number(factor * entry.before, 3)} → '
            f"{number(factor * entry.after, 3)} {escape(unit)}</text>",
        ]
    return Markup("".join([*parts, "</svg>"]))


def evidence_bars(evidence: Mapping[str, float], threshold: float | None, causes: Sequence[Cause]) -> Markup:
    """Log Bayes factors of the likeliest effects against "nothing", on a logarithmic axis, with the threshold."""
    named = {cause.effect for cause in causes}
    final = {**evidence, **{cause.effect: cause.evidence for cause in causes}}
    rows = sorted(final.items(), key=lambda entry: -entry[1])[:MOST_EFFECTS]
    if not rows:
        return Markup("")
    largest = max(EVIDENCE_LIMIT, rows[0][1])

    def length(value: float) -> float:
        return BAR_WIDTH * math.log1p(max(value, 0.0)) / math.log1p(largest)

    height = 26 * len(rows) + 26
    parts = [_open(height, "log Bayes factor of each effect against nothing")]
    for row, (effect, value) in enumerate(rows):
        y = 26 * row + 18
        kind = "after" if effect in named else "quiet"
        parts += [
            _label(plain(effect), y + 14),
            f'<rect class="{kind}" x="{LABEL_WIDTH}" y="{y + 3}" width="{length(value):.1f}" height="14" rx="2"/>',
            f'<text x="{LABEL_WIDTH + length(value) + 8:.1f}" y="{y + 14}">{number(value, 3)}</text>',
        ]
    if threshold is not None:
        x = LABEL_WIDTH + length(threshold)
        parts.append(f'<line class="limit-line" x1="{x:.1f}" x2="{x:.1f}" y1="14" y2="{height - 4}"/>')
        parts.append(
            f'<text class="limit-text" x="{x:.1f}" y="11" text-anchor="middle">needed: {number(threshold, 3)}</text>'
        )
    return Markup("".join([*parts, "</svg>"]))


def interval_mark(estimate: ParameterEstimate) -> Markup:
    """Interval of a parameter beside the vehicle file's value, on an axis that holds both."""
    values = [estimate.low, estimate.high, estimate.value, estimate.nominal]
    if not all(math.isfinite(value) for value in values):
        return Markup("")
    low, high = min(values), max(values)
    margin = 0.12 * (high - low) or max(abs(high), 1.0) * 0.1
    low, high = low - margin, high + margin

    def x(value: float) -> float:
        return 4 + (value - low) / (high - low) * (INTERVAL_WIDTH - 8)

    nominal = x(estimate.nominal)
    anchor = "start" if nominal < 40 else "end" if nominal > INTERVAL_WIDTH - 40 else "middle"
    return Markup(
        f'<svg class="interval" viewBox="0 0 {INTERVAL_WIDTH} {INTERVAL_HEIGHT}" role="img" '
        f'aria-label="{number(estimate.value, 3)} between {number(estimate.low, 3)} and {number(estimate.high, 3)}, '
        f'vehicle file {number(estimate.nominal, 3)}">'
        f'<line class="axis" x1="4" x2="{INTERVAL_WIDTH - 4}" y1="10" y2="10"/>'
        f'<line class="nominal" x1="{nominal:.1f}" x2="{nominal:.1f}" y1="2" y2="18"/>'
        f'<text x="{nominal:.1f}" y="30" text-anchor="{anchor}">vehicle file</text>'
        f'<rect class="range" x="{x(estimate.low):.1f}" y="6" width="{max(x(estimate.high) - x(estimate.low), 2):.1f}" '
        'height="8" rx="3"/>'
        f'<circle class="value" cx="{x(estimate.value):.1f}" cy="10" r="5"/></svg>'
    )


def _open(height: int, label: str) -> str:
    width = LABEL_WIDTH + BAR_WIDTH + TEXT_WIDTH
    return f'<svg class="bars" viewBox="0 0 {width} {height}" role="img" aria-label="{escape(label)}">'


def _label(text: str, y: float) -> str:
    return f'<text class="name" x="{LABEL_WIDTH - 8}" y="{y}" text-anchor="end">{escape(text)}</text>'


def _whisker(low: float, high: float, y: float) -> str:
    path = f"M{low:.1f} {y}H{high:.1f}M{low:.1f} {y - 4}V{y + 4}M{high:.1f} {y - 4}V{y + 4}"
    return f'<path class="whisker" d="{path}"/>'
