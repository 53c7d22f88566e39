"""Added terms of a car, compiled: a stack of {target, coefficient, factors} evaluated at the start of each step.

A term reads the state that the step before left (1 ms old) and adds to its target: to a torque, a tyre's friction or
side force, the rolling resistance, the rolling radius, or a force on the body. Without terms nothing is evaluated.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.extension_terms_file import (
    CAR_VARIABLES,
    FUNCTIONS,
    MOST_FACTORS,
    MOST_TERMS,
    TARGETS,
    VARIABLES,
    WHEELS_OF,
    Term,
)
from vehicle_model.plant_record import POSITION_SPIN, POSITION_TRAVEL, VELOCITY_SPIN, Record
from vehicle_model.vehicle_file import VehicleFile

TERM_RECORD = np.dtype(
    [
        ("target", "i8"),
        ("on_body", "i8"),  # 1 for a force on the body
        ("of_car", "i8"),  # 1 where no factor belongs to a wheel
        ("coefficient", "f8"),
        ("acts", "i8", (4,)),
        ("factors", "i8"),
        ("variable", "i8", (MOST_FACTORS,)),
        ("function", "i8", (MOST_FACTORS,)),
        ("symmetry", "i8", (MOST_FACTORS,)),
        ("exponent", "f8", (MOST_FACTORS,)),
        ("at", "f8", (MOST_FACTORS,)),
        ("width", "f8", (MOST_FACTORS,)),
        ("wave_number", "f8", (MOST_FACTORS,)),
        ("phase", "f8", (MOST_FACTORS,)),
        ("memory", "f8", (MOST_FACTORS, 4)),  # of relay and direction, a value per wheel
    ],
    align=True,
)

BRAKE_FACTOR, BRAKE, DRIVE, FRICTION_FACTOR, SIDE_FORCE, ROLLING, RADIUS_FACTOR, BODY_X, BODY_Y, YAW = range(
    len(TARGETS)
)
(
    _SPEED,
    _LATERAL_SPEED,
    _YAW_RATE,
    _ACCELERATION_X,
    _ACCELERATION_Y,
    _STEER,
    _ROLL,
    _PITCH,
    _TIME,
    _DISTANCE,
    _STOP_ENERGY,
    _WHEEL_SPEED,
    _WHEEL_ANGLE,
    _AXLE_DIFFERENCE,
    _SLIP_RATIO,
    _SLIP_ANGLE,
    _SLIDING,
    _LOAD,
    _FORCE_X,
    _FORCE_Y,
    _TRAVEL,
    _BRAKE_TORQUE,
    _DRIVE_TORQUE,
    _PRESSURE,
    _DISC_TEMPERATURE,
    _TYRE_HEATING,
    _PRESSURE_RATE,
) = range(len(VARIABLES))
_POWER, _ABOVE, _BELOW, _STEP, _EXCESS_SHARE, _LIMITED, _SINE, _RELAY, _DIRECTION = range(len(FUNCTIONS))
_ODD = 2

_SLOWEST_M_S = 0.5
"""Speed below which slip is not defined and a term sees none."""
_RELEASED_PA = 1e5
"""Pressure in all brakes below which a stop has ended."""
_TREAD_SHARE = 0.5
"""Of the sliding work that warms the tread; the road takes the rest."""


@njit(cache=True)
def _along_and_across(s: Record, i: int) -> tuple[float, float]:
    """Speed of the tyre's contact along the wheel's heading and to its left [m/s]."""
    forward_x, forward_y = s.forward[i, 0], s.forward[i, 1]
    at_x, at_y = s.contact_velocity[i, 0], s.contact_velocity[i, 1]
    return forward_x * at_x + forward_y * at_y, forward_x * at_y - forward_y * at_x


@njit(cache=True)
def _wheel_variable(
    kind: int,
    i: int,
    p: Record,
    s: Record,
    q: NDArray[np.float64],
    v: NDArray[np.float64],
    brake: NDArray[np.float64],
    drive: NDArray[np.float64],
) -> float:
    omega = v[VELOCITY_SPIN[i]] - s.carrier_spin[i]
    if kind == _WHEEL_SPEED:
        return omega
    if kind == _WHEEL_ANGLE:
        return q[POSITION_SPIN[i]]
    if kind == _AXLE_DIFFERENCE:
        return omega - (v[VELOCITY_SPIN[i ^ 1]] - s.carrier_spin[i ^ 1])
    if kind == _LOAD:
        return s.load[i]
    if kind == _FORCE_X:
        return s.force_x[i]
    if kind == _FORCE_Y:
        return s.force_y[i]
    if kind == _TRAVEL:
        return q[POSITION_TRAVEL[i]]
    if kind == _BRAKE_TORQUE:
        return brake[i]
    if kind == _DRIVE_TORQUE:
        return drive[i]
    if kind == _PRESSURE:
        return brake[i] / p.torque_per_pressure[i] if p.torque_per_pressure[i] > 0.0 else 0.0
    if kind == _DISC_TEMPERATURE:
        return p.disc_start_temperature[i] + s.disc_heating[i]
    if kind == _TYRE_HEATING:
        return s.tyre_heating[i]
    if kind == _PRESSURE_RATE:
        return s.brake_rate[i] / p.torque_per_pressure[i] if p.torque_per_pressure[i] > 0.0 else 0.0
    along, across = _along_and_across(s, i)
    rolling = p.radius[i] * omega
    if kind == _SLIDING:
        return math.sqrt((rolling - along) ** 2 + across * across)
    fastest = max(abs(rolling), abs(along))
    if fastest < _SLOWEST_M_S:
        return 0.0
    return (rolling - along) / fastest if kind == _SLIP_RATIO else math.atan2(across, abs(along))


@njit(cache=True)
def _car_variable(
    kind: int, s: Record, q: NDArray[np.float64], v: NDArray[np.float64], steer: float, time: float
) -> float:
    forward_x, forward_y = math.cos(s.yaw), math.sin(s.yaw)
    if kind == _SPEED:
        return forward_x * v[0] + forward_y * v[1]
    if kind == _LATERAL_SPEED:
        return forward_x * v[1] - forward_y * v[0]
    if kind == _YAW_RATE:
        return v[5]
    if kind == _ACCELERATION_X:
        return forward_x * s.acceleration[0] + forward_y * s.acceleration[1]
    if kind == _ACCELERATION_Y:
        return forward_x * s.acceleration[1] - forward_y * s.acceleration[0]
    if kind == _STEER:
        return steer
    if kind == _ROLL:
        return math.atan2(s.rotation[2, 1], s.rotation[2, 2])
    if kind == _PITCH:
        return -math.asin(s.rotation[2, 0])
    if kind == _STOP_ENERGY:
        return s.stop_energy
    return time if kind == _TIME else s.distance


@njit(cache=True)
def _power(x: float, exponent: float) -> float:
    """x to a power, x from 0 on."""
    if exponent == 1.0:
        return x
    return x * x if exponent == 2.0 else x**exponent


@njit(cache=True)
def _factor(t: Record, k: int, wheel: int, value: float) -> float:
    """Factor ``k`` of term ``t`` at a value of its variable."""
    symmetry = t.symmetry[k]
    if symmetry == 0:
        return _function(t, k, wheel, value)
    even = _function(t, k, wheel, abs(value))
    return -even if symmetry == _ODD and value < 0.0 else even


@njit(cache=True)
def _function(t: Record, k: int, wheel: int, x: float) -> float:
    function, at, width = t.function[k], t.at[k], t.width[k]
    if function == _POWER:
        return math.copysign(_power(abs(x), t.exponent[k]), x)
    if function == _ABOVE:
        return _power(x - at, t.exponent[k]) if x > at else 0.0
    if function == _BELOW:
        return _power(at - x, t.exponent[k]) if x < at else 0.0
    if function == _STEP:
        return 1.0 if x > at else 0.0
    if function == _EXCESS_SHARE:
        return 1.0 - at / x if x > at else 0.0
    if function == _LIMITED:
        return min(max((x - at) / width, -1.0), 1.0)
    if function == _SINE:
        return math.sin(t.wave_number[k] * x + t.phase[k])
    return _remembering(t, k, wheel, x)


@njit(cache=True)
def _remembering(t: Record, k: int, wheel: int, x: float) -> float:
    """Relay and direction, which depend on where x has been."""
    at, width, held = t.at[k], t.width[k], t.memory[k, wheel]
    if t.function[k] == _DIRECTION:
        held = min(max(held, x - width), x + width)
        t.memory[k, wheel] = held
        return (x - held) / width
    if x > at + width:
        held = 1.0
    elif x < at - width or held == 0.0:
        held = -1.0
    t.memory[k, wheel] = held
    return held


@njit(cache=True)
def _update_memory(p: Record, s: Record, v: NDArray[np.float64], brake: NDArray[np.float64], step: float) -> None:
    """Heat of discs and treads, energy that the brakes took since they were released, how fast they are pressed."""
    released = True
    for i in range(4):
        s.brake_rate[i] = (brake[i] - s.brake_before[i]) / step
        s.brake_before[i] = brake[i]
        released = released and brake[i] < _RELEASED_PA * p.torque_per_pressure[i]
        s.stop_energy += step * s.brake_torque[i] * abs(v[VELOCITY_SPIN[i]] - s.carrier_spin[i])
        omega = abs(v[VELOCITY_SPIN[i]] - s.carrier_spin[i])
        power = max(brake[i], 0.0) * omega
        cooling = p.disc_cooling[i] + p.disc_cooling_per_speed[i] * omega
        above = p.disc_start_temperature[i] + s.disc_heating[i] - p.ambient_temperature
        s.disc_heating[i] += step * (p.disc_heat_share[i] * power - cooling * above) / p.disc_heat_capacity[i]
        along, across = _along_and_across(s, i)
        sliding_x = p.radius[i] * (v[VELOCITY_SPIN[i]] - s.carrier_spin[i]) - along
        work = abs(s.force_x[i] * sliding_x) + abs(s.force_y[i] * across)
        s.tyre_heating[i] += step * (
            _TREAD_SHARE * work / p.tyre_heat_capacity - p.tyre_cooling_rate * s.tyre_heating[i]
        )
    if released:
        s.stop_energy = 0.0


@njit(cache=True)
def evaluate_terms(
    p: Record,
    s: Record,
    terms: NDArray[np.void],
    q: NDArray[np.float64],
    v: NDArray[np.float64],
    brake: NDArray[np.float64],
    drive: NDArray[np.float64],
    steer: float,
    time: float,
    step: float,
) -> None:
    """Sum the terms into ``s.added`` (target, wheel); a force on the body stands in the first column.

    Parameters
    ----------
    terms : shape (MOST_TERMS,), dtype ``TERM_RECORD``
        The first ``p.terms`` of them are used.
    brake, drive : shape (4,), N m
        Torques that enter the step, before any term changes them.
    """
    _update_memory(p, s, v, brake, step)
    for target in range(s.added.shape[0]):
        for i in range(4):
            s.added[target, i] = 0.0
    for n in range(p.terms):
        t = terms[n]
        for i in range(4):
            if t.acts[i] == 0:
                continue
            value = t.coefficient
            for k in range(t.factors):
                kind = t.variable[k]
                if kind < _WHEEL_SPEED:
                    x = _car_variable(kind, s, q, v, steer, time)
                else:
                    x = _wheel_variable(kind, i, p, s, q, v, brake, drive)
                value *= _factor(t, k, i, x)
            s.added[t.target, 0 if t.on_body == 1 else i] += value
            if t.on_body == 1 and t.of_car == 1:
                break
    if p.radius_changed == 1:
        for i in range(4):
            p.radius[i] = p.nominal_radius[i] * (1.0 + s.added[RADIUS_FACTOR, i])


def _fill(row: Record, term: Term) -> None:
    memory = row["memory"].copy()
    row["target"] = TARGETS.index(term.target)
    row["on_body"] = TARGETS.index(term.target) >= BODY_X
    row["of_car"] = all(factor.variable in CAR_VARIABLES for factor in term.factors)
    row["coefficient"] = term.coefficient
    row["acts"] = [wheel in WHEELS_OF[term.wheels] for wheel in range(4)]
    row["factors"] = len(term.factors)
    for k, factor in enumerate(term.factors):
        row["variable"][k] = VARIABLES.index(factor.variable)
        row["function"][k] = FUNCTIONS.index(factor.function)
        row["symmetry"][k] = ("none", "even", "odd").index(factor.symmetry)
        for name in ("exponent", "at", "width", "wave_number", "phase"):
            row[name][k] = getattr(factor, name, 0.0)
    row["memory"] = memory


def new_terms() -> NDArray[np.void]:
    """Memory for the stack of terms."""
    return np.zeros(MOST_TERMS, TERM_RECORD)


def write_terms(record: NDArray[np.void], terms: NDArray[np.void], vehicle: VehicleFile) -> None:
    """Fill the stack, and what its variables need of brakes and tyres; what relays and directions remember stays.

    Parameters
    ----------
    record : shape (1,), dtype ``PARAMETER_RECORD``
    terms : shape (MOST_TERMS,), dtype ``TERM_RECORD``
    """
    stack = vehicle.terms.stack
    for row, term in zip(terms, stack, strict=False):
        _fill(row, term)
    p = record[0]
    p["terms"] = len(stack)
    p["radius_changed"] = any(term.target == "wheel_radius_factor" for term in stack)
    p["tyre_heat_capacity"] = vehicle.terms.tyre_heat_capacity
    p["tyre_cooling_rate"] = vehicle.terms.tyre_cooling_rate
    p["ambient_temperature"] = vehicle.brakes.ambient_temperature
    for i in range(4):
        brake = vehicle.brakes.front if i < 2 else vehicle.brakes.rear
        # eq. 78: two pads
        p["torque_per_pressure"][i] = 2.0 * brake.pad_area * brake.pad_friction * brake.effective_radius
        for name in (
            "disc_heat_capacity",
            "disc_heat_share",
            "disc_cooling",
            "disc_cooling_per_speed",
            "disc_start_temperature",
        ):
            p[name][i] = getattr(brake, name)
