"""The main signals of a run as one picture for documents and mails (PNG, SVG or PDF, by the file's ending)."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.report.brake_charts import BAR, VALVES, valve_state
from bench.report.criteria_table import tally
from bench.report.friction_charts import friction_top
from bench.report.motion_charts import FAST_M_S, KMH, STANDING_M_S, wheel_rim_speeds
from bench.report.plot_style import INK, SOFT, VALVE_COLOURS, VERDICT_COLOURS, WHEEL_COLOURS, plot_style
from bench.report.run_data import FloatArray, RunData
from bench.report.run_reading import load_run
from bench.report.thinning import segments, thin
from signals.errors import InputError
from signals.wheels import WHEELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg", ".pdf")
SIZE_INCH = (11.0, 9.2)
RESOLUTION_DPI = 110


def draw_picture(run_dir: str | Path, path: str | Path) -> Path:
    """Draw speeds, slip, pressures with valve states and friction of a run.

    Raises
    ------
    InputError
        If the run has no signals, or the file's ending is none of png, svg, pdf.
    """
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: unknown kind of picture", allowed=", ".join(ENDINGS))
    run = load_run(run_dir)
    if len(run.time) < 2 or not run.has("speed"):
        raise InputError(f"{run.folder}: nothing was recorded that could be drawn")
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(
            4, 1, sharex=True, figsize=SIZE_INCH, height_ratios=(3, 2, 3.2, 2.2), layout="constrained"
        )
        _title(figure, run)
        for axis, draw in zip(axes, (_speeds, _slip, _pressures, _friction), strict=True):
            draw(axis, run)
            _mark_steps(axis, run)
        axes[-1].set_xlabel("time in s")
        axes[-1].set_xlim(run.focus() or (float(run.time[0]), float(run.time[-1])))
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=RESOLUTION_DPI, metadata={"Date": None} if path.suffix == ".svg" else None)
        pyplot.close(figure)
    return path


def _title(figure: "Figure", run: RunData) -> None:
    figure.suptitle(run.title, x=0.012, ha="left", fontsize=14, fontweight="bold", color=INK)
    figure.text(
        0.988, 0.985, f"{run.outcome.upper()}   {tally(run.verdict)}", ha="right", va="top", fontsize=10,
        fontweight="bold", color=VERDICT_COLOURS.get(run.outcome, INK),
    )  # fmt: skip


def _curve(axis: "Axes", run: RunData, values: FloatArray, **options: Any) -> None:
    points = thin(run.time, values)
    axis.plot(points.times(), points.values, **options)


def _speeds(axis: "Axes", run: RunData) -> None:
    for wheel, speed in wheel_rim_speeds(run).items():
        _curve(axis, run, speed * KMH, color=WHEEL_COLOURS[wheel], label=wheel.upper())
    if run.has("ecu_reference_speed"):
        reference = run.array("ecu_reference_speed") * KMH
        _curve(axis, run, reference, color="#b45309", linestyle="--", linewidth=1.0, label="ECU's reference")
    _curve(axis, run, run.array("speed") * KMH, color=INK, linewidth=2.0, label="car")
    axis.set_ylabel("speed in km/h")
    axis.set_ylim(bottom=0.0)
    axis.legend(ncols=6, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _slip(axis: "Axes", run: RunData) -> None:
    speed, highest = run.array("speed"), 20.0
    for wheel in WHEELS:
        if run.has(f"slip_ratio_{wheel}"):
            slip = -100.0 * run.array(f"slip_ratio_{wheel}")
            highest = max(highest, 1.08 * float(np.max(slip[speed > FAST_M_S], initial=0.0)))
            _curve(axis, run, np.where(speed > STANDING_M_S, slip, np.nan), color=WHEEL_COLOURS[wheel])
    axis.set_ylabel("brake slip in %")
    axis.set_ylim(-1.0, highest)


def _pressures(axis: "Axes", run: RunData) -> None:
    if run.has("true_master_pressure"):
        _curve(axis, run, run.array("true_master_pressure") * BAR, color=SOFT, linewidth=1.0, label="master cylinder")
    for wheel in WHEELS:
        if run.has(f"true_brake_pressure_{wheel}"):
            _curve(axis, run, run.array(f"true_brake_pressure_{wheel}") * BAR, color=WHEEL_COLOURS[wheel])
    axis.set_ylabel("pressure in bar\nand valves")
    top = axis.get_ylim()[1]
    lane = 0.055 * top
    for place, wheel in enumerate(WHEELS):
        if not run.has(f"valve_inlet_{wheel}", f"valve_outlet_{wheel}"):
            return
        bottom = -(place + 1) * 1.25 * lane
        states = valve_state(run.array(f"valve_inlet_{wheel}"), run.array(f"valve_outlet_{wheel}"))
        for code, state in VALVES:
            bars = [(start, end - start) for start, end, value in segments(run.time, states) if value == code]
            label = state.label if place == 0 else None
            axis.broken_barh(bars, (bottom, lane), facecolors=VALVE_COLOURS[state.colour], linewidth=0.0, label=label)
        axis.annotate(
            wheel.upper(), (1.004, bottom + 0.5 * lane), xycoords=("axes fraction", "data"), va="center", fontsize=7,
            color=SOFT,
        )  # fmt: skip
    axis.set_ylim(-5.4 * lane, top)
    axis.set_yticks([tick for tick in axis.get_yticks() if 0.0 <= tick <= top])
    axis.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _friction(axis: "Axes", run: RunData) -> None:
    names = run.signals.names if run.signals is not None else ()
    shown = []
    for axle, (left, right), style in (("front", ("fl", "fr"), "--"), ("rear", ("rl", "rr"), ":")):
        name = next((n for n in names if n.endswith(f".friction_limit_{axle}")), None)
        if name is not None:
            _estimate(axis, run, name, axle, WHEEL_COLOURS[left])
        if run.has(f"friction_limit_{left}", f"friction_limit_{right}"):
            shown.append(0.5 * (run.array(f"friction_limit_{left}") + run.array(f"friction_limit_{right}")))
            _curve(axis, run, shown[-1], color=INK, linewidth=1.1, linestyle=style, label=f"road {axle}")
    axis.set_ylabel("friction limit,\nmean of the axle")
    axis.set_ylim(0.0, friction_top(shown))
    axis.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)


def _estimate(axis: "Axes", run: RunData, name: str, axle: str, colour: str) -> None:
    """Estimated friction limit of an axle with the area of one standard deviation."""
    active = f"{name.partition('.')[0]}.active"
    running = run.array(active) > 0.5 if run.has(active) else np.ones(len(run.time), np.bool_)
    estimate = np.where(running, run.array(name), np.nan)
    sure = run.array(f"{name}_confidence") > 0.5 if run.has(f"{name}_confidence") else running
    _curve(axis, run, estimate, color=colour, alpha=0.3)
    _curve(axis, run, np.where(sure, estimate, np.nan), color=colour, linewidth=1.8, label=f"estimate {axle}")
    if run.has(f"{name}_std"):
        rows = slice(None, None, max(1, len(run.time) // 1500))
        low, high = estimate - run.array(f"{name}_std"), estimate + run.array(f"{name}_std")
        axis.fill_between(run.time[rows], low[rows], high[rows], color=colour, alpha=0.16, linewidth=0.0)


def _mark_steps(axis: "Axes", run: RunData) -> None:
    for step in run.steps()[1:]:
        axis.axvline(step.start_s, color=SOFT, linewidth=0.8, linestyle=(0, (2, 3)), zorder=0)
