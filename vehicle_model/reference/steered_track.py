"""The four-state car that the force document defines (its 15c), as a plant.

car = SteeredTrack(load_vehicle("neural_700kg"))
car.reset(speed_m_s=8.0)
car.step(1000, drive_torque=[0.0, 0.0, 75.0, 75.0], steer=0.5)
car.state()["lateral_speed"]
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from signals.quantities import FileModel
from signals.wheels import WHEELS
from vehicle_model.reference.linear_slope import side_force_slope
from vehicle_model.reference.reference_plant import ReferencePlant
from vehicle_model.reference.steered_track_step import PARAMETER_RECORD, STATE_RECORD, show, steered_track_tick
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile


class SteeredTrackOptions(FileModel):
    """The four-state car has no numerics to choose: its step is the document's 1 ms."""


class SteeredTrack(ReferencePlant):
    """Four-state car (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; a copy is kept.
    road : RoadFile, optional
        Its parameters can be read and set, but this car feels no road.
    """

    sections: ClassVar[tuple[str, ...]] = ("body", "axles", "wheels", "steering", "steered_track", "tyres")

    def __init__(self, vehicle: VehicleFile, road: RoadFile | None = None) -> None:
        super().__init__(vehicle, road, SteeredTrackOptions(), PARAMETER_RECORD, STATE_RECORD)

    def _take_memory(self) -> None:
        self._memory = self._parameters, self._state, self.outputs

    def _show(self, time_s: float) -> None:
        show(*self._memory)

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``)."""
        steered_track_tick(*self._memory, brake_torque, drive_torque, steer)

    def _write(self, section: str) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        body, given = vehicle.body, vehicle.steered_track
        p["mass"], p["yaw_inertia"] = body.mass, body.yaw_inertia
        p["to_front"] = body.centre_of_gravity_to_front_axle
        p["to_rear"] = body.wheelbase - body.centre_of_gravity_to_front_axle
        p["time_constant"], p["steering_ratio"] = given.steering_time_constant, vehicle.steering.ratio
        p["load"] = vehicle.static_loads()
        tracks = vehicle.axles.front.track, vehicle.axles.rear.track
        for i, name in enumerate(WHEELS):
            wheel = getattr(vehicle.wheels, name)
            p["wheel_x"][i] = p["to_front"] if i < 2 else -p["to_rear"]
            p["wheel_y"][i] = (0.5 if i % 2 == 0 else -0.5) * tracks[i // 2]
            p["radius"][i] = wheel.radius
        for axle, value in enumerate((given.cornering_stiffness_front, given.cornering_stiffness_rear)):
            p["stiffness"][axle] = 2.0 * side_force_slope(vehicle, axle) if value is None else value
