"""What the plants of the source documents have in common: memory, reset, outputs in a view, ticks in a row."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from signals.quantities import FileModel
from vehicle_model.interface import PLANT_OUTPUTS, TIME_STEP_S
from vehicle_model.plant_access import PlantAccess
from vehicle_model.road import RoadTables
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile


class ReferencePlant(PlantAccess, ABC):
    """Base of the documents' plants (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle, road
        Copies are kept; a level and dry road if left out.
    options : FileModel
        Numerics and variants of the plant.
    parameters, state : dtype
        Records of the compiled step; a state has at least speed, x, y, yaw and omega, the parameters radius.
    """

    time_step_s = TIME_STEP_S

    def __init__(
        self,
        vehicle: VehicleFile,
        road: RoadFile | None,
        options: FileModel,
        parameters: np.dtype[np.void],
        state: np.dtype[np.void],
    ) -> None:
        self._vehicle = vehicle.model_copy(deep=True)
        self._road = RoadTables(road or RoadFile())
        self._options = options
        self._parameters: NDArray[np.void] = np.zeros(1, parameters)
        self._state: NDArray[np.void] = np.zeros(1, state)
        self._brake, self._drive = np.zeros(4), np.zeros(4)
        self._time_s = 0.0
        self.outputs: NDArray[np.float64] = np.zeros(len(PLANT_OUTPUTS))
        self._allocate()
        self._write("body")
        self._take_memory()
        self.reset(speed_m_s=0.0)

    def _allocate(self) -> None:
        """Further memory of the compiled step."""

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

    def reset(
        self,
        *,
        speed_m_s: float,
        position_x_m: float = 0.0,
        position_y_m: float = 0.0,
        yaw_angle_rad: float = 0.0,
        time_s: float = 0.0,
    ) -> None:
        """Rest loads, moving at ``speed_m_s`` along the heading with freely rolling wheels."""
        self._state[:] = np.zeros(1, self._state.dtype)
        s = self._state[0]
        s["speed"], s["x"], s["y"], s["yaw"] = speed_m_s, position_x_m, position_y_m, yaw_angle_rad
        s["omega"] = speed_m_s / self._parameters[0]["radius"]
        self._time_s = time_s
        self.outputs[:] = 0.0
        self._drive[:] = 0.0
        self._show(time_s)

    @abstractmethod
    def _show(self, time_s: float) -> None:
        """Write the outputs of a car that has just been put on the road."""

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


class EnergyAccount(ReferencePlant):
    """Base of those that account for their energy."""

    def energy_account(self) -> dict[str, float]:
        """Energies since the reset [J]: what brakes, tyres, rolling and air took, and what the drive gave."""
        kinds = ("brake_energy", "tyre_energy", "rolling_energy", "air_energy", "drive_energy")
        return {kind: float(self._state[kind][0]) for kind in kinds}
