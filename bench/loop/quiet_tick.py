"""What a tick does to the car and the bus while nobody steps in between its parts, compiled into one call.

The parts' own compiled steps in the parts' own order: a run that takes this way now and then, and one that never does,
agree bit for bit. A dozen calls from Python cost more than what they do, hence this one.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.codec.codec import Receiver, Transmitter
from bench.codec.kernels import receive, transmit
from bench.links.frame import frames_address
from bench.loop.bus_load import BusLoad, bus_load
from hydraulics import HydraulicUnit
from hydraulics.tick import hydraulics_tick
from signals.catalogue import index_of
from signals.record_memory import addresses_at, addresses_of, numbers_at
from signals.vector import SignalVector
from vehicle_model import plant as mujoco_plant
from vehicle_model.driver import driver_step
from vehicle_model.interface import Plant
from vehicle_model.manoeuvre import Manoeuvre
from vehicle_model.plant_step import advance
from vehicle_model.powertrain import Powertrain, powertrain_step
from vehicle_model.sensors import Sensors
from vehicle_model.sensors_step import sensors_step

AT_VALUES, AT_DRIVER, AT_POWERTRAIN, AT_HYDRAULICS, AT_PLANT, AT_SENSORS = range(6)
AT_TRANSMITTER, AT_TAP, AT_LOAD, AT_RECEIVED, AT_DUE = range(6, 11)
PLACES = 11

_ACCELERATOR, _CLUTCH, _GEAR = index_of("driver_accelerator"), index_of("driver_clutch"), index_of("driver_gear")
_MASTER_PRESSURE, _PUMP = index_of("driver_master_pressure"), index_of("pump")
_STEERING, _BUS_LOAD = index_of("driver_steering_wheel_angle"), index_of("bus_load")


@njit(cache=True)
def before_plant(memory: int, time: float) -> None:
    """Driver, powertrain, hydraulics."""
    places: Any = addresses_at(memory)
    values = numbers_at(places[AT_VALUES])
    driver_step(places[AT_DRIVER], time)
    powertrain_step(places[AT_POWERTRAIN], values[_ACCELERATOR], values[_CLUTCH], values[_GEAR])
    hydraulics_tick(places[AT_HYDRAULICS], values[_MASTER_PRESSURE], values[_PUMP])


@njit(cache=True)
def after_plant(memory: int, tick: int, time: float, received_count: int) -> int:
    """Sensors, frames that are due, tap, bus load; returns the number of frames that are due."""
    places: Any = addresses_at(memory)
    sensors_step(places[AT_SENSORS], time)
    due = transmit(places[AT_TRANSMITTER], places[AT_DUE], 0, tick)
    receive(places[AT_TAP], places[AT_DUE], due, tick)
    load = bus_load(places[AT_LOAD], places[AT_RECEIVED], received_count, places[AT_DUE], due)
    numbers_at(places[AT_VALUES])[_BUS_LOAD] = load
    return int(due)


@njit(cache=True)
def car_tick(memory: int, time: float) -> None:
    """Hydraulics, MuJoCo car and sensors alone: no driver, no powertrain, no bus."""
    places: Any = addresses_at(memory)
    values = numbers_at(places[AT_VALUES])
    hydraulics_tick(places[AT_HYDRAULICS], values[_MASTER_PRESSURE], values[_PUMP])
    advance(places[AT_PLANT], values[_STEERING], time, 1)
    sensors_step(places[AT_SENSORS], time)


@njit(cache=True)
def mujoco_tick(memory: int, tick: int, time: float, received_count: int) -> int:
    """All of it with the MuJoCo car."""
    places: Any = addresses_at(memory)
    before_plant(memory, time)
    advance(places[AT_PLANT], numbers_at(places[AT_VALUES])[_STEERING], time, 1)
    return int(after_plant(memory, tick, time, received_count))


class Car:
    """Hydraulic unit, MuJoCo car and sensors of a signal vector, one call per tick; nothing drives it.

    Parameters
    ----------
    vector, sensed
        Signal vector, and the layout of block "bus" that the sensors write. Master pressure, valves, pump, drive
        torques and steering-wheel angle are read from the vector.
    """

    def __init__(
        self,
        vector: SignalVector,
        sensed: NDArray[np.float64],
        hydraulic_unit: HydraulicUnit,
        plant: mujoco_plant.Plant,
        sensors: Sensors,
    ) -> None:
        self._kept = vector, sensed, hydraulic_unit, plant
        self._sensors = sensors
        self._places = _places(vector, sensed, hydraulic_unit, plant, sensors)
        self._memory = int(self._places.ctypes.data)

    def tick(self, time_s: float) -> None:
        """Advance by 1 ms."""
        self._sensors.draw()
        car_tick(self._memory, time_s)


class QuietTick:
    """Driver, powertrain, hydraulics, plant, sensors, transmitter, tap and bus load of a run as one call.

    Parameters
    ----------
    vector, sensed
        Signal vector of the run and what the bench is about to send; everything else already writes into them.
    received, due : frame records
        Frames that came in this tick; frames to send, filled in here.
    """

    def __init__(
        self,
        vector: SignalVector,
        sensed: NDArray[np.float64],
        *,
        manoeuvre: Manoeuvre,
        powertrain: Powertrain,
        hydraulic_unit: HydraulicUnit,
        plant: Plant,
        sensors: Sensors,
        transmitter: Transmitter,
        tap: Receiver,
        bus_load: BusLoad,
        received: NDArray[np.void],
        due: NDArray[np.void],
    ) -> None:
        self._kept = (vector, sensed, manoeuvre, powertrain, hydraulic_unit, transmitter, tap, bus_load, received, due)
        self._values, self._plant, self._sensors = vector.values, plant, sensors
        self._brake, self._drive = _four(vector, "brake_torque_capacity_fl"), _four(vector, "drive_torque_demand_fl")
        self._places = _places(vector, sensed, hydraulic_unit, plant, sensors)
        powertrain.bind(_four(vector, "true_wheel_speed_fl"), vector.block("powertrain"))
        self._places[[AT_DRIVER, AT_POWERTRAIN]] = manoeuvre.address, powertrain.address
        self._places[[AT_TRANSMITTER, AT_TAP, AT_LOAD]] = transmitter.address, tap.address, bus_load.address
        self._places[[AT_RECEIVED, AT_DUE]] = frames_address(received), frames_address(due)
        self._memory = int(self._places.ctypes.data)
        self._in_one = isinstance(plant, mujoco_plant.Plant)

    def tick(self, tick: int, time_s: float, received_count: int) -> int:
        """Advance by 1 ms; returns the number of frames that are due."""
        self._sensors.draw()
        count: int
        if self._in_one:
            count = mujoco_tick(self._memory, tick, time_s, received_count)
            return count
        before_plant(self._memory, time_s)
        self._plant.tick(self._brake, self._drive, self._values[_STEERING], time_s)
        count = after_plant(self._memory, tick, time_s, received_count)
        return count


def _four(vector: SignalVector, first: str) -> NDArray[np.float64]:
    return vector.values[vector.index(first) : vector.index(first) + 4]


def _places(
    vector: SignalVector,
    sensed: NDArray[np.float64],
    hydraulic_unit: HydraulicUnit,
    plant: Plant,
    sensors: Sensors,
) -> NDArray[np.int64]:
    """List of addresses with those of the car's parts, which are bound to the vector."""
    valves = _four(vector, "valve_inlet_fl"), _four(vector, "valve_outlet_fl")
    hydraulic_unit.bind(*valves, _four(vector, "true_wheel_speed_fl"), vector.block("hydraulics"))
    sensors.bind(vector.values, sensed)
    places = np.zeros(PLACES, np.int64)
    places[AT_VALUES] = addresses_of(vector.values)[0]
    places[[AT_HYDRAULICS, AT_SENSORS]] = hydraulic_unit.address, sensors.address
    if isinstance(plant, mujoco_plant.Plant):
        plant.bind_torques(_four(vector, "brake_torque_capacity_fl"), _four(vector, "drive_torque_demand_fl"))
        places[AT_PLANT] = plant.address
    return places
