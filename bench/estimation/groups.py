"""What the estimators of a group are compared on: stops, settings, and the figures of their documents.

The estimators themselves and their groups are those of the registry (:mod:`estimators.registry`); a group that a new
document brings needs an entry here.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from signals.errors import unknown_name


@dataclass(frozen=True)
class Case:
    """A run that all estimators of a group see: a scenario with changes, as for ``--set``."""

    name: str
    scenario: str
    set: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Figure:
    """A figure that a document prints for a quantity."""

    quantity: str
    text: str
    source: str


@dataclass(frozen=True)
class Group:
    """How the estimators of a group are compared.

    Attributes
    ----------
    cases : tuple of Case
    variants : mapping of str to mapping
        Settings by the name that the estimator has in the comparison (``friction_ekf_z2`` is a second
        ``friction_ekf``).
    figures : tuple of Figure
        What the documents print, for the reader to set beside.
    phase : str
        What part of its runs is scored, in words.
    """

    title: str
    cases: tuple[Case, ...]
    variants: Mapping[str, Mapping[str, Any]]
    figures: tuple[Figure, ...] = ()
    phase: str = "over the run"


_NO_ABS = {"ecu.kind": "none"}
_FRICTION = "friction document"
_LOAD = "vertical-load document"
_FORCE = "force document"
_ATTITUDE = "attitude document"
ONE_FILTERS_OWN_NOISE = {
    "measurement_lateral_acceleration": 1.0,
    "measurement_roll_balance": 0.03,
    "measurement_yaw_balance": 3.0,
}
"""Settings of ``attitude_single`` that suit one filter best, chosen on the undisturbed slalom with seed 11."""
_SLALOM_OFFSET = "state/attitude_slalom_offset"
_LANE_CHANGE = "state/vertical_load_lane_change"
_STATE = "vehicle-state document"
_STATE_CAR = {"vehicle": "lada_vesta_assumed_steering"}

GROUPS: dict[str, Group] = {
    "friction": Group(
        "friction and braking",
        (
            Case("dry, ABS", "stops/dry"),
            Case("dry, locked", "stops/no_ecu"),
            Case("wet, ABS", "stops/wet"),
            Case("wet, locked", "stops/wet", _NO_ABS),
            Case("jump to 0.3, ABS", "stops/mu_jump_down"),
            Case("jump to 0.3, locked", "stops/mu_jump_down", _NO_ABS),
            Case("split, ABS", "stops/mu_split"),
            Case("split, locked", "stops/mu_split", _NO_ABS),
        ),
        {
            "friction_ekf": {"torque_mode": "known"},
            "friction_ekf_printed_sign": {"torque_mode": "known", "slip_rate_sign": -1},
            "friction_ekf_unknown_torque": {"torque_mode": "z2"},
            "friction_ekf_pitch_corrected": {"torque_mode": "known", "pitch_gradient": 0.0051},
            "friction_ukf": {"torque_mode": "known"},
            "friction_ukf_unknown_torque": {"torque_mode": "z2"},
            "force_ekf": {},
            "slip_slope_rls": {},
            "simple_braking": {},
            "cornering_stiffness_rls": {},
        },
        (
            Figure("speed", "RMSE at most 0.3 m/s, on a tuned twin 0.05", f"{_FRICTION} 4.8 A5"),
            Figure("speed", "RMSE 0.01 m/s with torques, 0.02 without, plant and filter alike", f"{_FRICTION} 3.6.8"),
            Figure("slip_front", "RMSE at most 0.02, on a tuned twin 0.005", f"{_FRICTION} 4.8 A6"),
            Figure("friction_limit_mean", "mean within 5 % of the truth, -5 ... +10 % under ABS", "4.8 A7 to A9"),
            Figure("friction_limit_mean", "within 5 % 0.14 s after the brake, 10 % 0.04 s after a jump", "3.6.8"),
            Figure("friction_limit_mean", "slip slope: 0.9 ... 1.1 within 1 s on dry asphalt", f"{_FRICTION} 4.8 A15"),
            Figure("friction_used_mean", "RMSE at most 0.05", f"{_FRICTION} 4.8 A10"),
            Figure("force_front", "force EKF: RMSE at most 10 % of m g/2 (636 N)", f"{_FRICTION} 4.8 A14"),
        ),
        "in braking",
    ),
    "state": Group(
        "vehicle state from production sensors",
        (
            Case("slalom, dry", "state/slalom_dry_asphalt"),
            Case("slalom, wet basalt", "state/slalom_wet_basalt"),
            Case("slalom, ice", "state/slalom_ice"),
            Case("bend with jumps", "state/mu_jump_in_bend"),
            Case("launch, dry", "state/launch_dry_asphalt"),
            Case("launch, ice", "state/launch_ice"),
            Case("launch, split", "state/launch_split"),
            Case("hill 6 %", "state/hill_6_up"),
            Case("stop, dry, ABS", "stops/dry", _STATE_CAR),
            Case("stop, dry, locked", "stops/no_ecu", _STATE_CAR),
            Case("stop, wet, ABS", "stops/wet", _STATE_CAR),
            Case("stop, wet, locked", "stops/wet", {**_STATE_CAR, **_NO_ABS}),
            Case("stop, jump, ABS", "stops/mu_jump_down", _STATE_CAR),
            Case("stop, jump, locked", "stops/mu_jump_down", {**_STATE_CAR, **_NO_ABS}),
            Case("stop, split, ABS", "stops/mu_split", _STATE_CAR),
            Case("stop, split, locked", "stops/mu_split", {**_STATE_CAR, **_NO_ABS}),
        ),
        {
            "vehicle_state_ukf": {},
            "wheel_sliding_mode": {},
            "magic_formula_fit": {},
            "road_grade": {},
            "observer_cascade": {},
            "observer_cascade_known_torque": {"longitudinal": {"brake_torque": "pressure"}},
        },
        (
            Figure("lateral_acceleration", "RMSE at most 11.1 % of the mean magnitude, slalom", f"{_STATE} 7 AC-25"),
            Figure("speed", "RMSE 0.95 % on ice, 2.1 % on icy snow, 5.1 % on dry asphalt", f"{_STATE} 7 AC-43 to 45"),
            Figure("road_grade", "mean error at most 6.2 % of the grade, length within 10 m", f"{_STATE} 7 AC-50, 51"),
        ),
        "in braking, else over the run",
    ),
    "load": Group(
        "vertical wheel loads",
        (
            Case("lane change, own car", _LANE_CHANGE),
            Case("lane change, own car, friction 0.2", _LANE_CHANGE, {"road.friction": 0.2}),
            Case("lane change, MuJoCo", _LANE_CHANGE, {"plant": "mujoco"}),
            Case("rough road, MuJoCo", "state/vertical_load_rough_road"),
        ),
        {
            "vertical_load_ukf": {},
            "vertical_load_ukf_set_a": {"noise_set": "a"},
            "vertical_load_ukf_printed": {"points": "diagonal", "redraw": False, "transfer": "steady"},
            "vertical_load_kf3": {},
            "vertical_load_kf2": {},
            "vertical_load_static": {},
        },
        (
            Figure("vertical_load_fl", "RMSE in E1: at rest 608 N, observers 36 to 52 N", f"{_LOAD} table 7.1"),
            Figure("vertical_load_fl", "RMSE in E2: at rest 583 N, observers 30 to 52 N", f"{_LOAD} table 7.1"),
            Figure("vertical_load_fl", "unscented over two sensors 0.48 ... 0.63 (unit printed wrong)", f"{_LOAD} 4"),
        ),
    ),
    "force": Group(
        "longitudinal axle forces",
        (Case("slalom, own car", "state/neural_force_slalom"),),
        {
            "neural_force_observer": {},
            "neural_force_observer_integral": {"network": "integral"},
            "neural_force_observer_no_network": {"network": "none"},
            "random_walk_force_ekf": {},
        },
        (
            Figure("force_front", "RMSE in S1 with noise: 43 N, random-walk filter 17.6 N", f"{_FORCE} 7 F5, F6"),
            Figure("force_rear", "RMSE in S1 with noise: 66 N, random-walk filter 61.7 N", f"{_FORCE} 7 F5, F6"),
            Figure("lateral_speed", "RMSE in S1 with noise: 0.0074 m/s, filter 0.0004 m/s", f"{_FORCE} 7 F5, F6"),
        ),
    ),
    "attitude": Group(
        "roll, pitch and sensor offsets",
        (
            Case("slalom, sound", "state/attitude_slalom"),
            Case("slalom, 100 mG", _SLALOM_OFFSET),
            Case("100 mG, banked", _SLALOM_OFFSET, {"road.bank": 0.07}),
        ),
        {
            "attitude_bank": {},
            "attitude_bank_fine": {
                "weighting": "accumulated",
                "virtual_offsets": [0.04 * 9.80665 * step for step in range(-4, 5)],
            },
            "attitude_bank_document": {"form": "car"},
            "attitude_bank_no_roll_balance": {"form": "car", "roll_balance": False},
            "attitude_single": {},
            "attitude_single_own_noise": ONE_FILTERS_OWN_NOISE,
            "attitude_augmented": {},
        },
        (
            Figure("roll_angle", "RMSE without offset: one filter 0.04 deg, bank 0.06, flat road", f"{_ATTITUDE} 6"),
            Figure("roll_angle", "RMSE with 100 mG: one filter 1.56 deg, bank 0.31, flat road", f"{_ATTITUDE} 6"),
            Figure("roll_angle", "RMSE with 100 mG: 1.71 deg, bank 1.36, road banked to 4 deg", f"{_ATTITUDE} 6"),
            Figure("roll_angle", "RMSE without roll balance: one filter 7.45 deg, bank 7.11", f"{_ATTITUDE} 6"),
            Figure("side_slip_angle", "RMSE with 100 mG: one filter 0.34 deg, bank 0.05", f"{_ATTITUDE} 6"),
        ),
    ),
}


def group_of(name: str) -> Group:
    """The comparison of a group.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    try:
        return GROUPS[name]
    except KeyError:
        raise unknown_name("group of estimators that can be compared", name, tuple(GROUPS)) from None
