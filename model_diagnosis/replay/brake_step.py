"""Wheel brakes of the replay: from the pressure to the torque, as the plant's friction brake, and more effects of it.

M = 2 A mu R p, mu = mu_0 fade(T) (speed)^b, C dT/dt = share M w - (h_0 + h_1 w)(T - T_air).
"""

import math

from numba import njit

from model_diagnosis.replay.lag_step import followed
from model_diagnosis.replay.record import Record

_REFERENCE_SPEED_M_S = 10.0
_SLOWEST_M_S = 0.5
_REFERENCE_PRESSURE_PA = 3e6
_RELEASED_PA = 1e5


@njit(cache=True, nogil=True, error_model="numpy")
def _effective_pressure(p: Record, s: Record, i: int, pressure: float) -> float:
    """Pressure that presses the pads: after the seal's hysteresis, the threshold and the curve of the caliper."""
    if p.hysteresis != 0.0:
        held = s.clamping[i]
        # the torque follows a rising pressure at once and a falling one only beyond the hysteresis
        held = pressure if pressure > held else min(held, pressure + p.hysteresis)
        s.clamping[i] = held
        pressure = held
    effective = max(pressure - p.threshold_pressure[i], 0.0)
    if p.pad_pressure_exponent[i] != 1.0 and effective > 0.0:
        effective *= (effective / _REFERENCE_PRESSURE_PA) ** (p.pad_pressure_exponent[i] - 1.0)
    return effective


@njit(cache=True, nogil=True, error_model="numpy")
def _friction_share(p: Record, s: Record, i: int, omega: float) -> float:
    """Friction of the pads over that of the vehicle file."""
    share = p.brake_factor[i] * s.brake_share[i]
    over = s.disc_temperature[i] - p.fade_temperature[i]
    if p.fade[i] != 0.0 and over > 0.0:
        share *= max(1.0 - p.fade[i] * over, p.fade_floor[i])
    if p.pad_speed_exponent[i] != 0.0:
        speed = max(omega * p.effective_radius[i], _SLOWEST_M_S)
        share *= (speed / _REFERENCE_SPEED_M_S) ** p.pad_speed_exponent[i]
    if p.in_stop_rise != 0.0:
        share *= 1.0 + p.in_stop_rise * s.stop_energy / p.stop_energy
    sine, cosine = p.thickness_variation_sine[i], p.thickness_variation_cosine[i]
    if sine != 0.0 or cosine != 0.0:
        angle = s.disc_angle[i]
        share *= 1.0 + sine * math.sin(angle) + cosine * math.cos(angle)
    return share


@njit(cache=True, nogil=True, error_model="numpy")
def brake_capacity(p: Record, s: Record, i: int, pressure: float, step: float) -> float:
    """Torque [N m] that a wheel brake can transmit; its disc warms up and turns by one step."""
    omega = abs(s.spin[i])
    share = _friction_share(p, s, i, omega)
    torque = p.torque_per_pressure[i] * _effective_pressure(p, s, i, pressure) * share
    if p.caliper_lag != 0.0:
        following = step / (2.0 * p.caliper_lag + step)
        before, target = s.lagged_torque[i], torque
        torque = before + following * (target - before)
        s.lagged_torque[i] = followed(before, target, 0.0, following)
    torque += p.drag_torque[i]
    above = s.disc_temperature[i] - p.ambient_temperature
    cooling = (p.cooling[i] + p.cooling_per_speed[i] * omega) * above
    s.disc_temperature[i] += step * (p.heat_share[i] * torque * omega - cooling) * p.inverse_capacity[i]
    s.disc_angle[i] += step * omega
    return torque


@njit(cache=True, nogil=True, error_model="numpy")
def count_stop_energy(s: Record, step: float) -> None:
    """Energy that the brakes took since they were last released."""
    if (
        s.pressure[0] < _RELEASED_PA
        and s.pressure[1] < _RELEASED_PA
        and s.pressure[2] < _RELEASED_PA
        and s.pressure[3] < _RELEASED_PA
    ):
        s.stop_energy = 0.0
        return
    for i in range(4):
        s.stop_energy += step * s.brake_torque[i] * s.spin[i]
