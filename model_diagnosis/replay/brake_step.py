"""Wheel brakes of the replay: from the pressure to the torque, as the plant's friction brake, and more effects of it.

M = 2 A mu R p, mu = mu_0 fade(T) (speed)^b, C dT/dt = share M w - (h_0 + h_1 w)(T - T_air).
"""

import math

from numba import njit

from model_diagnosis.replay.lag_step import followed
from model_diagnosis.replay.lanes import some, where
from model_diagnosis.replay.record import Record

_REFERENCE_SPEED_M_S = 10.0
_SLOWEST_M_S = 0.5
_REFERENCE_PRESSURE_PA = 3e6
_RELEASED_PA = 1e5
_SMALL_ANGLE = 0.3


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _effective_pressure(p: Record, s: Record, i: int, pressure: float) -> float:
    """Pressure that presses the pads: after the seal's hysteresis and the threshold."""
    if some(p.hysteresis != 0.0):
        held = s.clamping[i]
        # the torque follows a rising pressure at once and a falling one only beyond the hysteresis
        held = where(pressure > held, pressure, min(held, pressure + p.hysteresis))
        s.clamping[i] = held
        pressure = held
    return max(pressure - p.threshold_pressure[i], 0.0)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _friction_share(p: Record, s: Record, i: int, omega: float, effective: float) -> float:
    """Friction of the pads over that of the vehicle file, with the curve of the caliper over its pressure [Pa]."""
    share = p.brake_factor[i] * s.brake_share[i]
    over = s.disc_temperature[i] - p.fade_temperature[i]
    fades = (p.fade[i] != 0.0) & (over > 0.0)
    if some(fades):
        share *= where(fades, max(1.0 - p.fade[i] * over, p.fade_floor[i]), 1.0)
    logarithm = 0.0  # of both power laws together
    if some(p.pad_speed_exponent[i] != 0.0):
        speed = max(omega * p.effective_radius[i], _SLOWEST_M_S)
        logarithm += p.pad_speed_exponent[i] * math.log(speed / _REFERENCE_SPEED_M_S)
    if some(p.pad_pressure_exponent[i] != 1.0):
        logarithm += (p.pad_pressure_exponent[i] - 1.0) * math.log(effective / _REFERENCE_PRESSURE_PA)
    if some(logarithm != 0.0):
        share *= math.exp(logarithm)
    if some(p.in_stop_rise != 0.0):
        share *= 1.0 + p.in_stop_rise * s.stop_energy / p.stop_energy
    return share * (
        1.0 + p.thickness_variation_sine[i] * s.disc_sine[i] + p.thickness_variation_cosine[i] * s.disc_cosine[i]
    )


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def turn_disc(s: Record, i: int, angle: float) -> None:
    """Turn the disc's direction on; up to 0.3 rad by series, to 1e-12 of a turn in a whole manoeuvre."""
    square = angle * angle
    sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))))
    cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    cosine += 0.5 * (1.0 - sine * sine - cosine * cosine)  # what the series leaves of the circle
    is_large = angle >= _SMALL_ANGLE
    if some(is_large):
        sine, cosine = where(is_large, math.sin(angle), sine), where(is_large, math.cos(angle), cosine)
    before = s.disc_sine[i]
    s.disc_sine[i] = before * cosine + s.disc_cosine[i] * sine
    s.disc_cosine[i] = s.disc_cosine[i] * cosine - before * sine


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def brake_capacity(p: Record, s: Record, i: int, pressure: float, step: float) -> float:
    """Torque [N m] that a wheel brake can transmit; its disc warms up and turns by one step."""
    omega, torque = abs(s.spin[i]), 0.0
    effective = _effective_pressure(p, s, i, pressure)
    presses = effective > 0.0
    if some(presses):
        pressed = p.torque_per_pressure[i] * effective * _friction_share(p, s, i, omega, effective)
        torque = where(presses, pressed, 0.0)
    lags = p.caliper_lag != 0.0
    if some(lags):
        following = step / (2.0 * p.caliper_lag + step)
        before, target = s.lagged_torque[i], torque
        torque = where(lags, before + following * (target - before), target)
        s.lagged_torque[i] = followed(before, target, 0.0, following)
    torque += p.drag_torque[i]
    above = s.disc_temperature[i] - p.ambient_temperature
    cooling = (p.cooling[i] + p.cooling_per_speed[i] * omega) * above
    s.disc_temperature[i] += step * (p.heat_share[i] * torque * omega - cooling) * p.inverse_capacity[i]
    if some((p.thickness_variation_sine[i] != 0.0) | (p.thickness_variation_cosine[i] != 0.0)):
        turn_disc(s, i, step * omega)
    return torque


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def count_stop_energy(s: Record, step: float) -> None:
    """Energy that the brakes took since they were last released."""
    highest = max(max(s.pressure[0], s.pressure[1]), max(s.pressure[2], s.pressure[3]))
    energy = s.stop_energy
    for i in range(4):
        energy += step * s.brake_torque[i] * s.spin[i]
    s.stop_energy = where(highest < _RELEASED_PA, 0.0, energy)
