"""Stopping distance from delays and a constant deceleration, and its correction to a nominal start speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

LEGAL_RESPONSE_TIME_S = 0.36
"""Largest t_a + t_s/2 of a car of class M1 (Enisz 2015, l. 1580-1582)."""


@dataclass(frozen=True)
class BrakingDelays:
    """Times before the brakes act fully.

    Attributes
    ----------
    reaction_s, response_s, build_up_s
        t_r of the driver, t_a of the brake, t_s from the first to the full force.
    """

    reaction_s: float = 0.0
    response_s: float = 0.0
    build_up_s: float = 0.0

    @property
    def without_deceleration_s(self) -> float:
        """t_vz = t_r + t_a + t_s/2: the build-up counts as half without and half with full force (eq. 117)."""
        return self.reaction_s + self.response_s + self.build_up_s / 2.0

    @property
    def within_legal_limit(self) -> bool:
        """True if t_a + t_s/2 is at most 0.36 s (l. 1580)."""
        return self.response_s + self.build_up_s / 2.0 <= LEGAL_RESPONSE_TIME_S


def stopping_time(speed_m_s: ArrayLike, deceleration_m_s2: ArrayLike, delays: BrakingDelays) -> NDArray[np.float64]:
    """t_h = t_vz + v/a [s] (Enisz 2015, eq. 118)."""
    return np.asarray(delays.without_deceleration_s + np.divide(speed_m_s, deceleration_m_s2))


def stopping_distance(speed_m_s: ArrayLike, deceleration_m_s2: ArrayLike, delays: BrakingDelays) -> NDArray[np.float64]:
    """s_h = v t_vz + v^2/(2 a) [m] (Enisz 2015, eq. 119)."""
    speed = np.asarray(speed_m_s, float)
    return np.asarray(speed * delays.without_deceleration_s + speed**2 / (2.0 * np.asarray(deceleration_m_s2, float)))


def corrected_distance(
    distance_m: ArrayLike, measured_speed_m_s: ArrayLike, nominal_speed_m_s: float
) -> NDArray[np.float64]:
    """Braking distance as it would be from the nominal speed: s (v_nominal/v_measured)^2 [m].

    Source: friction document 4.5, rule 9 [REC], from eq. 119 without delay.
    """
    return np.asarray(np.asarray(distance_m, float) * (nominal_speed_m_s / np.asarray(measured_speed_m_s, float)) ** 2)


@dataclass(frozen=True)
class DistanceStatistics:
    """Result of repeated stops.

    Attributes
    ----------
    mean_m, standard_deviation_m
        Over the runs, the latter with n - 1.
    coefficient_of_variation
        Standard deviation over mean; the method asks for less than 3 % of at least 5 runs (l. 1658).
    """

    mean_m: float
    standard_deviation_m: float
    coefficient_of_variation: float
    runs: int

    @property
    def valid(self) -> bool:
        """True if there are enough runs and they scatter little enough."""
        return self.runs >= 5 and self.coefficient_of_variation < 0.03


def corrected_statistics(
    distances_m: Sequence[float], measured_speeds_m_s: Sequence[float], nominal_speed_m_s: float
) -> DistanceStatistics:
    """Correct each run to the nominal speed, then average.

    Raises
    ------
    ValueError
        If there are fewer than two runs or not as many speeds as distances.
    """
    if len(distances_m) != len(measured_speeds_m_s) or len(distances_m) < 2:
        raise ValueError(
            f"found {len(distances_m)} distances and {len(measured_speeds_m_s)} speeds, "
            "allowed: as many speeds as distances, at least two"
        )
    corrected = corrected_distance(distances_m, measured_speeds_m_s, nominal_speed_m_s)
    mean, deviation = float(corrected.mean()), float(corrected.std(ddof=1))
    return DistanceStatistics(mean, deviation, deviation / mean, len(distances_m))
