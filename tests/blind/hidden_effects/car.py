"""The hidden car: numbers of its data sheet, how far a car of the series is off them, and the record of the simulator.

Wheel order is front left, front right, rear left, rear right; axes are those of ISO 8855; SI units.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GRAVITY_M_S2 = 9.81
WHEELS = ("fl", "fr", "rl", "rr")
BALANCE_SCATTER = 0.02
MOST_SCATTERS = 3.0
"""No healthy car's number is farther off: four are an effect that has to be named."""

Numbers = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Number:
    """A number of the data sheet.

    Attributes
    ----------
    nominal : value, or one per wheel or axle
    scatter : standard deviation over cars of the series; of the nominal value if ``relative``
    common : True where one draw moves all wheels together
    paths : dotted paths of the user's vehicle file that state this scatter
    """

    nominal: float | tuple[float, ...]
    scatter: float = 0.0
    relative: bool = True
    common: bool = True
    paths: tuple[str, ...] = ()


def _axles(path: str) -> tuple[str, ...]:
    return tuple(path.replace("*", axle) for axle in ("front", "rear"))


def _wheels(path: str) -> tuple[str, ...]:
    return tuple(path.replace("*", wheel) for wheel in WHEELS)


DATA_SHEET: dict[str, Number] = {
    # body and suspension (friction document, Table 8)
    "mass": Number(1296.0, 0.03, paths=("body.mass",)),
    "wheelbase": Number(2.57),
    "cg_to_front": Number(1.25, 0.02, relative=False, paths=("body.centre_of_gravity_to_front_axle",)),
    "cg_height": Number(0.535, 0.03, paths=("body.centre_of_gravity_height",)),
    "track": Number(1.46),
    "yaw_inertia": Number(1817.473, 0.03, paths=("body.yaw_inertia",)),
    "pitch_inertia": Number(1520.0, 0.03, paths=("body.pitch_inertia",)),
    "roll_inertia": Number(392.85, 0.03, paths=("body.roll_inertia",)),
    "unsprung_mass": Number(38.0),
    "spring_rate": Number((20e3, 22e3), 0.03, paths=_axles("suspension.*.spring_rate")),
    "damper_rate": Number(
        (1600.0, 1700.0),
        0.05,
        paths=_axles("suspension.*.compression_damping") + _axles("suspension.*.rebound_damping"),
    ),
    "anti_roll_rate": Number((9e3, 3e3), 0.05, paths=_axles("suspension.*.anti_roll_rate")),
    "roll_centre": Number((0.0, 0.0), 0.01, relative=False, paths=_axles("suspension.*.roll_centre_height")),
    "support_angle": Number((0.0, 0.0), 0.01, relative=False, paths=_axles("suspension.*.brake_support_angle")),
    # air
    "frontal_area": Number(2.0),
    "drag_area": Number(0.8, 0.03, paths=("aerodynamics.drag_coefficient",)),
    "drag_height": Number(0.535),
    "air_density": Number(1.2),
    "lift_coefficient": Number((0.0, 0.0), 0.01, relative=False),
    "side_area": Number(2.0),
    "head_wind": Number(0.0, 0.3, relative=False),
    "side_wind": Number(0.0, 0.3, relative=False),
    # wheels and tyres
    "radius": Number((0.278,) * 4, 0.002, common=False, paths=_wheels("wheels.*.radius")),
    "radius_growth": Number(0.0),
    "wheel_inertia": Number((0.8,) * 4, 0.03, paths=_wheels("wheels.*.inertia")),
    "rolling_resistance": Number((0.015,) * 4, 0.05, paths=_wheels("wheels.*.rolling_resistance")),
    "peak_x": Number((1.12, 1.12, 0.98, 0.98)),
    "peak_y": Number((1.0,) * 4),
    "shape_x": Number(1.316),
    "shape_y": Number(1.4),
    "stiffness_x": Number((14.34,) * 4, 0.03, paths=_axles("tyres.*.longitudinal.stiffness")),
    "stiffness_y_front": Number(13.0, 0.03, paths=("tyres.front.lateral.stiffness",)),
    "stiffness_y_rear": Number(13.0, 0.03, paths=("tyres.rear.lateral.stiffness",)),
    "relaxation_x": Number(0.2, 0.1, paths=_axles("tyres.*.relaxation_length_longitudinal")),
    "relaxation_y": Number(0.2, 0.1, paths=_axles("tyres.*.relaxation_length_lateral")),
    "load_sensitivity": Number(0.0),
    "nominal_load": Number(3500.0),
    "friction_speed_loss": Number(0.0),
    "friction_heat_loss": Number(0.0),
    "conicity": Number(0.0, 5.0, relative=False),
    "pneumatic_trail": Number(0.03),
    "wheel_friction": Number((1.0,) * 4, 0.03, paths=_wheels("wheels.*.friction_factor")),
    "curve": Number(0.0),
    # brakes
    "pad_gain": Number((13e-5, 13e-5, 6.5e-5, 6.5e-5), 0.03, paths=_axles("brakes.*.pad_friction")),
    "balance": Number(0.0),
    "wheel_brake": Number((1.0,) * 4, 0.01, common=False, paths=_wheels("brakes.pad_glazing_*")),
    "pad_radius": Number(0.1),
    "pad_speed_exponent": Number(0.0, 0.01, relative=False, paths=_axles("brakes.*.pad_speed_exponent")),
    "pad_pressure_exponent": Number(1.0, 0.01, relative=False, paths=_axles("brakes.*.pad_pressure_exponent")),
    "pad_fade": Number(0.0),
    "pad_fade_temperature": Number(300.0),
    "in_stop_rise": Number(0.0, 0.01, relative=False),
    "brake_hysteresis": Number(0.0),
    "brake_threshold": Number(0.0),
    "drag_torque": Number((0.0,) * 4),
    "thickness_variation": Number((0.0,) * 4),
    "caliper_lag": Number(0.0),
    "disc_heat_capacity": Number(4000.0),
    "disc_cooling": Number(8.0),
    "disc_cooling_speed": Number(0.5),
    # hydraulics
    "booster_gain": Number(3e4, 0.03, paths=("brakes.booster_gain",)),
    "booster_knee": Number(1e9),
    "build_time": Number(0.05, 0.03, paths=("hydraulics.increase_time_constant",)),
    "dump_time": Number(0.03, 0.03, paths=("hydraulics.decrease_time_constant",)),
    "inlet_conductance": Number((1.0,) * 4),
    "outlet_conductance": Number((1.0,) * 4),
    "inlet_delay": Number((0.0,) * 4),
    "outlet_delay": Number((0.0,) * 4),
    "air_volume": Number((0.0,) * 4),
    "caliper_stiffness": Number((7e12, 1.6e13)),
    "brake_leak": Number((0.0,) * 4),
    "pump_flow": Number(6e-6),
    "pump_rate": Number(1.0),
    "accumulator_volume": Number(4e-6),
    "accumulator_start": Number(0.0),
    "circuit_loss": Number((0.0, 0.0)),
    # driveline, steering, road
    "engine_braking": Number(0.0),
    "driveline_drag": Number(0.0),
    "differential_torque": Number(0.0),
    "steering_ratio": Number(16.0, 0.01, paths=("steering.ratio",)),
    "steering_stiffness": Number(2e4, 0.05, paths=("steering.stiffness",)),
    "steering_offset": Number(0.0, 5e-4, relative=False, paths=("steering.offset",)),
    "grade": Number(0.0, 0.001, relative=False),
    "bank": Number(0.0, 0.001, relative=False),
    "roughness": Number(0.0),
    "friction_step_at": Number(1e9),
    "friction_step": Number(1.0),
    "friction_split": Number(0.0, 0.005, relative=False),
    # controller
    "abs_slip": Number(0.16),
    "abs_hold": Number(0.02),
    # unknown terms: kind 0 is none
    "unknown_kind": Number(0.0),
    "unknown_size": Number(0.0),
}
"""Numbers of the car; those without scatter are exact or belong to effects that a healthy car does not have."""

RECORD = np.dtype(
    [
        (name, "f8") if np.ndim(number.nominal) == 0 else (name, "f8", np.shape(number.nominal))
        for name, number in DATA_SHEET.items()
    ]
)


def nominal_car() -> Numbers:
    """The car of the data sheet: name -> array of shape () or (2,) per axle or (4,) per wheel."""
    return {name: np.array(number.nominal, float) for name, number in DATA_SHEET.items()}


def within_the_series(random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Normal draws in units of the scatter; what is off by more than three does not leave the factory."""
    draw = np.asarray(random.standard_normal(shape))
    while (rejected := np.abs(draw) > MOST_SCATTERS).any():
        draw = np.where(rejected, random.standard_normal(shape), draw)
    return draw


def draw_car(random: np.random.Generator) -> tuple[Numbers, dict[str, float]]:
    """A car of the series: every number with a scatter is off by a normal draw within three scatters.

    Returns
    -------
    car, deviations : deviations in units of the scatter, by name (``radius_fl`` where wheels differ)
    """
    car = nominal_car()
    deviations: dict[str, float] = {}
    for name, number in DATA_SHEET.items():
        if number.scatter == 0.0:
            continue
        draw = within_the_series(random, () if number.common else car[name].shape)
        change = number.scatter * draw
        car[name] = car[name] * (1.0 + change) if number.relative else car[name] + change
        if number.common:
            deviations[name] = float(draw)
        else:
            deviations |= {f"{name}_{wheel}": float(d) for wheel, d in zip(WHEELS, draw, strict=True)}
    balance = within_the_series(random, ())
    car["balance"] = car["balance"] + BALANCE_SCATTER * balance
    deviations["balance"] = float(balance)
    return car, deviations


def as_record(car: Mapping[str, NDArray[np.float64]]) -> np.void:
    """The car as the record that the compiled simulator reads."""
    record = np.zeros(1, RECORD)
    for name, value in car.items():
        record[name][0] = value
    result: np.void = record[0]
    return result


def scatter_table() -> dict[str, tuple[float, str]]:
    """Dotted path of the vehicle file -> (standard deviation, ``relative`` or ``absolute``)."""
    return {
        path: (number.scatter, "relative" if number.relative else "absolute")
        for number in DATA_SHEET.values()
        if number.scatter > 0.0
        for path in number.paths
    }
