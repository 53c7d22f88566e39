"""Wheel brakes: from the pressure of the caliper to the torque that it can transmit, and the heat of that.

    M = 2 A µ R p_c,   µ = µ_0 (1 - glazing) fade(T) (speed)^b,   C dT/dt = share M |ω| - (h_0 + h_1 |ω|) (T - T_air)

(eq. 78 of the friction document; the heat balance is the usual lumped one; a caliper's time constant, if it has one,
lets M lag). Every effect has a neutral value that leaves the torque bit for bit at 2 A µ_0 R p.
"""

import math
from typing import Any

from numba import njit

from hydraulics.record import STEP_S

_REFERENCE_SPEED_M_S = 10.0
_SLOWEST_M_S = 0.5
_REFERENCE_PRESSURE_PA = 3e6
_TURN = 2.0 * math.pi


@njit(cache=True)
def _clamping_pressure(p: Any, s: Any, wheel: int) -> float:
    """Pressure that reaches the pads: the piston moves once the fluid pushes more than its friction."""
    pressure, friction = s.pressure[wheel], p.piston_friction[wheel]
    clamping = s.clamping[wheel]
    if clamping < pressure - friction:
        clamping = pressure - friction
    elif clamping > pressure + friction:
        clamping = pressure + friction
    s.clamping[wheel] = clamping
    effective = max(clamping - p.threshold_pressure[wheel], 0.0)
    exponent = p.pad_pressure_exponent[wheel]
    if exponent != 1.0 and effective > 0.0:
        effective *= (effective / _REFERENCE_PRESSURE_PA) ** (exponent - 1.0)
    return float(effective)


@njit(cache=True)
def _friction_share(p: Any, s: Any, wheel: int, omega: float) -> float:
    """Friction of the pads over that of the vehicle file."""
    share = 1.0 - p.pad_glazing[wheel]
    over = s.disc_temperature[wheel] - p.fade_temperature[wheel]
    if p.fade[wheel] != 0.0 and over > 0.0:
        share *= max(1.0 - p.fade[wheel] * over, p.fade_floor[wheel])
    exponent = p.pad_speed_exponent[wheel]
    if exponent != 0.0:
        speed = max(omega * p.effective_radius[wheel], _SLOWEST_M_S)
        share *= (speed / _REFERENCE_SPEED_M_S) ** exponent
    variation = p.thickness_variation[wheel]
    if variation != 0.0:
        share *= 1.0 + variation * math.sin(s.disc_angle[wheel])
    return float(share)


@njit(cache=True)
def brake_torque(p: Any, s: Any, wheel: int, wheel_speed: float) -> float:
    """Torque [N m] that a brake can transmit now; its disc is heated by one step.

    While the wheel turns, the brake gives all that it can; a locked wheel makes no heat.
    """
    omega = abs(wheel_speed)
    torque = p.torque_per_pressure[wheel] * _clamping_pressure(p, s, wheel) * _friction_share(p, s, wheel, omega)
    lag = p.caliper_time_constant
    if lag != 0.0:
        torque = (lag * s.lagged_torque[wheel] + STEP_S * torque) / (lag + STEP_S)
        s.lagged_torque[wheel] = torque
    torque += p.drag_torque[wheel]
    above = s.disc_temperature[wheel] - p.ambient_temperature
    cooling = (p.disc_cooling[wheel] + p.disc_cooling_per_speed[wheel] * omega) * above
    heat = p.disc_heat_share[wheel] * torque * omega
    s.disc_temperature[wheel] += STEP_S * (heat - cooling) / p.disc_heat_capacity[wheel]
    angle = s.disc_angle[wheel] + STEP_S * omega
    s.disc_angle[wheel] = angle - _TURN if angle >= _TURN else angle
    return float(torque)
