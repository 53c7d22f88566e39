"""The MuJoCo car: 16 degrees of freedom, one compiled call per millisecond.

car = Plant(load_vehicle("ekf_car"), load_road("dry"))
car.reset(speed_m_s=25.0)
car.step(1000, brake_torque=1500.0)
car.state()["speed"]
car.set("road.friction", 0.5)
"""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from signals.errors import InputError
from signals.record_memory import numbers_address
from vehicle_model.body_forces import steering_angle
from vehicle_model.equilibrium import solve_equilibrium
from vehicle_model.extension_terms import new_terms, write_terms
from vehicle_model.guidance import guidance
from vehicle_model.interface import PLANT_OUTPUTS, TIME_STEP_S
from vehicle_model.mjcf import build_model, write_bodies, write_slides
from vehicle_model.plant_access import PlantAccess
from vehicle_model.plant_parameters import (
    GUIDANCE_SECTIONS,
    ONLY_WHEN_BUILT,
    RIGID_BODY_SECTIONS,
    SECTIONS,
    STEERING_AND_AIR_SECTIONS,
    WHEEL_NUMBERS,
    PlantOptions,
    copy_of,
    write_guidance,
    write_masses,
    write_numerics,
    write_steering_and_air,
    write_suspension,
    write_tyres,
    write_wheel_number,
    write_wheels,
)
from vehicle_model.plant_record import (
    PARAMETER_RECORD,
    POSITION_STEER,
    STATE_RECORD,
    VELOCITY_SPIN,
)
from vehicle_model.plant_step import ADDRESS_NAMES, advance, refresh, support_forces
from vehicle_model.rigid_bodies import RigidBodies, rigid_bodies
from vehicle_model.road import RoadTables
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres.coefficients import TYRE_SIZE
from vehicle_model.tyres.kernel import PREPARED_SIZE
from vehicle_model.vehicle_file import VehicleFile

_BRAKE_PLACE, _DRIVE_PLACE = ADDRESS_NAMES.index("brake"), ADDRESS_NAMES.index("drive")


class Plant(PlantAccess):
    """A car on a road (see ``vehicle_model.interface.Plant`` for what every plant offers).

    Parameters
    ----------
    vehicle : VehicleFile
        As ``load_vehicle`` gives it; a copy is kept.
    road : RoadFile, optional
        Level and dry if left out; a copy is kept.
    wheel_substeps : int
        Steps of the wheels' spin per integration step.
    steps_per_tick : int
        Integration steps of the car per millisecond.

    Raises
    ------
    InputError
        If the masses and inertias are those of no car, or the road names an unknown surface.

    Attributes
    ----------
    address : int
        Of the memory that `plant_step.advance` works on, for compiled callers.
    """

    time_step_s = TIME_STEP_S
    sections = SECTIONS
    only_when_built = ONLY_WHEN_BUILT

    def __init__(
        self,
        vehicle: VehicleFile,
        road: RoadFile | None = None,
        *,
        wheel_substeps: int = 5,
        steps_per_tick: int = 1,
    ) -> None:
        self._vehicle = copy_of(vehicle)
        self._at_rest = copy_of(vehicle)
        self._numbers = self._rigid_body_numbers()
        self._numbers_at_rest = dict(self._numbers)
        self._options: PlantOptions = PlantOptions(steps_per_tick=steps_per_tick, wheel_substeps=wheel_substeps)
        self._terms = new_terms()
        self._road = RoadTables(road or RoadFile())
        self._parameters = np.zeros(1, PARAMETER_RECORD)
        self._state = np.zeros(1, STATE_RECORD)
        self._tyres = np.zeros((4, TYRE_SIZE))
        self._prepared = np.zeros((4, PREPARED_SIZE))
        self._brake, self._drive = np.zeros(4), np.zeros(4)
        self._brake_in, self._drive_in = self._brake, self._drive
        self._time_s = 0.0
        self._model = build_model(self._bodies(), TIME_STEP_S / steps_per_tick)
        self._data, self._scratch = mujoco.MjData(self._model), mujoco.MjData(self._model)
        for section in (*SECTIONS, "plant"):
            self._write(section)
        self.outputs = np.zeros(len(PLANT_OUTPUTS))
        self._addresses = np.zeros(len(ADDRESS_NAMES), np.int64)
        self.address = int(self._addresses.ctypes.data)
        self._take_addresses()
        self.reset(speed_m_s=0.0)

    def _rigid_body_numbers(self) -> dict[str, float]:
        sections = {*RIGID_BODY_SECTIONS, *GUIDANCE_SECTIONS}
        return {path: value for section in sections for path, value in self._vehicle.numbers(section).items()}

    def _bodies(self) -> RigidBodies:
        return rigid_bodies(self._numbers, self._numbers_at_rest)

    def _write_changed(self, path: str) -> None:
        before = self._numbers.get(path)
        if before is not None:
            self._numbers[path] = self.get(path)
        section, _, rest = path.partition(".")
        wheel, _, name = rest.partition(".")
        if section == "wheels" and name in WHEEL_NUMBERS:
            write_wheel_number(self._parameters, wheel, name, self._numbers[path])
            return
        try:
            self._write(section)
        except InputError:
            if before is not None:
                self._numbers[path] = before
            raise

    def _write(self, section: str) -> None:
        """Bring the compiled step's memory up to date after a change in a section of the parameters."""
        if section == "tyres":
            write_tyres(self._parameters, self._tyres, self._vehicle)
            return
        if section == "terms":
            write_terms(self._parameters, self._terms, self._vehicle)
            return
        if section == "plant":
            write_numerics(self._parameters, self._options)
            self._model.opt.timestep = TIME_STEP_S / self._options.steps_per_tick
            return
        if section in GUIDANCE_SECTIONS:
            guided = guidance(self._numbers)
            write_slides(self._model, guided.slides)
            write_guidance(self._parameters, guided)
        if section in RIGID_BODY_SECTIONS:
            bodies = self._bodies()
            write_bodies(self._model, self._scratch, bodies)
            write_masses(self._parameters, self._vehicle, self._at_rest, bodies)
        if section == "wheels":
            write_wheels(self._parameters, self._vehicle, self._at_rest)
        elif section == "suspension":
            write_suspension(self._parameters, self._vehicle)
        if section in STEERING_AND_AIR_SECTIONS:
            write_steering_and_air(self._parameters, self._vehicle)

    def _take_addresses(self) -> None:
        memory: dict[str, NDArray[Any]] = {
            "positions": self._data.qpos,
            "velocities": self._data.qvel,
            "forces": self._data.qfrc_applied,
            "gravity": self._model.opt.gravity,
            "parameters": self._parameters,
            "state": self._state,
            "tyres": self._tyres,
            "prepared": self._prepared,
            "road": self._road.record,
            "jumps": self._road.jumps,
            "patches": self._road.patches,
            "points": self._road.points,
            "surfaces": self._road.surfaces,
            "heights": self._road.heights,
            "outputs": self.outputs,
            "terms": self._terms,
            "brake": self._brake_in,
            "drive": self._drive_in,
        }
        addresses = {name: array.ctypes.data for name, array in memory.items()}
        addresses |= {"model": self._model._address, "data": self._data._address}
        self._addresses[:] = [addresses[name] for name in ADDRESS_NAMES]

    def bind_torques(self, brake: NDArray[np.float64], drive: NDArray[np.float64]) -> None:
        """Read the torques from these arrays from now on: the same come tick by tick, so their addresses are kept."""
        places = numbers_address(brake, 4), numbers_address(drive, 4)
        self._addresses[_BRAKE_PLACE], self._addresses[_DRIVE_PLACE] = places
        self._brake_in, self._drive_in = brake, drive

    def bind(self, view: NDArray[np.float64]) -> None:
        """Write the outputs into ``view`` (block "plant" of a signal vector) from now on."""
        numbers_address(view, len(PLANT_OUTPUTS))
        view[:] = self.outputs
        self.outputs = view
        self._take_addresses()

    def reset(
        self,
        *,
        speed_m_s: float,
        position_x_m: float = 0.0,
        position_y_m: float = 0.0,
        yaw_angle_rad: float = 0.0,
        time_s: float = 0.0,
    ) -> None:
        """Static equilibrium, moving at ``speed_m_s`` along the heading with freely rolling wheels."""
        mujoco.mj_resetData(self._model, self._data)
        self._state[:] = np.zeros(1, STATE_RECORD)
        self._terms["memory"] = 0.0
        self._parameters["radius"] = self._parameters["nominal_radius"]
        self._time_s = time_s
        q, v = self._data.qpos, self._data.qvel
        q[:3] = position_x_m, position_y_m, self._parameters["height"][0]
        for wheel, place in enumerate(POSITION_STEER):
            q[place] = steering_angle(self._parameters[0], wheel, 0.0)
        self._state["yaw"] = yaw_angle_rad
        solve_equilibrium(self._model, self._data, lambda: support_forces(self.address, 0.0, time_s), yaw_angle_rad)
        mujoco.mj_forward(self._model, self._data)
        self._data.qfrc_applied[:] = 0.0
        v[0], v[1] = speed_m_s * np.cos(yaw_angle_rad), speed_m_s * np.sin(yaw_angle_rad)
        for wheel, place in enumerate(VELOCITY_SPIN):
            v[place] = speed_m_s / self._parameters["radius"][0, wheel]
        refresh(self.address, time_s)

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms (see ``vehicle_model.interface.Plant.tick``)."""
        if brake_torque is not self._brake_in or drive_torque is not self._drive_in:
            self.bind_torques(brake_torque, drive_torque)
        advance(self.address, steer, time_s, 1)

    def step(self, n: int, *, brake_torque: ArrayLike = 0.0, drive_torque: ArrayLike = 0.0, steer: float = 0.0) -> None:
        """Advance by ``n`` milliseconds with constant inputs; torques are one number or one per wheel [N m]."""
        self._brake[:] = brake_torque
        self._drive[:] = drive_torque
        self.bind_torques(self._brake, self._drive)
        advance(self.address, steer, self._time_s, n)
        self._time_s += n * TIME_STEP_S

    def energy_account(self) -> dict[str, float]:
        """Energies since the reset [J]: what brakes, tyres, rolling, dampers and air took, and what the drive gave."""
        kinds = ("brake_energy", "tyre_energy", "rolling_energy", "damper_energy", "air_energy", "drive_energy")
        return {kind: float(self._state[kind][0]) for kind in kinds}
