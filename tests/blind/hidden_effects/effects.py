"""Effects that can be hidden: what each changes in the car or in its measuring chain, and how large it may be.

Names and equations are those of the published catalogue; sizes are drawn in units of ``scatter``, the deviation that an
ordinary car may have.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hidden_effects.car import Numbers
from hidden_effects.tyre import arctangent

SMALLEST_UNITS = 4.0
"""Size in scatters below which an effect may be a healthy car's deviation."""

Change = Callable[[Numbers, Numbers, float, int], None]


@dataclass(frozen=True)
class HiddenEffect:
    """One effect.

    Attributes
    ----------
    unit : of the physical value; "1" for a factor on the nominal value
    relative : True where the value is a factor on the nominal one (its deviation is value − 1)
    scatter : ordinary deviation, the unit of size
    largest : largest size in units of scatter
    signs : directions that make sense
    places : number of wheels or axles among which one is drawn; 0 for none
    change : changes car and chain by a deviation at a place
    field : number that tells the true physical value afterwards ("" : the drawn deviation itself)
    needs : channels that must be in the log for it to be seen
    smallest : size in scatters from which the shipped manoeuvres show it (``isolability.detection_limit``), at least 4
    """

    name: str
    group: str
    unit: str
    relative: bool
    scatter: float
    largest: float
    signs: tuple[int, ...]
    change: Change
    places: int = 0
    field: str = ""
    needs: tuple[str, ...] = ()
    smallest: float = SMALLEST_UNITS


def _factor(field: str, rows: slice | None = None) -> Change:
    """Multiplies a number of the car, all wheels or those of a slice."""

    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        factor = np.ones_like(car[field])
        if rows is None:
            factor = factor * (1.0 + deviation)
        else:
            factor[rows] = 1.0 + deviation
        car[field] = car[field] * factor

    return change


def _factor_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        factor = np.ones_like(car[field])
        factor[place] = 1.0 + deviation
        car[field] = car[field] * factor

    return change


def _add(field: str, scale: float = 1.0) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        car[field] = car[field] + scale * deviation

    return change


def _add_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        values = car[field].copy()
        values[place] += deviation
        car[field] = values

    return change


def _sensor(field: str, *, factor: bool = False) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        chain[field] = chain[field] * (1.0 + deviation) if factor else chain[field] + deviation

    return change


def _sensor_at(field: str) -> Change:
    def change(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
        values = chain[field].copy()
        values[place] += deviation
        chain[field] = values

    return change


def _both_stiffnesses(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    for field in ("stiffness_y_front", "stiffness_y_rear")[place : place + 1]:
        car[field] = car[field] * (1.0 + deviation)


def _friction(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Peak friction in both directions; the slope at zero slip follows, as with the road's friction factor."""
    car["peak_x"], car["peak_y"] = car["peak_x"] * (1.0 + deviation), car["peak_y"] * (1.0 + deviation)


def _relaxation(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    for field in ("relaxation_x", "relaxation_y"):
        car[field] = car[field] + deviation


def _peak_shape(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Friction of the locked wheel over the peak falls by the deviation; peak and slope at zero stay."""
    shape, stiffness = float(car["shape_x"]), float(np.mean(car["stiffness_x"]))
    wanted = arctangent(1.0, shape, stiffness) - deviation
    low, high = 1.01, 1.95
    for _ in range(60):
        middle = 0.5 * (low + high)
        if arctangent(1.0, middle, stiffness * shape / middle) > wanted:
            low = middle
        else:
            high = middle
    car["stiffness_x"] = car["stiffness_x"] * shape / low
    car["shape_x"] = np.array(low)


def _load_growth(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["radius_growth"] = car["radius_growth"] + deviation


def _leak(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    """Deviation in cm^3/s at 100 bar."""
    leak = car["brake_leak"].copy()
    leak[place] += deviation * 1e-13
    car["brake_leak"] = leak


def _air(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    air = car["air_volume"].copy()
    air[2 * place : 2 * place + 2] += deviation
    car["air_volume"] = air


def _reflected(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    inertia = car["wheel_inertia"].copy()
    inertia[2:] += deviation
    car["wheel_inertia"] = inertia


def _lateral_wind(car: Numbers, chain: Numbers, deviation: float, place: int) -> None:
    car["side_wind"] = car["side_wind"] + deviation


_BOTH, _UP, _DOWN = (-1, 1), (1,), (-1,)

EFFECTS: tuple[HiddenEffect, ...] = (
    HiddenEffect("tyre_friction", "tyre", "1", True, 0.03, 14, _DOWN, _friction, field="peak_x"),
    HiddenEffect(
        "tyre_longitudinal_stiffness", "tyre", "1", True, 0.03, 13, _BOTH, _factor("stiffness_x"), field="stiffness_x"
    ),
    HiddenEffect(
        "tyre_cornering_stiffness",
        "tyre",
        "1",
        True,
        0.03,
        12,
        _BOTH,
        _both_stiffnesses,
        2,
        "stiffness_y_front,stiffness_y_rear",
        ("yaw_rate", "lateral_acceleration"),
    ),
    HiddenEffect(
        "tyre_load_sensitivity", "tyre", "1", False, 0.01, 33, _UP, _add("load_sensitivity"), field="load_sensitivity"
    ),
    HiddenEffect("tyre_relaxation_length", "tyre", "m", False, 0.02, 18, _UP, _relaxation, field="relaxation_x"),
    HiddenEffect("tyre_peak_shape", "tyre", "1", False, 0.01, 28, _UP, _peak_shape),
    HiddenEffect(
        "tyre_velocity_fade",
        "tyre",
        "s/m",
        False,
        0.0003,
        26,
        _UP,
        _add("friction_speed_loss"),
        field="friction_speed_loss",
    ),
    HiddenEffect(
        "tyre_camber_conicity",
        "tyre",
        "N",
        False,
        5.0,
        40,
        _BOTH,
        _add("conicity"),
        0,
        "conicity",
        ("yaw_rate", "lateral_acceleration"),
        5.0,
    ),
    HiddenEffect(
        "rolling_resistance",
        "tyre",
        "1",
        True,
        0.05,
        14,
        _BOTH,
        _factor("rolling_resistance"),
        field="rolling_resistance",
        smallest=6.5,
    ),
    HiddenEffect("wheel_radius_change", "tyre", "1", True, 0.002, 12, _BOTH, _factor_at("radius"), 4, "radius"),
    HiddenEffect("wheel_radius_load", "tyre", "s^2/m", False, 1e-7, 40, _UP, _load_growth, field="radius_growth"),
    HiddenEffect("brake_pad_friction", "brake", "1", True, 0.03, 13, _BOTH, _factor("pad_gain"), field="pad_gain"),
    HiddenEffect(
        "brake_pad_speed", "brake", "1", False, 0.01, 25, _BOTH, _add("pad_speed_exponent"), field="pad_speed_exponent"
    ),
    HiddenEffect("brake_pad_pressure", "brake", "1", False, 0.01, 20, _BOTH, _add("pad_pressure_exponent")),
    HiddenEffect("brake_in_stop_rise", "brake", "1", False, 0.01, 28, _UP, _add("in_stop_rise"), field="in_stop_rise"),
    HiddenEffect(
        "brake_hysteresis", "brake", "Pa", False, 1e4, 40, _UP, _add("brake_hysteresis"), field="brake_hysteresis"
    ),
    HiddenEffect(
        "brake_threshold", "brake", "Pa", False, 1e4, 30, _UP, _add("brake_threshold"), field="brake_threshold"
    ),
    HiddenEffect(
        "brake_drag_torque", "brake", "N m", False, 1.0, 50, _UP, _add_at("drag_torque"), 4, "drag_torque", smallest=10
    ),
    HiddenEffect("brake_balance", "brake", "1", False, 0.02, 12, _BOTH, _add("balance"), field="balance"),
    HiddenEffect(
        "wheel_brake_weak", "brake", "1", True, 0.01, 80, _DOWN, _factor_at("wheel_brake"), 4, "wheel_brake", smallest=6
    ),
    HiddenEffect(
        "disc_thickness_variation",
        "brake",
        "1",
        False,
        0.001,
        90,
        _UP,
        _add_at("thickness_variation"),
        4,
        "thickness_variation",
        smallest=7,
    ),
    HiddenEffect(
        "inlet_valve_conductance",
        "hydraulics",
        "1",
        True,
        0.03,
        16,
        _BOTH,
        _factor_at("inlet_conductance"),
        4,
        "inlet_conductance",
        ("master_pressure",),
    ),
    HiddenEffect(
        "outlet_valve_conductance",
        "hydraulics",
        "1",
        True,
        0.03,
        16,
        _BOTH,
        _factor_at("outlet_conductance"),
        4,
        "outlet_conductance",
        ("master_pressure",),
    ),
    HiddenEffect(
        "inlet_valve_delay",
        "hydraulics",
        "s",
        False,
        0.001,
        20,
        _UP,
        _add_at("inlet_delay"),
        4,
        "inlet_delay",
        ("master_pressure",),
    ),
    HiddenEffect(
        "outlet_valve_delay",
        "hydraulics",
        "s",
        False,
        0.001,
        20,
        _UP,
        _add_at("outlet_delay"),
        4,
        "outlet_delay",
        ("master_pressure",),
    ),
    HiddenEffect("caliper_air", "hydraulics", "m^3", False, 1e-7, 40, _UP, _air, 2, "air_volume", ("master_pressure",)),
    HiddenEffect("caliper_lag", "hydraulics", "s", False, 0.002, 40, _UP, _add("caliper_lag"), field="caliper_lag"),
    HiddenEffect(
        "hydraulic_leak", "hydraulics", "m^3/s/Pa", False, 0.04, 20, _UP, _leak, 4, "brake_leak", ("master_pressure",)
    ),
    HiddenEffect(
        "anti_dive_anti_lift",
        "suspension",
        "1",
        False,
        0.01,
        16,
        _BOTH,
        _add_at("support_tangent"),
        2,
        "support_tangent",
        ("pitch_rate",),
    ),
    HiddenEffect(
        "spring_rate",
        "suspension",
        "1",
        True,
        0.03,
        16,
        _BOTH,
        _factor("spring_rate"),
        field="spring_rate",
        needs=("pitch_rate", "roll_rate"),
    ),
    HiddenEffect(
        "damper_rate",
        "suspension",
        "1",
        True,
        0.05,
        12,
        _BOTH,
        _factor("damper_rate"),
        field="damper_rate",
        needs=("pitch_rate", "roll_rate"),
    ),
    HiddenEffect(
        "anti_roll_bar",
        "suspension",
        "1",
        True,
        0.05,
        15,
        _BOTH,
        _factor("anti_roll_rate"),
        field="anti_roll_rate",
        needs=("roll_rate",),
    ),
    HiddenEffect(
        "roll_centre_height",
        "suspension",
        "m",
        False,
        0.01,
        15,
        _BOTH,
        _add("roll_centre"),
        field="roll_centre",
        needs=("roll_rate",),
        smallest=5,
    ),
    HiddenEffect("mass_change", "body", "1", True, 0.03, 13, _BOTH, _factor("mass"), field="mass"),
    HiddenEffect(
        "cg_height_change",
        "body",
        "1",
        True,
        0.03,
        12,
        _BOTH,
        _factor("cg_height"),
        field="cg_height",
        needs=("pitch_rate",),
    ),
    HiddenEffect(
        "cg_longitudinal",
        "body",
        "m",
        False,
        0.02,
        10,
        _BOTH,
        _add("cg_to_front"),
        field="cg_to_front",
        needs=("yaw_rate", "lateral_acceleration"),
    ),
    HiddenEffect(
        "yaw_inertia",
        "body",
        "1",
        True,
        0.03,
        14,
        _BOTH,
        _factor("yaw_inertia"),
        field="yaw_inertia",
        needs=("yaw_rate",),
        smallest=5,
    ),
    HiddenEffect(
        "aero_drag", "aerodynamics", "1", True, 0.03, 25, _BOTH, _factor("drag_area"), field="drag_area", smallest=6.5
    ),
    HiddenEffect(
        "aero_lift_front_rear",
        "aerodynamics",
        "m^2",
        False,
        0.01,
        30,
        _BOTH,
        _add_at("lift_area"),
        2,
        "lift_area",
        smallest=12,
    ),
    HiddenEffect(
        "head_wind", "aerodynamics", "m/s", False, 0.3, 40, _BOTH, _add("head_wind"), field="head_wind", smallest=11
    ),
    HiddenEffect(
        "side_wind",
        "aerodynamics",
        "m/s",
        False,
        0.3,
        40,
        _BOTH,
        _lateral_wind,
        field="side_wind",
        needs=("yaw_rate", "lateral_acceleration"),
        smallest=7,
    ),
    HiddenEffect(
        "road_grade",
        "road",
        "1",
        False,
        0.001,
        40,
        _BOTH,
        _add("grade"),
        field="grade",
        needs=("longitudinal_acceleration",),
        smallest=6.5,
    ),
    HiddenEffect(
        "road_bank",
        "road",
        "1",
        False,
        0.001,
        40,
        _BOTH,
        _add("bank"),
        field="bank",
        needs=("lateral_acceleration",),
        smallest=5.5,
    ),
    HiddenEffect("mu_split", "road", "1", False, 0.005, 60, _BOTH, _add("friction_split"), field="friction_split"),
    HiddenEffect(
        "engine_braking", "driveline", "N m", False, 2.0, 70, _UP, _add("engine_braking"), field="engine_braking"
    ),
    HiddenEffect(
        "driveline_drag",
        "driveline",
        "N m s/rad",
        False,
        0.01,
        30,
        _UP,
        _add("driveline_drag"),
        field="driveline_drag",
        smallest=5,
    ),
    HiddenEffect("wheel_inertia_reflected", "driveline", "kg m^2", False, 0.03, 40, _UP, _reflected),
    HiddenEffect(
        "differential_locking",
        "driveline",
        "N m",
        False,
        2.0,
        80,
        _UP,
        _add("differential_torque"),
        field="differential_torque",
    ),
    HiddenEffect(
        "steering_ratio",
        "steering",
        "1",
        True,
        0.01,
        12,
        _BOTH,
        _factor("steering_ratio"),
        field="steering_ratio",
        needs=("yaw_rate", "lateral_acceleration"),
        smallest=5,
    ),
    HiddenEffect(
        "steering_compliance",
        "steering",
        "1",
        True,
        0.05,
        15,
        _DOWN,
        _factor("steering_stiffness"),
        field="steering_stiffness",
        needs=("yaw_rate", "lateral_acceleration"),
        smallest=11,
    ),
    HiddenEffect(
        "steering_offset",
        "steering",
        "rad",
        False,
        5e-4,
        30,
        _BOTH,
        _add("steering_offset"),
        field="steering_offset",
        needs=("yaw_rate", "lateral_acceleration"),
    ),
    HiddenEffect(
        "accelerometer_offset",
        "sensor",
        "m/s^2",
        False,
        0.02,
        20,
        _BOTH,
        _sensor("ax_offset"),
        field="chain:ax_offset",
        needs=("longitudinal_acceleration", "speed"),
        smallest=5,
    ),
    HiddenEffect(
        "accelerometer_scale",
        "sensor",
        "1",
        True,
        0.005,
        24,
        _BOTH,
        _sensor("ax_scale", factor=True),
        field="chain:ax_scale",
        needs=("longitudinal_acceleration",),
        smallest=5,
    ),
    HiddenEffect(
        "accelerometer_misalignment",
        "sensor",
        "rad",
        False,
        0.004,
        25,
        _BOTH,
        _sensor("misalignment"),
        field="chain:misalignment",
        needs=("longitudinal_acceleration", "lateral_acceleration"),
    ),
    HiddenEffect(
        "gyro_offset",
        "sensor",
        "rad/s",
        False,
        5e-4,
        30,
        _BOTH,
        _sensor("gyro_offset"),
        field="chain:gyro_offset",
        needs=("yaw_rate",),
    ),
    HiddenEffect(
        "gyro_scale",
        "sensor",
        "1",
        True,
        0.005,
        24,
        _BOTH,
        _sensor("gyro_scale", factor=True),
        field="chain:gyro_scale",
        needs=("yaw_rate",),
    ),
    HiddenEffect(
        "tone_ring_error", "sensor", "1", False, 5e-4, 30, _UP, _sensor_at("ring_error"), 4, "chain:ring_error"
    ),
    HiddenEffect(
        "pressure_sensor_scale",
        "sensor",
        "1",
        True,
        0.005,
        40,
        _BOTH,
        _sensor("pressure_scale", factor=True),
        field="chain:pressure_scale",
    ),
    HiddenEffect(
        "pressure_sensor_offset",
        "sensor",
        "Pa",
        False,
        1e4,
        30,
        _BOTH,
        _sensor("pressure_offset"),
        field="chain:pressure_offset",
    ),
    HiddenEffect(
        "pressure_sensor_lag", "sensor", "s", False, 0.002, 25, _UP, _sensor("pressure_lag"), field="chain:pressure_lag"
    ),
)
"""Effects that the shipped set of manoeuvres excites."""
