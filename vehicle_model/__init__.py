"""The car and its road: files, parameters, plants, tyres, powertrain, driver and sensors.

from vehicle_model import Plant, load_road, load_vehicle

car = Plant(load_vehicle("ekf_car"), load_road("dry"))
car.reset(speed_m_s=25.0)
car.step(1000, brake_torque=1500.0)
car.state()["speed"]
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from signals.compile_cache import prepare_compile_cache

prepare_compile_cache()

if TYPE_CHECKING:
    from vehicle_model.plant import Plant
    from vehicle_model.road_file import RoadFile, load_road
    from vehicle_model.vehicle_file import VehicleFile, load_vehicle, parameter_table, set_parameter

__all__ = ["Plant", "RoadFile", "VehicleFile", "load_road", "load_vehicle", "parameter_table", "set_parameter"]

_HOME = {
    "Plant": "plant",
    "RoadFile": "road_file",
    "load_road": "road_file",
    "VehicleFile": "vehicle_file",
    "load_vehicle": "vehicle_file",
    "parameter_table": "vehicle_file",
    "set_parameter": "vehicle_file",
}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"vehicle_model.{_HOME[name]}"), name)
    raise AttributeError(f"module 'vehicle_model' has no attribute {name!r}")
