"""One tick of either brake model, everything that it reads and writes by address."""

from typing import Any

from numba import njit

from hydraulics.first_order import first_order_step
from hydraulics.pressure import hcu_step
from hydraulics.record import PARAMETER_RECORD
from hydraulics.state import STATE_RECORD
from signals.record_memory import addresses_at, numbers_at, record_at

AT_PARAMETERS, AT_STATE, AT_INLET, AT_OUTLET, AT_WHEEL_SPEED, AT_OUT, FIRST_ORDER = range(7)
"""Places in the list of addresses: two records, then arrays of float64; last, 1 for the brake of eq. 79."""
PLACES = 7


@njit(cache=True)
def hydraulics_tick(memory: int, master_pressure: float, pump_on: float) -> None:
    """`pressure.hcu_step` or `first_order.first_order_step` on what the list of addresses at ``memory`` names."""
    places: Any = addresses_at(memory)
    parameters = record_at(places[AT_PARAMETERS], PARAMETER_RECORD)
    state = record_at(places[AT_STATE], STATE_RECORD)
    inlet, outlet = numbers_at(places[AT_INLET]), numbers_at(places[AT_OUTLET])
    wheel_speed, out = numbers_at(places[AT_WHEEL_SPEED]), numbers_at(places[AT_OUT])
    if places[FIRST_ORDER] != 0:
        first_order_step(parameters, state, inlet, outlet, wheel_speed, out, master_pressure, pump_on)
    else:
        hcu_step(parameters, state, inlet, outlet, wheel_speed, out, master_pressure, pump_on)
