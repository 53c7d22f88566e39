"""Log files as a user has them: CSV tables, MF4 files, or CAN logs (BLF) with their database, and the channel map."""

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hidden_effects.recording import CYCLE_S, MessageLog
from hidden_effects.sensors import CHANNELS, MESSAGES

FloatArray = NDArray[np.float64]

FORMATS = ("csv", "mf4", "blf")
_DEGREE = 57.29577951308232
_UNITS: dict[str, tuple[str, float]] = {
    "Pa": ("bar", 1e-5),
    "rad": ("deg", _DEGREE),
    "m/s": ("km/h", 3.6),
}
"""Unit that the logs use for a quantity, and the factor to it; other channels are logged in SI units."""

_RESOLUTION = {"bar": 0.01, "deg": 0.05, "km/h": 0.01, "rad/s": 0.0005, "m/s^2": 0.002, "N": 1.0, "N m": 0.5, "1": 1.0}
_FIRST_IDENTIFIER = 0x120


def _logged_unit(name: str) -> tuple[str, float]:
    unit = CHANNELS[name].unit
    return _UNITS.get(unit, (unit, 1.0))


def _column(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def _step(name: str) -> float:
    """Resolution of a CAN signal; yaw, roll and pitch rates are finer than wheel speeds."""
    unit = _logged_unit(name)[0]
    return 0.005 if name.startswith("wheel_speed") else _RESOLUTION[unit]


def write_logs(folder: Path, kind: str, manoeuvres: Mapping[str, Mapping[str, MessageLog]]) -> None:
    """One log per manoeuvre into a folder.

    Parameters
    ----------
    kind : ``csv``, ``mf4`` or ``blf``
    manoeuvres : name -> message -> frames in SI units
    """
    folder.mkdir(parents=True, exist_ok=True)
    writers = {"csv": _write_csv, "mf4": _write_mf4, "blf": _write_blf}
    for name, messages in manoeuvres.items():
        writers[kind](folder / f"{name}.{kind}", messages)


def _write_csv(path: Path, messages: Mapping[str, MessageLog]) -> None:
    """A table on one raster; a row whose frame was lost repeats the value before it."""
    longest = max(messages.values(), key=lambda log: len(log.time))
    rows = round(float(longest.time[-1]) / CYCLE_S) + 1
    time = longest.time
    if len(time) < rows:  # every message lost a frame: fill in the raster
        time = np.interp(np.arange(rows), np.round(time / CYCLE_S), time)
    names, columns = ["Time [s]"], [time]
    for log in messages.values():
        at = np.clip(np.round(log.time / CYCLE_S).astype(int), 0, rows - 1)
        row = np.full(rows, -1)
        row[at] = np.arange(len(at))
        row = np.maximum(np.maximum.accumulate(row), 0)[: len(time)]
        for name, values in log.channels.items():
            unit, factor = _logged_unit(name)
            names.append(f"{_column(name)} [{unit}]")
            columns.append(values[row] * factor)
    table = np.column_stack([column[: len(time)] for column in columns])
    lines = [";".join(names)]
    lines += [";".join(f"{value:.7g}" for value in row) for row in table]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_mf4(path: Path, messages: Mapping[str, MessageLog]) -> None:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as mdf:
        for log in messages.values():
            signals = []
            for name, values in log.channels.items():
                unit, factor = _logged_unit(name)
                signals.append(Signal(values * factor, log.time, unit=unit, name=_column(name)))
            if signals:
                mdf.append(signals, common_timebase=True)
        mdf.save(path, overwrite=True)


def _write_blf(path: Path, messages: Mapping[str, MessageLog]) -> None:
    import can

    frames: list[tuple[float, int, bytes]] = []
    for number, (_, log) in enumerate(messages.items()):
        if not log.channels:
            continue
        raw = np.stack([_raw(name, values) for name, values in log.channels.items()], axis=1)
        layout = struct.Struct("<" + "".join("B" if _is_switch(name) else "h" for name in log.channels))
        for stamp, values in zip(log.time, raw, strict=True):
            frames.append((float(stamp), _FIRST_IDENTIFIER + number, layout.pack(*values)))
    frames.sort(key=lambda frame: frame[0])
    with can.BLFWriter(str(path), compression_level=1) as writer:
        for stamp, identifier, data in frames:
            size = len(data) if len(data) <= 8 else next(s for s in (12, 16, 20, 24) if s >= len(data))
            writer.on_message_received(
                can.Message(
                    timestamp=1.7e9 + stamp,
                    arbitration_id=identifier,
                    data=data.ljust(size, b"\0"),
                    is_extended_id=False,
                    is_fd=size > 8,
                )
            )


def _is_switch(name: str) -> bool:
    return name.startswith("valve_") or name == "pump"


def _raw(name: str, values: FloatArray) -> NDArray[np.int64]:
    factor = _logged_unit(name)[1]
    if _is_switch(name):
        return np.round(values).astype(np.int64)
    return np.clip(np.round(values * factor / _step(name)), -32768, 32767).astype(np.int64)


def database(channels: Mapping[str, MessageLog]) -> str:
    """CAN database (DBC) of the messages in a log."""
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", "BU_: CAR LOGGER", ""]
    for number, (message, log) in enumerate(channels.items()):
        bits = [8 if _is_switch(name) else 16 for name in log.channels]
        size = sum(bits) // 8
        size = size if size <= 8 else next(s for s in (12, 16, 20, 24) if s >= size)
        if not bits:
            continue
        lines.append(f"BO_ {_FIRST_IDENTIFIER + number} {message}: {size} CAR")
        start = 0
        for name, width in zip(log.channels, bits, strict=True):
            unit = _logged_unit(name)[0]
            step, sign = (1.0, "+") if _is_switch(name) else (_step(name), "-")
            low, high = (0.0, 255.0) if _is_switch(name) else (-32768 * step, 32767 * step)
            lines.append(
                f' SG_ {_column(name)} : {start}|{width}@1{sign} ({step:g},0) [{low:g}|{high:g}] "{unit}" LOGGER'
            )
            start += width
        lines.append("")
    return "\n".join(lines) + "\n"


def channel_map(kind: str, messages: Mapping[str, MessageLog]) -> dict[str, Any]:
    """Content of the channel map that goes with the logs."""
    channels: dict[str, Any] = {}
    for message in MESSAGES:
        for name in messages[message].channels:
            unit = _logged_unit(name)[0]
            source = {"csv": f"{_column(name)} [{unit}]", "mf4": _column(name), "blf": f"{message}.{_column(name)}"}
            channels[name] = {"source": source[kind]} | ({} if unit == "1" else {"unit": unit})
    content: dict[str, Any] = {"format": 1, "channels": channels}
    if kind == "csv":
        content["clock"] = {"column": "Time [s]", "unit": "s"}
    if kind == "blf":
        content["dbc"] = "car.dbc"
    return content
