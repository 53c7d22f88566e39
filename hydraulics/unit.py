"""The hydraulic unit of a car: parameters by name around the compiled model."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydraulics.parameters import PARAMETERS
from hydraulics.record import PARAMETER_RECORD, fill_record
from hydraulics.selection_logic import LOGICS, SelectionLogic
from hydraulics.state import STATE_RECORD
from hydraulics.tick import (
    AT_INLET,
    AT_OUT,
    AT_OUTLET,
    AT_PARAMETERS,
    AT_STATE,
    AT_WHEEL_SPEED,
    FIRST_ORDER,
    PLACES,
    hydraulics_tick,
)
from signals.catalogue import block_slice
from signals.errors import InputError, unknown_name
from signals.record_memory import numbers_address

STANDSTILL = np.zeros(4)
_OUTPUTS = block_slice("hydraulics").stop - block_slice("hydraulics").start
# other parameters that the course of a segment depends on
_TIME_CONSTANTS = ("_conductance_", ".fluid_temperature", ".laminar_share")
_BY_PATH = {parameter.path: parameter for parameter in PARAMETERS}


class HydraulicUnit:
    """Pressures and torque capacities of four wheel brakes (friction document 2.4.2 and 2.6).

    Parameters
    ----------
    numbers
        Dotted path to SI value; the geometry of the brakes is required, what else is missing takes its default, and
        paths of other parts of the car are ignored.
    selection_logic
        ``"abs"``, ``"esp"`` or a table of one's own.
    brake
        ``"hcu"`` for the pressure model of 2.6, ``"first_order"`` for the brake of eq. 79.

    Raises
    ------
    InputError
        If a required parameter is missing, a value is out of range, or a choice is unknown.

    Attributes
    ----------
    address : int
        Of the memory that `hydraulics.tick.hydraulics_tick` works on, for compiled callers.
    """

    def __init__(
        self,
        numbers: Mapping[str, float],
        selection_logic: str | SelectionLogic = "abs",
        brake: Literal["hcu", "first_order"] = "hcu",
    ) -> None:
        if brake not in ("hcu", "first_order"):
            raise InputError("unknown brake model", found=repr(brake), allowed="hcu, first_order")
        self._values = {
            path: _checked(path, numbers.get(path, parameter.default)) for path, parameter in _BY_PATH.items()
        }
        self._parameters: NDArray[np.void] = np.zeros(1, PARAMETER_RECORD)
        self._state: NDArray[np.void] = np.zeros(1, STATE_RECORD)
        fill_record(self._values, self._parameters)
        self.selection_logic = _logic(selection_logic)
        self._parameters[0]["logic"][:] = self.selection_logic.table.reshape(-1)
        self._addresses = np.zeros(PLACES, np.int64)
        self._addresses[AT_PARAMETERS] = self._parameters.ctypes.data
        self._addresses[AT_STATE] = self._state.ctypes.data
        self._addresses[FIRST_ORDER] = brake == "first_order"
        self.address = int(self._addresses.ctypes.data)
        self._inlet = self._outlet = self._wheel_speed = self._out = np.zeros(0)
        self.reset()

    def reset(self) -> None:
        """Back to the start: no pressure, empty accumulators, discs at their temperature of the start."""
        self._state[:] = np.zeros(1, STATE_RECORD)
        self._state[0]["previous_state"][:] = -1
        self._state[0]["disc_temperature"] = self._parameters[0]["disc_start_temperature"]

    def tick(
        self,
        master_pressure_pa: float,
        valve_inlet: NDArray[np.float64],
        valve_outlet: NDArray[np.float64],
        pump: float,
        out: NDArray[np.float64],
        wheel_speed: NDArray[np.float64] = STANDSTILL,
    ) -> None:
        """Advance by 1 ms.

        Parameters
        ----------
        master_pressure_pa
            The driver's pressure.
        valve_inlet, valve_outlet : shape (4,)
            1 where the valve is energised: inlet closed, outlet open.
        pump
            1 while the return pump is commanded.
        out : shape (18,)
            Block "hydraulics" of the signal catalogue; ``hydraulic_state`` is 3 where the valves' combination is
            invalid and the pressure is therefore held.
        wheel_speed : shape (4,), rad/s
            Heats the discs and counts where the torque depends on it.
        """
        if (
            valve_inlet is not self._inlet
            or valve_outlet is not self._outlet
            or wheel_speed is not self._wheel_speed
            or out is not self._out
        ):
            self.bind(valve_inlet, valve_outlet, wheel_speed, out)
        hydraulics_tick(self.address, master_pressure_pa, pump)

    def bind(
        self,
        inlet: NDArray[np.float64],
        outlet: NDArray[np.float64],
        wheel_speed: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> None:
        """Use these arrays from now on: the same come tick by tick, so their addresses are kept."""
        self._addresses[AT_INLET] = numbers_address(inlet, 4)
        self._addresses[AT_OUTLET] = numbers_address(outlet, 4)
        self._addresses[AT_WHEEL_SPEED] = numbers_address(wheel_speed, 4)
        self._addresses[AT_OUT] = numbers_address(out, _OUTPUTS)
        self._inlet, self._outlet, self._wheel_speed, self._out = inlet, outlet, wheel_speed, out

    def names(self) -> tuple[str, ...]:
        """Dotted paths of all parameters."""
        return tuple(self._values)

    def get(self, path: str) -> float:
        """Value of a parameter, SI.

        Raises
        ------
        InputError
            If there is no such parameter.
        """
        if path not in self._values:
            raise unknown_name("parameter of the hydraulic unit", path, self.names())
        return self._values[path]

    def set(self, path: str, value: float) -> None:
        """Change a parameter while the unit runs; pressures go on from where they are.

        Raises
        ------
        InputError
            If there is no such parameter or the value is out of its range.
        """
        before = self.get(path)
        checked = _checked(path, value)
        if checked == before:
            return
        self._values[path] = checked
        fill_record(self._values, self._parameters)
        if path.endswith("_time_constant") or any(part in path for part in _TIME_CONSTANTS):
            # the running segments go on from their pressures; no other parameter is part of a segment's course
            self._state[0]["rearm"] = 1

    @property
    def wheel_pressure_pa(self) -> NDArray[np.float64]:
        """Copy of the four wheel pressures, Pa."""
        return np.array(self._state[0]["pressure"])

    @property
    def accumulator_volume_m3(self) -> NDArray[np.float64]:
        """Fluid in the accumulators of both circuits (front left with rear right, front right with rear left), m^3."""
        return np.array(self._state[0]["accumulator"])

    @property
    def pumped_volume_m3(self) -> NDArray[np.float64]:
        """Fluid that the pump has taken out of both accumulators since the start, m^3."""
        return np.array(self._state[0]["pumped"])

    @property
    def invalid_steps(self) -> NDArray[np.int64]:
        """Steps with an invalid combination of valves since the start, per wheel."""
        return np.array(self._state[0]["invalid_steps"])


def _logic(choice: str | SelectionLogic) -> SelectionLogic:
    if isinstance(choice, SelectionLogic):
        return choice
    if choice not in LOGICS:
        raise unknown_name("selection logic", choice, tuple(LOGICS))
    return LOGICS[choice]()


def _checked(path: str, value: float | None) -> float:
    parameter = _BY_PATH[path]
    if value is None:
        raise InputError(f"{path} is missing: {parameter.description}, in {parameter.unit}")
    if not parameter.low <= value <= parameter.high:
        allowed = f"{parameter.low:g} to {parameter.high:g} {parameter.unit}"
        raise InputError(f"{path} is out of range", found=f"{value:g}", allowed=allowed)
    return float(value)
