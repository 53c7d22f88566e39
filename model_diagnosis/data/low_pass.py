"""First-order low-pass of a channel: the filter, how it is told, how it is undone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import signal

from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import slope
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

_UNDONE_UP_TO_S = 0.6


def first_order(values: FloatArray, time_constant_s: float) -> FloatArray:
    """First-order lag on the common time base, in steady state at the first sample."""
    pole = float(np.exp(-SAMPLE_TIME_S / time_constant_s))
    result: FloatArray = signal.lfilter([1.0 - pole], [1.0, -pole], values, zi=[pole * values[0]])[0]
    return result


def least_between(time_constants_s: FloatArray, costs: FloatArray) -> float:
    """Time constant at the minimum of the parabola over log time constant; they are a geometric sequence."""
    logs = np.log(time_constants_s)
    k = int(np.argmin(costs))
    if not 0 < k < len(logs) - 1:
        return float(time_constants_s[k])
    before, low, after = costs[k - 1 : k + 2]
    bend = before - 2.0 * low + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(np.exp(logs[k] + shift * (logs[1] - logs[0])))


def named_and_undone(
    manoeuvres: Sequence[Manoeuvre], channel: str, time_constant_s: float, gain: float
) -> tuple[DataFault, list[Manoeuvre]]:
    """The data fault, and the manoeuvres with filters up to 0.6 s undone and slower channels left out."""
    undone = time_constant_s <= _UNDONE_UP_TO_S
    what = "undone" if undone else "too slow to be undone: the channel is not used"
    fault = DataFault(
        kind="low_pass_channel",
        channel=channel,
        value=time_constant_s,
        unit="s",
        evidence=gain,
        repaired=undone,
        message=f"{channel} is low-passed with a time constant of {time_constant_s:.2g} s; {what}",
    )
    mend = _undone if undone else _left_out
    return fault, [mend(m, channel, time_constant_s) if channel in m.channels else m for m in manoeuvres]


def _undone(manoeuvre: Manoeuvre, channel: str, time_constant_s: float) -> Manoeuvre:
    values = manoeuvre.channels[channel]
    return replace(manoeuvre, channels=dict(manoeuvre.channels) | {channel: values + time_constant_s * slope(values)})


def _left_out(manoeuvre: Manoeuvre, channel: str, time_constant_s: float) -> Manoeuvre:
    channels = {name: series for name, series in manoeuvre.channels.items() if name != channel}
    weights = {name: series for name, series in manoeuvre.weights.items() if name != channel}
    return replace(manoeuvre, channels=channels, weights=weights)
