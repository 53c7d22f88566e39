"""``bench diagnose map``: a channel map for logs that nobody has mapped yet, with the reason of every line."""

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bench.diagnosis.progress import SearchProgress
from bench.verdict.output_files import replace_file
from model_diagnosis.data.mapping import SuggestedMap, Suggestion, suggest_channels
from model_diagnosis.data.uses import what_is_lost
from signals.errors import InputError
from signals.measured.channel_map import ChannelMap, channel_units
from signals.measured.measured_log import log_columns
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import load_vehicle

_WANTED = (
    *((f"wheel_speed_{wheel}",) for wheel in WHEELS),
    ("speed",),
    ("longitudinal_acceleration",),
    ("lateral_acceleration",),
    ("yaw_rate",),
    ("steering_wheel_angle", "road_wheel_angle"),
    (*(f"brake_pressure_{wheel}" for wheel in WHEELS), "master_pressure"),
    ("master_pressure",),
    ("drive_torque_f", "drive_torque_r", "engine_torque"),
)
"""Channels that a diagnosis of a car lives on; of a row one is enough."""
_SHOWN_UNUSED, _SHOWN_OTHERS = 40, 3


@dataclass(frozen=True)
class WrittenMap:
    """Suggestions and the file that they are in.

    Attributes
    ----------
    missing : signals that no column was found for, of each kind one, with what cannot be seen without it
    """

    suggested: SuggestedMap
    missing: dict[str, str]
    file: Path

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "file": str(self.file),
            "clock": self.suggested.clock.model_dump(),
            "dbc": self.suggested.dbc,
            "channels": [asdict(one) for one in self.suggested.channels],
            "unused": list(self.suggested.unused),
            "missing": self.missing,
        }


def suggest(
    logs: Sequence[str], vehicle: str, dbc: Path | None, out: Path | None, progress: SearchProgress
) -> WrittenMap:
    """Suggest one map for logs of several loggers, or several logs of one, and write it.

    Raises
    ------
    InputError
        If a log cannot be read, no column of any is a signal, or the file is there already.
    """
    file = out or Path(f"{Path(logs[0]).name.split('.', 1)[0]}_channels.yaml")
    if file.exists():
        raise InputError(f"{file}: is there already", mend="give another name: --out FILE")
    car = load_vehicle(vehicle)
    database = None if dbc is None else str(dbc)
    loggers = _loggers(logs, database)
    maps = []
    for number, of_one in enumerate(loggers):
        progress(", ".join(Path(log).name for log in of_one), number / len(loggers))
        maps.append(suggest_channels(of_one, car, database))
    suggested = _together(maps)
    if not suggested.channels:
        raise InputError(
            f"{', '.join(logs)}: no column is a signal that we know, by name or by the way it goes",
            found=", ".join(suggested.unused[:_SHOWN_UNUSED]),
            mend="write the map by hand: docs/diagnosis.md shows one",
        )
    written = WrittenMap(suggested, _missing(suggested), file)
    replace_file(file, map_text(written, logs).encode())
    return written


def _loggers(logs: Sequence[str], dbc: str | None) -> list[list[str]]:
    """Logs of the same columns together: what one of them does not move another one does."""
    loggers: dict[tuple[str, ...], list[str]] = {}
    for log in logs:
        loggers.setdefault(tuple(log_columns(Path(log), ChannelMap(dbc=dbc, channels={}))), []).append(log)
    return list(loggers.values())


def _together(maps: Sequence[SuggestedMap]) -> SuggestedMap:
    """One map: a column with the name goes before one without, an earlier log before a later one."""
    suggestions = sorted((s for one in maps for s in one.channels), key=lambda s: not s.by_name)
    channels: dict[str, Suggestion] = {}
    for suggestion in suggestions:
        channels.setdefault(suggestion.name, suggestion)
    used = {one.source for one in channels.values()}
    columns = dict.fromkeys([*(name for one in maps for name in one.unused), *(s.source for s in suggestions)])
    unused = [name for name in columns if name not in used]
    clock = next((one.clock for one in maps if one.clock.column), maps[0].clock)
    order = list(channel_units())
    ordered = sorted(channels.values(), key=lambda one: order.index(one.name))
    return SuggestedMap(clock, maps[0].dbc, tuple(ordered), tuple(unused))


def _missing(suggested: SuggestedMap) -> dict[str, str]:
    names = {one.name for one in suggested.channels}
    if any(name.startswith("slip_") for name in names):
        return {}
    return {kinds[0]: what_is_lost(kinds[0]) for kinds in _WANTED if not names & set(kinds)}


def map_text(written: WrittenMap, logs: Sequence[str]) -> str:
    """The file: a line for each channel with its reason beside it, then what was not found and not used."""
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    suggested = written.suggested
    channels = CommentedMap()
    for one in suggested.channels:
        line = CommentedMap(source=one.source, **({} if one.unit is None else {"unit": one.unit}))
        if one.sign < 0:
            line["sign"] = -1
        line.fa.set_flow_style()
        channels[one.name] = line
        channels.yaml_add_eol_comment(_remark(one), key=one.name, column=0)
    content = CommentedMap(format=1)
    if suggested.dbc is not None:
        content["dbc"] = os.path.relpath(Path(suggested.dbc).resolve(), written.file.parent.resolve())
    if suggested.clock.column:
        clock = CommentedMap(column=suggested.clock.column, unit=suggested.clock.unit)
        clock.fa.set_flow_style()
        content["clock"] = clock
    content["channels"] = channels
    stream = StringIO()
    yaml = YAML()
    yaml.width = 1000
    yaml.dump(content, stream)
    names = ", ".join(Path(log).name for log in logs)
    head = f"# Suggested by `bench diagnose map` for {names}. Look through it: units and signs above all.\n"
    tail = [f"# no column found: {name}. {lost}" for name, lost in written.missing.items()]
    if suggested.unused:
        more = f" and {len(suggested.unused) - _SHOWN_UNUSED} more" if len(suggested.unused) > _SHOWN_UNUSED else ""
        tail.append(f"# not used: {', '.join(suggested.unused[:_SHOWN_UNUSED])}{more}")
    return head + stream.getvalue() + "".join(f"{line}\n" for line in tail)


def _remark(one: Suggestion) -> str:
    """Reason of a line in words, with what is to be looked at."""
    parts = [one.reason, *([one.motion] if one.motion else [])]
    if _unit_is_open(one):
        parts.append(f"CHECK THE UNIT, {one.unit or channel_units()[one.name]} is taken")
    if one.others:
        parts.append(f"or {', '.join(one.others[:_SHOWN_OTHERS])}")
    return "; ".join(parts)


def _unit_is_open(one: Suggestion) -> bool:
    """True where neither the log nor the other channels tell the unit of what has one."""
    return (one.unit is None or one.is_likely) and not one.motion and channel_units()[one.name] != "1"


def print_map(written: WrittenMap, logs: Sequence[str], vehicle: str, console: Console) -> None:
    """Print suggestions for people."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim")
    for head in ("signal", "column", "unit", "sign", "why"):
        table.add_column(head)
    for one in written.suggested.channels:
        unit = f"{one.unit or channel_units()[one.name]}?" if _unit_is_open(one) else one.unit or ""
        cells = (one.name, one.source, unit, "−" if one.sign < 0 else "", _remark(one))
        table.add_row(*(escape(cell) for cell in cells))
    console.print(table)
    for name, lost in written.missing.items():
        console.print(f"[yellow]no column found: {name}. {lost}[/]")
    if written.suggested.unused:
        console.print(f"not used: {', '.join(written.suggested.unused[:_SHOWN_UNUSED])}", style="dim", markup=False)
    console.print(f"\nfile: {written.file}", markup=False)
    console.print(
        f"next: look through it, then bench diagnose {' '.join(logs)} --vehicle {vehicle} --channels {written.file}",
        markup=False,
    )
