"""The longitudinal single-track car that the friction document defines (2.4 and 2.5), as a plant.

car = SingleTrack(load_vehicle("ekf_car"))
car.reset(speed_m_s=26.4)
car.step(1000, brake_torque=1500.0)
car.state()["speed"]

Both wheels of an axle share the axle's state: inertia and torques are the axle's sums (2.4.3). Rolling resistance is a
force on the car, C_roll m g cos(gamma) (eq. 27), as in the filter that the document builds on this model.
"""

import numpy as np
from numpy.typing import NDArray

from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS
from vehicle_model.reference.axle_scaling import axle_inertia
from vehicle_model.reference.reference_plant import EnergyAccount
from vehicle_model.reference.single_track_record import PARAMETER_RECORD, STATE_RECORD
from vehicle_model.reference.single_track_step import refresh, single_track_tick
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres.coefficients import TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PREPARED_SIZE
from vehicle_model.vehicle_file import VehicleFile

SECTIONS = ("body", "axles", "wheels", "steering", "aerodynamics", "tyres")


class SingleTrackOptions(FileModel):
    """Numerics of the single-track car."""

    substeps: int = parameter("1", 5, low=5, high=1000, description="integration steps per millisecond")


class SingleTrack(EnergyAccount):
    """Longitudinal single-track car (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; a copy is kept.
    road : RoadFile, optional
        Level and dry if left out; a copy is kept.
    substeps : int
        Integration steps per millisecond, at least 5 (friction document 1.8).

    Raises
    ------
    InputError
        If the road names an unknown surface.
    """

    sections = SECTIONS

    _options: SingleTrackOptions

    def __init__(self, vehicle: VehicleFile, road: RoadFile | None = None, *, substeps: int = 5) -> None:
        super().__init__(vehicle, road, SingleTrackOptions(substeps=substeps), PARAMETER_RECORD, STATE_RECORD)

    def _allocate(self) -> None:
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
            self.outputs,
        )

    def _show(self, time_s: float) -> None:
        refresh(*self._memory, self._drive, time_s)

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``); the steering-wheel angle has no effect."""
        single_track_tick(*self._memory, brake_torque, drive_torque, time_s)

    def _write(self, section: str) -> None:
        # the record is small: all of it, whatever the section
        vehicle, p = self._vehicle, self._parameters[0]
        body, air = vehicle.body, vehicle.aerodynamics
        wheels = [getattr(vehicle.wheels, name) for name in WHEELS]
        p["substeps"] = self._options.substeps
        p["mass"], p["wheelbase"] = body.mass, body.wheelbase
        p["to_front"], p["height"] = body.centre_of_gravity_to_front_axle, body.centre_of_gravity_height
        p["drag"] = 0.5 * air.air_density * air.drag_coefficient * air.frontal_area
        p["drag_height"] = air.drag_height
        p["rolling"] = sum(wheel.rolling_resistance for wheel in wheels) / 4.0
        p["half_track"] = 0.5 * vehicle.axles.front.track, 0.5 * vehicle.axles.rear.track
        p["friction_factor"] = [wheel.friction_factor for wheel in wheels]
        pair = vehicle.tyre_pair
        for axle, tyre in enumerate((pair.front, pair.rear)):
            left, right = wheels[2 * axle], wheels[2 * axle + 1]
            p["radius"][axle] = 0.5 * (left.radius + right.radius)
            p["inertia"][axle] = axle_inertia(left.inertia, right.inertia)
            contact = tyre.contact
            p["contact_stiffness"][axle] = 2.0 * contact.longitudinal_stiffness
            p["contact_damping"][axle] = 2.0 * contact.damping
            p["full_below"][axle], p["none_above"][axle] = contact.full_below, contact.none_above
            for row in self._tyres[2 * axle : 2 * axle + 2]:
                write_tyre(tyre, row, right=False)
