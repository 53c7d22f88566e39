"""Valves, return pump and low-pressure accumulators of the two brake circuits."""

from typing import Any

from numba import njit

from hydraulics.fluid import stiffness_share
from hydraulics.record import DECREASE, INCREASE, LONGEST_DELAY_STEPS, STEP_S

STUCK_OPEN = 1.0


@njit(cache=True, forceinline=True)
def circuit_of(parameters: Any, wheel: int) -> int:
    """Brake circuit of a wheel: diagonal, front left with rear right, or front and rear."""
    if parameters.front_rear_split != 0:
        return 0 if wheel < 2 else 1
    return 0 if wheel in (0, 3) else 1


@njit(cache=True, forceinline=True)
def flow_factor(parameters: Any, wheel: int, mode: int) -> float:
    """Factor on a time constant: cold fluid flows slowly, and so does fluid through a valve of small conductance."""
    if mode == INCREASE:
        return float(parameters.flow_resistance / parameters.inlet_conductance[wheel])
    if mode == DECREASE:
        return float(parameters.flow_resistance / parameters.outlet_conductance[wheel])
    return 1.0


@njit(cache=True, forceinline=True)
def stiffness(parameters: Any, wheel: int, pressure: float) -> float:
    """Pressure per volume [Pa/m^3] of a wheel brake, air included."""
    return float(parameters.caliper_stiffness[wheel] * stiffness_share(parameters, wheel, pressure))


@njit(cache=True, forceinline=True)
def remember_inputs(state: Any, inlet: Any, outlet: Any, master_pressure: float) -> None:
    """Store the commands and the master pressure of this step in the delay lines."""
    position = (state.position + 1) % LONGEST_DELAY_STEPS
    state.position = position
    state.master_history[position] = master_pressure
    for wheel in range(4):
        state.inlet_history[position, wheel] = inlet[wheel]
        state.outlet_history[position, wheel] = outlet[wheel]


@njit(cache=True, forceinline=True)
def inlet_closed(parameters: Any, state: Any, wheel: int) -> int:
    """1 if the inlet valve is closed, after its dead time and its fault."""
    stuck = parameters.inlet_stuck[wheel]
    if stuck > 0.5:
        return 0 if stuck < STUCK_OPEN + 0.5 else 1
    position = (state.position - parameters.inlet_delay[wheel]) % LONGEST_DELAY_STEPS
    return 1 if state.inlet_history[position, wheel] > 0.5 else 0


@njit(cache=True, forceinline=True)
def outlet_open(parameters: Any, state: Any, wheel: int) -> int:
    """1 if the outlet valve is open, after its dead time and its fault."""
    stuck = parameters.outlet_stuck[wheel]
    if stuck > 0.5:
        return 1 if stuck < STUCK_OPEN + 0.5 else 0
    position = (state.position - parameters.outlet_delay[wheel]) % LONGEST_DELAY_STEPS
    return 1 if state.outlet_history[position, wheel] > 0.5 else 0


@njit(cache=True, forceinline=True)
def pump_back(parameters: Any, state: Any) -> None:
    """Return pump: empties both accumulators for one step."""
    for circuit in range(2):
        volume = min(state.accumulator[circuit], parameters.pump_flow * parameters.pump_rate * STEP_S)
        state.accumulator[circuit] -= volume
        state.pumped[circuit] += volume


@njit(cache=True, forceinline=True)
def accumulator_pressure(parameters: Any, state: Any, circuit: int) -> float:
    """Pressure of a circuit's accumulator: a spring, 0 when empty."""
    return float(parameters.accumulator_pressure * state.accumulator[circuit] / parameters.accumulator_volume)


@njit(cache=True, forceinline=True)
def take_up(parameters: Any, state: Any, wheel: int, wanted: float) -> float:
    """Move the fluid of a pressure drop into the accumulator.

    Returns
    -------
    float
        The pressure that the accumulator's free volume allows, Pa. Fluid never flows back through the outlet valve.
    """
    pressure = float(state.pressure[wheel])
    if wanted >= pressure:
        return pressure
    circuit = circuit_of(parameters, wheel)
    per_volume = stiffness(parameters, wheel, pressure)
    room = _room(parameters, state, circuit)
    volume = min((pressure - wanted) / per_volume, room)
    state.accumulator[circuit] += volume
    return wanted if volume < room else max(wanted, float(pressure - volume * per_volume))


@njit(cache=True, forceinline=True)
def _room(parameters: Any, state: Any, circuit: int) -> float:
    """Volume that a circuit's accumulator can still take."""
    capacity = parameters.accumulator_volume * (1.0 - parameters.accumulator_blocked[circuit])
    return max(capacity - state.accumulator[circuit], 0.0)


@njit(cache=True, forceinline=True)
def leak(parameters: Any, state: Any, wheel: int, pressure: float, line: float, low: float) -> float:
    """Pressure after the leaks of a step: past the inlet valve, past the outlet valve, out of the wheel brake."""
    inlet, outlet, out = parameters.inlet_leak[wheel], parameters.outlet_leak[wheel], parameters.brake_leak[wheel]
    if inlet == 0.0 and outlet == 0.0 and out == 0.0:
        return pressure
    gained = STEP_S * (inlet * (line - pressure) - out * pressure)
    released = 0.0
    if outlet != 0.0:
        circuit = circuit_of(parameters, wheel)
        released = min(STEP_S * outlet * max(pressure - low, 0.0), _room(parameters, state, circuit))
        state.accumulator[circuit] += released
    if gained == released:
        return pressure
    return max(pressure + stiffness(parameters, wheel, pressure) * (gained - released), 0.0)
