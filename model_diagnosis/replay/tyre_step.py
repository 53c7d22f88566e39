"""Tyre of the replay inside the compiled step: tables of the vehicle's own tyre, combined by similarity."""

import math

from numba import njit

from model_diagnosis.replay.lanes import cell_of, some, where
from model_diagnosis.replay.record import CELLS, Record

LEAST_SHARE = 0.05
LIGHTEST_N = 1.0
"""Load that a wheel in the air is given: slips at the peak are over it."""

_ROLLING_SLIP = 1e-9
"""Slip over the slip at the peak below which a direction has no meaning: forces go with the slips."""

_TREAD_HEAT_J_K = 5400.0
_TREAD_COOLING_1_S = 1.0 / 60.0


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _look_up(s: Record, axle: int, direction: int, cell: float, t: float) -> tuple[float, float]:
    """Friction over its peak and its slope by the table's variable times a cell's width, by cubic pieces."""
    value_0, slope_0 = s.table[axle, direction, cell, 0], s.table[axle, direction, cell, 1]
    value_1, slope_1 = s.table[axle, direction, cell + 1, 0], s.table[axle, direction, cell + 1, 1]
    difference = value_1 - value_0
    third = slope_0 + slope_1 - 2.0 * difference
    second = difference - slope_0 - third
    return value_0 + t * (slope_0 + t * (second + t * third)), slope_0 + t * (2.0 * second + t * 3.0 * third)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def tyre_forces(
    s: Record,
    axle: int,
    x: float,
    y: float,
    peak_force_x: float,
    peak_force_y: float,
) -> tuple[float, float, float, float]:
    """Forces [N] along and across, the slope of the first by ``x``, and the length of (x, y).

    Parameters
    ----------
    x, y : slip over the slip at the peak, along and across
    """
    relative = math.sqrt(x * x + y * y)
    share = 1.0 / (1.0 + relative)
    place = relative * share * CELLS
    cell = cell_of(place, CELLS - 1)
    along, rise = _look_up(s, axle, 0, cell, place - cell)
    across, _ = _look_up(s, axle, 1, cell, place - cell)
    inverse = 1.0 / relative
    square = x * x * inverse * inverse
    slope = rise * CELLS * share * share * square + along * inverse * (1.0 - square)
    force_x, force_y, slope = (
        peak_force_x * along * x * inverse,
        peak_force_y * across * y * inverse,
        peak_force_x * slope,
    )
    rolls = relative < _ROLLING_SLIP
    if some(rolls):
        stiffness = peak_force_x * s.table[axle, 0, 0, 1] * CELLS
        force_x, slope = where(rolls, stiffness * x, force_x), where(rolls, stiffness, slope)
        force_y = where(rolls, peak_force_y * s.table[axle, 1, 0, 1] * CELLS * y, force_y)
    return force_x, force_y, slope, relative


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def load_share(loss: float, rise: float) -> float:
    """Friction or stiffness over that at the reference load, ``rise`` the load over it less 1."""
    return max(1.0 - loss * rise, LEAST_SHARE)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def road_friction(p: Record, wheel: int, load: float, distance: float, speed: float, over_temperature: float) -> float:
    """Factor on the friction of a wheel: the tyre's own, load, a step or split of the road, speed, heat."""
    friction = p.friction[wheel]
    if some(p.more_load_loss != 0.0):
        rise = load * p.inverse_nominal_load[wheel] - 1.0
        usual = max(1.0 - p.file_load_loss[wheel] * rise, LEAST_SHARE)
        friction *= max(usual - p.more_load_loss * rise, LEAST_SHARE) / usual
    if some(p.friction_step != 0.0):
        friction *= where(distance > p.friction_step_place, 1.0 + p.friction_step, 1.0)
    if some(p.friction_split != 0.0):
        friction *= 1.0 + (1.0 if wheel % 2 == 0 else -1.0) * p.friction_split
    if some(p.velocity_fade != 0.0):
        friction *= 1.0 - p.velocity_fade * speed
    if some(p.heat_fade != 0.0):
        friction *= max(1.0 - p.heat_fade * over_temperature * over_temperature, LEAST_SHARE)
    return max(friction, LEAST_SHARE)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def wheel_forces(
    p: Record, s: Record, i: int, slip_x: float, slip_y: float, load: float, speed: float
) -> tuple[float, float, float, float]:
    """Forces [N] of a wheel's tyre along and across, the slope of the first by its slip, and the relative slip.

    Parameters
    ----------
    slip_x, slip_y : slips that the tyre's relaxation leaves
    load : N
    speed : of the wheel along its plane [m/s]
    """
    friction = road_friction(p, i, load, s.distance, speed, s.tyre_heat[i]) * s.grip_share[i]
    rise = load * p.inverse_load[i] - 1.0
    share_x, share_y = load_share(p.load_loss_x[i], rise), load_share(p.load_loss_y[i], rise)
    inverse_x = p.inverse_peak_x[i] * load_share(p.stiffness_loss_x[i], rise) / share_x
    inverse_y = p.inverse_peak_y[i] * load_share(p.stiffness_loss_y[i], rise) / share_y
    if some((p.friction_stiffens[i] != 1.0) & (friction != 1.0)):
        softer = friction ** (p.friction_stiffens[i] - 1.0)
        inverse_x, inverse_y = inverse_x * softer, inverse_y * softer
    force_x, force_y, slope, relative = tyre_forces(
        s,
        i // 2,
        slip_x * inverse_x,
        slip_y * inverse_y,
        p.peak_x[i] * friction * share_x * load,
        p.peak_y[i] * friction * share_y * load,
    )
    force_y += p.camber_stiffness * p.camber_angle * load + p.conicity
    return force_x, force_y, slope * inverse_x, relative


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def warm_tread(s: Record, i: int, sliding_power: float, step: float) -> None:
    """Half of the sliding power [W] of a step warms the tread, which cools towards the air."""
    s.tyre_heat[i] += step * (0.5 * sliding_power / _TREAD_HEAT_J_K - s.tyre_heat[i] * _TREAD_COOLING_1_S)
