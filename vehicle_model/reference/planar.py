"""The planar car that the vehicle-state document defines (its section 2), as a plant.

car = Planar(load_vehicle("lada_vesta_assumed_steering"))
car.reset(speed_m_s=15.0)
car.step(1000, drive_torque=[100.0, 100.0, 0.0, 0.0], steer=0.3)
car.state()["lateral_speed"]

Body in the plane of the road, one sprung mass that pitches and rolls, four spinning wheels; tyre forces of pure slip.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS
from vehicle_model.reference.planar_record import PARAMETER_RECORD, STATE_RECORD
from vehicle_model.reference.planar_step import planar_tick, refresh
from vehicle_model.reference.reference_plant import EnergyAccount
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres.coefficients import TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PREPARED_SIZE
from vehicle_model.vehicle_file import VehicleFile


class PlanarOptions(FileModel):
    """Numerics and variants of the planar car."""

    substeps: int = parameter("1", 10, low=1, high=1000, description="integration steps per millisecond; 10: 0.1 ms")
    roll_dynamics: int = parameter(
        "1", 1, low=0, high=1, description="1: wheel loads follow the body's roll (listings); 0: at once (eq. 3.2)"
    )
    slowest: float = parameter(
        "m/s",
        0.3,
        low=0.05,
        high=2.0,
        description="smallest speed in the divisors of slip and slip angle, which are not defined at standstill",
    )


class Planar(EnergyAccount):
    """Planar car (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; a copy is kept. It has to have a steering map.
    road : RoadFile, optional
        Level and dry if left out; a copy is kept.
    substeps, roll_dynamics
        See :class:`PlanarOptions`.

    Raises
    ------
    InputError
        If the vehicle has no steering map, or the road names an unknown surface.
    """

    sections: ClassVar[tuple[str, ...]] = (
        "body",
        "axles",
        "wheels",
        "suspension",
        "steering",
        "aerodynamics",
        "planar",
        "tyres",
    )

    def __init__(
        self, vehicle: VehicleFile, road: RoadFile | None = None, *, substeps: int = 10, roll_dynamics: int = 1
    ) -> None:
        self._numerics = PlanarOptions(substeps=substeps, roll_dynamics=roll_dynamics)
        super().__init__(vehicle, road, self._numerics, PARAMETER_RECORD, STATE_RECORD)

    def _allocate(self) -> None:
        steering_map = self._vehicle.steering.map
        if steering_map is None:
            raise InputError(
                "steering.map: missing; the planar car takes the road-wheel angles from it",
                found=f"vehicle {self._vehicle.name!r} without a map",
                mend="give steering.map with steering_wheel_angle, left and right, or take a car that has one "
                "(lada_vesta_assumed_steering)",
            )
        self._steering = np.zeros((3, len(steering_map.steering_wheel_angle)))
        self._tyres = np.zeros((4, TYRE_SIZE))
        self._prepared = np.zeros((4, PREPARED_SIZE))

    def _take_memory(self) -> None:
        road = self._road
        self._memory = (
            self._parameters,
            self._state,
            self._tyres,
            self._prepared,
            road.record,
            road.jumps,
            road.patches,
            road.points,
            road.surfaces,
            self._steering,
            self.outputs,
        )

    def _show(self, time_s: float) -> None:
        refresh(*self._memory, self._drive, time_s)

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``)."""
        planar_tick(*self._memory, brake_torque, drive_torque, steer, time_s)

    def _write(self, section: str) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        body, air, options = vehicle.body, vehicle.aerodynamics, self._numerics
        p["substeps"], p["roll_dynamics"], p["slowest"] = options.substeps, options.roll_dynamics, options.slowest
        p["mass"], p["height"] = body.mass, body.centre_of_gravity_height
        p["yaw_inertia"], p["pitch_inertia"], p["roll_inertia"] = (
            body.yaw_inertia,
            body.pitch_inertia,
            body.roll_inertia,
        )
        p["to_front"] = body.centre_of_gravity_to_front_axle
        p["to_rear"] = body.wheelbase - body.centre_of_gravity_to_front_axle
        p["drag"] = 0.5 * air.air_density * air.drag_coefficient * air.frontal_area
        p["drag_height"] = air.drag_height
        p["rolling_speed_factor"] = vehicle.planar.rolling_resistance_speed_factor
        self._fill_body_springs()
        pair = vehicle.tyre_pair
        for i, name in enumerate(WHEELS):
            wheel = getattr(vehicle.wheels, name)
            track = vehicle.axles.front.track if i < 2 else vehicle.axles.rear.track
            p["wheel_x"][i] = p["to_front"] if i < 2 else -p["to_rear"]
            p["wheel_y"][i] = 0.5 * track if i % 2 == 0 else -0.5 * track
            p["radius"][i], p["inertia"][i] = wheel.radius, wheel.inertia
            p["rolling"][i], p["friction_factor"][i] = wheel.rolling_resistance, wheel.friction_factor
            write_tyre(pair.front if i < 2 else pair.rear, self._tyres[i], right=i % 2 == 1)
        p["map_points"] = self._steering.shape[1]
        steering = vehicle.steering
        if steering.map is not None:
            angles = steering.map.left, steering.map.right
            self._steering[0], self._steering[1:] = steering.map.steering_wheel_angle, angles
            self._steering[1:] += steering.offset

    def _fill_body_springs(self) -> None:
        vehicle, p = self._vehicle, self._parameters[0]
        pitch_stiffness = pitch_damping = roll_stiffness = roll_damping = 0.0
        for axle, arm in (("front", p["to_front"]), ("rear", p["to_rear"])):
            springs, track = getattr(vehicle.suspension, axle), getattr(vehicle.axles, axle).track
            damping = 0.5 * (springs.compression_damping + springs.rebound_damping)
            pitch_stiffness += 2.0 * springs.spring_rate * arm**2
            pitch_damping += 2.0 * damping * arm**2
            roll_stiffness += (0.5 * springs.spring_rate + springs.anti_roll_rate) * track**2
            roll_damping += 0.5 * damping * track**2
        given = vehicle.planar
        p["pitch_stiffness"] = pitch_stiffness if given.pitch_stiffness is None else given.pitch_stiffness
        p["pitch_damping"] = pitch_damping if given.pitch_damping is None else given.pitch_damping
        p["roll_stiffness"] = roll_stiffness if given.roll_stiffness is None else given.roll_stiffness
        p["roll_damping"] = roll_damping if given.roll_damping is None else given.roll_damping
