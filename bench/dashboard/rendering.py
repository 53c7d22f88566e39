"""The dashboard as text: a panel that adapts to the width of the terminal."""

import math
from collections.abc import Iterable, Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from bench.dashboard.snapshot import FrictionEstimate, RunView, Snapshot

WIDEST = 100
WIDE = 76
SILENT_AFTER_S = 0.05
LABEL_WIDTH = 10

_EIGHTHS = " ▏▎▍▌▋▊▉█"
_LEVELS = "▁▂▃▄▅▆▇█"
_STATE_STYLES = {"build-up": "blue", "hold": "yellow", "release": "bold red", "rebuild": "cyan", "–": "dim"}
_WHEELS_LONG = ("front left", "front right", "rear left", "rear right")
_WHEELS_SHORT = ("FL", "FR", "RL", "RR")
_MODES = {"realtime": "real time", "lockstep": "lock-step"}


def horizontal_bar(share: float, width: int) -> str:
    """Bar of ``width`` cells filled to ``share`` (0 to 1) in steps of an eighth of a cell."""
    eighths = round(max(0.0, min(1.0, share)) * width * 8)
    full, rest = divmod(eighths, 8)
    text = "█" * full + (_EIGHTHS[rest] if rest else "")
    return text.ljust(width)


def sparkline(values: Sequence[float], width: int, highest: float) -> str:
    """The last ``width`` values as blocks of eight heights."""
    recent = values[-width:]
    top = max(highest, 1e-9)
    return "".join(_LEVELS[min(7, max(0, int(7.99 * value / top)))] for value in recent)


def signed(value: float | None, decimals: int, unit: str) -> str:
    """Number with a true minus sign and its unit; a dash where there is none."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return ("−" + text[1:] if text.startswith("-") and float(text) != 0.0 else text.lstrip("-")) + unit


def describe_run(view: RunView) -> str:
    """How the run is made: ECU, link, pace."""
    information = view.information
    ecu = information.get("ecu")
    parts = [f"{ecu} ECU" if ecu else "", information.get("link"), _MODES.get(str(information.get("mode")), "")]
    return " · ".join(str(part) for part in parts if part)


def render(view: RunView, width: int, note: str = "") -> RenderableType:
    """The dashboard's panel.

    Parameters
    ----------
    width : int
        Cells of the terminal.
    note : str
        Shown at the lower right, for a replay.
    """
    width = min(width, WIDEST)
    inner = width - 4
    snapshot = view.snapshot
    lines: list[RenderableType] = [_headline(view, inner), _motion(snapshot, inner), Text("")]
    if snapshot.slip_percent:
        lines += [_wheel_table(snapshot, inner), Text("")]
    lines.append(_status_table(view, inner))
    title = Text(str(view.information.get("scenario") or "run"), style="bold")
    how = describe_run(view)
    if how and len(how) + len(title) + 6 < width:
        title.append(f" · {how}", style="dim")
    return Panel(
        Group(*lines), title=title, title_align="left", subtitle=Text(note, style="dim") if note else None,
        subtitle_align="right", box=box.ROUNDED, width=width, border_style="red" if _alarming(snapshot) else "dim",
    )  # fmt: skip


def _alarming(snapshot: Snapshot) -> bool:
    silent = snapshot.ecu_silent_s is not None and snapshot.ecu_silent_s > SILENT_AFTER_S
    return bool(snapshot.switches.get("lamp")) or (silent and snapshot.time_s > 1.0)


def _headline(view: RunView, inner: int) -> Text:
    snapshot = view.snapshot
    roomy = inner >= 44
    phase = f"{snapshot.phase or '–':<{LABEL_WIDTH if roomy else 1}} "
    text = Text(phase, style="bold cyan", no_wrap=True, overflow="ellipsis")
    text.append(f"t {snapshot.time_s:7.3f} s   " if roomy else f"{snapshot.time_s:.3f} s ", style="default")
    text.append(f"{signed(snapshot.speed_kmh, 1, ' km/h'):>11}  ", style="bold default")
    room = inner - len(text)
    if room >= 10:
        text.append(sparkline(snapshot.speed_history, room, view.highest_speed_kmh), style="green")
    return text


def _motion(snapshot: Snapshot, inner: int) -> Text:
    parts = [
        ("deceleration" if inner > WIDE else "decel", signed(snapshot.deceleration_m_s2, 1, " m/s²")),
        ("distance" if inner > WIDE else "dist", signed(snapshot.distance_m, 1, " m")),
        ("yaw", signed(snapshot.yaw_rate_deg_s, 1, " °/s")),
        ("steer", signed(snapshot.steering_deg, 0, "°")),
    ]
    return Text("   ").join(Text.assemble((f"{label} ", "dim"), value) for label, value in parts)


def _wheel_table(snapshot: Snapshot, inner: int) -> Table:
    wide = inner >= WIDE - 4
    table = Table.grid(padding=(0, 1), expand=True)
    table.add_column(width=LABEL_WIDTH if wide else 6, no_wrap=True, style="dim")
    for _ in range(4):
        table.add_column(ratio=1, no_wrap=True)
    table.add_row("", *(Text(name, style="bold") for name in (_WHEELS_LONG if wide else _WHEELS_SHORT)))
    unit = " km/h" if wide else ""
    table.add_row("wheel", *(f"{max(0.0, speed):.1f}{unit}" for speed in snapshot.wheel_speed_kmh))
    table.add_row("slip", *(_slip_cell(slip, 6 if wide else 0) for slip in snapshot.slip_percent))
    if snapshot.pressure_bar:
        changes = snapshot.pressure_change_bar
        cells = [_pressure_cell(p, c, wide) for p, c in zip(snapshot.pressure_bar, changes, strict=True)]
        table.add_row("pressure" if wide else "bar", *cells)
    for label, states in (("valve", snapshot.valve), ("ECU phase" if wide else "ECU", snapshot.ecu_phase)):
        if states:
            table.add_row(label, *(Text(state, style=_STATE_STYLES.get(state, "")) for state in states))
    return table


def _slip_cell(slip: float, bar_width: int) -> Text:
    if math.isnan(slip):
        return Text("–".rjust(bar_width + 6 if bar_width else 5), style="dim")
    style = "bold red" if slip > 50 else "red" if slip > 30 else "yellow" if slip > 18 else "green"
    cell = Text(style=style)
    if bar_width:
        cell.append(horizontal_bar(slip / 40.0, bar_width) + " ")
    cell.append(f"{signed(slip, 0, ' %'):>5}")
    return cell


def _pressure_cell(pressure: float, change: float, wide: bool) -> Text:
    arrow, style = ("↑", "blue") if change > 0.3 else ("↓", "red") if change < -0.3 else ("=", "dim")
    return Text.assemble(f"{pressure:5.1f}{' bar' if wide else ''} ", (arrow, style))


def _status_table(view: RunView, inner: int) -> Table:
    """Friction, ECU, bus and loop; what does not fit a narrow terminal goes to the next line."""
    snapshot = view.snapshot
    table = Table.grid(padding=(0, 1), expand=True)
    table.add_column(width=LABEL_WIDTH if inner >= WIDE - 4 else 8, no_wrap=True, style="dim")
    table.add_column(ratio=1)
    if snapshot.friction or snapshot.friction_road:
        table.add_row("friction", _listed(_friction_parts(snapshot)))
    table.add_row("ECU", _listed(_ecu_parts(snapshot)))
    table.add_row("bus", _listed(_bus_parts(snapshot)))
    virtual = view.information.get("mode") == "lockstep"
    table.add_row("loop", Text("virtual time, no deadlines") if virtual else _listed(_loop_parts(snapshot)))
    return table


def _listed(parts: Iterable[Text]) -> Text:
    line = Text()
    for part in parts:
        if line:
            line.append(" · ", style="dim")
        line.append_text(part)
    return line


def _friction_parts(snapshot: Snapshot) -> Iterable[Text]:
    for estimate in snapshot.friction:
        yield _friction_text(estimate)
    if snapshot.friction_road:
        left, right = snapshot.friction_road[0], snapshot.friction_road[1]
        road = f"{left:.2f}" if abs(left - right) < 0.005 else f"{left:.2f} | {right:.2f}"
        yield Text(f"road {road}")


def _friction_text(estimate: FrictionEstimate) -> Text:
    text = Text(f"{estimate.axle} {estimate.value:.2f}")
    if estimate.deviation is not None:
        text.append(f" ±{estimate.deviation:.2f}")
    if estimate.confident is not None:
        text.append(" sure" if estimate.confident else " unsure", style="green" if estimate.confident else "yellow")
    return text


def _ecu_parts(snapshot: Snapshot) -> Iterable[Text]:
    for label, on in snapshot.switches.items():
        style = ("bold red" if label == "lamp" else "bold green") if on else ""
        yield Text(f"{label} {'on' if on else 'off'}", style=style)
    if snapshot.ecu_fault_code:
        yield Text(f"fault {snapshot.ecu_fault_code}", style="bold red")
    silent = snapshot.ecu_silent_s
    if silent is not None and silent > SILENT_AFTER_S:
        yield Text(f"silent for {silent:.2f} s" if silent < 1e3 else "not heard yet", style="bold red")


def _bus_parts(snapshot: Snapshot) -> Iterable[Text]:
    if snapshot.bus_load_percent is not None:
        yield Text(f"load {snapshot.bus_load_percent:.0f} %")
    yield Text(f"{snapshot.frames:,} frames".replace(",", " "))
    faults = snapshot.faults_active
    yield Text(f"faults {faults or 'none'}", style="bold red" if faults else "")


def _loop_parts(snapshot: Snapshot) -> Iterable[Text]:
    if snapshot.lateness_max_us > 0.0:
        yield Text(f"late p99 {_micro(snapshot.lateness_p99_us)}, max {_micro(snapshot.lateness_max_us)}")
    style = "bold yellow" if snapshot.overruns else ""
    yield Text(f"overruns {snapshot.overruns} of {snapshot.ticks:,}".replace(",", " "), style=style)
    if snapshot.tick_cpu_us > 0.0:
        yield Text(f"tick {_micro(snapshot.tick_cpu_us)}")


def _micro(value_us: float) -> str:
    if value_us >= 1000.0:
        return f"{value_us / 1000.0:.1f} ms"
    return f"{value_us:.1f} µs" if value_us < 10.0 else f"{value_us:.0f} µs"


def plain_line(view: RunView) -> str:
    """One line of progress for a run without a terminal."""
    snapshot = view.snapshot
    parts = [f"t {snapshot.time_s:6.1f} s", f"{snapshot.phase or '–':<10}"]
    parts.append(f"{signed(snapshot.speed_kmh, 1, ' km/h'):>11}")
    if snapshot.deceleration_m_s2 is not None:
        parts.append(f"{signed(snapshot.deceleration_m_s2, 1, ' m/s²'):>10}")
    if snapshot.slip_percent:
        parts.append("slip " + " ".join(f"{signed(slip, 0, ''):>3}" for slip in snapshot.slip_percent) + " %")
    if snapshot.pressure_bar:
        parts.append("pressure " + " ".join(f"{pressure:3.0f}" for pressure in snapshot.pressure_bar) + " bar")
    if snapshot.friction:
        known = (f"{e.value:.2f}" if e.confident is not False else "   –" for e in snapshot.friction)
        parts.append("friction " + " ".join(known))
    if snapshot.bus_load_percent is not None:
        parts.append(f"bus {snapshot.bus_load_percent:.0f} %")
    if snapshot.lateness_max_us > 0.0:
        parts.append(f"late p99 {_micro(snapshot.lateness_p99_us)}")
    parts.append(f"overruns {snapshot.overruns}")
    parts += [name for name, on in snapshot.switches.items() if on]
    if snapshot.faults_active:
        parts.append(f"faults {snapshot.faults_active}")
    return "  ".join(parts)
