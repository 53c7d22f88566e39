"""What follows from a car's numbers, computed once before it runs."""

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.81

_FORWARD = np.array([1.0, 1.0, -1.0, -1.0])
_LEFTWARD = np.array([1.0, -1.0, 1.0, -1.0])


def derive(record: NDArray[np.void]) -> None:
    """Fill the derived fields of a car's record (shape ``(1,)``)."""
    p = record[0]
    front, rear = p["front_arm"], p["front_arm"] - p["wheelbase"]
    p["wheel_x"] = front, front, rear, rear
    tracks = np.array([p["track_front"], p["track_front"], p["track_rear"], p["track_rear"]])
    p["wheel_y"] = 0.5 * tracks * _LEFTWARD
    weight = 0.5 * p["mass"] * GRAVITY / p["wheelbase"]
    p["static_load"] = -weight * rear, -weight * rear, weight * front, weight * front
    p["inverse_mass"], p["inverse_yaw"] = 1.0 / p["mass"], 1.0 / p["yaw_inertia"]
    p["inverse_sprung"] = 1.0 / (p["mass"] - p["unsprung_mass"].sum())
    p["inverse_roll"], p["inverse_pitch"] = 1.0 / p["roll_inertia"], 1.0 / p["pitch_inertia"]
    p["steering_lag"] = p["steering_damping"] / p["steering_stiffness"]
    p["inverse_load"], p["inverse_capacity"] = 1.0 / p["reference_load"], 1.0 / p["heat_capacity"]
    p["inverse_nominal_load"] = 1.0 / p["nominal_load"]
    for letter, factor in (("x", "longitudinal_stiffness"), ("y", "cornering_stiffness")):
        p[f"inverse_peak_{letter}"] = p[factor] / p[f"peak_slip_{letter}"]
    p["inverse_peak_x"] /= 1.0 + p["peak_shift"]
    _derive_suspension(p, tracks)


def _derive_suspension(p: np.void, tracks: NDArray[np.float64]) -> None:
    """Springs and bars in series with the tyres: k k_t/(k + k_t) of the mean, (k + 2a) k_t/(k + 2a + k_t) of the half
    difference; what the links carry past the springs."""
    tyre, spring = p["vertical_stiffness"], p["spring_rate"]
    rolling = spring + 2.0 * p["anti_roll_rate"]
    p["mean_share"], p["half_share"] = tyre / (spring + tyre), tyre / (rolling + tyre)
    p["mean_rate"], p["half_rate"] = p["mean_share"] * spring, p["half_share"] * rolling
    pole = p["pitch_pole"] * float(p["wheel_x"] @ p["mean_rate"]) / float(p["mean_rate"].sum())
    p["pitch_arm"] = p["wheel_x"] - pole
    p["guide_brake"], p["guide_drive"] = -_FORWARD * p["brake_support"], -_FORWARD * p["drive_support"]
    p["guide_side"] = -_LEFTWARD * 2.0 * p["roll_centre_height"] / tracks
