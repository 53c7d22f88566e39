"""What the cornering-stiffness method is tried on: the double lane change of its document (E2), which nobody brakes."""

from bench.estimation.perturbations import (
    AS_ASSUMED,
    BANK,
    DEGREE,
    GRADE,
    LATENCY,
    LATERAL_OFFSET,
    LONGITUDINAL_OFFSET,
    LOST_FRAMES,
    YAW_OFFSET,
    Level,
    Perturbation,
    RobustnessPlan,
    inertial_noise,
    lateral_stiffness,
    mass,
    noise,
    smaller_wheels,
)

_ROLL_GRADIENT = 0.0108
"""Of the scenario's car [rad s^2/m], as in its file: a body that leans is told to the method, not found by it."""

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
    BANK,
    LATERAL_OFFSET,
    YAW_OFFSET,
    LONGITUDINAL_OFFSET,
    noise({"x 2": inertial_noise(2.0), "x 5": inertial_noise(5.0)}),
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
            Level("softer, 9", lateral_stiffness(9.0, 9.0)),
            Level("two kinds", lateral_stiffness(13.0, 26.0)),
            Level("harder, 26", lateral_stiffness(26.0, 26.0)),
        ),
    ),
)

CORNERING_PLAN = RobustnessPlan(
    "friction/e2_double_lane_change_33",
    {},
    {
        "cornering_stiffness_rls": {"roll_gradient": _ROLL_GRADIENT},
        "cornering_stiffness_rls_two_degrees": {"slip_angle_span": 2 * DEGREE, "roll_gradient": _ROLL_GRADIENT},
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
