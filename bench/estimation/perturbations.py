"""Things that are other than an estimator assumes, in growing sizes: what every group's plan is put together from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any

DEGREE = pi / 180
"""One degree [rad]."""

WITHOUT_TRUTH = ("share", "smallest")
"""Figures of a plan that need no true value."""


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
        Quantities that tables and charts show: name to ``rmse`` or ``relative`` (mean error over mean of the truth);
        of outputs without a truth ``share`` (of the phase, for flags) or ``smallest`` (while it is to be trusted).
    """

    scenario: str
    set: Mapping[str, Any]
    variants: Mapping[str, Mapping[str, Any]]
    quantities: Mapping[str, str]
    perturbations: tuple[Perturbation, ...]


AS_ASSUMED = Level("as assumed")
LATENCY = Perturbation(
    "latency",
    "the signals come later",
    (AS_ASSUMED, Level("10 ms", latency_ticks=10), Level("20 ms", latency_ticks=20)),
)
LOST_FRAMES = Perturbation(
    "lost_frames", "frames are lost", (AS_ASSUMED, Level("2 %", lost_frames=0.02), Level("5 %", lost_frames=0.05))
)
GRADE = Perturbation(
    "grade",
    "the road is not level",
    (Level("-5 %", {"road.grade": -0.05}), AS_ASSUMED, Level("+5 %", {"road.grade": 0.05})),
)


def mass(nominal: float, **others: float) -> Perturbation:
    """The car heavier by 10 and 20 %; ``others`` are further masses, by path with two underscores for a dot."""
    masses = {"body.mass": nominal, **{path.replace("__", "."): value for path, value in others.items()}}
    levels = (Level(f"+{share} %", {p: m * (1 + share / 100) for p, m in masses.items()}) for share in (10, 20))
    return Perturbation("mass", "the car is heavier than its file says", (AS_ASSUMED, *levels))


def offsets(name: str, title: str, path: str, sizes: Mapping[str, float]) -> Perturbation:
    return Perturbation(name, title, (AS_ASSUMED, *(Level(label, {path: size}) for label, size in sizes.items())))


LONGITUDINAL_OFFSET = offsets(
    "accelerometer_offset",
    "the longitudinal accelerometer has an offset",
    "sensors.longitudinal_acceleration.offset",
    {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
)
LATERAL_OFFSET = offsets(
    "lateral_accelerometer_offset",
    "the lateral accelerometer has an offset",
    "sensors.lateral_acceleration.offset",
    {"0.1 m/s²": 0.1, "0.3 m/s²": 0.3},
)
YAW_OFFSET = offsets(
    "yaw_gyroscope_offset",
    "the yaw gyroscope has an offset",
    "sensors.yaw_rate.offset",
    {"0.5 deg/s": 0.5 * DEGREE, "2 deg/s": 2 * DEGREE},
)
BANK = offsets("bank", "the road is banked", "road.bank", {"2 %": 0.02, "5 %": 0.05})


def noise(factors: Mapping[str, Mapping[str, float]]) -> Perturbation:
    levels = (Level(label, dict(numbers)) for label, numbers in factors.items())
    return Perturbation("sensor_noise", "the sensors are noisier", (AS_ASSUMED, *levels))


def braking_noise(factor: float) -> dict[str, float]:
    """Noise of longitudinal accelerometer and tone rings, as a multiple of what the scenarios assume."""
    return {
        "sensors.longitudinal_acceleration.noise": 0.05 * factor,
        "sensors.wheel_speed.edge_jitter": 1e-6 * factor,
        "sensors.wheel_speed.pitch_error": 0.003 * factor,
    }


def inertial_noise(factor: float) -> dict[str, float]:
    """The same with lateral accelerometer and yaw gyroscope."""
    return {
        **braking_noise(factor),
        "sensors.lateral_acceleration.noise": 0.05 * factor,
        "sensors.yaw_rate.noise": 0.002 * factor,
    }


def lateral_stiffness(front: float, rear: float) -> dict[str, float]:
    """Other stiffness of the lateral tyre curves, by axle."""
    return {"tyres.front.lateral.stiffness": front, "tyres.rear.lateral.stiffness": rear}


def smaller_wheels(**radii: float) -> Perturbation:
    """Wheels that are smaller by 1.5 and 3 % than the given radii [m], by wheel."""

    def smaller(share: float) -> dict[str, float]:
        return {f"wheels.{wheel}.radius": radius * (1.0 - share) for wheel, radius in radii.items()}

    levels = (AS_ASSUMED, Level("-1.5 %", smaller(0.015)), Level("-3 %", smaller(0.03)))
    return Perturbation("wheel_radius", "the wheels are smaller than the file says", levels)


def adaptive_damper(own_plant: str) -> Perturbation:
    """The dampers adapt, which only the MuJoCo car has; ``own_plant`` names the group's own plant."""
    levels = (
        Level(own_plant),
        Level("passive", plant="mujoco"),
        Level("adaptive", {"suspension.adaptive.mode": 1.0}, plant="mujoco"),
    )
    return Perturbation("adaptive_damper", "the dampers are adaptive (MuJoCo car)", levels)
