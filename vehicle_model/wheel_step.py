"""Spin and contact of one wheel over one integration step, compiled.

The car's motion is held; the wheel's spin is integrated in sub-steps, linearly implicit in the slope of the tyre force,
so that it is stable down to standstill. Friction of brake and rolling is set-valued: it takes any value up to its
capacity, so that a braked wheel stands exactly still. Below a low speed elastic bristles carry the force in place of
the slip curve, which is not defined there.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.extension_terms import ROLLING
from vehicle_model.plant_record import Record
from vehicle_model.tyres.coefficients import MAGIC_FORMULA, TIR
from vehicle_model.tyres.curves import LEAST_PEAK_SLIP, MOST_PEAK_SLIP
from vehicle_model.tyres.kernel import (
    PEAK_FORCE_X,
    PEAK_FORCE_Y,
    STIFFNESS_X,
    STIFFNESS_Y,
    across,
    along,
    peak_slips,
)
from vehicle_model.tyres.prepared_row import KIND

_SMALLEST_SPEED = 1e-6
NEAR_X, NEAR_Y = 1e-5, 1e-6
"""Changes of slip within a step for which a costly tyre formula is followed along its tangent: 3e-5 of the load."""

_NOWHERE = 1e9


@njit(cache=True)
def _sticks(prepared: NDArray[np.float64], slip_x: float, slip_y: float) -> bool:
    """True while the slip is not beyond that of the peak."""
    if prepared[KIND] == TIR:
        square = slip_x * slip_x + slip_y * slip_y
        if square < LEAST_PEAK_SLIP**2 or square > MOST_PEAK_SLIP**2:  # no need to know where the peaks are
            return square < LEAST_PEAK_SLIP**2
    peak_x, peak_y = peak_slips(prepared)
    relative_x, relative_y = slip_x / peak_x, slip_y / peak_y
    return relative_x * relative_x + relative_y * relative_y <= 1.0


@njit(cache=True)
def _friction_limit(
    prepared: NDArray[np.float64],
    slip_x: float,
    slip_y: float,
    curve_x: float,
    curve_y: float,
    force_x: float,
    force_y: float,
) -> float:
    """Largest bristle force in the direction of (force_x, force_y): the peak before it is passed, the curve after."""
    if not _sticks(prepared, slip_x, slip_y):
        return math.sqrt(curve_x * curve_x + curve_y * curve_y)
    length = math.sqrt(force_x * force_x + force_y * force_y)
    peak_x, peak_y = prepared[PEAK_FORCE_X], prepared[PEAK_FORCE_Y]
    if length == 0.0 or peak_x <= 0.0 or peak_y <= 0.0:
        return peak_x
    along, across = force_x / length / peak_x, force_y / length / peak_y
    return 1.0 / math.sqrt(along * along + across * across)


@njit(cache=True)
def _bristles(
    p: Record,
    s: Record,
    i: int,
    prepared: NDArray[np.float64],
    slip_x: float,
    slip_y: float,
    curve_x: float,
    curve_y: float,
    slide_x: float,
    slide_y: float,
    roll: float,
    step: float,
) -> tuple[float, float, float]:
    """Force of the bristles and its derivative by the sliding speed along the wheel.

    Parameters
    ----------
    slide_x, slide_y : m/s
        Speed of the tread over the road, turned round: forces point along it.
    roll : m/s
        Magnitude of the rolling speed, at which deflected bristles leave the contact.
    """
    stiff_x, stiff_y, damping = p.contact_stiffness_x[i], p.contact_stiffness_y[i], p.contact_damping[i]
    # in steady rolling the deflection is slip times stiffness over bristle stiffness: both descriptions agree
    left_x = 1.0 + step * roll * stiff_x / max(prepared[STIFFNESS_X], 1.0)
    left_y = 1.0 + step * roll * stiff_y / max(prepared[STIFFNESS_Y], 1.0)
    force_x = stiff_x * (s.bristle_x[i] + step * slide_x) / left_x + damping * slide_x
    force_y = stiff_y * (s.bristle_y[i] + step * slide_y) / left_y + damping * slide_y
    limit = _friction_limit(prepared, slip_x, slip_y, curve_x, curve_y, force_x, force_y)
    length = math.sqrt(force_x * force_x + force_y * force_y)
    if length > limit:
        share = limit / length
        return force_x * share, force_y * share, 0.0
    return force_x, force_y, stiff_x * step / left_x + damping


@njit(cache=True)
def spin_wheel(
    p: Record,
    s: Record,
    i: int,
    tyre: NDArray[np.float64],
    prepared: NDArray[np.float64],
    omega: float,
    brake: float,
    drive: float,
    v_x: float,
    v_y: float,
    time_step: float,
) -> float:
    """Integrate the spin of wheel ``i``; mean forces and torques go into the state ``s``.

    Parameters
    ----------
    tyre, prepared
        Row of the tyre and the row that ``prepare`` made of it.
    omega : rad/s
        Speed of the wheel relative to its carrier.
    brake, drive : N m
        Torque that the brake can transmit; drive torque.
    v_x, v_y : m/s
        Velocity of the carrier at the contact, along the wheel's heading and to its left.

    Returns
    -------
    float
        Speed of the wheel after the step.
    """
    substeps = p.substeps
    h = time_step / substeps
    radius, inertia = p.radius[i], p.spin_inertia[i]
    rolling_resistance = p.rolling_resistance[i]
    if p.terms > 0:
        rolling_resistance = max(rolling_resistance + s.added[ROLLING, i], 0.0)
    rolling = rolling_resistance * s.load[i] * radius
    capacity = brake + rolling
    brake_share = brake / capacity if capacity > 0.0 else 0.0
    full_below, none_above = p.contact_full_below[i], p.contact_none_above[i]
    relaxation_x, relaxation_y = p.relaxation_x[i], p.relaxation_y[i]
    stiff_x, stiff_y, damping = p.contact_stiffness_x[i], p.contact_stiffness_y[i], p.contact_damping[i]
    inertia_torque = inertia * s.carrier_acceleration[i]
    sum_x = sum_y = sum_z = sum_friction = sum_slip_x = sum_slip_y = 0.0
    friction_work = drive_work = tyre_work = 0.0
    slide_y = -v_y
    abs_x, abs_y = abs(v_x), abs(v_y)
    slow = max(abs_x, abs_y) < none_above
    force_y = moment_z = b_x = b_y = b_slope = 0.0
    # the last evaluation of a formula that costs much; a curve is as cheap as its tangent
    costly = prepared[KIND] != MAGIC_FORMULA
    at_x = at_y = _NOWHERE
    at_force = at_slope = at_force_y = at_moment = 0.0
    # at low speed the bristles want the side force in each sub-step too: only the very same slip is evaluated once
    near_x, near_y = (0.0, 0.0) if slow else (NEAR_X, NEAR_Y)

    for _ in range(substeps):
        roll = radius * omega
        slide_x = roll - v_x
        speed = max(max(abs_x, abs_y), abs(roll))
        divisor = max(speed, _SMALLEST_SPEED)
        slip_x, slip_y = slide_x / divisor, slide_y / divisor
        # derivative of slip_x by omega: the divisor turns with the wheel where rolling is the faster
        slip_slope = radius * v_x / (divisor * roll) if abs(roll) >= divisor and v_x * roll > 0.0 else radius / divisor
        if speed < full_below:
            s.lagged_slip_x[i], s.lagged_slip_y[i] = slip_x, slip_y
        else:
            weight_x = 1.0 / (relaxation_x + h * divisor)
            weight_y = 1.0 / (relaxation_y + h * divisor)
            if relaxation_x > 0.0:
                slip_x = (relaxation_x * s.lagged_slip_x[i] + h * slide_x) * weight_x
                slip_slope *= h * divisor * weight_x
            if relaxation_y > 0.0:
                slip_y = (relaxation_y * s.lagged_slip_y[i] + h * slide_y) * weight_y
            s.lagged_slip_x[i], s.lagged_slip_y[i] = slip_x, slip_y
        if costly and abs(slip_x - at_x) <= near_x and abs(slip_y - at_y) <= near_y:
            force_x, slope = at_force + at_slope * (slip_x - at_x), at_slope
            force_y, moment_z = at_force_y, at_moment
        elif costly and speed < full_below and _sticks(prepared, slip_x, slip_y):
            force_x = slope = force_y = moment_z = 0.0  # the bristles alone act, and below the peak
        else:
            force_x, slope = along(tyre, prepared, slip_x, slip_y)
            if slow:
                force_y, moment_z = across(tyre, prepared, slip_x, slip_y, force_x)
            at_x, at_y, at_force, at_slope = slip_x, slip_y, force_x, slope
            at_force_y, at_moment = force_y, moment_z
        slope *= slip_slope
        if speed < none_above:
            b_x, b_y, b_slope = _bristles(
                p, s, i, prepared, slip_x, slip_y, force_x, force_y, slide_x, slide_y, abs(roll), h
            )
            share = min((none_above - speed) / (none_above - full_below), 1.0)
            force_x += share * (b_x - force_x)
            force_y += share * (b_y - force_y)
            slope += share * (radius * b_slope - slope)
            moment_z *= 1.0 - share
        slope = max(slope, 0.0)

        # momentum without friction, linearly implicit; friction then takes as much of it as it can
        momentum = inertia * omega + h * (drive - force_x * radius - inertia_torque) + h * radius * slope * omega
        mass = inertia + h * radius * slope
        if abs(momentum) <= h * capacity:
            new_omega = 0.0
            friction = -momentum / h
        else:
            friction = -capacity if momentum > 0.0 else capacity
            new_omega = (momentum + h * friction) / mass
        force_x += slope * (new_omega - omega)
        mean_omega = 0.5 * (omega + new_omega)
        if speed < none_above:
            # the deflection that carries this force; it also holds where the bristles slide
            slide_x = radius * new_omega - v_x
            b_x += b_slope * radius * (new_omega - omega)
            s.bristle_x[i] = (b_x - damping * slide_x) / stiff_x
            s.bristle_y[i] = (b_y - damping * slide_y) / stiff_y
        omega = new_omega
        sum_x += force_x
        sum_y += force_y
        sum_z += moment_z
        sum_slip_x += slip_x
        sum_slip_y += slip_y
        sum_friction += friction
        friction_work -= friction * mean_omega
        drive_work += drive * mean_omega
        tyre_work += force_x * radius * mean_omega

    if not slow:  # the side force changes little within a step: once, at the mean slip
        force_y, moment_z = across(tyre, prepared, sum_slip_x / substeps, sum_slip_y / substeps, sum_x / substeps)
        sum_y, sum_z = force_y * substeps, moment_z * substeps
    mean_friction = sum_friction / substeps
    s.force_x[i] = sum_x / substeps
    s.force_y[i] = sum_y / substeps
    s.moment_z[i] = sum_z / substeps
    s.brake_torque[i] = -mean_friction * brake_share
    s.rolling_torque[i] = -mean_friction * (1.0 - brake_share)
    s.drive_torque[i] = drive
    s.brake_energy += h * friction_work * brake_share
    s.rolling_energy += h * friction_work * (1.0 - brake_share)
    s.drive_energy += h * drive_work
    s.tyre_energy += h * tyre_work
    if max(max(abs_x, abs_y), abs(radius * omega)) >= none_above:
        slide_x = radius * omega - v_x
        s.bristle_x[i] = (s.force_x[i] - damping * slide_x) / stiff_x
        s.bristle_y[i] = (s.force_y[i] - damping * slide_y) / stiff_y
    return omega
