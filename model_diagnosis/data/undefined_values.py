"""Values that stand for "not defined": a marker far off what the channel ever measures, the slip of a free wheel."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_diagnosis.data.sample_values import is_motion
from model_diagnosis.data.samples import BoolArray, Samples
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.result import DataFault
from signals.wheels import WHEELS

_FEWEST = 3
_MOST_OF_SAMPLES = 0.5
_FEWEST_VALUES = 20
_AWAY_OF_SPAN = 2.0
"""Distance of a marker from every measured value, in units of their span."""
_FORCES = ("longitudinal_force_", "lateral_force_", "vertical_load_", "suspension_travel_")
_LOCKED = 0.01
_FREE_FORCE = 0.1
"""Force over load below which a wheel surely rolls: a locked one has far more on any road but ice (0.05)."""


def check_markers(channel: Samples) -> tuple[Samples, list[DataFault]]:
    """Mask a value that is repeated exactly and lies far from all others, as logs write it where nothing was measured.

    A signal that moves there has values in between; what is set (pressures, steering, torques) may jump and is not
    looked at.
    """
    if not (is_motion(channel.name) or channel.name.startswith(_FORCES)):
        return channel, []
    rows = np.flatnonzero(channel.valid)
    values = channel.values[rows]
    if len(values) < _FEWEST_VALUES:
        return channel, []
    for marker in (float(values.max()), float(values.min())):
        marked = values == marker
        rest = values[~marked]
        if not _FEWEST <= marked.sum() <= _MOST_OF_SAMPLES * len(values) or len(np.unique(rest)) < _FEWEST_VALUES:
            continue
        if float(np.min(np.abs(rest - marker))) <= _AWAY_OF_SPAN * float(np.ptp(rest)):
            continue
        wrong = np.zeros(len(channel.values), dtype=bool)
        wrong[rows[marked]] = True
        share = float(np.mean(marked))
        message = (
            f"{channel.name} is exactly {marker:.6g} {channel.unit} in {100.0 * share:.2g} % of the samples and else "
            f"between {rest.min():.6g} and {rest.max():.6g}: a marker where nothing was measured; masked"
        )
        fault = DataFault(
            kind="undefined_value",
            channel=channel.name,
            value=marker,
            unit=channel.unit,
            repaired=True,
            message=message,
        )
        return channel.masked(wrong), [fault]
    return channel, []


def check_free_wheels(manoeuvres: Sequence[Manoeuvre]) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Mask a slip of −1, a locked wheel's, where the measured force and load say that the wheel rolls."""
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for wheel in WHEELS:
        name = f"slip_ratio_{wheel}"
        free = [_free(manoeuvre, wheel) for manoeuvre in repaired]
        counted = sum(int(one.sum()) for one in free)
        if counted < _FEWEST:
            continue
        total = sum(int((m.weight(name) > 0.0).sum()) for m in repaired)
        message = (
            f"{name} is -1, a locked wheel's, in {100.0 * counted / total:.2g} % of the samples, in which the wheel "
            f"has less force than {_FREE_FORCE:.0%} of its load: it rolls freely and no slip was measured; masked"
        )
        faults.append(
            DataFault(kind="undefined_value", channel=name, value=-1.0, unit="1", repaired=True, message=message)
        )
        repaired = [_masked(m, name, one) for m, one in zip(repaired, free, strict=True)]
    return faults, repaired


def _free(manoeuvre: Manoeuvre, wheel: str) -> BoolArray:
    """(n,) True where the slip says locked and the force says rolling."""
    names = (f"slip_ratio_{wheel}", f"longitudinal_force_{wheel}", f"vertical_load_{wheel}")
    if not all(name in manoeuvre.channels for name in names):
        return np.zeros(manoeuvre.samples, dtype=bool)
    slip, force, load = (manoeuvre.channels[name] for name in names)
    known = np.all([manoeuvre.weight(name) > 0.0 for name in names], axis=0)
    free: BoolArray = known & (np.abs(slip + 1.0) < _LOCKED) & (np.abs(force) < _FREE_FORCE * np.abs(load))
    return free


def _masked(manoeuvre: Manoeuvre, name: str, wrong: BoolArray) -> Manoeuvre:
    if not wrong.any():
        return manoeuvre
    weights = dict(manoeuvre.weights) | {name: np.where(wrong, 0.0, manoeuvre.weight(name))}
    return replace(manoeuvre, weights=weights)
