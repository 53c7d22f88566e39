"""Hydraulic unit, calipers and discs of the hidden car, compiled.

Hydraulics: flow over compliance with first-order valves (friction document 2.6); air by a polytropic bubble; torque and
heat by the usual lumped laws (SAE 740415 for the exponents of speed and pressure).
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hidden_effects.unknown_terms import torque_factor

VALVE_LAG_S = 0.002
RETURN_TIME_S = 0.01
AIR_PRESSURE_PA = 1.013e5
POLYTROPIC = 1.2
AMBIENT_DEGC = 20.0
FULL_ACCUMULATOR_PA = 5e5
REFERENCE_STOP_J = 5e5
"""Energy of a stop from 100 km/h by which the rise of friction within a stop is scaled."""
RELEASED_PA = 3e4
"""Highest pressure of the brakes between two stops, a sensor's noise."""


@njit(cache=True)
def stiffness_of(car: Any, i: int, pressure: float) -> float:
    """Pressure per volume [Pa/m^3] of brake ``i``: of caliper and hoses, softer by a polytropic bubble of air."""
    stiffness = car.caliper_stiffness[i // 2]
    absolute = AIR_PRESSURE_PA + max(pressure, 0.0)
    bubble = stiffness * car.air_volume[i] * AIR_PRESSURE_PA ** (1.0 / POLYTROPIC)
    soft: float = stiffness / (1.0 + bubble / (POLYTROPIC * absolute ** (1.0 / POLYTROPIC + 1.0)))
    return soft


@njit(cache=True)
def wheel_pressure(
    car: Any, i: int, pressure: float, supply: float, low: float, inlet: float, outlet: float, step: float
) -> float:
    """Pressure [Pa] of wheel ``i`` after a step; ``inlet``/``outlet`` are the openings of its valves, 0 to 1."""
    stiffness = car.caliper_stiffness[i // 2]
    rate = inlet * car.inlet_conductance[i] * (supply - pressure) / car.build_time
    rate -= outlet * car.outlet_conductance[i] * (pressure - low) / car.dump_time
    rate -= stiffness * car.brake_leak[i] * pressure
    if pressure > supply:
        rate -= (pressure - supply) / RETURN_TIME_S
    return max(pressure + step * rate * stiffness_of(car, i, pressure) / stiffness, 0.0)


@njit(cache=True)
def piston_pressure(car: Any, piston: float, pressure: float) -> float:
    """Pressure [Pa] at the pads: it follows a rising one and falls only after that fell by ``brake_hysteresis``."""
    return max(min(piston, pressure + car.brake_hysteresis), pressure)


@njit(cache=True)
def brake_torque(
    car: Any,
    i: int,
    piston: float,
    pressure_rate: float,
    spin: float,
    turned: float,
    disc: float,
    stop_energy: float,
    speed: float,
    yaw_rate: float,
) -> float:
    """Torque [N m] that the brake of wheel ``i`` can transmit, drag of the pads included.

    Parameters
    ----------
    turned : rad
        Angle of the wheel since the start.
    disc, stop_energy : degC, J
        Temperature of the disc; energy that the car's brakes took since they were last released.
    """
    acting = max(piston - car.brake_threshold, 0.0)
    gain = car.pad_gain[i] * car.wheel_brake[i]
    gain *= 1.0 + car.balance if i < 2 else 1.0 - car.balance * car.pad_gain[0] / car.pad_gain[2]
    torque = gain * acting
    if acting > 0.0 and car.pad_pressure_exponent != 1.0:
        torque *= (acting / 3e6) ** (car.pad_pressure_exponent - 1.0)
    if car.pad_speed_exponent != 0.0:
        torque *= (max(abs(spin), 0.5) * car.pad_radius / 10.0) ** car.pad_speed_exponent
    torque *= max(1.0 - car.pad_fade * max(disc - car.pad_fade_temperature, 0.0), 0.2)
    torque *= 1.0 + car.in_stop_rise * stop_energy / REFERENCE_STOP_J
    torque *= 1.0 + car.thickness_variation[i] * math.sin(turned + 1.7 * i)
    torque *= torque_factor(car.unknown_kind, car.unknown_size, speed, yaw_rate, piston, pressure_rate)
    return torque + car.drag_torque[i]


@njit(cache=True)
def disc_temperature(car: Any, disc: float, power: float, spin: float, step: float) -> float:
    """Temperature [degC] of a disc after a step in which it took ``power`` [W]: what it took, less Newton's cooling."""
    cooling = (car.disc_cooling + car.disc_cooling_speed * abs(spin)) * (disc - AMBIENT_DEGC)
    return disc + step * (0.9 * power - cooling) / car.disc_heat_capacity


@njit(cache=True)
def released(car: Any, i: int, volumes: NDArray[np.float64], circuit: int, before: float, wanted: float) -> float:
    """Pressure [Pa] of wheel ``i`` whose fluid goes into its circuit's accumulator: no more leaves than has room."""
    stiffness = stiffness_of(car, i, before)
    room = car.accumulator_volume - volumes[circuit]
    taken = min(max(before - wanted, 0.0) / stiffness, max(room, 0.0))
    volumes[circuit] += taken
    return max(wanted, before - taken * stiffness)


@njit(cache=True)
def pump_back(car: Any, volumes: NDArray[np.float64], pump: bool, step: float) -> None:
    """The running pump empties the two circuits' accumulators [m^3]."""
    for circuit in range(2):
        pumped = step * car.pump_flow * car.pump_rate if pump else 0.0
        volumes[circuit] = max(volumes[circuit] - pumped, 0.0)
