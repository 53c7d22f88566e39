"""Where the residuals live: their mean over speed, slip, load, pressure, temperature, before and after, in pictures."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from bench.diagnosis_report.words import shown, signal_words
from bench.report.formatting import number
from model_diagnosis.findings import Findings, FloatArray, ManoeuvreFindings
from signals.measured.channel_map import channel_units
from signals.wheels import WHEELS

BINS = 12
FEWEST_IN_A_BIN = 15
MOST_SIGNALS = 6
NOISE_STDS_OF_A_MEAN = 2.0
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 250, 132, 44, 22, 10, 10


@dataclass(frozen=True)
class Binned:
    """Mean residual over one state.

    Attributes
    ----------
    centres, before, after, band : (k,) arrays
        Middle of each bin, mean residual with the vehicle file and with what was found, and the part of a mean that the
        sensor's noise explains (two standard deviations).
    """

    centres: FloatArray
    before: FloatArray
    after: FloatArray
    band: FloatArray


STATES = (
    ("speed", "speed", "km/h", 3.6),
    ("brake_slip", "brake slip", "%", 100.0),
    ("slip_angle", "slip angle", "°", 180.0 / math.pi),
    ("load", "vertical load", "kN", 1e-3),
    ("pressure", "brake pressure", "bar", 1e-5),
    ("temperature", "disc temperature", "°C", 1.0),
)
STEMS = {
    "brake_slip": ("slip_ratio_", -1.0),
    "slip_angle": ("slip_angle_", 1.0),
    "load": ("vertical_load_", 1.0),
    "pressure": ("brake_pressure_", 1.0),
    "temperature": ("brake_disc_temperature_", 1.0),
}
LEAST_SPAN = {
    "speed": 1.0,
    "brake_slip": 0.005,
    "slip_angle": 0.003,
    "load": 500.0,
    "pressure": 1e5,
    "temperature": 5.0,
}
"""Span of a state [m/s, 1, rad, N, Pa, K] over which a mean says anything: half a degree of a disc does not."""
FORCES = ("longitudinal_force_", "lateral_force_")
LATERAL = (
    "lateral_force_",
    "lateral_acceleration",
    "yaw_rate",
    "lateral_speed",
    "side_slip_angle",
    "roll_rate",
    "roll_angle",
)


def residual_maps(findings: Findings, signals: Sequence[str]) -> list[tuple[str, str, list[Markup]]]:
    """Signal in words, its unit and its pictures, one per state that the data has; the worst signals first.

    Parameters
    ----------
    findings : Findings
    signals : sequence of str
        Ranked (`bench.diagnosis_report.signal_charts.ranked_signals`).
    """
    rows = []
    extended = any(np.any(part.after != part.before) for part in findings.manoeuvres)
    for signal in signals[:MOST_SIGNALS]:
        factor, unit = shown(signal, channel_units().get(signal, "1"))
        pictures = []
        for state, title, state_unit, state_factor in STATES:
            binned = binned_residual(findings, signal, state)
            if binned is not None:
                axis = f"{title}, {state_unit}"
                pictures.append(
                    _picture(binned, factor, state_factor, axis, f"{signal_words(signal)} over {axis}", extended)
                )
        if pictures:
            rows.append((signal_words(signal), unit, pictures))
    return rows


def binned_residual(findings: Findings, signal: str, state: str) -> Binned | None:
    """Mean residual of a signal over a state, all manoeuvres together; None where it hardly changes or is not there.

    Parameters
    ----------
    findings : Findings
    signal : str
        A compared signal; for that of one wheel, slip, pressure and temperature are that wheel's. The slip angle is
        looked at for lateral signals, the brake slip for the others, the load for a wheel's forces.
    state : {"speed", "brake_slip", "slip_angle", "load", "pressure", "temperature"}
    """
    over, before, after = [], [], []
    for part in findings.manoeuvres:
        if signal not in part.signals:
            continue
        column = part.signals.index(signal)
        values = state_of(part, signal, state)
        if values is None:
            continue
        valid = (part.weights[:, column] > 0) & np.isfinite(values)
        over.append(values[valid])
        before.append((part.measured - part.before)[valid, column])
        after.append((part.measured - part.after)[valid, column])
    all_values = np.concatenate(over) if over else np.zeros(0)
    if not len(all_values):
        return None
    low, high = (float(value) for value in np.quantile(all_values, [0.005, 0.995]))
    if high - low < LEAST_SPAN[state]:
        return None
    edges = np.linspace(low, high, BINS + 1)
    place = np.clip(np.searchsorted(edges, all_values, side="right") - 1, 0, BINS - 1)
    counts = np.bincount(place, minlength=BINS)
    kept = counts >= FEWEST_IN_A_BIN
    if np.count_nonzero(kept) < 2:
        return None
    means = [np.bincount(place, np.concatenate(r), BINS)[kept] / counts[kept] for r in (before, after)]
    noise = findings.sensor_std.get(signal, 0.0) / np.sqrt(counts[kept])
    return Binned(0.5 * (edges[1:] + edges[:-1])[kept], means[0], means[1], NOISE_STDS_OF_A_MEAN * noise)


def state_of(part: ManoeuvreFindings, signal: str, state: str) -> FloatArray | None:
    """Values (n,) of a state for a signal: of its own wheel where it has one, else the mean over the wheels."""
    known = {**part.manoeuvre.channels, **part.states}
    if state == "speed":
        return known.get("speed")
    if (state == "slip_angle") != signal.startswith(LATERAL) and state in ("slip_angle", "brake_slip"):
        return None
    if state == "load" and not signal.startswith(FORCES):
        return None
    stem, sign = STEMS[state]
    own = signal.rpartition("_")[2]
    wheels = [own] if own in WHEELS else list(WHEELS)
    found = [known[stem + wheel] for wheel in wheels if stem + wheel in known]
    if not found:
        return known.get("master_pressure") if state == "pressure" else None
    return np.asarray(sign * np.mean(found, axis=0), dtype=np.float64)


def _picture(binned: Binned, factor: float, state_factor: float, axis: str, label: str, extended: bool) -> Markup:
    x_values = state_factor * binned.centres
    before, after, band = factor * binned.before, factor * binned.after, factor * binned.band
    shown_values = np.concatenate([before, after, band, -band])
    bottom, top = float(shown_values.min()), float(shown_values.max())
    margin = 0.08 * (top - bottom) or 1.0
    low, high = float(x_values[0]), float(x_values[-1])

    def x(value: float) -> float:
        return LEFT + (value - low) / (high - low) * (WIDTH - LEFT - RIGHT)

    def y(value: float) -> float:
        return TOP + (top + margin - value) / (top - bottom + 2.0 * margin) * (HEIGHT - TOP - BOTTOM)

    def points(values: FloatArray) -> str:
        return " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in zip(x_values, values, strict=True))

    outline = points(band) + " " + " ".join(reversed(points(-band).split()))
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="mean residual of {escape(label)}">',
        f'<polygon class="noise" points="{outline}"/>',
        f'<line class="axis" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(0):.1f}" y2="{y(0):.1f}"/>',
    ]
    for value in (bottom, 0.0, top):
        if value == 0.0 or abs(y(value) - y(0.0)) > 12:
            parts.append(f'<text x="{LEFT - 5}" y="{y(value) + 4:.1f}" text-anchor="end">{number(value, 2)}</text>')
    for value, anchor in ((low, "start"), (high, "end")):
        parts.append(f'<text x="{x(value):.1f}" y="{HEIGHT - 6}" text-anchor="{anchor}">{number(value, 3)}</text>')
    middle = (LEFT + WIDTH - RIGHT) / 2
    parts.append(f'<text x="{middle}" y="{HEIGHT - 6}" text-anchor="middle">{escape(axis)}</text>')
    parts.append(f'<polyline class="curve c-fr" points="{points(before)}"/>')
    parts += [
        f'<circle class="f-fr" cx="{x(a):.1f}" cy="{y(b):.1f}" r="2.2"/>' for a, b in zip(x_values, before, strict=True)
    ]
    if extended:
        parts.append(f'<polyline class="curve c-fl" points="{points(after)}"/>')
        parts += [
            f'<circle class="f-fl" cx="{x(a):.1f}" cy="{y(b):.1f}" r="2.2"/>'
            for a, b in zip(x_values, after, strict=True)
        ]
    return Markup("".join([*parts, "</svg>"]))
