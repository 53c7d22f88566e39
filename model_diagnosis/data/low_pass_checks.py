"""Low-passed channels: a first-order lag explains a channel from its twin far better than any delay does.

A noisy twin fits better once it is smoothed, whatever the channel is; so the delay is given the same smoothing without
its phase, and only the phase decides.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import COARSE_STEP, correlations
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twins import AX_SPEED, AX_WHEELS, AY_YAW, YAW_WHEELS, reached, slope, twins_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

CHANNELS = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "speed")
_TIME_CONSTANTS_S = np.geomspace(0.03, 5.0, 14)
_BAND_HZ = (0.05, 4.0)
_SLOW_BAND_HZ = (0.05, 1.5)
_WIDEST_LAG_S = 2.5
_SHORTEST_S = {AX_WHEELS.name: 0.3, AX_SPEED.name: 0.08, AY_YAW.name: 0.1, YAW_WHEELS.name: 0.08}
"""Time constants that the car itself makes between the sides: slip for ax and wheels, side slip for ay and yaw rate."""
_SHORTEST_REPLAYED_S = 0.06
_SHARE_OF_TWIN = 0.35
_SHARE_OF_REPLAY = 0.6
_SHARE_OF_SPEED = 0.3
_LEAST_OF_REPLAY = 0.03
_WORST_FIT = 0.3
_WELL_EXPLAINED = 0.02
"""Share of a channel's power that a delay may leave unexplained without any further question."""
_GAIN = 20.0
_INDEPENDENT_PER_S = 2.0
_RESTORED_UP_TO_S = 0.6


@dataclass(frozen=True)
class _Pair:
    """A channel's series and the same quantity without a filter, per manoeuvre.

    Attributes
    ----------
    shortest_s : time constants below are the car's own
    share : of what a delay leaves unexplained, that a filter may leave to be named
    least : share of the power that a delay must leave unexplained
    """

    filtered: Sequence[FloatArray]
    plain: Sequence[FloatArray]
    valid: Sequence[BoolArray]
    shortest_s: float
    share: float
    band_hz: tuple[float, float] = _BAND_HZ
    least: float = 0.0


def first_order(values: FloatArray, time_constant_s: float) -> FloatArray:
    """First-order lag on the common time base, in steady state at the first sample."""
    pole = float(np.exp(-SAMPLE_TIME_S / time_constant_s))
    result: FloatArray = signal.lfilter([1.0 - pole], [1.0, -pole], values, zi=[pole * values[0]])[0]
    return result


def smoothed(values: FloatArray, time_constant_s: float) -> FloatArray:
    """The amplitudes of a first-order lag without its phase."""
    size = 2 * len(values)
    frequency = 2.0 * np.pi * np.fft.rfftfreq(size, SAMPLE_TIME_S)
    mirrored = np.concatenate((values, values[::-1]))
    gain = 1.0 / np.sqrt(1.0 + (frequency * time_constant_s) ** 2)
    result: FloatArray = np.fft.irfft(np.fft.rfft(mirrored) * gain, size)[: len(values)]
    return result


def _unexplained(pair: _Pair, plain: Sequence[FloatArray], step: int = 1) -> float:
    """Share of the filtered side's power that no delay of the plain side explains, by delays of ``step`` samples."""
    total = correlations(pair.filtered, plain, pair.valid, _WIDEST_LAG_S, pair.band_hz, step).sum(axis=0)
    return 1.0 - float(np.clip(np.max(total), 0.0, 1.0)) ** 2


def _fit(pair: _Pair) -> tuple[float, float]:
    """Time constant [s] and log likelihood that it wins over a pure delay; (0, 0) where it does not."""
    if _unexplained(pair, pair.plain) < _WELL_EXPLAINED:
        return 0.0, 0.0
    filtered = [[first_order(p, float(t)) for p in pair.plain] for t in _TIME_CONSTANTS_S]
    shares = np.array([_unexplained(pair, plain, COARSE_STEP) for plain in filtered])
    k = int(np.argmin(shares))
    share = max(_unexplained(pair, filtered[k]), 1e-4)
    if _TIME_CONSTANTS_S[k] < pair.shortest_s or share > _WORST_FIT:
        return 0.0, 0.0
    delayed = (list(pair.plain), [smoothed(p, float(_TIME_CONSTANTS_S[k])) for p in pair.plain])
    unexplained = min(_unexplained(pair, plain) for plain in delayed)
    if unexplained < pair.least or share > pair.share * unexplained:
        return 0.0, 0.0
    seconds = SAMPLE_TIME_S * sum(float(v.sum()) for v in pair.valid)
    gain = 0.5 * _INDEPENDENT_PER_S * seconds * float(np.log(unexplained / share))
    return _refined(shares, k), gain


def _refined(shares: FloatArray, k: int) -> float:
    """Time constant at the minimum of a parabola over log time constant."""
    logs = np.log(_TIME_CONSTANTS_S)
    if not 0 < k < len(logs) - 1:
        return float(_TIME_CONSTANTS_S[k])
    before, low, after = shares[k - 1 : k + 2]
    bend = before - 2.0 * low + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(np.exp(logs[k] + shift * (logs[1] - logs[0])))


def _pairs(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, channel: str, replayed: Sequence[Manoeuvre] | None
) -> list[_Pair]:
    if replayed is not None and not _drives_its_own_replay(manoeuvres, channel):
        both = [
            (m, r) for m, r in zip(manoeuvres, replayed, strict=True) if channel in m.channels and channel in r.channels
        ]
        if not both:
            return []
        # a speed's level hardly tells a filter from a delay, its slow changes do
        change = slope if channel == "speed" else np.asarray
        measured = [change(m.channels[channel]) for m, _ in both]
        predicted = [change(r.channels[channel]) for _, r in both]
        valid = [reached(m, channel) for m, _ in both]
        band_hz = _SLOW_BAND_HZ if channel == "speed" else _BAND_HZ
        share = _SHARE_OF_SPEED if channel == "speed" else _SHARE_OF_REPLAY
        return [_Pair(measured, predicted, valid, _SHORTEST_REPLAYED_S, share, band_hz, _LEAST_OF_REPLAY)]
    found = []
    for twin in twins_of(manoeuvres, geometry):
        if twin.kind.name not in _SHORTEST_S:
            continue
        if twin.kind.late == channel:
            found.append(_Pair(twin.left, twin.right, twin.valid, _SHORTEST_S[twin.kind.name], _SHARE_OF_TWIN))
        elif twin.kind.early == channel:
            found.append(_Pair(twin.right, twin.left, twin.valid, _SHORTEST_S[twin.kind.name], _SHARE_OF_TWIN))
    return found


def _drives_its_own_replay(manoeuvres: Sequence[Manoeuvre], channel: str) -> bool:
    """True where a replay takes the drive torque, which nobody measured, from this very channel and so follows it."""
    driven = any(name.startswith(("drive_torque", "engine_torque")) for m in manoeuvres for name in m.channels)
    return channel == "longitudinal_acceleration" and not driven


def check_low_pass(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, replayed: Sequence[Manoeuvre] | None = None
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name channels that a filter has smoothed; undo filters up to 0.6 s, give slower channels weight 0.

    Parameters
    ----------
    replayed : the same manoeuvres as the vehicle file predicts them from the inputs; without it the twins are compared
    """
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for _ in CHANNELS:
        fits = {c: [_fit(p) for p in _pairs(repaired, geometry, c, replayed)] for c in CHANNELS}
        named = {c: max(found, key=lambda f: f[1]) for c, found in fits.items() if _consistent(found)}
        if not named:
            break
        channel = max(named, key=lambda c: sum(gain for _, gain in fits[c]))
        time_constant, gain = named[channel]
        faults.append(_fault(channel, time_constant, gain))
        repaired = [_restored(m, channel, time_constant) for m in repaired]
    return faults, repaired


def _consistent(fits: Sequence[tuple[float, float]]) -> bool:
    """True where the evidence is strong and most twins of the channel show it."""
    shown = [fit for fit in fits if fit[1] > 0.0]
    return bool(shown) and sum(g for _, g in shown) > _GAIN and 2 * len(shown) > len(fits) - (len(fits) > 1)


def _fault(channel: str, time_constant: float, gain: float) -> DataFault:
    undone = time_constant <= _RESTORED_UP_TO_S
    what = "undone" if undone else "too slow to be undone: the channel is not used"
    message = f"{channel} is low-passed with a time constant of {time_constant:.2g} s; {what}"
    return DataFault(
        kind="low_pass_channel",
        channel=channel,
        value=time_constant,
        unit="s",
        evidence=gain,
        repaired=undone,
        message=message,
    )


def _restored(manoeuvre: Manoeuvre, channel: str, time_constant: float) -> Manoeuvre:
    if channel not in manoeuvre.channels:
        return manoeuvre
    values = manoeuvre.channels[channel]
    if time_constant > _RESTORED_UP_TO_S:
        channels = {name: series for name, series in manoeuvre.channels.items() if name != channel}
        weights = {name: series for name, series in manoeuvre.weights.items() if name != channel}
        return replace(manoeuvre, channels=channels, weights=weights)
    return replace(manoeuvre, channels=dict(manoeuvre.channels) | {channel: values + time_constant * slope(values)})
