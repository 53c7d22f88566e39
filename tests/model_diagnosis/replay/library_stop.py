"""A stop of the manoeuvre library as the replay drives it, to be spoiled by a test."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.manoeuvre_library import LIBRARY
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]
SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_STOP = next(one for one in LIBRARY if one.name == "stop_medium")


def planned_inputs() -> tuple[FloatArray, dict[str, FloatArray]]:
    """Time and inputs of the library's stop at 4 m/s^2."""
    return _STOP.inputs("r")


def driven(car: VehicleFile, time: FloatArray, inputs: dict[str, FloatArray]) -> Manoeuvre:
    """The stop with these inputs, without noise: speed and wheel speeds are those of a free run of the replay."""
    channels = inputs | {"speed": np.full_like(time, _STOP.speed)}
    channels |= {name: channels["speed"] / getattr(car.wheels, name[-2:]).radius for name in SPEEDS}
    blank = Manoeuvre("stop", time, channels, {name: np.ones_like(time) for name in channels}, "made for a test")
    replay = Replay(car, [blank])
    run = replay.free_run(np.zeros(len(replay.columns)), 0)
    made = {name: run[:, place] for place, name in enumerate(replay.signals(0)) if name in ("speed", *SPEEDS)}
    return replace(blank, channels=channels | made)
