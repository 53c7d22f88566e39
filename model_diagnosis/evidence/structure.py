"""Structural isolability: which effects any test could tell apart with the channels at hand, whatever the data.

The car is a set of equations over unknown variables; effects are faults of equations, channels are equations that make
variables known. Fault i can be isolated from fault j where i still acts on the structurally overdetermined part once
j's equations are taken away (Krysander and Frisk, Sensor placement for fault diagnosis, IEEE SMC-A 38 (2008) 1398).
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from signals.wheels import WHEELS


@dataclass(frozen=True)
class Equation:
    """Unknowns of one equation and the effects that act on it."""

    name: str
    unknowns: frozenset[str]
    effects: frozenset[str] = frozenset()


_BRAKE = (
    "brake_pad_friction brake_pad_speed brake_pad_pressure brake_pad_fade brake_in_stop_rise brake_hysteresis "
    "brake_threshold brake_balance caliper_lag disc_thickness_variation"
)
_TORQUE = "rolling_resistance engine_braking driveline_drag wheel_inertia_reflected differential_locking"
_TYRE_X = "tyre_friction tyre_longitudinal_stiffness tyre_load_sensitivity tyre_peak_shape tyre_temperature_fade"
_TYRE_Y = "tyre_friction tyre_cornering_stiffness tyre_load_sensitivity tyre_camber_conicity tyre_relaxation_length"
_HYDRAULICS = (
    "inlet_valve_conductance outlet_valve_conductance inlet_valve_delay outlet_valve_delay caliper_air hydraulic_leak "
    "pump_rate low_pressure_accumulator_full circuit_failure"
)
_ACCELEROMETER = "accelerometer_offset accelerometer_scale accelerometer_levelled"
_PRESSURE = "pressure_sensor_scale pressure_sensor_offset pressure_sensor_lag"

SAME_TERM: tuple[frozenset[str], ...] = (
    frozenset({"brake_pad_friction", "pressure_sensor_scale"}),
    frozenset({"brake_threshold", "pressure_sensor_offset"}),
    frozenset({"wheel_radius_change", "wheel_speed_scale"}),
    frozenset({"steering_offset", "steering_sensor_offset"}),
)
"""Effects that enter as the same function of the same variable: what structure cannot isolate, no data can."""


def _of(names: str) -> frozenset[str]:
    return frozenset(names.split())


def _equation(name: str, unknowns: str, effects: str = "") -> Equation:
    return Equation(name, _of(unknowns), _of(effects))


@cache
def car_equations() -> tuple[Equation, ...]:
    """Equations of the replay's car, without any channel."""
    forces = " ".join(f"fx_{wheel} fy_{wheel}" for wheel in WHEELS)
    equations = [
        _equation("longitudinal force", f"along v steer {forces}", "mass_change aero_drag head_wind"),
        _equation("speed", "dv along vy yaw_rate", "road_grade"),
        _equation("lateral force", f"across v vy steer {forces}", "mass_change side_wind"),
        _equation("lateral speed", "dvy across v yaw_rate", "road_bank"),
        _equation("yaw moment", f"dyaw steer {forces}", "yaw_inertia cg_longitudinal"),
        _equation("derivative of speed", "dv v"),
        _equation("derivative of lateral speed", "dvy vy"),
        _equation("derivative of yaw rate", "dyaw yaw_rate"),
        _equation("steering", "steer wheel_angle fy_fl fy_fr", "steering_ratio steering_offset steering_compliance"),
    ]
    for wheel in WHEELS:
        i = f"_{wheel}"
        equations += [
            _equation(f"wheel torque{i}", f"dspin{i} torque{i} fx{i} load{i} drive{i}", _TORQUE),
            _equation(f"brake{i}", f"torque{i} pressure{i} spin{i}", f"{_BRAKE} brake_drag_torque wheel_brake_weak"),
            _equation(f"slip{i}", f"slip{i} spin{i} v yaw_rate", "wheel_radius_change wheel_radius_load"),
            _equation(f"tyre along{i}", f"fx{i} slip{i} alpha{i} load{i}", _TYRE_X),
            _equation(f"slip angle{i}", f"alpha{i} v vy yaw_rate steer"),
            _equation(f"tyre across{i}", f"fy{i} slip{i} alpha{i} load{i}", _TYRE_Y),
            _equation(f"load{i}", f"load{i} along across", "cg_height_change anti_roll_bar roll_centre_height"),
            _equation(f"derivative of spin{i}", f"dspin{i} spin{i}"),
        ]
    return tuple(equations)


@cache
def sensors() -> Mapping[str, tuple[Equation, ...]]:
    """What each channel makes known."""
    single = {
        "longitudinal_acceleration": _equation("ax", "along", _ACCELEROMETER),
        "lateral_acceleration": _equation("ay", "across", _ACCELEROMETER),
        "yaw_rate": _equation("r", "yaw_rate", "gyro_offset gyro_scale"),
        "speed": _equation("v", "v"),
        "lateral_speed": _equation("vy", "vy"),
        "steering_wheel_angle": _equation("steering wheel", "wheel_angle", "steering_sensor_offset"),
        "road_grade": _equation("grade", "v"),
    }
    for wheel in WHEELS:
        single |= {
            f"wheel_speed_{wheel}": _equation(f"w_{wheel}", f"spin_{wheel}", "tone_ring_error wheel_speed_scale"),
            f"brake_pressure_{wheel}": _equation(f"p_{wheel}", f"pressure_{wheel}", _PRESSURE),
            f"reference_pressure_{wheel}": _equation(f"reference p_{wheel}", f"pressure_{wheel}"),
            f"brake_torque_{wheel}": _equation(f"torque wheel_{wheel}", f"torque_{wheel}"),
            f"longitudinal_force_{wheel}": _equation(f"force wheel x_{wheel}", f"fx_{wheel}"),
            f"lateral_force_{wheel}": _equation(f"force wheel y_{wheel}", f"fy_{wheel}"),
            f"vertical_load_{wheel}": _equation(f"force wheel z_{wheel}", f"load_{wheel}"),
        }
    known: dict[str, tuple[Equation, ...]] = {channel: (equation,) for channel, equation in single.items()}
    known["master_pressure"] = tuple(_equation(f"hydraulics_{w}", f"pressure_{w}", _HYDRAULICS) for w in WHEELS)
    for axle, wheels in (("f", WHEELS[:2]), ("r", WHEELS[2:])):
        known[f"drive_torque_{axle}"] = tuple(_equation(f"drive_{wheel}", f"drive_{wheel}") for wheel in wheels)
    return known


SENSORS_TO_ADD = ("reference_pressure", "brake_torque", "longitudinal_force", "vertical_load", "lateral_force", "speed")
"""Sensors that a plan may ask for, the cheapest first; wheel sensors on all four wheels."""


def structural_model(channels: Collection[str]) -> list[Equation]:
    """Equations of the car with these channels measured; channels that structure does not know are passed over."""
    known = sensors()
    return [*car_equations(), *(equation for channel in channels if channel in known for equation in known[channel])]


def overdetermined(equations: list[Equation]) -> list[Equation]:
    """Structurally overdetermined part (Dulmage and Mendelsohn): what an unmatched equation reaches alternately."""
    unknowns = sorted({name for equation in equations for name in equation.unknowns})
    if not equations or not unknowns:
        return list(equations)
    place = {name: column for column, name in enumerate(unknowns)}
    incidence = np.zeros((len(equations), len(unknowns)), dtype=np.int8)
    for row, equation in enumerate(equations):
        incidence[row, [place[name] for name in equation.unknowns]] = 1
    matched: NDArray[np.int32] = maximum_bipartite_matching(csr_array(incidence), perm_type="column")
    owner = {int(column): row for row, column in enumerate(matched) if column >= 0}
    reached = {row for row, column in enumerate(matched) if column < 0}
    waiting = list(reached)
    while waiting:
        for column in np.flatnonzero(incidence[waiting.pop()]):
            row = owner[int(column)]  # an unmatched unknown here would lengthen the matching
            if row not in reached:
                reached.add(row)
                waiting.append(row)
    return [equations[row] for row in sorted(reached)]


def is_isolable(equations: list[Equation], effect: str, other: str) -> bool:
    """True if some test can react to ``effect`` without reacting to ``other``."""
    rest = [equation for equation in equations if other not in equation.effects]
    return any(effect in equation.effects for equation in overdetermined(rest))


def are_forced_together(channels: Collection[str], effect: str, other: str) -> bool:
    """True if the two enter as the same term and no channel tells them apart: they are one group on any data."""
    if not any({effect, other} <= pair for pair in SAME_TERM):
        return False
    equations = structural_model(channels)
    return not (is_isolable(equations, effect, other) and is_isolable(equations, other, effect))


def separating_sensor(channels: Collection[str], effect: str, other: str) -> str | None:
    """First of the sensors to add that makes both effects isolable from each other; None where none does."""
    for sensor in SENSORS_TO_ADD:
        added = [sensor] if sensor in sensors() else [f"{sensor}_{wheel}" for wheel in WHEELS]
        if set(added) <= set(channels):
            continue
        equations = structural_model([*channels, *added])
        if is_isolable(equations, effect, other) and is_isolable(equations, other, effect):
            return sensor
    return None
