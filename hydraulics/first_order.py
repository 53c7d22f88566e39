"""Brake of eq. 79: first-order pressure with a hydraulic delay, modulated by the same valves."""

from typing import Any

import numpy as np
from numba import njit

from hydraulics.pressure import line_pressure, low_pressure, run_pump, softened, wheel_mode, write_outputs
from hydraulics.record import DECREASE, HOLD, INCREASE, INVALID, LONGEST_DELAY_STEPS, STEP_S
from hydraulics.valves import flow_factor, leak, remember_inputs, take_up


@njit(cache=True)
def _delayed_master(parameters: Any, state: Any) -> float:
    """p_0(t) = integral of the demanded gradient up to t - t_D, which is the master pressure t_D ago."""
    steps = parameters.delay / STEP_S
    whole = int(np.floor(steps))
    part = steps - whole
    newer = state.master_history[(state.position - whole) % LONGEST_DELAY_STEPS]
    older = state.master_history[(state.position - whole - 1) % LONGEST_DELAY_STEPS]
    return float(newer + part * (older - newer))


@njit(cache=True)
def _approach(pressure: float, goal_before: float, goal: float, time_constant: float) -> float:
    """Exact step of tau dp/dt + p = goal for a goal that moves linearly within the step."""
    kept = np.exp(-STEP_S / time_constant)
    ramp = 1.0 - time_constant / STEP_S * (1.0 - kept)
    return float(kept * pressure + (1.0 - kept) * goal_before + (goal - goal_before) * ramp)


@njit(cache=True)
def first_order_step(
    parameters: Any,
    state: Any,
    inlet: Any,
    outlet: Any,
    wheel_speed: Any,
    out: Any,
    master_pressure: float,
    pump_on: float,
) -> None:
    """One step of the brake tau_b dp/dt + p = p_0 (Enisz 2015, eq. 79); arguments as in ``pressure.hcu_step``.

    p_0 is what can be reached; closed inlet valves keep the pressure, open outlet valves let it fall to the low
    pressure with the same time constant.
    """
    remember_inputs(state, inlet, outlet, master_pressure)
    pump = run_pump(parameters, state, pump_on)
    before, supply = state.delayed_supply, _delayed_master(parameters, state)
    for wheel in range(4):
        mode = wheel_mode(parameters, state, wheel, pump, out)
        pressure = state.pressure[wheel]
        low = low_pressure(parameters, state, wheel, pump)
        line = line_pressure(parameters, wheel, supply)
        if mode in (DECREASE, INVALID):
            time_constant = parameters.first_order_time_constant * flow_factor(parameters, wheel, DECREASE)
            wanted = softened(parameters, state, wheel, _approach(pressure, low, low, time_constant))
            pressure = take_up(parameters, state, wheel, wanted)
            state.pressure[wheel] = pressure
        if mode in (INCREASE, INVALID) or (mode == HOLD and line < pressure):
            time_constant = parameters.first_order_time_constant * flow_factor(parameters, wheel, INCREASE)
            wanted = _approach(pressure, line_pressure(parameters, wheel, before), line, time_constant)
            pressure = softened(parameters, state, wheel, wanted)
        state.pressure[wheel] = max(leak(parameters, state, wheel, pressure, line, low), 0.0)
    state.delayed_supply = supply
    write_outputs(parameters, state, master_pressure, wheel_speed, out)
