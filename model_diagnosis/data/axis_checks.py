"""Accelerometer axes that were taken for each other: the one named lateral follows the change of speed."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import Motion, reached, slope, slow
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

_ALONG, _ACROSS = "longitudinal_acceleration", "lateral_acceleration"
_SURE, _DOUBTFUL = 0.8, 0.5
"""Correlation with the other axis' motion from which a swap is named, and below which the own axis' must be."""
_SLOW_HZ = 1.0
_LEAST_S = 10.0
_MOVES_M_S2 = 0.3
"""Standard deviation of an acceleration by the speeds from which an axis can be told by it."""


def check_swapped_axes(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name and undo accelerations along and across the car that stand under each other's name, whatever their signs.

    Both must speak for it: the channel named lateral follows the change of speed and the one named longitudinal does
    not, and the latter is no worse on speed times yaw rate than the former.
    """
    parts = [part for m in manoeuvres if (part := _four_accelerations(m, geometry)) is not None]
    joined = np.concatenate(parts, axis=1) if parts else np.zeros((4, 0))
    if joined.shape[1] * SAMPLE_TIME_S < _LEAST_S or np.any(np.std(joined, axis=1) == 0.0):
        return [], list(manoeuvres)
    size = np.abs(np.corrcoef(joined))
    along_own, along_other, across_own, across_other = size[0, 2], size[0, 3], size[1, 3], size[1, 2]
    sure = across_other > _SURE and along_own < _DOUBTFUL and np.std(joined[2]) > _MOVES_M_S2
    if not sure or along_other < across_own:
        return [], list(manoeuvres)
    message = (
        f"{_ALONG} and {_ACROSS} stand under each other's name: the change of speed is in the one called lateral "
        f"(correlation {across_other:.2f} against {along_own:.2f}); exchanged"
    )
    fault = DataFault(
        kind="channel_swap",
        channel=f"{_ALONG}, {_ACROSS}",
        value=2.0,
        unit="channels",
        evidence=float(across_other),
        repaired=True,
        message=message,
    )
    return [fault], [_exchanged(m) for m in manoeuvres]


def _four_accelerations(manoeuvre: Manoeuvre, geometry: Geometry) -> FloatArray | None:
    """(4, k) slow: read along and across, change of speed, speed times yaw rate, where all were measured."""
    channels = manoeuvre.channels
    speed = channels.get("speed", Motion(manoeuvre, geometry).wheels_speed())
    if speed is None or not all(name in channels for name in (_ALONG, _ACROSS, "yaw_rate")):
        return None
    series = (channels[_ALONG], channels[_ACROSS], slope(speed), speed * channels["yaw_rate"])
    measured = reached(manoeuvre, _ALONG) & reached(manoeuvre, _ACROSS) & reached(manoeuvre, "yaw_rate")
    return np.stack([slow(values, _SLOW_HZ)[measured] for values in series])


def _exchanged(manoeuvre: Manoeuvre) -> Manoeuvre:
    if _ALONG not in manoeuvre.channels or _ACROSS not in manoeuvre.channels:
        return manoeuvre
    names = {_ALONG: _ACROSS, _ACROSS: _ALONG}
    return replace(
        manoeuvre,
        channels={name: manoeuvre.channels[names.get(name, name)] for name in manoeuvre.channels},
        weights={name: manoeuvre.weights[names.get(name, name)] for name in manoeuvre.weights},
    )
