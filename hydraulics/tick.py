"""One tick of either brake model, its records by their addresses."""

from typing import Any

from numba import carray, njit

from hydraulics.first_order import first_order_step
from hydraulics.pressure import hcu_step
from hydraulics.record import PARAMETER_RECORD
from hydraulics.state import STATE_RECORD
from signals.record_memory import pointer


@njit(cache=True)
def hcu_tick(
    records: Any, inlet: Any, outlet: Any, wheel_speed: Any, out: Any, master_pressure: float, pump_on: float
) -> None:
    """`pressure.hcu_step` with the addresses of its two records (shape (2,))."""
    parameters = carray(pointer(records[0]), 1, PARAMETER_RECORD)
    state = carray(pointer(records[1]), 1, STATE_RECORD)
    hcu_step(parameters, state, inlet, outlet, wheel_speed, out, master_pressure, pump_on)


@njit(cache=True)
def first_order_tick(
    records: Any, inlet: Any, outlet: Any, wheel_speed: Any, out: Any, master_pressure: float, pump_on: float
) -> None:
    """`first_order.first_order_step` with the addresses of its two records (shape (2,))."""
    parameters = carray(pointer(records[0]), 1, PARAMETER_RECORD)
    state = carray(pointer(records[1]), 1, STATE_RECORD)
    first_order_step(parameters, state, inlet, outlet, wheel_speed, out, master_pressure, pump_on)
