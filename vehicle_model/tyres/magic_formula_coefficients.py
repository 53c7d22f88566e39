"""Magic Formula, first half: everything that does not depend on slip, compiled.

Equation numbers are those of Pacejka 2012; dfz and dpi are the normalised changes of load and pressure.
"""

import math

import numpy as np
from numba import njit

from vehicle_model.plant_record import Record
from vehicle_model.tyres.magic_formula_record import VERSION_52

COEFFICIENT_RECORD = np.dtype(
    [
        (name, "f8")
        for name in (
            "load",
            "dfz",
            "camber",  # gamma* = sin(gamma); gamma itself in 5.2
            "shape_x",
            "peak_x",
            "stiffness_x",
            "b_x",
            "e_x",  # without the factor that depends on the sign of the slip
            "shift_x",
            "offset_x",
            "shape_y",
            "peak_y",
            "stiffness_y",
            "b_y",
            "e_y",  # likewise, with e_y_sign as the part that changes sign
            "e_y_sign",
            "shift_y",
            "offset_y",
            # the same at zero camber, for the aligning moment of 6.x
            "peak_y_0",
            "b_y_0",
            "e_y_0",
            "e_y_sign_0",
            "shift_y_0",
            "offset_y_0",
            "stiffness_y_0",
            # combined slip
            "weight_b_x",
            "weight_e_x",
            "weight_b_y",
            "weight_b_y_0",
            "weight_e_y",
            "weight_shift_y",
            "kappa_side_force",
            # aligning moment
            "b_t",
            "d_t",
            "e_t",
            "e_t_sign",
            "shift_t",
            "shift_r",
            "b_r",
            "d_r",
            "arm",
            "arm_side_force",
            "share",  # of a load below the lightest evaluated one, for the plant
        )
    ]
)


@njit(cache=True)
def _quotient(value: float, divisor: float, extra: float) -> float:
    """``value / divisor``, 0 where the divisor vanishes; ``extra`` is a program's own addition to the divisor."""
    divisor += extra
    return value / divisor if abs(divisor) > 1e-12 else 0.0


@njit(cache=True)
def _longitudinal(p: Record, c: Record, dpi: float, camber_angle: float, friction: float) -> None:
    load, dfz = c.load, c.dfz
    gamma = camber_angle * p.LGAX
    c.shape_x = p.PCX1 * p.LCX  # 4.E11
    pressure = 1.0 + p.PPX3 * dpi + p.PPX4 * dpi * dpi
    mu = (p.PDX1 + p.PDX2 * dfz) * pressure * (1.0 - p.PDX3 * gamma * gamma) * p.LMUX * friction  # 4.E13
    c.peak_x = abs(mu) * load  # 4.E12
    c.e_x = (p.PEX1 + p.PEX2 * dfz + p.PEX3 * dfz * dfz) * p.LEX  # 4.E14
    pressure = 1.0 + p.PPX1 * dpi + p.PPX2 * dpi * dpi
    c.stiffness_x = load * (p.PKX1 + p.PKX2 * dfz) * math.exp(p.PKX3 * dfz) * pressure * p.LKX  # 4.E15
    c.b_x = _quotient(c.stiffness_x, c.shape_x * c.peak_x, 0.1 * p.denominator_plus_0_1)  # 4.E16
    c.shift_x = (p.PHX1 + p.PHX2 * dfz) * p.LHX  # 4.E17
    # 4.E18; shifts lose their effect on slippery roads through lambda' (4.E8) with A = 10
    grip = p.LMUX * friction
    c.offset_x = load * (p.PVX1 + p.PVX2 * dfz) * p.LVX * (10.0 * grip / (1.0 + 9.0 * grip))


@njit(cache=True)
def _lateral(
    p: Record, c: Record, dpi: float, gamma: float, friction: float
) -> tuple[float, float, float, float, float, float, float]:
    """Peak, stiffness, B, E, sign part of E, horizontal and vertical shift of the side force at a camber."""
    load, dfz, nominal = c.load, c.dfz, p.FNOMIN * p.LFZO
    old = p.VERSION == VERSION_52
    square = gamma * gamma
    pressure = 1.0 + p.PPY3 * dpi + p.PPY4 * dpi * dpi
    side = -1.0 if p.camber_raises_side_friction != 0.0 else 1.0
    mu = (p.PDY1 + p.PDY2 * dfz) * pressure * (1.0 - side * p.PDY3 * square) * p.LMUY * friction  # 4.E23
    peak = abs(mu) * load  # 4.E22
    steepness = 2.0 if old else p.PKY4
    at = (p.PKY2 + (0.0 if old else p.PKY5 * square)) * (1.0 + p.PPY2 * dpi)
    stiffness = p.PKY1 * nominal * (1.0 + p.PPY1 * dpi) * (1.0 - p.PKY3 * abs(gamma)) * p.LKY  # 4.E25
    stiffness *= math.sin(steepness * math.atan(_quotient(load / nominal, at, 0.0)))
    b = _quotient(stiffness, c.shape_y * peak, 0.1 * p.denominator_plus_0_1)  # 4.E26
    grip = p.LMUY * friction
    shift_grip = 10.0 * grip / (1.0 + 9.0 * grip)
    camber_scale = p.LKYG if old else p.LKYC
    offset_camber = load * (p.PVY3 + p.PVY4 * dfz) * gamma * camber_scale * shift_grip  # 4.E28
    offset = load * (p.PVY1 + p.PVY2 * dfz) * p.LVY * shift_grip + offset_camber  # 4.E29
    shift = (p.PHY1 + p.PHY2 * dfz) * p.LHY  # 4.E27
    if old:
        shift += p.PHY3 * gamma * camber_scale
    else:
        camber_stiffness = load * (p.PKY6 + p.PKY7 * dfz) * (1.0 + p.PPY5 * dpi) * p.LKYC  # 4.E30
        shift += _quotient(camber_stiffness * gamma - offset_camber, stiffness, 0.0)
    curvature = (p.PEY1 + p.PEY2 * dfz) * p.LEY  # 4.E24
    even = curvature * (1.0 + (0.0 if old else p.PEY5 * square))
    return peak, stiffness, b, even, curvature * (p.PEY3 + p.PEY4 * gamma), shift, offset


@njit(cache=True)
def _combined(p: Record, c: Record, friction_peak: float) -> None:
    dfz, gamma = c.dfz, c.camber
    square = 0.0 if p.VERSION == VERSION_52 else gamma * gamma
    c.weight_b_x = (p.RBX1 + p.RBX3 * square) * p.LXAL  # 4.E54
    c.weight_e_x = p.REX1 + p.REX2 * dfz  # 4.E56
    c.weight_b_y = (p.RBY1 + p.RBY4 * square) * p.LYKA  # 4.E62
    c.weight_b_y_0 = p.RBY1 * p.LYKA
    c.weight_e_y = p.REY1 + p.REY2 * dfz  # 4.E64
    c.weight_shift_y = p.RHY1 + p.RHY2 * dfz  # 4.E65
    c.kappa_side_force = friction_peak * (p.RVY1 + p.RVY2 * dfz + p.RVY3 * gamma) * p.LVYKA  # 4.E67


@njit(cache=True)
def _aligning(p: Record, c: Record, dpi: float, camber_angle: float, friction: float) -> None:
    load, dfz, radius, nominal = c.load, c.dfz, p.UNLOADED_RADIUS, p.FNOMIN * p.LFZO
    old = p.VERSION == VERSION_52
    gamma = camber_angle * p.LGAZ if old else c.camber
    size = abs(gamma)
    grip = p.LMUY * friction
    c.shift_t = p.QHZ1 + p.QHZ2 * dfz + (p.QHZ3 + p.QHZ4 * dfz) * gamma  # 4.E35
    c.b_t = (p.QBZ1 + p.QBZ2 * dfz + p.QBZ3 * dfz * dfz) * (1.0 + p.QBZ4 * gamma + p.QBZ5 * size)  # 4.E40
    c.b_t = abs(c.b_t * _quotient(p.LKY, grip, 0.0))
    c.d_t = load * radius / nominal * (p.QDZ1 + p.QDZ2 * dfz) * (1.0 - p.PPZ1 * dpi) * p.LTR  # 4.E42
    c.d_t *= 1.0 + p.QDZ3 * (gamma if old else size) + p.QDZ4 * gamma * gamma  # 4.E43
    c.e_t = p.QEZ1 + p.QEZ2 * dfz + p.QEZ3 * dfz * dfz  # 4.E44
    c.e_t_sign = (p.QEZ4 + p.QEZ5 * gamma) * (2.0 / math.pi)
    flat = p.residual_without_camber != 0.0
    b_y, stiffness = (c.b_y_0, c.stiffness_y_0) if flat else (c.b_y, c.stiffness_y)
    shift, offset = (c.shift_y_0, c.offset_y_0) if flat else (c.shift_y, c.offset_y)
    c.shift_r = shift + _quotient(offset, stiffness, 0.0)  # 4.E38
    c.b_r = p.QBZ9 * _quotient(p.LKY, grip, 0.0) + p.QBZ10 * b_y * c.shape_y  # 4.E45
    by_camber = (p.QDZ8 + p.QDZ9 * dfz) * (1.0 + p.PPZ2 * dpi)
    if not old:
        by_camber += (p.QDZ10 + p.QDZ11 * dfz) * size
    c.d_r = load * radius * ((p.QDZ6 + p.QDZ7 * dfz) * p.LRES + by_camber * gamma * p.LKZC) * grip  # 4.E47
    c.arm = radius * (p.SSZ1 + (p.SSZ3 + p.SSZ4 * dfz) * gamma) * p.LS  # 4.E76
    c.arm_side_force = radius * p.SSZ2 / nominal * p.LS


@njit(cache=True)
def coefficients(p: Record, c: Record, load: float, camber_angle: float, pressure: float, friction: float) -> None:
    """Fill ``c`` (a record of ``COEFFICIENT_RECORD``) for an operating point.

    Parameters
    ----------
    p : record of ``TIR_RECORD``
    load : N
        Vertical load, positive.
    camber_angle : rad
        Inclination, positive as in TYDEX-W: top of the wheel to the right.
    pressure : Pa
        Inflation pressure.
    friction : float
        Factor of the road on both friction coefficients.
    """
    nominal = p.FNOMIN * p.LFZO
    c.load = load
    c.dfz = (load - nominal) / nominal  # 4.E2a
    dpi = _quotient(pressure - p.NOMPRES, p.NOMPRES, 0.0)  # 4.E2b
    c.camber = camber_angle * p.LGAY if p.VERSION == VERSION_52 else math.sin(camber_angle)  # 4.E4
    _longitudinal(p, c, dpi, camber_angle, friction)
    c.shape_y = p.PCY1 * p.LCY  # 4.E21
    (c.peak_y, c.stiffness_y, c.b_y, c.e_y, c.e_y_sign, c.shift_y, c.offset_y) = _lateral(p, c, dpi, c.camber, friction)
    if c.camber == 0.0 or (p.VERSION == VERSION_52 and p.residual_without_camber == 0.0):
        c.peak_y_0, c.stiffness_y_0, c.b_y_0, c.e_y_0 = c.peak_y, c.stiffness_y, c.b_y, c.e_y
        c.e_y_sign_0, c.shift_y_0, c.offset_y_0 = c.e_y_sign, c.shift_y, c.offset_y
    else:
        (c.peak_y_0, c.stiffness_y_0, c.b_y_0, c.e_y_0, c.e_y_sign_0, c.shift_y_0, c.offset_y_0) = _lateral(
            p, c, dpi, 0.0, friction
        )
    _combined(p, c, c.peak_y)
    _aligning(p, c, dpi, camber_angle, friction)
