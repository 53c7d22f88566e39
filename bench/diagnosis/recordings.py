"""A recording of the bench as a log that a measuring engineer would bring: what the bus carried, frame by frame.

The recording holds every decoded signal once a millisecond; a log holds a sample for each frame. The speed over ground
stands for an optical sensor on the side. Nothing else of the plant's truth is handed on.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bench.recording.arrays import FloatArray, RunArrays
from bench.recording.reading import Recording
from bench.report.run_data import find_run
from estimators.channels import CHANNELS
from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap
from signals.wheels import WHEELS

SPEED_PERIOD_S = 0.01
SPEED_RESOLUTION_M_S = 0.01
VALVE_PERIOD_S = 0.005
WAKING_S = 0.05
"""Left out at the start: tone rings have shown no edge yet and frames have not come."""
LARGEST_AGE_S = 10.0
"""Signals that never came have a greater age."""
REFERENCE = "speed"

VALVES = (
    *(f"valve_inlet_{wheel}" for wheel in WHEELS),
    *(f"valve_outlet_{wheel}" for wheel in WHEELS),
    "pump",
)
LOGGED = (
    *(f"wheel_speed_{wheel}" for wheel in WHEELS),
    "longitudinal_acceleration",
    "lateral_acceleration",
    "yaw_rate",
    "roll_rate",
    "pitch_rate",
    "steering_wheel_angle",
    "master_pressure",
    *(f"brake_pressure_{wheel}" for wheel in WHEELS),
    "drive_torque_f",
    "drive_torque_r",
    *VALVES,
)


def recording_of(log: str) -> Path | None:
    """Folder or file of a recording of the bench, found as `bench estimate` finds it; None for any other log."""
    path = Path(log)
    if path.is_dir():
        return path
    if path.exists():
        return path if path.suffix == ".mcap" or (path.parent / "scenario.yaml").is_file() else None
    try:
        return find_run(log)
    except InputError:
        return None


def as_log(recording: Path, folder: Path, teeth: int) -> tuple[Path, ChannelMap]:
    """Write the bus signals of a recording into an MF4 log of its own; its path, and the map that reads it.

    ``teeth`` are those of the car's tone rings, from whose edges all wheel speeds of the bus come.

    Raises
    ------
    InputError
        If the recording cannot be read or holds no signal of the bus.
    """
    from asammdf import MDF
    from asammdf import Signal as Mf4Signal

    opened = Recording.open(recording)
    name = opened.folder.name if recording.is_dir() or recording.stem == "signals" else recording.stem
    path = folder / f"{name}.mf4"
    left_out = VALVES if _valves_worked(opened) else ()
    present = [signal for signal in (*LOGGED, REFERENCE) if signal in opened and signal not in left_out]
    if not any(signal in present for signal in LOGGED):
        raise InputError(f"{opened.path}: the recording holds no signal of the bus", mend="recording.signals: ['*']")
    with MDF(version="4.10") as mdf:
        for signal in present:
            times, values = _samples(opened, signal)
            mdf.append(Mf4Signal(values, times, name=signal, unit=opened.units.get(signal, "1")))
        mdf.save(path, overwrite=True)
    channels = {
        signal: Channel(source=signal, teeth=teeth if signal.startswith("wheel_speed_") else None) for signal in present
    }
    return path, ChannelMap(file_format="mf4", channels=channels)


def _valves_worked(recording: RunArrays) -> bool:
    """True where the control unit switched a valve.

    It switches in steps of 5 ms; on the 10 ms of the diagnosis such commands would speak of sampling and not of valves.
    The measured wheel pressures drive the replay then.
    """
    return any(signal in recording and bool(np.any(recording.array(signal) > 0.5)) for signal in VALVES)


def car_of(recordings: Sequence[Path]) -> str:
    """Car of the first recording's scenario; empty where none is told."""
    from bench.estimation.source import open_source

    return next((car for path in recordings if (car := open_source(path).vehicle)), "")


def _samples(recording: RunArrays, signal: str) -> tuple[FloatArray, FloatArray]:
    """Times and values at which a new sample came in: frames of it, or a fixed period where no age of it is known."""
    age = CHANNELS[signal].age if signal in CHANNELS else ""
    awake = recording.time >= recording.time[0] + WAKING_S
    if age in recording:
        ages = recording.array(age)
        fresh = awake & (ages < LARGEST_AGE_S) & (np.diff(ages, prepend=-np.inf) < 0.0)
        return (recording.time - ages)[fresh], recording.array(signal)[fresh]
    period = SPEED_PERIOD_S if signal == REFERENCE else VALVE_PERIOD_S
    step = max(1, round(period / float(np.median(np.diff(recording.time)))))
    values = recording.array(signal)[awake][::step]
    if signal == REFERENCE:
        values = SPEED_RESOLUTION_M_S * np.round(values / SPEED_RESOLUTION_M_S)
    return recording.time[awake][::step], values
