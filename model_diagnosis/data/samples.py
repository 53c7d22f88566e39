"""Channels as logged: own time stamps, catalogue units, and the logger and message that they came with."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap, channel_units
from signals.measured.measured_log import format_of, holds_frames, in_si, log_columns, read_sources
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LATE_S = 0.005
"""Time from tooth to tooth above which a wheel's speed counts no more: the usual period of its frames, within which a
sensor sees no tooth then."""


@dataclass(frozen=True)
class Samples:
    """One channel of one logger.

    Attributes
    ----------
    name, unit : catalogue name and unit
    time : (n,) on the logger's clock [s]
    values : (n,) in ``unit``; NaN where the log has no number
    valid : (n,) False where the sample is missing, held or otherwise not a measurement
    source : column or Message.Signal
    logger : file name
    message : CAN message, "" where the log has none
    restored : samples whose CAN frame an export had cut short and that reading completed
    teeth : of the tone ring that times a wheel's speed; None where the map tells none
    """

    name: str
    unit: str
    time: FloatArray
    values: FloatArray
    valid: BoolArray
    source: str
    logger: str
    message: str = ""
    restored: int = 0
    teeth: int | None = None

    @property
    def origin(self) -> str:
        """Logger, and message where there is one."""
        return f"{self.logger}:{self.message}" if self.message else self.logger

    def with_values(self, values: FloatArray) -> "Samples":
        """The same samples with other values."""
        return replace(self, values=values)

    def masked(self, wrong: BoolArray) -> "Samples":
        """The same with the samples of ``wrong`` (n,) marked as no measurement."""
        return replace(self, valid=self.valid & ~wrong)

    @property
    def slowest_on_time_rad_s(self) -> float:
        """Speed [rad/s] below which a tooth passes in more than ``LATE_S``; 0 without teeth."""
        return 0.0 if self.teeth is None else _slowest_on_time_rad_s(self.teeth)

    def period_s(self) -> float:
        """Usual distance of two samples that carry a number [s]; 0 with fewer than two."""
        steps = np.diff(self.time[np.isfinite(self.values)])
        steps = steps[steps > 0.0]
        return float(np.median(steps)) if len(steps) else 0.0


def read_samples(path: str | Path, channel_map: ChannelMap, vehicle: VehicleFile) -> dict[str, Samples]:
    """Every channel of the map that one log has, its faults left in.

    Returns
    -------
    catalogue name -> samples, in the map's order; empty where the log has none of them

    Raises
    ------
    InputError
        If the log cannot be read.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such log")
    if not channel_map.channels:
        raise InputError(f"{path}: the channel map names no channel")
    restored: dict[str, int] = {}
    raw = read_sources(path, channel_map, missing_ok=True, restored=restored)
    can_log = holds_frames(format_of(path, channel_map), channel_map)
    return {
        name: replace(
            _samples(path, name, channel, raw[channel.source], vehicle, can_log),
            restored=restored.get(channel.source, 0),
        )
        for name, channel in channel_map.channels.items()
        if channel.source in raw
    }


def _samples(
    path: Path,
    name: str,
    channel: Channel,
    raw: tuple[FloatArray, FloatArray],
    vehicle: VehicleFile,
    can_log: bool,
) -> Samples:
    time, values = raw
    wheel = name.removeprefix("wheel_speed_")
    radius = float(getattr(vehicle.wheels, wheel).radius) if wheel in WHEELS else None
    converted = in_si(path, name, channel, values, radius)
    return Samples(
        name=name,
        unit=channel_units()[name],
        time=time - channel.delay_s - (0.0 if channel.teeth is None else _tooth_age_s(converted, channel.teeth)),
        values=np.where(np.isfinite(converted), converted, np.nan),
        valid=np.isfinite(converted),
        source=channel.source,
        logger=path.name,
        teeth=channel.teeth,
        message=channel.source.split(".", 1)[0] if can_log and "." in channel.source else "",
    )


def _tooth_age_s(wheel_speed: FloatArray, teeth: int) -> FloatArray:
    """Mean age (n,) of the last tooth, half a tooth at this speed [rad/s]; at most half of ``LATE_S``.

    A speed that is timed between teeth is late by this and by something constant. The former changes with the speed, as
    no constant lag does: a wheel that comes back from deep slip seems to stay there, as on a tyre that loses more by
    sliding.
    """
    age: FloatArray = np.pi / (teeth * np.fmax(np.abs(wheel_speed), _slowest_on_time_rad_s(teeth)))
    return age


def _slowest_on_time_rad_s(teeth: int) -> float:
    return 2.0 * np.pi / (teeth * LATE_S)


def missing_channels(
    paths: Sequence[str | Path], channel_map: ChannelMap, found: Sequence[str]
) -> list[tuple[str, str, list[str]]]:
    """(catalogue name, source, names that the logs have) for everything of the map that no log holds."""
    missing = [(name, channel.source) for name, channel in channel_map.channels.items() if name not in found]
    if not missing:
        return []
    names = list(dict.fromkeys(n for path in paths for n in log_columns(Path(path), channel_map)))
    return [(name, source, names) for name, source in missing]
