"""Brake fluid: viscosity over temperature, and what air in a wheel brake does to its stiffness."""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

REFERENCE_TEMPERATURE_C = 20.0
ATMOSPHERE_PA = 101_325.0
POLYTROPIC_EXPONENT = 1.2
"""Of air bubbles in a brake fluid: between isothermal and adiabatic, assumed."""

# kinematic viscosity [mm^2/s] at two temperatures [degC], inside the limits of FMVSS 116 for DOT 4 (at most 1800, at
# least 1.5); usual values of data sheets, assumed
_COLD = (-40.0, 1300.0)
_HOT = (100.0, 2.1)


def _walther(viscosity_mm2_s: float) -> float:
    return math.log10(math.log10(viscosity_mm2_s + 0.7))


def kinematic_viscosity(temperature_c: float) -> float:
    """Kinematic viscosity of a DOT 4 fluid [mm^2/s] by Walther's equation, ASTM D341.

    log log (ν + 0.7) = A - B log T, through the values at -40 and 100 °C.
    """
    low, high = math.log10(_COLD[0] + 273.15), math.log10(_HOT[0] + 273.15)
    slope = (_walther(_COLD[1]) - _walther(_HOT[1])) / (high - low)
    exponent = _walther(_COLD[1]) - slope * (math.log10(temperature_c + 273.15) - low)
    return float(10.0 ** (10.0**exponent) - 0.7)


def viscosity_ratio(temperature_c: float) -> float:
    """Viscosity over that at 20 °C; exactly 1 there."""
    return kinematic_viscosity(temperature_c) / kinematic_viscosity(REFERENCE_TEMPERATURE_C)


_COMPLIANCE_AT_ATMOSPHERE = 1.0 / (POLYTROPIC_EXPONENT * ATMOSPHERE_PA)
"""Of a bubble over its volume [1/Pa]."""

_CELLS = 1024
"""Of the table of powers: 2e-6 of the value at 200 bar, where the error of cubic pieces (h^4 / 384 times the fourth
derivative) is largest."""


def _powers() -> NDArray[np.float64]:
    """Values and slopes by cell (_CELLS + 1, 2) of ratio^(1 + 1/n) at equally spaced ratios."""
    ratio, exponent = np.linspace(0.0, 1.0, _CELLS + 1), 1.0 + 1.0 / POLYTROPIC_EXPONENT
    return np.stack([ratio**exponent, exponent * ratio ** (exponent - 1.0) / _CELLS], axis=1)


_POWERS = _powers()


@njit(cache=True, forceinline=True)
def compliance_share(ratio: float) -> float:
    """Compliance of a bubble over that at the atmosphere, (p_0/p)^(1 + 1/n), by cubic pieces.

    Powers took most of the time of a hydraulic unit with air in its brakes. Off by at most 2e-6 of the value up to
    200 bar.
    """
    place = ratio * _CELLS
    cell = min(int(place), _CELLS - 1)
    t = place - cell
    value, slope = _POWERS[cell, 0], _POWERS[cell, 1]
    difference = _POWERS[cell + 1, 0] - value
    third = slope + _POWERS[cell + 1, 1] - 2.0 * difference
    return float(value + t * (slope + t * (difference - slope - third + t * third)))


@njit(cache=True, forceinline=True)
def stiffness_share(parameters: Any, wheel: int, pressure: float) -> float:
    """Stiffness of a wheel brake with air in it over that without, 1 without.

    The volumes add: V(p) = p/k + V_a (1 - (p_0/(p_0 + p))^(1/n)), so the stiffness is dp/dV = 1/(1/k + dV_a/dp).

    Parameters
    ----------
    pressure : Pa
        Above the atmosphere's; a measured one below it is a sensor's offset, and no brake is emptier than open.
    """
    air = parameters.air_volume[wheel]
    if air == 0.0:
        return 1.0
    ratio = ATMOSPHERE_PA / (ATMOSPHERE_PA + max(pressure, 0.0))
    compliance = air * _COMPLIANCE_AT_ATMOSPHERE * compliance_share(ratio)
    return float(1.0 / (1.0 + parameters.caliper_stiffness[wheel] * compliance))
