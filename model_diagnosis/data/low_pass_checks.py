"""Low-passed channels: a first-order lag explains a channel from its twin far better than any delay does.

A noisy twin fits better once it is smoothed, whatever the channel is; so the delay is given the same smoothing without
its phase, and only the phase decides.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_diagnosis.data.delay_checks import INERTIAL
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import COARSE_STEP, correlations
from model_diagnosis.data.low_pass import first_order, least_between, named_and_undone
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twin_kinds import AX_SPEED, AX_WHEELS, AY_YAW, YAW_WHEELS
from model_diagnosis.data.twins import reached, slope, twins_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

CHANNELS = (*INERTIAL, "speed")
_TIME_CONSTANTS_S = np.geomspace(0.03, 5.0, 14)
_BAND_HZ = (0.05, 4.0)
_SLOW_BAND_HZ = (0.05, 1.5)
_WIDEST_LAG_S = 2.5
_SHORTEST_S = {AX_WHEELS.name: 0.3, AX_SPEED.name: 0.08, AY_YAW.name: 0.1, YAW_WHEELS.name: 0.08}
"""Time constants that the car itself makes between the sides: slip for ax and wheels, side slip for ay and yaw rate."""
_SHORTEST_REPLAYED_S = 0.06
_SHARE_OF_TWIN = 0.35
_SHARE_OF_SPEED = 0.3
_LEAST_OF_REPLAY = 0.03
_WORST_FIT = 0.3
_WELL_EXPLAINED = 0.02
"""Share of a channel's power that a delay may leave unexplained without any further question."""
_GAIN = 20.0
_INDEPENDENT_PER_S = 2.0


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
    return least_between(_TIME_CONSTANTS_S, shares), gain


def _pairs(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, channel: str, replayed: Sequence[Manoeuvre] | None
) -> list[_Pair]:
    if replayed is not None and channel == "speed":
        return _replayed_speed(manoeuvres, replayed)
    found = []
    for twin in twins_of(manoeuvres, geometry):
        if twin.kind.name not in _SHORTEST_S:
            continue
        if twin.kind.late == channel:
            found.append(_Pair(twin.left, twin.right, twin.valid, _SHORTEST_S[twin.kind.name], _SHARE_OF_TWIN))
        elif twin.kind.early == channel:
            found.append(_Pair(twin.right, twin.left, twin.valid, _SHORTEST_S[twin.kind.name], _SHARE_OF_TWIN))
    return found


def _replayed_speed(manoeuvres: Sequence[Manoeuvre], replayed: Sequence[Manoeuvre]) -> list[_Pair]:
    """Slopes of the speed: its level hardly tells a filter from a delay, its slow changes do."""
    both = [(m, r) for m, r in zip(manoeuvres, replayed, strict=True) if "speed" in m.channels]
    if not both:
        return []
    measured, predicted = ([slope(one.channels["speed"]) for one in side] for side in zip(*both, strict=True))
    valid = [reached(m, "speed") for m, _ in both]
    return [_Pair(measured, predicted, valid, _SHORTEST_REPLAYED_S, _SHARE_OF_SPEED, _SLOW_BAND_HZ, _LEAST_OF_REPLAY)]


def check_low_pass(
    manoeuvres: Sequence[Manoeuvre],
    geometry: Geometry,
    replayed: Sequence[Manoeuvre] | None = None,
    channels: Sequence[str] = CHANNELS,
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name channels that a filter has smoothed; undo filters up to 0.6 s, leave slower channels out.

    Parameters
    ----------
    replayed : the same manoeuvres as the vehicle file predicts them from the inputs; without it twins of the speed are
        compared, as are those of the other channels
    channels : that are asked
    """
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for _ in channels:
        fits = {c: [_fit(p) for p in _pairs(repaired, geometry, c, replayed)] for c in channels}
        named = {c: max(found, key=lambda f: f[1]) for c, found in fits.items() if _consistent(found)}
        if not named:
            break
        channel = max(named, key=lambda c: sum(gain for _, gain in fits[c]))
        time_constant, gain = named[channel]
        fault, repaired = named_and_undone(repaired, channel, time_constant, gain)
        faults.append(fault)
    return faults, repaired


def _consistent(fits: Sequence[tuple[float, float]]) -> bool:
    """True where the evidence is strong and most twins of the channel show it."""
    shown = [fit for fit in fits if fit[1] > 0.0]
    return bool(shown) and sum(g for _, g in shown) > _GAIN and 2 * len(shown) > len(fits) - (len(fits) > 1)
