"""Wheel pressures: exponential segments that are re-armed at events (eqs 106-115, friction document 2.6.2)."""

from typing import Any

import numpy as np
from numba import njit

from hydraulics.fluid import stiffness_share
from hydraulics.friction_brake import brake_torque
from hydraulics.record import DECREASE, HOLD, INCREASE, INVALID, STEP_S
from hydraulics.selection_logic import TARGET_PUMP
from hydraulics.valves import (
    accumulator_pressure,
    circuit_of,
    flow_factor,
    inlet_closed,
    leak,
    outlet_open,
    pump_back,
    remember_inputs,
    take_up,
)


@njit(cache=True, forceinline=True)
def select(parameters: Any, inlet: int, outlet: int, pump: int) -> tuple[int, int]:
    """State and kind of target that the selection logic gives."""
    active = 1 if parameters.active_build_up > 0.5 else 0
    entry = 2 * (8 * inlet + 4 * outlet + 2 * pump + active)
    return int(parameters.logic[entry]), int(parameters.logic[entry + 1])


@njit(cache=True, forceinline=True)
def supply_pressure(parameters: Any, pump: int, master_pressure: float) -> float:
    """Pressure that both circuits get: the driver's, or the pump's during active build-up if that is higher."""
    _, target = select(parameters, 0, 0, pump)
    return max(master_pressure, float(parameters.pump_pressure)) if target == TARGET_PUMP else master_pressure


@njit(cache=True, forceinline=True)
def line_pressure(parameters: Any, wheel: int, supply: float) -> float:
    """Pressure in front of a wheel's inlet valve: the supply, less what a failed circuit loses."""
    return float(supply * (1.0 - parameters.circuit_failure[circuit_of(parameters, wheel)]))


@njit(cache=True, forceinline=True)
def low_pressure(parameters: Any, state: Any, wheel: int, pump: int) -> float:
    """Pressure behind the wheel's outlet valve: a running pump leaves a share of the accumulator's, as a rule none."""
    if pump and parameters.pump_back_pressure == 0.0:
        return 0.0
    share = float(parameters.pump_back_pressure) if pump else 1.0
    return share * accumulator_pressure(parameters, state, circuit_of(parameters, wheel))


@njit(cache=True, forceinline=True)
def _supply_changed(parameters: Any, state: Any, wheel: int, mode: int, supply: float) -> bool:
    """Step 1 (eqs 107-108): has the supply moved since the last time it was noted?"""
    if mode != INCREASE or abs(supply - state.supply_start[wheel]) < parameters.threshold:
        return False
    state.supply_start[wheel] = supply
    return True


@njit(cache=True, forceinline=True)
def _events(parameters: Any, state: Any, wheel: int, mode: int, goal: float, changed: bool) -> tuple[bool, bool]:
    """Whether the segment's time restarts, and whether target and difference are set anew."""
    differs = mode != state.previous_state[wheel]
    near = abs(state.pressure[wheel] - goal) <= parameters.threshold
    if parameters.literal_event > 0.5:
        return differs and (changed or near), differs and changed
    event = differs or changed or state.rearm != 0
    if mode == INCREASE and parameters.rearm_near_target > 0.5 and near:
        event = True
    # the pump was switched or the accumulator filled: what is behind the outlet valve is another pressure now
    if mode == DECREASE and abs(goal - state.target[wheel]) >= max(parameters.threshold, 1.0):
        event = True
    return event, event


@njit(cache=True, forceinline=True)
def _follow_segment(parameters: Any, state: Any, wheel: int, mode: int, goal: float) -> float:
    """Steps 1 to 5: pressure of one wheel after this step, before the limits of valves and accumulator."""
    changed = _supply_changed(parameters, state, wheel, mode, goal)
    restart, retarget = _events(parameters, state, wheel, mode, goal, changed)

    continued = state.segment_time[wheel] + STEP_S
    elapsed = STEP_S if restart else continued
    if retarget:
        if mode == HOLD:
            before = max(state.previous_state[wheel], 0)
            before = HOLD if before == INVALID else before
            running = parameters.time_constant[before] * flow_factor(parameters, wheel, before)
            state.target[wheel] -= state.difference[wheel] * np.exp(-continued / running)
        else:
            state.target[wheel] = goal
        state.difference[wheel] = state.target[wheel] - state.pressure[wheel]
    state.segment_time[wheel] = elapsed
    if state.difference[wheel] == 0.0:  # at rest: no exponential
        return float(state.target[wheel])
    time_constant = parameters.time_constant[mode] * flow_factor(parameters, wheel, mode)
    return float(state.target[wheel] - state.difference[wheel] * np.exp(-elapsed / time_constant))


@njit(cache=True, forceinline=True)
def _continue_from(state: Any, wheel: int, mode: int, pressure: float) -> None:
    """Let the running segment go on from a pressure that a limit has set."""
    if mode == HOLD:
        state.target[wheel] = pressure
    state.difference[wheel] = state.target[wheel] - pressure
    state.segment_time[wheel] = 0.0


@njit(cache=True, forceinline=True)
def softened(parameters: Any, state: Any, wheel: int, wanted: float) -> float:
    """Pressure after a step in which the flow would reach ``wanted`` without air in the wheel brake."""
    before = state.pressure[wheel]
    if parameters.air_volume[wheel] == 0.0 or wanted == before:
        return wanted
    share = stiffness_share(parameters, wheel, before)
    middle = before + 0.5 * share * (wanted - before)  # gas stiffens a lot within a step
    return float(before + stiffness_share(parameters, wheel, middle) * (wanted - before))


@njit(cache=True, forceinline=True)
def _flow_through(parameters: Any, state: Any, wheel: int, line: float, low: float) -> None:
    """Both valves open: fluid comes in from the line and leaves to the accumulator, each by its own valve."""
    before = float(state.pressure[wheel])
    filling = parameters.time_constant[INCREASE] * flow_factor(parameters, wheel, INCREASE)
    emptying = parameters.time_constant[DECREASE] * flow_factor(parameters, wheel, DECREASE)
    filled = softened(parameters, state, wheel, line - (line - before) * np.exp(-STEP_S / filling))
    emptied = softened(parameters, state, wheel, low - (low - before) * np.exp(-STEP_S / emptying))
    pressure = filled - before + take_up(parameters, state, wheel, emptied)
    pressure = leak(parameters, state, wheel, pressure, line, low)
    state.pressure[wheel] = max(min(pressure, line), 0.0)
    # whatever comes next begins at rest
    state.target[wheel], state.difference[wheel], state.segment_time[wheel] = state.pressure[wheel], 0.0, 0.0
    state.previous_state[wheel] = INVALID


@njit(cache=True, forceinline=True)
def _wheel_step(parameters: Any, state: Any, wheel: int, mode: int, line: float, low: float) -> None:
    if mode == INVALID:
        _flow_through(parameters, state, wheel, line, low)
        return
    goal = low if mode == DECREASE else line
    wanted = _follow_segment(parameters, state, wheel, mode, goal)

    pressure = softened(parameters, state, wheel, wanted)
    if mode == DECREASE:
        pressure = take_up(parameters, state, wheel, pressure)
    pressure = leak(parameters, state, wheel, pressure, line, low)
    # check valve beside the inlet valve: fluid flows back as soon as the line pressure is the lower one
    pressure = max(min(pressure, line), 0.0)
    if pressure != wanted:
        _continue_from(state, wheel, mode, pressure)
    state.pressure[wheel] = pressure
    state.previous_state[wheel] = mode


@njit(cache=True, forceinline=True)
def write_outputs(parameters: Any, state: Any, master_pressure: float, wheel_speed: Any, out: Any) -> None:
    """Brake torques; fill the block "hydraulics" of the catalogue, the states of the selection logic excepted."""
    out[0] = master_pressure
    for wheel in range(4):
        out[1 + wheel] = state.pressure[wheel]
        out[10 + wheel] = brake_torque(parameters, state, wheel, wheel_speed[wheel])
        out[14 + wheel] = state.disc_temperature[wheel]
    worst = max(state.accumulator[0], state.accumulator[1])
    out[9] = parameters.accumulator_pressure * worst / parameters.accumulator_volume


@njit(cache=True, forceinline=True)
def wheel_mode(parameters: Any, state: Any, wheel: int, pump: int, out: Any) -> int:
    """What the selection logic makes of a wheel's valves.

    An invalid combination is reported, and held unless the unit lets fluid flow through both valves.
    """
    mode, _ = select(parameters, inlet_closed(parameters, state, wheel), outlet_open(parameters, state, wheel), pump)
    out[5 + wheel] = mode
    if mode == INVALID:
        state.invalid_steps[wheel] += 1
        return INVALID if parameters.flow_through > 0.5 else HOLD
    return int(mode)


@njit(cache=True, forceinline=True)
def run_pump(parameters: Any, state: Any, pump_on: float) -> int:
    """1 if the return pump runs in this step; it then empties the accumulators."""
    if pump_on <= 0.5 or parameters.pump_failure > 0.5 or parameters.pump_rate == 0.0:
        return 0
    pump_back(parameters, state)
    return 1


@njit(cache=True, forceinline=True)
def pressure_step(
    parameters: Any, state: Any, inlet: Any, outlet: Any, out: Any, master_pressure: float, pump_on: float
) -> None:
    """One step of the four wheel pressures, without torques and heat; arguments as in ``hcu_step``.

    Of ``out`` the states of the selection logic are filled.
    """
    remember_inputs(state, inlet, outlet, master_pressure)
    pump = run_pump(parameters, state, pump_on)
    supply = supply_pressure(parameters, pump, master_pressure)
    for wheel in range(4):
        mode = wheel_mode(parameters, state, wheel, pump, out)
        line = line_pressure(parameters, wheel, supply)
        _wheel_step(parameters, state, wheel, mode, line, low_pressure(parameters, state, wheel, pump))
    state.rearm = 0


@njit(cache=True, forceinline=True)
def hcu_step(
    parameters: Any,
    state: Any,
    inlet: Any,
    outlet: Any,
    wheel_speed: Any,
    out: Any,
    master_pressure: float,
    pump_on: float,
) -> None:
    """One step of the hydraulic unit for four wheels.

    Parameters
    ----------
    parameters, state : records of ``PARAMETER_RECORD`` and ``STATE_RECORD``
    inlet, outlet : shape (4,), 1 where the valve is energised
    wheel_speed : shape (4,), rad/s
    out : shape (18,), block "hydraulics" of the catalogue
    master_pressure : Pa
    pump_on : above 0.5 while the pump is commanded
    """
    pressure_step(parameters, state, inlet, outlet, out, master_pressure, pump_on)
    write_outputs(parameters, state, master_pressure, wheel_speed, out)
