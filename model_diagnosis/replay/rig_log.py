"""What the replay of a wheel on a rig keeps of each manoeuvre: what drives it, and the forces to compare."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.rig import FORCES, LOAD, SET_SLIPS, rig_wheel
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay.gaps import BEGINNING, GAP_STEPS
from model_diagnosis.replay.inputs import SLOWEST_M_S
from model_diagnosis.replay.smoothing import without_noise
from signals.errors import InputError
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class RigLog:
    """What stays the same of one manoeuvre for every theta.

    Attributes
    ----------
    wheel : index in wheel order
    signals : compared forces, the columns of the arrays
    chosen : of the run's two forces, in the order of ``signals``
    driving : (n, 4) slip ratio, slip angle [rad], vertical load [N], belt speed [m/s] without their sensors' noise; a
        slip that is not set is 0
    measured, weights : (n, c)
    """

    wheel: int
    signals: tuple[str, ...]
    chosen: NDArray[np.int64]
    driving: FloatArray
    measured: FloatArray
    weights: FloatArray


def read_rig(manoeuvre: Manoeuvre) -> RigLog:
    """Prepare a manoeuvre of a wheel on a rig; its channels on one raster.

    Raises
    ------
    InputError
        If it is no such manoeuvre, or lacks load or speed.
    """
    channels = manoeuvre.channels
    wheel = rig_wheel(channels)
    if wheel is None:
        raise InputError(
            f"{manoeuvre.source}: not the log of one wheel on a rig",
            found=", ".join(sorted(channels)) or "no channels",
            allowed="slip ratio or slip angle, vertical load, forces of one wheel, speed, and no channel of a car",
            mend="diagnose and hold out logs of a rig and of a car apart",
        )
    drivers = [*(f"{kind}_{wheel}" for kind in SET_SLIPS), f"{LOAD}_{wheel}", "speed"]
    missing = [name for name in drivers[2:] if name not in channels]
    if missing:
        raise InputError(
            f"{manoeuvre.source}: the tyre of a wheel on a rig cannot be replayed without {' and '.join(missing)}",
            found=", ".join(sorted(channels)),
            allowed=f"slip ratio or slip angle, {LOAD}_{wheel} and speed beside the forces",
            mend=f"map {' and '.join(missing)} in the channel map",
        )
    # without the slip of its own direction a force has no cause that was measured
    signals = [
        f"{force}_{wheel}"
        for force, slip in zip(FORCES, SET_SLIPS, strict=True)
        if f"{force}_{wheel}" in channels and f"{slip}_{wheel}" in channels
    ]
    nothing = np.zeros(manoeuvre.samples)
    # a prediction with the noise of its inputs in it gains by whatever averages it: a later sensor, a quicker tyre
    driving = np.stack([_quiet(channels.get(name, nothing)) for name in drivers], axis=1)
    counts = (driving[:, -1] >= SLOWEST_M_S) & _driven(manoeuvre, [name for name in drivers if name in channels])
    return RigLog(
        wheel=WHEELS.index(wheel),
        signals=tuple(signals),
        chosen=np.array([FORCES.index(name.removesuffix(f"_{wheel}")) for name in signals], dtype=np.int64),
        driving=np.ascontiguousarray(driving),
        measured=np.stack([channels[name] for name in signals], axis=1) if signals else np.zeros((len(driving), 0)),
        weights=np.stack([manoeuvre.weight(name) * counts for name in signals], axis=1)
        if signals
        else np.zeros((len(driving), 0)),
    )


def _quiet(values: FloatArray) -> FloatArray:
    """Values (n,) without noise; what rests exactly most of the time is a command, whose steps are no noise."""
    rests = np.median(np.abs(np.diff(values))) == 0.0
    return values if rests else without_noise(values)


def _driven(manoeuvre: Manoeuvre, names: list[str]) -> BoolArray:
    """True (n,) where everything that drives the wheel has been known for as long as the tyre remembers."""
    known: BoolArray = np.ones(manoeuvre.samples, dtype=np.bool_)
    known[:BEGINNING] = False
    for name in names:
        samples = np.flatnonzero(manoeuvre.weight(name) > 0.0)
        if len(samples) < 2:
            return np.zeros(manoeuvre.samples, dtype=np.bool_)
        steps = np.diff(samples)
        for place in np.flatnonzero(steps > GAP_STEPS * np.median(steps)):
            known[samples[place] + 1 : samples[place + 1] + BEGINNING] = False
        known[samples[-1] + 1 :] = False
    return known
