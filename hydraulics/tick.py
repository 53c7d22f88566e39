"""One tick of either brake model, everything that it reads and writes by address."""

from typing import Any

from numba import njit

from hydraulics.first_order import first_order_step
from hydraulics.pressure import hcu_step
from hydraulics.record import PARAMETER_RECORD
from hydraulics.state import STATE_RECORD
from signals.record_memory import addresses_at, numbers_at, record_at

AT_PARAMETERS, AT_STATE, AT_INLET, AT_OUTLET, AT_WHEEL_SPEED, AT_OUT = range(6)
"""Places in the list of addresses: two records, then arrays of float64."""
ADDRESSES = 6


@njit(cache=True)
def hcu_tick(memory: int, master_pressure: float, pump_on: float) -> None:
    """`pressure.hcu_step` with its records and arrays from the list of addresses at ``memory``."""
    places: Any = addresses_at(memory)
    hcu_step(
        record_at(places[AT_PARAMETERS], PARAMETER_RECORD),
        record_at(places[AT_STATE], STATE_RECORD),
        numbers_at(places[AT_INLET]),
        numbers_at(places[AT_OUTLET]),
        numbers_at(places[AT_WHEEL_SPEED]),
        numbers_at(places[AT_OUT]),
        master_pressure,
        pump_on,
    )


@njit(cache=True)
def first_order_tick(memory: int, master_pressure: float, pump_on: float) -> None:
    """`first_order.first_order_step` with its records and arrays from the list of addresses at ``memory``."""
    places: Any = addresses_at(memory)
    first_order_step(
        record_at(places[AT_PARAMETERS], PARAMETER_RECORD),
        record_at(places[AT_STATE], STATE_RECORD),
        numbers_at(places[AT_INLET]),
        numbers_at(places[AT_OUTLET]),
        numbers_at(places[AT_WHEEL_SPEED]),
        numbers_at(places[AT_OUT]),
        master_pressure,
        pump_on,
    )
