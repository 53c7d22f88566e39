"""Wheel brakes of the replay: from the pressure to the torque, as the plant's friction brake, and more effects of it.

M = 2 A mu R p, mu = mu_0 fade(T) (speed)^b, C dT/dt = share M w - (h_0 + h_1 w)(T - T_air).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.record import Record
from model_diagnosis.replay.state import (
    BRAKE_TORQUE,
    CLAMPING,
    DISC_ANGLE,
    DISC_TEMPERATURE,
    LAGGED_TORQUE,
    SPIN,
    STOP_ENERGY,
)

_REFERENCE_SPEED_M_S = 10.0
_SLOWEST_M_S = 0.5
_REFERENCE_PRESSURE_PA = 3e6
_RELEASED_PA = 1e5


@njit(cache=True, nogil=True)
def _effective_pressure(p: Record, wheels: NDArray[np.float64], i: int, pressure: float) -> float:
    """Pressure that presses the pads: after the seal's hysteresis, the threshold and the curve of the caliper."""
    if p.hysteresis != 0.0:
        held = wheels[CLAMPING, i]
        # the torque follows a rising pressure at once and a falling one only beyond the hysteresis
        held = pressure if pressure > held else min(held, pressure + p.hysteresis)
        wheels[CLAMPING, i] = held
        pressure = held
    effective = max(pressure - p.threshold_pressure[i], 0.0)
    if p.pad_pressure_exponent != 1.0 and effective > 0.0:
        effective *= (effective / _REFERENCE_PRESSURE_PA) ** (p.pad_pressure_exponent - 1.0)
    return effective


@njit(cache=True, nogil=True)
def _friction_share(p: Record, wheels: NDArray[np.float64], body: NDArray[np.float64], i: int, omega: float) -> float:
    """Friction of the pads over that of the vehicle file."""
    share = p.brake_factor[i]
    over = wheels[DISC_TEMPERATURE, i] - p.fade_temperature[i]
    if p.fade[i] != 0.0 and over > 0.0:
        share *= max(1.0 - p.fade[i] * over, p.fade_floor[i])
    if p.pad_speed_exponent != 0.0:
        speed = max(omega * p.effective_radius[i], _SLOWEST_M_S)
        share *= (speed / _REFERENCE_SPEED_M_S) ** p.pad_speed_exponent
    if p.in_stop_rise != 0.0:
        share *= 1.0 + p.in_stop_rise * body[STOP_ENERGY] / p.stop_energy
    sine, cosine = p.thickness_variation_sine[i], p.thickness_variation_cosine[i]
    if sine != 0.0 or cosine != 0.0:
        angle = wheels[DISC_ANGLE, i]
        share *= 1.0 + sine * math.sin(angle) + cosine * math.cos(angle)
    return share


@njit(cache=True, nogil=True)
def brake_capacity(
    p: Record, body: NDArray[np.float64], wheels: NDArray[np.float64], i: int, pressure: float, step: float
) -> float:
    """Torque [N m] that a wheel brake can transmit; its disc warms up and turns by one step."""
    omega = abs(wheels[SPIN, i])
    share = _friction_share(p, wheels, body, i, omega)
    torque = p.torque_per_pressure[i] * _effective_pressure(p, wheels, i, pressure) * share
    lagged = (p.caliper_lag * wheels[LAGGED_TORQUE, i] + step * torque) / (p.caliper_lag + step)
    wheels[LAGGED_TORQUE, i] = lagged
    torque = lagged + p.drag_torque[i]
    above = wheels[DISC_TEMPERATURE, i] - p.ambient_temperature
    cooling = (p.cooling[i] + p.cooling_per_speed[i] * omega) * above
    wheels[DISC_TEMPERATURE, i] += step * (p.heat_share[i] * torque * omega - cooling) / p.heat_capacity[i]
    wheels[DISC_ANGLE, i] += step * omega
    return torque


@njit(cache=True, nogil=True)
def count_stop_energy(
    body: NDArray[np.float64], wheels: NDArray[np.float64], inputs: NDArray[np.float64], step: float
) -> None:
    """Energy that the brakes took since they were last released."""
    if inputs[0] < _RELEASED_PA and inputs[1] < _RELEASED_PA and inputs[2] < _RELEASED_PA and inputs[3] < _RELEASED_PA:
        body[STOP_ENERGY] = 0.0
        return
    for i in range(4):
        body[STOP_ENERGY] += step * wheels[BRAKE_TORQUE, i] * wheels[SPIN, i]
