"""Effects of tyres and wheel brakes."""

from hidden_effects.changes import (
    add,
    add_at,
    both_stiffnesses,
    factor,
    factor_at,
    friction,
    load_growth,
    peak_shape,
    relaxation,
)
from hidden_effects.hidden_effect import BOTH, DOWN, UP, HiddenEffect

TYRE_AND_BRAKE: tuple[HiddenEffect, ...] = (
    HiddenEffect(
        "tyre_friction", "tyre", "1", True, 0.03, 14, DOWN, friction, field="peak_x", also=("peak_y", "wheel_friction")
    ),
    HiddenEffect(
        "tyre_longitudinal_stiffness", "tyre", "1", True, 0.03, 13, BOTH, factor("stiffness_x"), field="stiffness_x"
    ),
    HiddenEffect(
        "tyre_cornering_stiffness",
        "tyre",
        "1",
        True,
        0.03,
        12,
        BOTH,
        both_stiffnesses,
        2,
        "stiffness_y_front,stiffness_y_rear",
        ("yaw_rate", "lateral_acceleration"),
    ),
    HiddenEffect(
        "tyre_load_sensitivity", "tyre", "1", False, 0.01, 33, UP, add("load_sensitivity"), field="load_sensitivity"
    ),
    HiddenEffect(
        "tyre_relaxation_length",
        "tyre",
        "m",
        False,
        0.02,
        18,
        UP,
        relaxation,
        field="relaxation_x",
        also=("relaxation_y",),
    ),
    HiddenEffect("tyre_peak_shape", "tyre", "1", False, 0.01, 28, UP, peak_shape),
    HiddenEffect(
        "tyre_velocity_fade",
        "tyre",
        "s/m",
        False,
        0.0003,
        26,
        UP,
        add("friction_speed_loss"),
        field="friction_speed_loss",
    ),
    HiddenEffect(
        "tyre_camber_conicity",
        "tyre",
        "N",
        False,
        5.0,
        40,
        BOTH,
        add("conicity"),
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
        BOTH,
        factor("rolling_resistance"),
        field="rolling_resistance",
        smallest=6.5,
    ),
    HiddenEffect("wheel_radius_change", "tyre", "1", True, 0.002, 12, BOTH, factor_at("radius"), 4, "radius"),
    HiddenEffect("wheel_radius_load", "tyre", "s^2/m", False, 1e-7, 40, UP, load_growth, field="radius_growth"),
    HiddenEffect("brake_pad_friction", "brake", "1", True, 0.03, 13, BOTH, factor("pad_gain"), field="pad_gain"),
    HiddenEffect(
        "brake_pad_speed", "brake", "1", False, 0.01, 25, BOTH, add("pad_speed_exponent"), field="pad_speed_exponent"
    ),
    HiddenEffect(
        "brake_pad_pressure",
        "brake",
        "1",
        False,
        0.01,
        20,
        BOTH,
        add("pad_pressure_exponent"),
        field="pad_pressure_exponent",
    ),
    HiddenEffect("brake_in_stop_rise", "brake", "1", False, 0.01, 28, UP, add("in_stop_rise"), field="in_stop_rise"),
    HiddenEffect(
        "brake_hysteresis", "brake", "Pa", False, 1e4, 40, UP, add("brake_hysteresis"), field="brake_hysteresis"
    ),
    HiddenEffect("brake_threshold", "brake", "Pa", False, 1e4, 30, UP, add("brake_threshold"), field="brake_threshold"),
    HiddenEffect(
        "brake_drag_torque", "brake", "N m", False, 1.0, 50, UP, add_at("drag_torque"), 4, "drag_torque", smallest=10
    ),
    HiddenEffect("brake_balance", "brake", "1", False, 0.02, 12, BOTH, add("balance"), field="balance"),
    HiddenEffect(
        "wheel_brake_weak", "brake", "1", True, 0.01, 80, DOWN, factor_at("wheel_brake"), 4, "wheel_brake", smallest=6
    ),
    HiddenEffect(
        "disc_thickness_variation",
        "brake",
        "1",
        False,
        0.001,
        90,
        UP,
        add_at("thickness_variation"),
        4,
        "thickness_variation",
        smallest=7,
    ),
)
