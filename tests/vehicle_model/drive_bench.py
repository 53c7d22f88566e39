"""A car, its powertrain and its driver in the order of a tick, without ECU, hydraulics and sensors."""

from collections.abc import Callable
from typing import Any

import numpy as np

from signals.vector import SignalVector
from signals.yaml_files import parse_yaml, validate
from vehicle_model.manoeuvre import Manoeuvre
from vehicle_model.manoeuvre_file import ManoeuvreFile
from vehicle_model.powertrain import Powertrain
from vehicle_model.reference.single_track import SingleTrack
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

TORQUE_PER_PRESSURE = np.array([13.0, 13.0, 6.5, 6.5]) / 1e5  # N m/Pa per wheel, friction document 2.4.2


def manoeuvre_of(text: str) -> ManoeuvreFile:
    return validate(parse_yaml(text, "manoeuvre.yaml"), ManoeuvreFile)


class Drive:
    """Runs a manoeuvre tick by tick.

    Attributes
    ----------
    vector
        Signals of the run.
    begins
        Time at which each phase began.
    gears
        (time, gear) at each change of gear.
    """

    def __init__(
        self,
        manoeuvre: str | ManoeuvreFile,
        *,
        vehicle: VehicleFile | None = None,
        road: RoadFile | None = None,
        speed_m_s: float = 0.0,
        plant: Any = SingleTrack,
    ) -> None:
        vehicle = vehicle or load_vehicle("ekf_car")
        file = manoeuvre_of(manoeuvre) if isinstance(manoeuvre, str) else manoeuvre
        self.vector = SignalVector()
        self.plant = plant(vehicle, road or RoadFile())
        self.plant.bind(self.vector.block("plant"))
        self.plant.reset(speed_m_s=speed_m_s)
        self.driver = Manoeuvre(file, self.vector, vehicle)
        self.powertrain = Powertrain(vehicle)
        self.brake_torque = np.zeros(4)
        self.begins: dict[str, float] = {}
        self.gears: list[tuple[float, int]] = []
        self.tick_number = 0

    def __getitem__(self, name: str) -> float:
        return self.vector[name]

    @property
    def time(self) -> float:
        return self.tick_number * 1e-3

    def tick(self) -> None:
        vector, values, index = self.vector, self.vector.values, self.vector.index
        values[index("time")] = self.time
        self.driver.tick(self.time)
        wheels = slice(index("true_wheel_speed_fl"), index("true_wheel_speed_fl") + 4)
        self.powertrain.tick(
            self["driver_accelerator"],
            self["driver_clutch"],
            self["driver_gear"],
            values[wheels],
            vector.block("powertrain"),
        )
        self.brake_torque[:] = TORQUE_PER_PRESSURE * self["driver_master_pressure"]
        drive = slice(index("drive_torque_demand_fl"), index("drive_torque_demand_fl") + 4)
        self.plant.tick(self.brake_torque, values[drive], self["driver_steering_wheel_angle"], self.time)
        self.begins.setdefault(self.driver.phase, self.time)
        gear = int(self["driver_gear"])
        if not self.gears or self.gears[-1][1] != gear:
            self.gears.append((self.time, gear))
        self.tick_number += 1

    def run(self, duration_s: float, look: Callable[["Drive"], None] | None = None) -> "Drive":
        """Advance until the manoeuvre has finished, at most ``duration_s``; ``look`` is called after each tick."""
        for _ in range(round(duration_s * 1000)):
            self.tick()
            if look is not None:
                look(self)
            if self.driver.finished:
                break
        return self
