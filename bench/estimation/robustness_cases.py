"""What the friction group is tried on: a stop of its own car."""

from bench.estimation.perturbations import (
    AS_ASSUMED,
    GRADE,
    LATENCY,
    LOST_FRAMES,
    Level,
    Perturbation,
    RobustnessPlan,
    adaptive_damper,
    braking_noise,
    mass,
    noise,
    offsets,
    smaller_wheels,
)


def _tyres(**numbers: float) -> dict[str, float]:
    return {f"tyres.{name.replace('__', '.longitudinal.')}": value for name, value in numbers.items()}


def _noise(factor: float) -> dict[str, float]:
    return {**braking_noise(factor), "sensors.brake_pressure.noise": 1e4 * factor}


_FRICTION = (
    mass(1296.0),
    smaller_wheels(fl=0.278, fr=0.278, rl=0.278, rr=0.278),
    GRADE,
    offsets(
        "accelerometer_offset",
        "the accelerometer has an offset",
        "sensors.longitudinal_acceleration.offset",
        {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
    ),
    noise({"x 2": _noise(2.0), "x 5": _noise(5.0)}),
    LATENCY,
    LOST_FRAMES,
    adaptive_damper("single track"),
    Perturbation(
        "unknown_torque",
        "the wheel torques are not known",
        (Level("known"), Level("unknown", settings={"torque_mode": "z2"})),
    ),
    Perturbation(
        "other_car",
        "another car, its file known",
        (
            Level("Table 8"),
            Level("Table 11", {"vehicle": "asphalt_car", "ecu.calibration": "asphalt_car"}),
        ),
    ),
    Perturbation(
        "grip_jump",
        "the grip falls during the stop",
        (
            AS_ASSUMED,
            Level("1 to 0.8", {"road.jumps": [{"position": "74 m", "friction": 0.8}]}),
            Level("1 to 0.6", {"road.jumps": [{"position": "74 m", "friction": 0.6}]}),
        ),
    ),
    Perturbation(
        "rubber",
        "other rubber: the curve's stiffness k2 is not that of the filter",
        (
            AS_ASSUMED,
            Level("softer, 10", _tyres(front__stiffness=10.0, rear__stiffness=10.0)),
            Level("two kinds", _tyres(front__stiffness=20.0, rear__stiffness=10.0)),
            Level("harder, 25", _tyres(front__stiffness=25.0, rear__stiffness=25.0)),
        ),
    ),
    Perturbation(
        "abs_calibration",
        "another calibration of the ABS",
        (Level("sensitive"), Level("coarse", {"ecu.calibration": "coarse"})),
    ),
)

FRICTION_PLAN = RobustnessPlan(
    "friction/e10_abs_grip_jump",
    {"road.jumps": []},
    {
        "friction_ekf": {"torque_mode": "known"},
        "friction_ekf_unknown_torque": {"torque_mode": "z2"},
        "friction_ukf": {"torque_mode": "known"},
        "force_ekf": {},
        "force_ekf_document_rows": {"rolling_speed": "none"},
        "slip_slope_rls": {},
        "simple_braking": {},
    },
    {
        "speed": "rmse",
        "friction_limit_mean": "relative",
        "friction_used_mean": "rmse",
        "force_front": "rmse",
        "force_rear": "rmse",
    },
    _FRICTION,
)
