"""Stops with constant use of friction beside the document's road tests (vehicle-state document 4.5, 7 AC-56).

The document compares nine stops with a production ABS with the same stops under an ideal controller that keeps the
tyres at the peak. Its percentages refer to the improved stop; the smaller ones on the base of the production ABS stand
beside.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

GRAVITY_M_S2 = 9.80665
MASS_KG = 1559.0
DRAG_KG_M = 0.45


@dataclass(frozen=True)
class TabulatedStop:
    """A row of the table of 4.5: SI units, friction as a magnitude."""

    number: int
    surface: str
    speed_km_h: float
    abs_distance_m: float
    abs_time_s: float
    improved_distance_m: float
    improved_friction: float
    improved_time_s: float


TABLE: tuple[TabulatedStop, ...] = (
    TabulatedStop(1, "snow", 100.0, 88.5, 6.445, 81.4, 0.476, 5.820),
    TabulatedStop(2, "snow", 100.0, 87.6, 6.480, 80.7, 0.471, 5.835),
    TabulatedStop(3, "snow", 100.0, 94.0, 6.685, 84.6, 0.476, 5.920),
    TabulatedStop(4, "snow", 80.0, 53.6, 4.815, 52.5, 0.478, 4.655),
    TabulatedStop(5, "snow", 80.0, 54.1, 4.850, 52.4, 0.478, 4.650),
    TabulatedStop(6, "ice", 60.0, 70.5, 8.565, 60.3, 0.239, 7.030),
    TabulatedStop(7, "ice", 60.0, 67.3, 8.025, 59.1, 0.239, 6.955),
    TabulatedStop(8, "ice", 60.0, 65.2, 7.810, 60.4, 0.238, 7.060),
    TabulatedStop(9, "ice", 60.0, 64.1, 7.795, 59.0, 0.239, 6.945),
)


@dataclass(frozen=True)
class Stop:
    """A stop of the model beside its row.

    Attributes
    ----------
    distance_error, time_error
        Of the model against the improved columns, relative.
    """

    row: TabulatedStop
    distance_m: float
    time_s: float

    @property
    def distance_error(self) -> float:
        """Distance of the model over the tabulated one, less one."""
        return self.distance_m / self.row.improved_distance_m - 1.0

    @property
    def time_error(self) -> float:
        """Time of the model over the tabulated one, less one."""
        return self.time_s / self.row.improved_time_s - 1.0


def stop(speed_m_s: float, friction: float) -> tuple[float, float]:
    """Distance [m] and time [s] of a straight stop with constant friction in use and the drag of the air.

    Exact solution of m dv/dt = -friction m g - 0.45 v^2 (eq. 3.1 with F_wx of listing B).
    """
    deceleration, drag = friction * GRAVITY_M_S2, DRAG_KG_M / MASS_KG
    distance = math.log1p(drag * speed_m_s**2 / deceleration) / (2.0 * drag)
    return distance, math.atan(speed_m_s * math.sqrt(drag / deceleration)) / math.sqrt(drag * deceleration)


def abs_study() -> list[Stop]:
    """The nine stops at the tabulated "improved" friction."""
    return [Stop(row, *stop(row.speed_km_h / 3.6, row.improved_friction)) for row in TABLE]


def mean_percentages(surface: str, rows: Iterable[TabulatedStop] = TABLE) -> dict[str, tuple[float, float]]:
    """Mean reduction of distance and time [%] over a surface's rows, on the base of the ABS and the improved stop."""
    chosen = [row for row in rows if row.surface == surface]
    result = {}
    for base in ("abs", "improved"):
        distances, times = [], []
        for row in chosen:
            to_distance = row.abs_distance_m if base == "abs" else row.improved_distance_m
            to_time = row.abs_time_s if base == "abs" else row.improved_time_s
            distances.append(100.0 * (row.abs_distance_m - row.improved_distance_m) / to_distance)
            times.append(100.0 * (row.abs_time_s - row.improved_time_s) / to_time)
        result[base] = sum(distances) / len(distances), sum(times) / len(times)
    return result
