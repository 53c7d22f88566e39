"""What each group of estimators is tried on; the friction group's cases stand in :mod:`robustness_cases`."""

from collections.abc import Mapping
from typing import Any

from bench.estimation.robustness_cases import AS_ASSUMED, FRICTION_PLAN, Level, Perturbation, RobustnessPlan
from signals.errors import unknown_name

_DEGREE = 0.017453292519943295


def _mass(nominal: float, **others: float) -> Perturbation:
    """The car heavier by 10 and 20 %; ``others`` are further masses, by path with two underscores for a dot."""
    masses = {"body.mass": nominal, **{path.replace("__", "."): value for path, value in others.items()}}
    levels = (Level(f"+{share} %", {p: m * (1 + share / 100) for p, m in masses.items()}) for share in (10, 20))
    return Perturbation("mass", "the car is heavier than its file says", (AS_ASSUMED, *levels))


def _offsets(name: str, title: str, path: str, sizes: Mapping[str, float]) -> Perturbation:
    return Perturbation(name, title, (AS_ASSUMED, *(Level(label, {path: size}) for label, size in sizes.items())))


def _noise(factors: Mapping[str, Mapping[str, float]]) -> Perturbation:
    levels = (Level(label, dict(numbers)) for label, numbers in factors.items())
    return Perturbation("sensor_noise", "the sensors are noisier", (AS_ASSUMED, *levels))


def _inertial_noise(factor: float) -> dict[str, Any]:
    return {
        "sensors.longitudinal_acceleration.noise": 0.05 * factor,
        "sensors.lateral_acceleration.noise": 0.05 * factor,
        "sensors.yaw_rate.noise": 0.002 * factor,
        "sensors.roll_rate.noise": 0.005 * factor,
        "sensors.wheel_speed.edge_jitter": 1e-6 * factor,
        "sensors.wheel_speed.pitch_error": 0.003 * factor,
    }


_NOISE = _noise({"x 2": _inertial_noise(2.0), "x 5": _inertial_noise(5.0)})
_LATERAL_OFFSET = _offsets(
    "lateral_accelerometer_offset",
    "the lateral accelerometer has an offset",
    "sensors.lateral_acceleration.offset",
    {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
)
_YAW_OFFSET = _offsets(
    "yaw_gyroscope_offset",
    "the yaw gyroscope has an offset",
    "sensors.yaw_rate.offset",
    {"0.5 deg/s": 0.5 * _DEGREE, "2 deg/s": 2 * _DEGREE},
)
_ROLL_OFFSET = _offsets(
    "roll_gyroscope_offset",
    "the roll gyroscope has an offset",
    "sensors.roll_rate.offset",
    {"0.2 deg/s": 0.2 * _DEGREE, "1 deg/s": _DEGREE},
)
_BANK = _offsets("bank", "the road is banked", "road.bank", {"2 %": 0.02, "5 %": 0.05})
_LATENCY = Perturbation(
    "latency",
    "the signals come later",
    (AS_ASSUMED, Level("10 ms", latency_ticks=10), Level("20 ms", latency_ticks=20)),
)
_LOST_FRAMES = Perturbation(
    "lost_frames", "frames are lost", (AS_ASSUMED, Level("2 %", lost_frames=0.02), Level("5 %", lost_frames=0.05))
)
_LINE = (_LATENCY, _LOST_FRAMES)

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

PLANS: dict[str, RobustnessPlan] = {
    "friction": FRICTION_PLAN,
    "state": RobustnessPlan(
        "state/slalom_dry_asphalt",
        {},
        {"vehicle_state_ukf": {}, "wheel_sliding_mode": {}, "observer_cascade": {}},
        {"lateral_acceleration": "rmse", "yaw_rate": "rmse", "slip_angle_fl": "rmse"},
        (_mass(1559.0), _LATERAL_OFFSET, _YAW_OFFSET, _NOISE, *_LINE),
    ),
    "load": RobustnessPlan(
        "state/vertical_load_lane_change",
        {},
        {"vertical_load_ukf": {}, "vertical_load_kf3": {}, "vertical_load_kf2": {}, "vertical_load_static": {}},
        {"vertical_load_fl": "rmse", "vertical_load_rl": "rmse"},
        (
            _mass(1862.0, two_track__sprung_mass=1592.0),
            _CENTRE_OF_GRAVITY,
            _ROLL_OFFSET,
            _LATERAL_OFFSET,
            _NOISE,
            _UNEQUAL_TRACKS,
            *_LINE,
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
        (_mass(700.0), _YAW_OFFSET, _NOISE, *_LINE),
    ),
    "attitude": RobustnessPlan(
        "state/attitude_slalom",
        {},
        {"attitude_bank": {}, "attitude_single": {}, "attitude_augmented": {}},
        {"roll_angle": "rmse", "side_slip_angle": "rmse"},
        (_mass(1296.0), _BANK, _LATERAL_OFFSET, _ROLL_OFFSET, _YAW_OFFSET, *_LINE),
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
