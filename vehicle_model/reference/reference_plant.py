"""What the plants of the source documents have in common: outputs in a view, ticks one after the other."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_model.interface import PLANT_OUTPUTS, TIME_STEP_S
from vehicle_model.plant_access import PlantAccess


class ReferencePlant(PlantAccess, ABC):
    """Base of the documents' plants (see ``vehicle_model.interface.Plant`` for what every plant offers)."""

    time_step_s = TIME_STEP_S

    def __init__(self) -> None:
        self._brake, self._drive = np.zeros(4), np.zeros(4)
        self._time_s = 0.0
        self.outputs: NDArray[np.float64] = np.zeros(len(PLANT_OUTPUTS))

    def bind(self, view: NDArray[np.float64]) -> None:
        """Write the outputs into ``view`` (block "plant" of a signal vector) from now on."""
        if view.shape != self.outputs.shape or view.dtype != np.float64:
            raise ValueError(f"found a view of shape {view.shape}, allowed: {len(PLANT_OUTPUTS)} float64")
        view[:] = self.outputs
        self.outputs = view
        self._take_memory()

    @abstractmethod
    def _take_memory(self) -> None:
        """Called when ``outputs`` has moved."""

    @abstractmethod
    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``)."""

    def step(self, n: int, *, brake_torque: ArrayLike = 0.0, drive_torque: ArrayLike = 0.0, steer: float = 0.0) -> None:
        """Advance by ``n`` milliseconds with constant inputs; torques are one number or one per wheel [N m]."""
        self._brake[:] = brake_torque
        self._drive[:] = drive_torque
        for _ in range(n):
            self.tick(self._brake, self._drive, steer, self._time_s)
            self._time_s += TIME_STEP_S
