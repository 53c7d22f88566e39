"""Magic Formula, second half: forces and moments at a slip, compiled (Pacejka 2012, equation numbers in the lines)."""

import math

from numba import njit

from vehicle_model.plant_record import Record
from vehicle_model.tyres.magic_formula_record import VERSION_52

_CLAMP = math.pi / 2.0 - 0.01


@njit(cache=True)
def _sign(x: float) -> float:
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@njit(cache=True)
def _limited(e: float, p: Record) -> float:
    """Curvature factors are at most 1 (book, below 4.E14): else a curve may dive and return."""
    return e if p.curvature_unlimited != 0.0 or e < 1.0 else 1.0


@njit(cache=True)
def _curve(b_x: float, shape: float, e: float) -> float:
    """sin(C arctan(B x - E (B x - arctan(B x))))."""
    return math.sin(shape * math.atan(b_x - e * (b_x - math.atan(b_x))))


@njit(cache=True)
def _weight(b_x: float, shape: float, e: float) -> float:
    """cos(C arctan(B x - E (B x - arctan(B x))))."""
    if b_x == 0.0:
        return 1.0
    return math.cos(shape * math.atan(b_x - e * (b_x - math.atan(b_x))))


@njit(cache=True)
def _clamped(x: float, p: Record) -> float:
    return x if p.argument_clamped == 0.0 else min(max(x, -_CLAMP), _CLAMP)


@njit(cache=True)
def pure_longitudinal(p: Record, c: Record, kappa: float) -> float:
    """Longitudinal force without side slip, 4.E9."""
    slip = kappa + c.shift_x  # 4.E10
    e = _limited(c.e_x * (1.0 - p.PEX4 * _sign(slip)), p)  # 4.E14
    return c.peak_x * _curve(_clamped(c.b_x * slip, p), c.shape_x, e) + c.offset_x


@njit(cache=True)
def longitudinal_force_and_slope(p: Record, c: Record, kappa: float, alpha: float) -> tuple[float, float]:
    """Longitudinal force under combined slip and its derivative by the slip ratio, the weight's own change left out."""
    slip = kappa + c.shift_x
    e = _limited(c.e_x * (1.0 - p.PEX4 * _sign(slip)), p)
    x = _clamped(c.b_x * slip, p)
    y = x - e * (x - math.atan(x))
    angle = c.shape_x * math.atan(y)
    slope = c.peak_x * math.cos(angle) * c.shape_x * c.b_x * (1.0 - e * (x * x / (1.0 + x * x))) / (1.0 + y * y)
    weight = _longitudinal_weight(p, c, kappa, alpha)
    return weight * (c.peak_x * math.sin(angle) + c.offset_x), weight * slope


@njit(cache=True)
def _side_force(p: Record, c: Record, alpha: float, angle: float, flat: bool) -> float:
    """Side force without longitudinal slip, 4.E19; ``flat`` leaves out the camber (for the aligning moment of 6.x)."""
    if flat:
        peak, b, e, e_sign, shift, offset = c.peak_y_0, c.b_y_0, c.e_y_0, c.e_y_sign_0, c.shift_y_0, c.offset_y_0
    else:
        peak, b, e, e_sign, shift, offset = c.peak_y, c.b_y, c.e_y, c.e_y_sign, c.shift_y, c.offset_y
    slip = (angle if p.angle_in_side_force != 0.0 else alpha) + shift  # 4.E20
    sign = _sign(angle if p.curvature_sign_of_angle != 0.0 else slip)
    curvature = _limited(e - e_sign * sign, p)  # 4.E24
    return peak * _curve(_clamped(b * slip, p), c.shape_y, curvature) + offset


@njit(cache=True)
def _longitudinal_weight(p: Record, c: Record, kappa: float, alpha: float) -> float:
    """G_xa, 4.E53."""
    if alpha == 0.0:
        return 1.0
    b = c.weight_b_x / math.sqrt(1.0 + (p.RBX2 * kappa) ** 2)  # 4.E54: cos(arctan(x))
    e = _limited(c.weight_e_x, p)
    return _weight(b * (alpha + p.RHX1), p.RCX1, e) / _weight(b * p.RHX1, p.RCX1, e)


@njit(cache=True)
def _lateral_weight(p: Record, c: Record, kappa: float, alpha: float, flat: bool) -> float:
    """G_yk, 4.E60."""
    b = (c.weight_b_y_0 if flat else c.weight_b_y) / math.sqrt(1.0 + (p.RBY2 * (alpha - p.RBY3)) ** 2)  # 4.E62
    e = _limited(c.weight_e_y, p)
    shift = c.weight_shift_y
    return _weight(b * (kappa + shift), p.RCY1, e) / _weight(b * shift, p.RCY1, e)


@njit(cache=True)
def lateral_force(p: Record, c: Record, kappa: float, alpha: float, angle: float) -> float:
    """Side force under combined slip, 4.E58."""
    by_kappa = 0.0
    if c.kappa_side_force != 0.0:
        peak = c.kappa_side_force / math.sqrt(1.0 + (p.RVY4 * alpha) ** 2)  # 4.E67: cos(arctan(x))
        by_kappa = peak * math.sin(p.RVY5 * math.atan(p.RVY6 * kappa))  # 4.E66
    return _side_force(p, c, alpha, angle, False) * _lateral_weight(p, c, kappa, alpha, False) + by_kappa


@njit(cache=True)
def plane_forces(p: Record, c: Record, kappa: float, alpha: float, angle: float) -> tuple[float, float]:
    """Longitudinal and side force under combined slip, 4.E50 and 4.E58.

    Parameters
    ----------
    kappa : float
        Slip ratio, driving positive.
    alpha, angle : float, rad
        alpha* of the version: tangent of the slip angle (6.x) or the angle itself (5.2); the angle.
    """
    force_x = pure_longitudinal(p, c, kappa) * _longitudinal_weight(p, c, kappa, alpha)
    return force_x, lateral_force(p, c, kappa, alpha, angle)


@njit(cache=True)
def _equivalent(p: Record, c: Record, slip: float, kappa: float) -> float:
    """Slip angle with the same effect as slip angle and slip ratio together, 4.E77 and 4.E78, without its sign."""
    ratio = c.stiffness_x / c.stiffness_y if c.stiffness_y != 0.0 else 0.0
    if p.VERSION == VERSION_52:
        return math.atan(math.sqrt(math.tan(slip) ** 2 + (ratio * kappa) ** 2))
    return math.sqrt(slip * slip + (ratio * kappa) ** 2)


@njit(cache=True)
def aligning_moment(
    p: Record, c: Record, kappa: float, alpha: float, angle: float, force_x: float, force_y: float
) -> float:
    """Self-aligning moment, 4.E71."""
    old = p.VERSION == VERSION_52
    cosine = math.cos(angle)
    trail_slip, residual_slip = alpha + c.shift_t, alpha + c.shift_r  # 4.E34, 4.E37
    e = _limited(c.e_t * (1.0 + c.e_t_sign * math.atan(c.b_t * p.QCZ1 * trail_slip)), p)  # 4.E44
    sign = _sign(kappa if p.trail_sign_of_slip_ratio != 0.0 else trail_slip)
    b_x = c.b_t * _equivalent(p, c, trail_slip, kappa) * sign
    trail = c.d_t * _weight(b_x, p.QCZ1, e) * cosine  # 4.E73
    residual_slip = _equivalent(p, c, residual_slip, kappa) * _sign(residual_slip)
    residual = c.d_r / math.sqrt(1.0 + (c.b_r * residual_slip) ** 2) * cosine  # 4.E75: cos(arctan(x))
    if p.residual_cosine_twice != 0.0:
        residual *= cosine
    if old:
        side = _side_force(p, c, alpha, angle, False) * _lateral_weight(p, c, kappa, alpha, False)
    else:
        side = _side_force(p, c, alpha, angle, True) * _lateral_weight(p, c, kappa, alpha, True)  # 4.E74
    arm = c.arm + c.arm_side_force * force_y  # 4.E76
    return -trail * side + residual + arm * force_x


@njit(cache=True)
def overturning_moment(p: Record, load: float, camber_angle: float, pressure: float, force_y: float) -> float:
    """Overturning moment, 4.E69, with the terms of 6.2 in QSX12 to QSX14."""
    dpi = (pressure - p.NOMPRES) / p.NOMPRES if p.NOMPRES > 0.0 else 0.0
    nominal = p.FNOMIN
    side, vertical = force_y / nominal, load / nominal
    deflected = math.cos(p.QSX5 * math.atan(p.QSX6 * vertical) ** 2)
    value = (
        p.QSX1 * p.LVMX
        - p.QSX2 * camber_angle * (1.0 + p.PPMX1 * dpi)
        - p.QSX12 * camber_angle * abs(camber_angle)
        + p.QSX3 * side
        + p.QSX4 * deflected * math.sin(p.QSX7 * camber_angle + p.QSX8 * math.atan(p.QSX9 * side))
        + p.QSX10 * math.atan(p.QSX11 * vertical) * camber_angle
    )
    by_side_force = force_y * (p.QSX13 + p.QSX14 * abs(camber_angle))
    return p.UNLOADED_RADIUS * (load * value + by_side_force) * p.LMX


@njit(cache=True)
def rolling_moment(p: Record, load: float, camber_angle: float, pressure: float, speed: float, force_x: float) -> float:
    """Rolling-resistance moment, 4.E70; negative (ISO) when rolling forwards."""
    nominal, reference = p.FNOMIN, p.LONGVL if p.LONGVL > 0.0 else 1.0
    ratio = abs(speed) / reference
    vertical = load / nominal
    value = p.QSY1 + p.QSY2 * force_x / nominal + p.QSY3 * ratio + p.QSY4 * ratio**4
    value += (p.QSY5 + p.QSY6 * vertical) * camber_angle * camber_angle
    pressures = pressure / p.NOMPRES if p.NOMPRES > 0.0 else 1.0
    value *= vertical**p.QSY7 * pressures**p.QSY8
    direction = -1.0 if speed < 0.0 else 1.0
    return -direction * load * p.UNLOADED_RADIUS * value * p.LMY


@njit(cache=True)
def ellipse_forces(p: Record, c: Record, kappa: float, alpha: float, angle: float) -> tuple[float, float]:
    """Forces under combined slip by the friction ellipse of PAC2002, for files without combined-slip coefficients.

    Each force keeps to the ellipse through the two peaks, in the direction beta of the slip vector.
    """
    force_x, force_y = pure_longitudinal(p, c, kappa), _side_force(p, c, alpha, angle, False)
    along = kappa + c.shift_x + (c.offset_x / c.stiffness_x if c.stiffness_x != 0.0 else 0.0)
    across = math.sin(alpha + c.shift_y + (c.offset_y / c.stiffness_y if c.stiffness_y != 0.0 else 0.0))
    used_x, used_y = abs(force_x - c.offset_x), abs(force_y - c.offset_y)
    if abs(along) < 1e-9 or abs(across) < 1e-9 or used_x < 1e-9 or used_y < 1e-9:
        return force_x, force_y
    tangent = abs(across / along)
    weight_x = 1.0 / math.sqrt(1.0 + (used_x * tangent / c.peak_y) ** 2)
    weight_y = tangent / math.sqrt((used_y / c.peak_x) ** 2 + tangent * tangent)
    return force_x * weight_x, force_y * weight_y
