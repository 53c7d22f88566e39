"""What the estimators of a group are tried on: things that are other than the estimator assumes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

WHEELS = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class Level:
    """One size of a perturbation.

    Attributes
    ----------
    label : str
        On the axis of the chart.
    set : mapping
        Changes of the scenario.
    scenario, plant : str
        In place of the group's.
    settings : mapping
        Changes of every estimator's settings that has the key.
    latency_ticks, lost_frames : int, float
        What happens to the signals between bus and estimator: delayed by so many ticks; a share of the frames of each
        kind does not arrive.
    """

    label: str
    set: Mapping[str, Any] = field(default_factory=dict)
    scenario: str = ""
    plant: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    latency_ticks: int = 0
    lost_frames: float = 0.0


@dataclass(frozen=True)
class Perturbation:
    """Something that is other than assumed, in growing sizes; the first level is as assumed."""

    name: str
    title: str
    levels: tuple[Level, ...]


@dataclass(frozen=True)
class RobustnessPlan:
    """What a group is tried on.

    Attributes
    ----------
    scenario, set : str, mapping
        The run and its changes that every level starts from.
    variants : mapping
        Estimators by their name here, with settings.
    quantities : mapping
        Quantities that tables and charts show: name to ``rmse`` or ``relative`` (mean error over mean of the truth).
    """

    scenario: str
    set: Mapping[str, Any]
    variants: Mapping[str, Mapping[str, Any]]
    quantities: Mapping[str, str]
    perturbations: tuple[Perturbation, ...]


AS_ASSUMED = Level("as assumed")


def _radius(factor: float) -> dict[str, float]:
    return {f"wheels.{wheel}.radius": 0.278 * factor for wheel in WHEELS}


def _tyres(**numbers: float) -> dict[str, float]:
    return {f"tyres.{name.replace('__', '.longitudinal.')}": value for name, value in numbers.items()}


def _noise(factor: float) -> dict[str, Any]:
    return {
        "sensors.longitudinal_acceleration.noise": 0.05 * factor,
        "sensors.brake_pressure.noise": 1e4 * factor,
        "sensors.wheel_speed.edge_jitter": 1e-6 * factor,
        "sensors.wheel_speed.pitch_error": 0.003 * factor,
    }


_FRICTION = (
    Perturbation(
        "mass",
        "the car is heavier than its file says",
        (
            AS_ASSUMED,
            Level("+10 %", {"body.mass": 1296 * 1.1}),
            Level("+20 %", {"body.mass": 1296 * 1.2}),
        ),
    ),
    Perturbation(
        "wheel_radius",
        "the wheels are smaller than the file says",
        (AS_ASSUMED, Level("-1.5 %", _radius(0.985)), Level("-3 %", _radius(0.97))),
    ),
    Perturbation(
        "grade",
        "the road is not level",
        (
            Level("-5 %", {"road.grade": -0.05}),
            AS_ASSUMED,
            Level("+5 %", {"road.grade": 0.05}),
        ),
    ),
    Perturbation(
        "accelerometer_offset",
        "the accelerometer has an offset",
        (
            AS_ASSUMED,
            Level("0.1 m/s²", {"sensors.longitudinal_acceleration.offset": 0.1}),
            Level("0.3 m/s²", {"sensors.longitudinal_acceleration.offset": 0.3}),
        ),
    ),
    Perturbation(
        "sensor_noise",
        "the sensors are noisier",
        (AS_ASSUMED, Level("x 2", _noise(2.0)), Level("x 5", _noise(5.0))),
    ),
    Perturbation(
        "latency",
        "the signals come later",
        (AS_ASSUMED, Level("10 ms", latency_ticks=10), Level("20 ms", latency_ticks=20)),
    ),
    Perturbation(
        "lost_frames",
        "frames are lost",
        (AS_ASSUMED, Level("2 %", lost_frames=0.02), Level("5 %", lost_frames=0.05)),
    ),
    Perturbation(
        "adaptive_damper",
        "the dampers are adaptive (MuJoCo car)",
        (
            Level("single track"),
            Level("passive", plant="mujoco"),
            Level("adaptive", {"suspension.adaptive.mode": 1.0}, plant="mujoco"),
        ),
    ),
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
