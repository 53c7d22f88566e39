"""The two-track car with a roll axis that the vertical-load document uses (its 4.1), as a plant.

car = TwoTrack(load_vehicle("e_class_suv"))
car.reset(speed_m_s=19.4)
car.step(1000, steer=0.3)
car.state()["vertical_load_fl"]
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from signals.quantities import FileModel
from signals.wheels import WHEELS
from vehicle_model.reference.linear_slope import side_force_slope
from vehicle_model.reference.reference_plant import ReferencePlant
from vehicle_model.reference.two_track_record import PARAMETER_RECORD, STATE_RECORD
from vehicle_model.reference.two_track_step import refresh, two_track_tick
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile


class TwoTrackOptions(FileModel):
    """The two-track car has no numerics to choose: its step is the document's 1 ms."""


class TwoTrack(ReferencePlant):
    """Two-track car (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; a copy is kept.
    road : RoadFile, optional
        Level and dry if left out; a copy is kept.

    Raises
    ------
    InputError
        If the road names an unknown surface.
    """

    sections: ClassVar[tuple[str, ...]] = (
        "body",
        "axles",
        "wheels",
        "suspension",
        "steering",
        "planar",
        "two_track",
        "tyres",
    )

    def __init__(self, vehicle: VehicleFile, road: RoadFile | None = None) -> None:
        super().__init__(vehicle, road, TwoTrackOptions(), PARAMETER_RECORD, STATE_RECORD)

    def _take_memory(self) -> None:
        road = self._road
        self._memory = (
            self._parameters,
            self._state,
            road.record,
            road.jumps,
            road.patches,
            road.points,
            self.outputs,
        )

    def _show(self, time_s: float) -> None:
        refresh(*self._memory)

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``)."""
        two_track_tick(*self._memory, brake_torque, drive_torque, steer, time_s)

    def _write(self, section: str) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        body, given = vehicle.body, vehicle.two_track
        p["mass"], p["yaw_inertia"], p["height"] = body.mass, body.yaw_inertia, body.centre_of_gravity_height
        p["to_front"] = body.centre_of_gravity_to_front_axle
        p["to_rear"] = body.wheelbase - body.centre_of_gravity_to_front_axle
        p["track"] = 0.5 * (vehicle.axles.front.track + vehicle.axles.rear.track)
        p["steering_ratio"], p["steering_offset"] = vehicle.steering.ratio, vehicle.steering.offset
        p["road_roll_moment"] = given.road_roll_moment
        for i, name in enumerate(WHEELS):
            wheel = getattr(vehicle.wheels, name)
            p["wheel_x"][i] = p["to_front"] if i < 2 else -p["to_rear"]
            p["wheel_y"][i] = 0.5 * p["track"] if i % 2 == 0 else -0.5 * p["track"]
            p["radius"][i] = wheel.radius
            p["friction_factor"][i] = wheel.friction_factor
        self._fill_roll_axis()
        self._fill_springs()
        stiffness = given.cornering_stiffness_front, given.cornering_stiffness_rear
        for axle, value in enumerate(stiffness):
            p["cornering_stiffness"][axle] = side_force_slope(vehicle, axle) if value is None else value

    def _fill_roll_axis(self) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        body, given, suspension = vehicle.body, vehicle.two_track, vehicle.suspension
        front_share = p["to_rear"] / body.wheelbase
        wheels = sum(getattr(vehicle.wheels, name).unsprung_mass for name in WHEELS)
        p["sprung_mass"] = body.mass - wheels if given.sprung_mass is None else given.sprung_mass
        heights = suspension.front.roll_centre_height, suspension.rear.roll_centre_height
        axis = front_share * heights[0] + (1.0 - front_share) * heights[1]
        p["roll_centre"] = axis if given.roll_centre_height is None else given.roll_centre_height
        p["roll_arm"] = p["height"] - p["roll_centre"]
        moved = body.roll_inertia + p["sprung_mass"] * p["roll_arm"] ** 2
        p["roll_inertia"] = moved if given.roll_axis_inertia is None else given.roll_axis_inertia
        share = front_share if given.front_roll_share is None else given.front_roll_share
        p["roll_share"] = share, 1.0 - share

    def _fill_springs(self) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        stiffness = damping = 0.0
        for axle in ("front", "rear"):
            springs, track = getattr(vehicle.suspension, axle), getattr(vehicle.axles, axle).track
            stiffness += (0.5 * springs.spring_rate + springs.anti_roll_rate) * track**2
            damping += 0.25 * (springs.compression_damping + springs.rebound_damping) * track**2
        given = vehicle.planar
        p["roll_stiffness"] = stiffness if given.roll_stiffness is None else given.roll_stiffness
        p["roll_damping"] = damping if given.roll_damping is None else given.roll_damping
