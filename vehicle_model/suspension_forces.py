"""Forces of springs, dampers, anti-roll bars and stops on the wheels' travel, compiled.

Travel is positive in compression and counts along the body's z axis; every force is the one at the wheel.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.plant_record import POSITION_TRAVEL, VELOCITY_TRAVEL, Record

_SMALLEST_FORCE = 1e-6


@njit(cache=True)
def damper_force(p: Record, wheel: int, rate: float) -> float:
    """Force of a passive damper [N] at a rate of travel [m/s]: two rates, or its curve, drawn on beyond its ends."""
    last = p.damper_points[wheel] - 1
    if last < 0:
        return (p.compression_damping[wheel] if rate > 0.0 else p.rebound_damping[wheel]) * rate
    speeds, forces = p.damper_speeds[wheel], p.damper_forces[wheel]
    k = 1
    while k < last and rate > speeds[k]:
        k += 1
    share = (rate - speeds[k - 1]) / (speeds[k] - speeds[k - 1])
    force = forces[k - 1] + share * (forces[k] - forces[k - 1])
    # beyond an end the curve goes on with its last slope, but a falling one never drives
    return force if force * rate > 0.0 else 0.0


@njit(cache=True)
def _valve(p: Record, s: Record, wheel: int, rate: float, passive: float, step: float) -> float:
    """Factor of an adaptive damper: skyhook where the damper can give that force, else as soft as it goes; lagged."""
    body_rate = s.hub_velocity[wheel, 2] - s.slide[wheel, 2] * rate
    wanted = -p.skyhook_damping * body_rate  # on the body, upwards, as a compressed damper's
    aim = p.soft_scale
    if wanted * passive > 0.0:
        aim = min(
            max(wanted / max(abs(passive), _SMALLEST_FORCE) * (1.0 if passive > 0.0 else -1.0), aim), p.firm_scale
        )
    before = s.valve[wheel] if s.valve[wheel] > 0.0 else 1.0
    return before + (aim - before) * step / (step + p.valve_time_constant)


@njit(cache=True)
def stop_force(p: Record, wheel: int, travel: float) -> float:
    """Force of bump and rebound stop [N], positive against compression."""
    deep = travel - p.bump_clearance[wheel]
    if deep > 0.0:
        return (p.bump_rate[wheel] + p.bump_progression[wheel] * deep) * deep
    deep = -travel - p.rebound_clearance[wheel]
    if deep > 0.0:
        return -p.rebound_rate[wheel] * deep
    return 0.0


@njit(cache=True)
def stop_energy(p: Record, wheel: int, travel: float) -> float:
    """Energy in bump and rebound stop [J]."""
    deep = travel - p.bump_clearance[wheel]
    if deep > 0.0:
        return (0.5 * p.bump_rate[wheel] + p.bump_progression[wheel] * deep / 3.0) * deep * deep
    deep = -travel - p.rebound_clearance[wheel]
    if deep > 0.0:
        return 0.5 * p.rebound_rate[wheel] * deep * deep
    return 0.0


@njit(cache=True)
def add_suspension(
    p: Record, s: Record, q: NDArray[np.float64], v: NDArray[np.float64], force: NDArray[np.float64], step: float
) -> None:
    """Add the forces of the suspension to the generalised ones; ``step`` [s] moves the valves of adaptive dampers."""
    for i in range(4):
        travel, rate = q[POSITION_TRAVEL[i]], v[VELOCITY_TRAVEL[i]]
        other = q[POSITION_TRAVEL[i ^ 1]]
        damping = damper_force(p, i, rate)
        if p.damping_scale[i] != 1.0:
            damping *= p.damping_scale[i]
        if p.adaptive != 0:
            s.valve[i] = _valve(p, s, i, rate, damping, step)
            damping *= s.valve[i]
        s.damper_force[i] = damping
        elastic = p.spring_preload[i] + p.spring_rate[i] * travel + p.anti_roll_rate[i] * (travel - other)
        force[VELOCITY_TRAVEL[i]] -= elastic + damping
        if p.stops[i] != 0:
            force[VELOCITY_TRAVEL[i]] -= stop_force(p, i, travel)
        if p.carrier_pitch[i] != 0.0:
            # the brake turns the carrier, which pitches with the travel
            force[VELOCITY_TRAVEL[i]] += s.brake_torque[i] * p.carrier_pitch[i] * s.carrier_cosine[i]
