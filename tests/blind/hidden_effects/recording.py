"""From a simulated manoeuvre to what loggers write: CAN sampling with jitter, lost frames, a second logger's clock."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hidden_effects.car import Numbers
from hidden_effects.data_faults import BY_NAME, Fault, noiseless
from hidden_effects.sensors import (
    CHANNELS,
    MESSAGES,
    RATE_HZ,
    SECOND_LOGGER,
    delayed,
    noise,
    quantised,
    through_chain,
    true_channels,
)
from hidden_effects.simulator import Drive

FloatArray = NDArray[np.float64]

CYCLE_S = 0.01
JITTER_S = 3e-4
LOST_SHARE = 1e-3
LARGEST_CLOCK_OFFSET_S = 0.3


@dataclass(frozen=True)
class Loggers:
    """How a case is recorded.

    Attributes
    ----------
    clock_offset_s : how late the second logger's channels are
    phases_s : message -> its sampling instants' place within a cycle
    missing : channels that nobody recorded
    """

    clock_offset_s: float
    phases_s: dict[str, float]
    missing: tuple[str, ...] = ()
    fault: Fault | None = None


@dataclass(frozen=True)
class MessageLog:
    """Frames of one message: time stamps (n,) [s] and channels, name -> (n,) in SI units."""

    time: FloatArray
    channels: dict[str, FloatArray] = field(default_factory=dict)


def draw_loggers(random: np.random.Generator, *, one_raster: bool) -> Loggers:
    """Loggers of a case; ``one_raster`` samples all messages at the same instants, as a table does."""
    phases = {message: 0.0 if one_raster else float(random.uniform(0.0, CYCLE_S)) for message in MESSAGES}
    phases["VALVES"] = 0.0
    return Loggers(float(random.uniform(0.0, LARGEST_CLOCK_OFFSET_S)), phases)


def record(
    columns: FloatArray, drive: Drive, chain: Numbers, loggers: Loggers, random: np.random.Generator
) -> dict[str, MessageLog]:
    """What the loggers wrote: message -> frames, in SI units."""
    series = true_channels(columns, drive.pedal, drive.steering_wheel, drive.drive_torque)
    series = through_chain(series, chain)
    kind = BY_NAME[loggers.fault.kind] if loggers.fault is not None else None
    if kind is not None and kind.before_sampling is not None and loggers.fault is not None:
        series = kind.before_sampling(series, loggers.fault)
    series["speed"] = delayed(series["speed"], loggers.clock_offset_s)
    samples = int((len(columns) - 1) / RATE_HZ / CYCLE_S)
    truth_time = np.arange(len(columns)) / RATE_HZ
    sampled: dict[str, FloatArray] = {}
    for name, channel in CHANNELS.items():
        instants = np.arange(samples) * CYCLE_S + loggers.phases_s[channel.message]
        stepped = channel.message == "VALVES"
        value = series[name][np.minimum((instants * RATE_HZ + 1e-6).astype(int), len(columns) - 1)]
        if not stepped:
            value = np.interp(instants, truth_time, series[name])
        if name not in noiseless(loggers.fault):
            value = value + noise(channel, samples, random)
        sampled[name] = quantised(value, channel.resolution)
    if kind is not None and kind.after_sampling is not None and loggers.fault is not None:
        sampled = kind.after_sampling(sampled, loggers.fault, random)
    return {message: _message_log(message, samples, sampled, loggers, random) for message in MESSAGES}


def _message_log(
    message: str, samples: int, sampled: dict[str, FloatArray], loggers: Loggers, random: np.random.Generator
) -> MessageLog:
    stamps = np.arange(samples) * CYCLE_S + loggers.phases_s[message]
    stamps = np.sort(stamps + np.clip(JITTER_S * random.standard_normal(samples), -1e-3, 1e-3))
    stamps = stamps - min(stamps[0], 0.0)
    kept = random.random(samples) >= LOST_SHARE
    kept[0] = kept[-1] = True
    channels = {
        name: sampled[name][kept]
        for name, channel in CHANNELS.items()
        if channel.message == message and name not in loggers.missing
    }
    return MessageLog(stamps[kept], channels)


def is_second_logger(message: str) -> bool:
    """True for the message that the second logger writes."""
    return message == SECOND_LOGGER
