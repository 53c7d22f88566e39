"""What a set of deviations makes of a manoeuvre, in two parts that most deviations do not share."""

from collections.abc import Container, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Key = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Parts:
    """Prediction of one manoeuvre before the sensors, and the deviations that each part was made with.

    Attributes
    ----------
    car : (n, c) outputs of the car
    pressures : (n, 4) of the wheel brakes by the hydraulic unit [Pa]; None where the log tells nothing of it
    """

    car_key: Key
    car: FloatArray
    pressure_key: Key
    pressures: FloatArray | None


def selected(deviations: Mapping[str, float], columns: Container[str]) -> Key:
    """Deviations of these columns, to compare; the same ones in the same order."""
    return tuple([(column, value) for column, value in deviations.items() if column in columns and value != 0.0])


def without(deviations: Mapping[str, float], columns: Container[str]) -> Key:
    """Deviations of all other columns, to compare; the same ones in the same order."""
    return tuple([(column, value) for column, value in deviations.items() if column not in columns and value != 0.0])
