"""Logs through a channel map into manoeuvres on the common time base."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from model_diagnosis.data.drive_clocks import offsets_by_lags
from model_diagnosis.data.drives import Drive, begin_s, duration_s, split_at_pauses, with_clocks_set_back
from model_diagnosis.data.geometry import geometry_of, wheel_radii
from model_diagnosis.data.grid import on_grid, own_samples
from model_diagnosis.data.loggers import join_loggers
from model_diagnosis.data.lost_frames import mask_lost_frames
from model_diagnosis.data.sample_timing import check_cut_frames, check_timing
from model_diagnosis.data.sample_values import VALUE_CHECKS, check_resting_pressures, is_motion
from model_diagnosis.data.samples import Samples, missing_channels, read_samples
from model_diagnosis.data.segmentation import LOWEST_SPEED_M_S, SHORTEST_S, cut
from model_diagnosis.data.undefined_values import check_markers
from model_diagnosis.data.uses import what_is_lost
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from signals.errors import InputError, nearest_name
from signals.measured.channel_map import ChannelMap
from vehicle_model.vehicle_file import VehicleFile

_FORCES = ("longitudinal_force_", "lateral_force_")


def read_manoeuvres(paths: Sequence[str | Path], channel_map: ChannelMap, vehicle: VehicleFile) -> list[Manoeuvre]:
    """Read logs, mask and name what is wrong with their samples, cut them into manoeuvres.

    Logs of different channels that ran at the same time are taken as loggers of one drive. What was found is in each
    manoeuvre's ``reading_faults`` (the same for all manoeuvres of one drive).

    Raises
    ------
    InputError
        If a log cannot be read, has no channel that a car's motion shows in, or no two seconds above 4 m/s.
    """
    if not paths:
        raise InputError("no log given", mend="name at least one: bench diagnose LOG… --vehicle FILE")
    logs = [read_samples(path, channel_map, vehicle) for path in paths]
    found = {name for log in logs for name in log}
    missing = _missing(paths, channel_map, sorted(found))
    _require_motion(paths, found, missing)
    drives = []
    for drive in join_loggers(logs, wheel_radii(vehicle)):
        checked, faults = check_samples(drive.channels)
        drives.append(replace(drive, channels=checked, faults=(*drive.faults, *faults, *missing)))
    manoeuvres = _of_drives(drives, vehicle)
    offsets_s = offsets_by_lags(manoeuvres, geometry_of(vehicle))
    if offsets_s:
        # on the time base a drive is cut to what its loggers share, which is more once their clocks agree
        manoeuvres = _of_drives(
            [with_clocks_set_back(drive, offsets_s.get(drive.files, {})) for drive in drives], vehicle
        )
    if not manoeuvres:
        raise InputError(
            f"{', '.join(str(p) for p in paths)}: too short for a diagnosis",
            found=f"no {SHORTEST_S:.0f} s in one piece above {LOWEST_SPEED_M_S:.0f} m/s",
            mend="record at least one manoeuvre of some seconds, or check unit and source of the speeds in the map",
        )
    return _named_apart(manoeuvres)


def check_samples(channels: Mapping[str, Samples]) -> tuple[dict[str, Samples], list[DataFault]]:
    """Every check of one drive's samples: stamps first, then each channel's values."""
    checked, faults = check_timing(dict(channels))
    faults += check_cut_frames(channels)
    faults += check_resting_pressures(checked)
    for name in checked:
        for check in (check_markers, *VALUE_CHECKS):
            checked[name], found = check(checked[name])
            faults += found
    return mask_lost_frames(checked), faults


def _missing(paths: Sequence[str | Path], channel_map: ChannelMap, found: Sequence[str]) -> list[DataFault]:
    faults = []
    for name, source, offered in missing_channels(paths, channel_map, found):
        nearest = nearest_name(source, offered)
        hint = f"; nearest in the log: {nearest!r}" if nearest else ""
        message = f"{name}: no log has a channel {source!r}{hint}. {what_is_lost(name)}"
        faults.append(DataFault(kind="missing_channel", channel=name, message=message))
    return faults


def _require_motion(paths: Sequence[str | Path], found: set[str], missing: Sequence[DataFault]) -> None:
    if not any(is_motion(name) or name.startswith(_FORCES) for name in found):
        raise InputError(
            f"{', '.join(str(p) for p in paths)}: no channel that the car's motion shows in",
            found=", ".join(sorted(found)) or "no channel of the map",
            allowed="at least one of wheel_speed_*, speed, longitudinal_acceleration, lateral_acceleration, yaw_rate",
            mend="\n".join(fault.message for fault in missing[:3]),
        )


def _of_drives(drives: Sequence[Drive], vehicle: VehicleFile) -> list[Manoeuvre]:
    return [
        manoeuvre
        for drive in drives
        for part in split_at_pauses(drive)
        if duration_s(part) >= SHORTEST_S
        for manoeuvre in _manoeuvres(part, vehicle, begin_s(drive))
    ]


def _manoeuvres(drive: Drive, vehicle: VehicleFile, origin_s: float) -> list[Manoeuvre]:
    """Manoeuvres of a part of a drive that began at ``origin_s`` on the logs' clock."""
    try:
        time, values, weights = on_grid(drive.channels)
    except InputError as error:
        raise InputError(f"{drive.files}: {error}") from None
    radii = wheel_radii(vehicle)
    origins = {name: drive.channels[name].origin for name in values}
    stretches = cut(values, weights, radii)
    own = own_samples(drive.channels, time)
    made = []
    for begin, end in stretches:
        known = {name: one.phase(begin, end) for name, one in own.items()}
        phases = {name: phase for name, phase in known.items() if phase is not None}
        taken = {name: own[name].values for name in phases}
        measured = {name: own[name].weights for name in phases}
        on_time = {
            name: np.where(np.abs((values | taken)[name]) < drive.channels[name].slowest_on_time_rad_s, 0.0, series)
            for name, series in (weights | measured).items()
        }
        made.append(
            Manoeuvre(
                name=drive.name if len(stretches) == 1 else f"{drive.name} {time[begin] - time[0]:.1f} s",
                time=SAMPLE_TIME_S * np.arange(end - begin, dtype=np.float64),
                channels={name: series[begin:end] for name, series in (values | taken).items()},
                weights={name: series[begin:end] for name, series in on_time.items()},
                source=f"{drive.files}, {time[begin]:.2f} s to {time[end - 1]:.2f} s",
                origins=origins,
                start_s=float(time[begin]) - origin_s,
                reading_faults=drive.faults,
                drive=drive.files,
                phases=phases,
                set_back_s=drive.set_back_s,
            )
        )
    return made


def _named_apart(manoeuvres: Sequence[Manoeuvre]) -> list[Manoeuvre]:
    """Equal names get a number, in order."""
    counts: dict[str, int] = {}
    named = []
    for manoeuvre in manoeuvres:
        counts[manoeuvre.name] = counts.get(manoeuvre.name, 0) + 1
        repeated = counts[manoeuvre.name]
        named.append(replace(manoeuvre, name=f"{manoeuvre.name} ({repeated})") if repeated > 1 else manoeuvre)
    return named
