"""What the evidence needs of a replay; the vehicle's replay has it, and so has the linear car of the tests."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Effect, EffectParameter
from model_diagnosis.manoeuvre import Manoeuvre

FloatArray = NDArray[np.float64]


class ReplayModel(Protocol):
    """Replay of all manoeuvres as a function of the deviations theta (p,), 0 neutral.

    Lists hold one array per manoeuvre, rows are samples and columns the manoeuvre's compared signals.
    """

    @property
    def manoeuvres(self) -> Sequence[Manoeuvre]:
        """The manoeuvres."""

    @property
    def forces_measured(self) -> bool:
        """True where what drives and brakes the wheels was measured in every manoeuvre."""

    @property
    def torque_measured(self) -> bool:
        """True where a torque of brakes or drive was measured at any time."""

    @property
    def limit_approached(self) -> bool:
        """True where half of the tyres' friction, or of the slip at its peak, was used at any time."""

    effects: tuple[Effect, ...]
    columns: tuple[str, ...]
    parameters: tuple[EffectParameter, ...]
    owner: NDArray[np.int64]

    def signals(self, manoeuvre: int) -> tuple[str, ...]:
        """Names of the compared signals of a manoeuvre."""
        ...

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        """Measured minus predicted, (n, c) per manoeuvre, 0 where the weight is 0."""
        ...

    def weights(self) -> list[FloatArray]:
        """Weights (n, c) per manoeuvre."""
        ...

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        """Derivative of the prediction to the deviations, (n, c, len(columns)) per manoeuvre."""
        ...

    def corrections(self, manoeuvre: int) -> FloatArray:
        """(c, k) change of each of k states of the observer by one unit of each signal's residual; k may be 0."""
        ...

    def sensor_std(self, signal: str) -> float:
        """Own noise of the signal's sensor in the signal's unit."""
        ...
