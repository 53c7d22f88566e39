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
_SMALL_ANGLE = 0.3


@njit(cache=True, nogil=True, error_model="numpy")
def _effective_pressure(p: Record, s: Record, i: int, pressure: float) -> float:
    """Pressure that presses the pads: after the seal's hysteresis and the threshold."""
    if p.hysteresis != 0.0:
        held = s.clamping[i]
        # the torque follows a rising pressure at once and a falling one only beyond the hysteresis
        held = pressure if pressure > held else min(held, pressure + p.hysteresis)
        s.clamping[i] = held
        pressure = held
    return max(pressure - p.threshold_pressure[i], 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _friction_share(p: Record, s: Record, i: int, omega: float, effective: float) -> float:
    """Friction of the pads over that of the vehicle file, with the curve of the caliper over its pressure [Pa]."""
    share = p.brake_factor[i] * s.brake_share[i]
    over = s.disc_temperature[i] - p.fade_temperature[i]
    if p.fade[i] != 0.0 and over > 0.0:
        share *= max(1.0 - p.fade[i] * over, p.fade_floor[i])
    logarithm = 0.0  # of both power laws together
    if p.pad_speed_exponent[i] != 0.0:
        speed = max(omega * p.effective_radius[i], _SLOWEST_M_S)
        logarithm += p.pad_speed_exponent[i] * math.log(speed / _REFERENCE_SPEED_M_S)
    if p.pad_pressure_exponent[i] != 1.0:
        logarithm += (p.pad_pressure_exponent[i] - 1.0) * math.log(effective / _REFERENCE_PRESSURE_PA)
    if logarithm != 0.0:
        share *= math.exp(logarithm)
    if p.in_stop_rise != 0.0:
        share *= 1.0 + p.in_stop_rise * s.stop_energy / p.stop_energy
    return share * (
        1.0 + p.thickness_variation_sine[i] * s.disc_sine[i] + p.thickness_variation_cosine[i] * s.disc_cosine[i]
    )


@njit(cache=True, nogil=True, error_model="numpy")
def turn_disc(s: Record, i: int, angle: float) -> None:
    """Turn the disc's direction on; up to 0.3 rad by series, to 1e-12 of a turn in a whole manoeuvre."""
    if angle < _SMALL_ANGLE:
        square = angle * angle
        sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))))
        cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
        cosine += 0.5 * (1.0 - sine * sine - cosine * cosine)  # what the series leaves of the circle
    else:
        sine, cosine = math.sin(angle), math.cos(angle)
    before = s.disc_sine[i]
    s.disc_sine[i] = before * cosine + s.disc_cosine[i] * sine
    s.disc_cosine[i] = s.disc_cosine[i] * cosine - before * sine


@njit(cache=True, nogil=True, error_model="numpy")
def brake_capacity(p: Record, s: Record, i: int, pressure: float, step: float) -> float:
    """Torque [N m] that a wheel brake can transmit; its disc warms up and turns by one step."""
    omega, torque = abs(s.spin[i]), 0.0
    effective = _effective_pressure(p, s, i, pressure)
    if effective > 0.0:
        torque = p.torque_per_pressure[i] * effective * _friction_share(p, s, i, omega, effective)
    if p.caliper_lag != 0.0:
        following = step / (2.0 * p.caliper_lag + step)
        before, target = s.lagged_torque[i], torque
        torque = before + following * (target - before)
        s.lagged_torque[i] = followed(before, target, 0.0, following)
    torque += p.drag_torque[i]
    above = s.disc_temperature[i] - p.ambient_temperature
    cooling = (p.cooling[i] + p.cooling_per_speed[i] * omega) * above
    s.disc_temperature[i] += step * (p.heat_share[i] * torque * omega - cooling) * p.inverse_capacity[i]
    if p.thickness_variation_sine[i] != 0.0 or p.thickness_variation_cosine[i] != 0.0:
        turn_disc(s, i, step * omega)
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
