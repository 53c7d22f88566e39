"""Memory of faults: present while seen, stored until healed as the table of faults says."""

from typing import Any

import numpy as np
from numba import njit

from bench.ecu.faults import FAULTS
from bench.ecu.records import FAULT_CODES, TASK_S

NOT_STORED, STORED, TO_BE_PROVEN = range(3)
"""A stored fault of a sensor becomes one to be proven at key-on: a healthy drive then clears it."""

_NEEDS_KEY_ON = np.zeros(FAULT_CODES, np.int64)
for _fault in FAULTS.values():
    _NEEDS_KEY_ON[_fault.code] = _fault.healing == "key-on and healthy drive"


@njit(cache=True)
def set_fault(state: Any, code: int, present: bool) -> None:
    """Note whether the condition of a fault holds in this task."""
    state.fault_present[code] = 1 if present else 0


@njit(cache=True)
def forget_at_key_on(state: Any) -> None:
    """Stored faults of sensors have to be proven gone by driving."""
    for code in range(FAULT_CODES):
        if state.fault_stored[code] == STORED:
            state.fault_stored[code] = TO_BE_PROVEN
    state.healthy_tasks = 0


@njit(cache=True)
def forget_messages(state: Any) -> None:
    """Clear what a sleeping bus explains: faults of messages, and which of them were ever heard."""
    for code in range(FAULT_CODES):
        if not _NEEDS_KEY_ON[code]:
            state.fault_present[code], state.fault_stored[code] = 0, NOT_STORED
    state.seen[:] = 0
    state.rejected_run[:] = 0
    state.first_fault = 0


@njit(cache=True)
def heal_after_healthy_drive(calibration: Any, state: Any) -> None:
    """Clear stored faults after an unbraked drive above the healing speed without any fault present."""
    healthy = not state.braking and state.slowest_wheel > calibration.monitoring_healing_speed
    for code in range(FAULT_CODES):
        if state.fault_present[code]:
            healthy = False
    state.healthy_tasks = state.healthy_tasks + 1 if healthy else 0
    if state.healthy_tasks * TASK_S <= calibration.monitoring_healing_time:
        return
    for code in range(FAULT_CODES):
        if state.fault_stored[code] == TO_BE_PROVEN or not _NEEDS_KEY_ON[code]:
            state.fault_stored[code] = NOT_STORED


@njit(cache=True)
def store_and_select(state: Any) -> None:
    """Store what is present; the reported code is the first that occurred and is still active."""
    lowest = 0
    for code in range(FAULT_CODES - 1, 0, -1):
        if state.fault_present[code]:
            state.fault_stored[code] = STORED
        if state.fault_stored[code]:
            lowest = code
    if state.first_fault == 0 or not state.fault_stored[state.first_fault]:
        state.first_fault = lowest
