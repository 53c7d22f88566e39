"""What the cornering-stiffness method is tried on: the double lane change of its document (E2), which nobody brakes."""

from typing import Any

from bench.estimation.perturbations import (
    AS_ASSUMED,
    GRADE,
    LATENCY,
    LOST_FRAMES,
    Level,
    Perturbation,
    RobustnessPlan,
    mass,
    noise,
    offsets,
    smaller_wheels,
)

_DEGREE = 0.017453292519943295
_ROLL_GRADIENT = 0.0108
"""Of the scenario's car [rad s^2/m], as in its file: a body that leans is told to the method, not found by it."""


def _noise(factor: float) -> dict[str, Any]:
    return {
        "sensors.longitudinal_acceleration.noise": 0.05 * factor,
        "sensors.lateral_acceleration.noise": 0.05 * factor,
        "sensors.yaw_rate.noise": 0.002 * factor,
        "sensors.wheel_speed.edge_jitter": 1e-6 * factor,
        "sensors.wheel_speed.pitch_error": 0.003 * factor,
    }


def _lateral_stiffness(front: float, rear: float) -> dict[str, float]:
    return {"tyres.front.lateral.stiffness": front, "tyres.rear.lateral.stiffness": rear}


_CORNERING = (
    mass(1544.0),
    Perturbation(
        "centre_of_gravity_height",
        "the centre of gravity is higher",
        (
            AS_ASSUMED,
            Level("+5 %", {"body.centre_of_gravity_height": 0.55 * 1.05}),
            Level("+10 %", {"body.centre_of_gravity_height": 0.55 * 1.10}),
        ),
    ),
    smaller_wheels(fl=0.278, fr=0.278, rl=0.278, rr=0.278),
    GRADE,
    offsets("bank", "the road is banked", "road.bank", {"2 %": 0.02, "5 %": 0.05}),
    offsets(
        "lateral_accelerometer_offset",
        "the lateral accelerometer has an offset",
        "sensors.lateral_acceleration.offset",
        {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
    ),
    offsets(
        "yaw_gyroscope_offset",
        "the yaw gyroscope has an offset",
        "sensors.yaw_rate.offset",
        {"0.5 deg/s": 0.5 * _DEGREE, "2 deg/s": 2 * _DEGREE},
    ),
    offsets(
        "accelerometer_offset",
        "the longitudinal accelerometer has an offset",
        "sensors.longitudinal_acceleration.offset",
        {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
    ),
    noise({"x 2": _noise(2.0), "x 5": _noise(5.0)}),
    LATENCY,
    LOST_FRAMES,
    Perturbation(
        "adaptive_damper",
        "the dampers are adaptive",
        (Level("passive"), Level("adaptive", {"suspension.adaptive.mode": 1.0})),
    ),
    Perturbation(
        "other_car",
        "another car, its file known",
        (Level("Table 4"), Level("Table 8", {"vehicle": "ekf_car"})),
    ),
    Perturbation(
        "less_grip",
        "the road has less grip",
        (AS_ASSUMED, Level("0.6", {"road.friction": 0.6}), Level("0.3", {"road.friction": 0.3})),
    ),
    Perturbation(
        "grip_jump",
        "the grip falls in the lane change",
        (
            AS_ASSUMED,
            Level("1 to 0.6", {"road.jumps": [{"position": "30 m", "friction": 0.6}]}),
            Level("1 to 0.3", {"road.jumps": [{"position": "30 m", "friction": 0.3}]}),
        ),
    ),
    Perturbation(
        "rubber",
        "other rubber: the stiffness of the lateral curve",
        (
            AS_ASSUMED,
            Level("softer, 9", _lateral_stiffness(9.0, 9.0)),
            Level("two kinds", _lateral_stiffness(13.0, 26.0)),
            Level("harder, 26", _lateral_stiffness(26.0, 26.0)),
        ),
    ),
)

CORNERING_PLAN = RobustnessPlan(
    "friction/e2_double_lane_change_33",
    {},
    {
        "cornering_stiffness_rls": {"roll_gradient": _ROLL_GRADIENT},
        "cornering_stiffness_rls_two_degrees": {"slip_angle_span": 2 * _DEGREE, "roll_gradient": _ROLL_GRADIENT},
    },
    {
        "side_slip_angle": "rmse",
        "slip_angle_front": "rmse",
        "friction_used_front": "rmse",
        "slope_front": "smallest",
        "slope_rear": "smallest",
        "limit_reached_front": "share",
        "limit_reached_rear": "share",
    },
    _CORNERING,
)
