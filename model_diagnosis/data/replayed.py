"""Manoeuvres as the vehicle file predicts them, for comparison with the measured ones."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.manoeuvre import Manoeuvre
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]


class ReplayModel(Protocol):
    """What the data checks need of a replay; ``model_diagnosis.replay.replay.Replay`` is one."""

    columns: tuple[str, ...]
    parameters: tuple[EffectParameter, ...]

    def signals(self, m: int) -> tuple[str, ...]:
        """Compared signals of manoeuvre ``m``."""

    def weights(self) -> list[FloatArray]:
        """(n, c) of each manoeuvre."""

    def free_run(self, theta: FloatArray, m: int, horizon_s: float | None = None) -> FloatArray:
        """(n, c) without corrections."""

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        """Measured minus predicted (n, c) of each manoeuvre."""

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        """(n, c, p) of each manoeuvre."""

    def sensor_std(self, signal: str) -> float:
        """Own noise of a signal's sensor."""


class ReplayFactory(Protocol):
    """Builds a replay of manoeuvres; the class ``Replay`` itself."""

    def __call__(self, vehicle: VehicleFile, manoeuvres: Sequence[Manoeuvre]) -> ReplayModel:
        """Replay of the manoeuvres by the vehicle."""


def replayed_manoeuvres(model: ReplayModel, manoeuvres: Sequence[Manoeuvre], theta: FloatArray) -> list[Manoeuvre]:
    """The manoeuvres with every compared signal replaced by its free run; the inputs stay as measured."""
    result = []
    for m, manoeuvre in enumerate(manoeuvres):
        predicted = model.free_run(theta, m)
        outputs = {name: predicted[:, k] for k, name in enumerate(model.signals(m))}
        result.append(replace(manoeuvre, channels=dict(manoeuvre.channels) | outputs))
    return result
