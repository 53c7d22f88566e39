"""When within a sample each signal was taken: messages of a bus have their own phases, and only a table has one raster.

A sample k of a channel belongs to the instant k + phase of the manoeuvre's time base, in samples. Laid on the raster by
straight lines, the pressures and wheel speeds of a stop with ABS would be off by bars and rad/s.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.record import (
    CORRECTED,
    INPUT_BANK,
    INPUT_DRIVE_FRONT,
    INPUT_DRIVE_REAR,
    INPUT_GRADE,
    INPUT_STEER,
    INPUTS,
)
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

_STEER = ("road_wheel_angle", "steering_wheel_angle", "steering_command")
_DRIVE = {INPUT_DRIVE_FRONT: ("drive_torque_f", "engine_torque"), INPUT_DRIVE_REAR: ("drive_torque_r", "engine_torque")}


@dataclass(frozen=True)
class Phases:
    """Phases of one manoeuvre in samples, from -0.5 to 0.5.

    Attributes
    ----------
    inputs : (INPUTS,) of what drives the car
    corrected : (6,) of what the observer corrects on
    outputs : (c,) of the compared signals of the car
    pressure, master, command : of the wheel pressures, of master pressure or pedal force, of the valves' commands
    """

    inputs: FloatArray
    corrected: FloatArray
    outputs: FloatArray
    pressure: float
    master: float
    command: float


def phases_of(manoeuvre: Manoeuvre, signals: Sequence[str]) -> Phases:
    """Phases of a manoeuvre; ``signals`` are the compared ones of the car."""

    def phase(*names: str) -> float:
        present = [name for name in names if name in manoeuvre.channels]
        return manoeuvre.phases.get(present[0], 0.0) / SAMPLE_TIME_S if present else 0.0

    master = phase("master_pressure", "pedal_force")
    pressure = phase("brake_pressure_fl", "master_pressure", "pedal_force")
    inputs = np.zeros(INPUTS)
    inputs[: len(WHEELS)] = pressure
    for column, names in _DRIVE.items():
        inputs[column] = phase(*names)
    inputs[INPUT_STEER], inputs[INPUT_GRADE] = phase(*_STEER), phase("road_grade")
    inputs[INPUT_BANK] = phase("road_bank")
    return Phases(
        inputs,
        np.array([phase(name) for name in CORRECTED]),
        np.array([phase(name) for name in signals]),
        pressure,
        master,
        phase("valve_inlet_fl"),
    )
