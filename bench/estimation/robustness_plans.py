"""What each group of estimators is tried on; the friction group's cases stand in :mod:`robustness_cases`."""

from typing import Any

from bench.estimation.groups import ONE_FILTERS_OWN_NOISE
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
    adaptive_damper,
    inertial_noise,
    lateral_stiffness,
    mass,
    noise,
    offsets,
    smaller_wheels,
)
from bench.estimation.robustness_cases import FRICTION_PLAN
from bench.estimation.robustness_cornering import CORNERING_PLAN
from signals.errors import unknown_name


def _noise(factor: float) -> dict[str, float]:
    return {**inertial_noise(factor), "sensors.roll_rate.noise": 0.005 * factor}


_NOISE = noise({"x 2": _noise(2.0), "x 5": _noise(5.0)})
_ROLL_OFFSET = offsets(
    "roll_gyroscope_offset",
    "the roll gyroscope has an offset",
    "sensors.roll_rate.offset",
    {"0.2 deg/s": 0.2 * DEGREE, "1 deg/s": DEGREE},
)
_LESS_GRIP: dict[str, Any] = {"road.jumps": [{"time": "10 s", "friction": 0.6, "transition_time": "0.1 s"}]}
_LINE = (LATENCY, LOST_FRAMES)

_CENTRE_OF_GRAVITY = Perturbation(
    "centre_of_gravity_height",
    "the centre of gravity is higher",
    (
        AS_ASSUMED,
        Level("+5 %", {"body.centre_of_gravity_height": 0.719 * 1.05}),
        Level("+10 %", {"body.centre_of_gravity_height": 0.719 * 1.10}),
    ),
)
_UNEQUAL_TRACKS = Perturbation(
    "rough_road",
    "the road is rough, left and right unlike (MuJoCo car)",
    (
        Level("own car"),
        Level("MuJoCo, smooth", plant="mujoco"),
        Level("MuJoCo, rough", scenario="state/vertical_load_rough_road"),
    ),
)


def _friction_falls(second: int, where: str) -> Perturbation:
    levels = (
        Level(
            f"1 to {share:g}",
            {"road.jumps": [{"time": f"{second} s", "friction": share, "transition_time": "0.1 s"}]},
        )
        for share in (0.8, 0.6)
    )
    return Perturbation("grip_jump", f"the grip falls in the {where}", (AS_ASSUMED, *levels))


# the state group's own: a slalom at 60 km/h, and where braking is what matters a stop of the same car
_STATE_STOP = "stops/dry"
_STATE_CAR: dict[str, Any] = {"vehicle": "lada_vesta_assumed_steering"}
_PRESSURES = {"longitudinal": {"brake_torque": "pressure"}}

_STATE_ONLY = (
    smaller_wheels(fl=0.3015, fr=0.3015, rl=0.3023, rr=0.3023),
    GRADE,
    LONGITUDINAL_OFFSET,
    adaptive_damper("planar car"),
    Perturbation(
        "unknown_torque",
        "a stop: the brake torques are not known",
        (
            Level("known", _STATE_CAR, scenario=_STATE_STOP, settings=_PRESSURES),
            Level("unknown", _STATE_CAR, scenario=_STATE_STOP),
        ),
    ),
    Perturbation(
        "other_car",
        "another car, its file known",
        (
            Level("Lada Vesta"),
            Level(
                "E-class SUV",
                {"vehicle": "e_class_suv_assumed_steering"},
                settings={"longitudinal": {"driven_axle": "rear"}},
            ),
        ),
    ),
    _friction_falls(8, "slalom"),
    Perturbation(
        "rubber",
        "other rubber: the stiffness of the lateral curve",
        (
            AS_ASSUMED,
            Level("softer", lateral_stiffness(5.0, 6.3)),
            Level("two kinds", lateral_stiffness(7.2, 18.0)),
            Level("harder", lateral_stiffness(14.4, 18.0)),
        ),
    ),
    Perturbation(
        "abs_calibration",
        "a stop: another calibration of the ABS, brake torques known",
        (
            Level("sensitive", _STATE_CAR, scenario=_STATE_STOP, settings=_PRESSURES),
            Level(
                "coarse",
                {**_STATE_CAR, "ecu.calibration": "coarse"},
                scenario=_STATE_STOP,
                settings=_PRESSURES,
            ),
        ),
    ),
)

PLANS: dict[str, RobustnessPlan] = {
    "friction": FRICTION_PLAN,
    "cornering": CORNERING_PLAN,
    "state": RobustnessPlan(
        "state/slalom_dry_asphalt",
        {},
        {"vehicle_state_ukf": {}, "wheel_sliding_mode": {}, "road_grade": {}, "observer_cascade": {}},
        {
            "lateral_acceleration": "rmse",
            "yaw_rate": "rmse",
            "slip_angle_fl": "rmse",
            "friction_limit_lateral_fl": "relative",
            "speed": "rmse",
            "road_grade": "rmse",
        },
        (mass(1559.0), LATERAL_OFFSET, YAW_OFFSET, _NOISE, *_LINE, *_STATE_ONLY),
    ),
    "load": RobustnessPlan(
        "state/vertical_load_lane_change",
        {},
        {"vertical_load_ukf": {}, "vertical_load_kf3": {}, "vertical_load_kf2": {}, "vertical_load_static": {}},
        {"vertical_load_fl": "rmse", "vertical_load_rl": "rmse"},
        (
            mass(1862.0, two_track__sprung_mass=1592.0),
            _CENTRE_OF_GRAVITY,
            _ROLL_OFFSET,
            LATERAL_OFFSET,
            _NOISE,
            _UNEQUAL_TRACKS,
            *_LINE,
            smaller_wheels(fl=0.347, fr=0.347, rl=0.347, rr=0.347),
            GRADE,
            LONGITUDINAL_OFFSET,
            _friction_falls(2, "lane change"),
            adaptive_damper("own car"),
            Perturbation(
                "other_car",
                "another car, its file known (MuJoCo car)",
                (
                    Level("E-class SUV", plant="mujoco"),
                    Level("Lada Vesta", {"vehicle": "lada_vesta_assumed_steering"}, plant="mujoco"),
                ),
            ),
        ),
    ),
    "force": RobustnessPlan(
        "state/neural_force_slalom",
        {},
        {
            "neural_force_observer": {},
            "neural_force_observer_no_network": {"network": "none"},
            "random_walk_force_ekf": {},
        },
        {"force_total": "rmse", "lateral_speed": "rmse"},
        (
            mass(700.0),
            YAW_OFFSET,
            _NOISE,
            *_LINE,
            smaller_wheels(fl=0.27, fr=0.27, rl=0.27, rr=0.27),
            Perturbation(
                "mujoco",
                "the MuJoCo car in place of the document's, level, on a grade, with adaptive dampers, with less grip",
                (
                    Level("own car"),
                    Level("MuJoCo", plant="mujoco"),
                    Level("+5 %", {"road.grade": 0.05}, plant="mujoco"),
                    Level("adaptive", {"suspension.adaptive.mode": 1.0}, plant="mujoco"),
                    Level("grip 0.6", _LESS_GRIP, plant="mujoco"),
                ),
            ),
        ),
    ),
    "attitude": RobustnessPlan(
        "state/attitude_slalom",
        {},
        {
            "attitude_bank": {},
            "attitude_single": {},
            "attitude_single_own_noise": ONE_FILTERS_OWN_NOISE,
            "attitude_augmented": {},
        },
        {"roll_angle": "rmse", "side_slip_angle": "rmse"},
        (
            mass(1296.0),
            BANK,
            LATERAL_OFFSET,
            _ROLL_OFFSET,
            YAW_OFFSET,
            *_LINE,
            _NOISE,
            smaller_wheels(fl=0.278, fr=0.278, rl=0.278, rr=0.278),
            GRADE,
            LONGITUDINAL_OFFSET,
            Perturbation(
                "adaptive_damper",
                "the dampers are adaptive",
                (Level("passive"), Level("adaptive", {"suspension.adaptive.mode": 1.0})),
            ),
            Perturbation(
                "other_car",
                "another car, its file known",
                (Level("Table 8"), Level("Lada Vesta", {"vehicle": "lada_vesta_assumed_steering"})),
            ),
            _friction_falls(30, "slalom"),
        ),
    ),
}


def plan_of(group: str) -> RobustnessPlan:
    """What a group is tried on.

    Raises
    ------
    InputError
        If there is nothing for it.
    """
    try:
        return PLANS[group]
    except KeyError:
        raise unknown_name("group of estimators with a robustness plan", group, tuple(PLANS)) from None
