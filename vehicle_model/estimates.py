"""Estimates for data that are unknown: inertias, frontal area, grip and how it is shared by two directions."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_model.inertias import frontal_area, pitch_inertia, roll_inertia, yaw_inertia

__all__ = [
    "friction_coefficient",
    "frontal_area",
    "largest_longitudinal_force",
    "maximum_friction",
    "pitch_inertia",
    "roll_inertia",
    "typical_static_friction",
    "yaw_inertia",
]

Values = NDArray[np.float64]


def friction_coefficient(force_x: ArrayLike, force_y: ArrayLike, vertical_load: ArrayLike) -> Values:
    """Instantaneous coefficient: resultant horizontal force over vertical load, all in N (Enisz 2015, eq. 1)."""
    return np.hypot(force_x, force_y) / np.abs(vertical_load)


def maximum_friction(largest_horizontal_force: ArrayLike, vertical_load: ArrayLike) -> Values:
    """Attainable coefficient |F_hor,max|/|F_z|, both forces in N (Kamm circle; Enisz 2015, eq. 23, l. 489)."""
    return np.asarray(np.abs(largest_horizontal_force) / np.abs(vertical_load))


def largest_longitudinal_force(maximum: ArrayLike, vertical_load: ArrayLike, force_y: ArrayLike) -> Values:
    """Largest braking or driving force [N] that keeps the grip while the tyre carries a lateral force.

    Parameters
    ----------
    maximum
        Attainable friction coefficient mu_max.
    vertical_load, force_y : N

    Returns
    -------
    force : N
        sqrt((mu_max F_z)^2 - F_y^2); zero where the lateral force alone uses up the grip.

    Source: Enisz 2015, l. 491 (verbal); friction document 2.1 [REC].
    """
    left = np.square(np.multiply(maximum, vertical_load)) - np.square(force_y)
    return np.sqrt(np.maximum(left, 0.0))


# speed [km/h]: new and used tyre on dry, wet 0.2 mm, wet 1 mm, puddle 2 mm
_TYPICAL = {
    50: {"new": (0.85, 0.65, 0.55, 0.5), "used": (1.0, 0.5, 0.4, 0.25)},
    90: {"new": (0.8, 0.6, 0.3, 0.05), "used": (0.95, 0.2, 0.1, 0.05)},
    130: {"new": (0.75, 0.55, 0.2, 0.0), "used": (0.9, 0.2, 0.1, 0.0)},
}
_FILMS = ("dry", "wet_0.2mm", "wet_1mm", "puddle_2mm")


def typical_static_friction(
    speed_m_s: float,
    film: Literal["dry", "wet_0.2mm", "wet_1mm", "puddle_2mm", "ice"],
    tyre: Literal["new", "used"] = "new",
) -> float:
    """Typical static friction coefficient, linear in speed between the rows of Table 1 and held outside them.

    A used tyre has a tread of at least 1.6 mm; for ice the upper bound 0.1 stands for all rows.

    Source: Enisz 2015, Table 1, l. 278-292.
    """
    if film == "ice":
        return 0.1
    column = _FILMS.index(film)
    speeds = sorted(_TYPICAL)
    values = [_TYPICAL[speed][tyre][column] for speed in speeds]
    return float(np.interp(speed_m_s * 3.6, speeds, values))
