"""The controller's 5 ms task: decoded signals in, valve commands and status out."""

from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.ecu.calibration import CalibrationFile, load_calibration
from bench.ecu.coordination import (
    assess_wheels,
    control_slip,
    delay_yaw_moment,
    distribute,
    rest_valves,
    run_pump,
)
from bench.ecu.monitoring import watch_inputs
from bench.ecu.pressure_estimate import estimate_pressures
from bench.ecu.records import (
    BRAKE,
    PRESENT,
    STATE_RECORD,
    bus_position,
    calibration_record,
)
from bench.ecu.reference_speed import choose_underbraked_wheel, update_reference
from bench.ecu.wheel_speed import measure_wheels

_INLET = bus_position("valve_inlet_fl")
_OUTLET = bus_position("valve_outlet_fl")
_PUMP = bus_position("pump")
_ABS = bus_position("abs_active")
_LAMP = bus_position("abs_lamp")
_EBD = bus_position("ebd_active")
_FAULT = bus_position("ecu_fault_code")
_REFERENCE = bus_position("ecu_reference_speed")
_PHASE = bus_position("ecu_phase_fl")
_MASTER = bus_position("master_pressure")
_SWITCH = bus_position("brake_switch")

ASSUMED_MASTER_PRESSURE_PA = 1e7


@njit(cache=True)
def _read_brake(calibration: Any, state: Any, values: Any, health: Any) -> None:
    if not health[BRAKE, PRESENT]:
        # a bus that does not carry the brake: always ready, at a pressure that an emergency stop has
        state.master_pressure, state.braking = ASSUMED_MASTER_PRESSURE_PA, 1
        return
    state.master_pressure = max(values[_MASTER], 0.0)
    pressed = values[_SWITCH] > 0.5 or state.master_pressure > calibration.limits_braking_pressure
    state.braking = 1 if pressed else 0


@njit(cache=True)
def _regulate(calibration: Any, state: Any) -> None:
    """Slip control where a wheel needs it, brake-force distribution else, plain braking where neither may act."""
    may_control = state.abs_available and state.braking and state.reference >= calibration.limits_cut_out_speed
    if not may_control:
        state.abs_active = 0
    needed = assess_wheels(calibration, state)
    if may_control and needed and state.reference >= calibration.limits_cut_in_speed:
        state.abs_active = 1
    if state.abs_active:
        state.ebd_active = 0
        choose_underbraked_wheel(calibration, state)
        control_slip(calibration, state)
        delay_yaw_moment(calibration, state)
        return
    rest_valves(state, state.ebd_available and state.braking)
    if state.ebd_available and state.braking:
        distribute(calibration, state)


@njit(cache=True)
def _write_command(calibration: Any, state: Any, command: Any) -> None:
    for wheel in range(4):
        command[_INLET + wheel] = state.inlet[wheel]
        command[_OUTLET + wheel] = state.outlet[wheel]
        command[_PHASE + wheel] = state.phase[wheel]
    command[_PUMP] = 1.0 if run_pump(calibration, state) else 0.0
    command[_ABS] = state.abs_active
    command[_LAMP] = state.lamp
    command[_EBD] = state.ebd_active
    command[_FAULT] = state.first_fault
    command[_REFERENCE] = state.reference


@njit(cache=True)
def controller_task(
    calibration_record: Any, state_record: Any, values: Any, health: Any, command: Any, with_edges: bool
) -> None:
    """One 5 ms task.

    Parameters
    ----------
    calibration_record, state_record : shape (1,), dtypes of ``bench.ecu.records``
    values : decoded signals, layout of block "bus"
    health : int64, shape (sources, 4)
        Age in ticks, refused frames so far, period in ticks and presence of each source.
    command : layout of block "bus"; the ECU's own signals are written
    with_edges : False where the bus has no pulse counters
    """
    calibration, state = calibration_record[0], state_record[0]
    estimate_pressures(calibration, state)
    _read_brake(calibration, state, values, health)
    measure_wheels(calibration, state, values, health, with_edges)
    watch_inputs(calibration, state, values, health, with_edges)
    update_reference(calibration, state, values)
    _regulate(calibration, state)
    _write_command(calibration, state, command)


class Controller:
    """The emulated ECU's controller.

    Parameters
    ----------
    calibration
        Name of a shipped calibration, a path, or a calibration.
    with_edges
        False where the bus has no pulse counters.
    watch_timeouts
        False lets any message be missing for ever without a fault.
    """

    def __init__(
        self, calibration: str | Path | CalibrationFile, *, with_edges: bool = True, watch_timeouts: bool = True
    ) -> None:
        loaded = calibration if isinstance(calibration, CalibrationFile) else load_calibration(calibration)
        self.calibration = loaded
        self._record = calibration_record(loaded)
        if not watch_timeouts:
            self._record["monitoring_timeout_periods"] = np.inf
        self._state: NDArray[np.void] = np.zeros(1, STATE_RECORD)
        self._with_edges = with_edges
        self.reset()

    def reset(self) -> None:
        """As after power-on."""
        self._state[:] = np.zeros(1, STATE_RECORD)
        state = self._state[0]
        state["underbraked_wheel"], state["next_underbraked"] = -1, 2
        state["wheel_valid"][:] = 1

    @property
    def records(self) -> tuple[NDArray[np.void], NDArray[np.void]]:
        """Calibration and memory, as ``controller_task`` takes them."""
        return self._record, self._state

    def stored_faults(self) -> list[int]:
        """Codes in the fault memory, present or not yet healed; see :mod:`bench.ecu.faults`."""
        return [int(code) for code in np.flatnonzero(self._state[0]["fault_stored"])]

    def task(self, values: NDArray[np.float64], health: NDArray[np.int64], command: NDArray[np.float64]) -> None:
        """Run the 5 ms task; arguments as in ``controller_task``."""
        controller_task(self._record, self._state, values, health, command, self._with_edges)
