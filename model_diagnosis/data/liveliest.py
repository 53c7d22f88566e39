"""The manoeuvres of long drives in which the most happens, for a search that need not last as long as the drive."""

from collections.abc import Sequence

import numpy as np

from model_diagnosis.data.rig import is_on_rig
from model_diagnosis.data.rig_sweeps import farthest_apart
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, FloatArray, Manoeuvre
from signals.errors import InputError
from signals.wheels import WHEELS

_BLOCK_S = 0.5


def liveliest(manoeuvres: Sequence[Manoeuvre], at_most_s: float) -> list[Manoeuvre]:
    """Manoeuvres with the largest changes of speed and direction, in their order, of ``at_most_s`` together.

    The liveliest one is taken in any case. What lasts longer than the rest of the time is passed over. Of a wheel on
    a rig those that are farthest apart are taken: it is lively in all of them, each at one load.

    Raises
    ------
    InputError
        If ``at_most_s`` is not positive.
    """
    if at_most_s <= 0.0:
        raise InputError("time to search", found=f"{at_most_s:g} s", allowed="above 0 s", mend="120 s is enough")
    if is_on_rig(manoeuvres):
        order = farthest_apart(manoeuvres)
    else:
        order = sorted(range(len(manoeuvres)), key=lambda k: liveliness(manoeuvres[k]), reverse=True)
    chosen: list[int] = []
    left = at_most_s
    for k in order:
        if not chosen or manoeuvres[k].duration_s <= left:
            chosen.append(k)
            left -= manoeuvres[k].duration_s
    return [manoeuvres[k] for k in sorted(chosen)]


def liveliness(manoeuvre: Manoeuvre) -> float:
    """Root mean square of how accelerations along and across vary [m/s²], each over means of half a second."""
    return float(np.sqrt(sum(np.var(_means(values)) for values in _accelerations(manoeuvre))))


def _accelerations(manoeuvre: Manoeuvre) -> list[FloatArray]:
    """Change of speed and speed times yaw rate, or what the accelerometers read where these are not known."""
    channels = manoeuvre.channels
    wheels = [channels[f"wheel_speed_{w}"] for w in WHEELS if f"wheel_speed_{w}" in channels]
    found = []
    if "speed" in channels:
        found.append(np.gradient(channels["speed"], SAMPLE_TIME_S))
    elif "longitudinal_acceleration" in channels:
        found.append(channels["longitudinal_acceleration"])
    elif wheels:
        found.append(np.gradient(np.mean(wheels, axis=0), SAMPLE_TIME_S))
    if "lateral_acceleration" in channels:
        found.append(channels["lateral_acceleration"])
    elif "yaw_rate" in channels and "speed" in channels:
        found.append(channels["speed"] * channels["yaw_rate"])
    return found


def _means(values: FloatArray) -> FloatArray:
    length = round(_BLOCK_S / SAMPLE_TIME_S)
    blocks = max(len(values) // length, 1)
    return np.array([part.mean() for part in np.array_split(values, blocks)])
