"""Stopping-distance model against Table 9 of the friction document, speed correction against its Tables 12 and 13."""

from collections.abc import Callable

import numpy as np
import pytest

from vehicle_model.stopping_distance import (
    BrakingDelays,
    corrected_distance,
    corrected_statistics,
    stopping_distance,
    stopping_time,
)

SPEEDS_KMH = (10, 30, 50, 60, 70, 80, 90, 100, 120, 140, 160, 180, 200)
TABLE_9 = {
    4.4: (3.7, 16, 36, 48, 62, 78, 96, 115, 160, 210, 270, 335, 405),
    5.0: (3.5, 15, 33, 44, 57, 71, 87, 105, 145, 190, 240, 300, 365),
    5.8: (3.4, 14, 30, 40, 52, 65, 79, 94, 130, 170, 215, 265, 320),
    7.0: (3.3, 13, 28, 36, 46, 57, 70, 83, 110, 145, 185, 230, 275),
    8.0: (3.3, 13, 26, 34, 43, 53, 64, 79, 105, 135, 170, 205, 250),
    9.0: (3.2, 12, 25, 32, 40, 50, 60, 71, 95, 125, 155, 190, 225),
}
DELAY_ONLY = (2.8, 8.3, 14, 17, 19, 22, 25, 28, 33, 39, 44, 50, 56)
MISPRINT = (8.0, 100)
ONE_SECOND = BrakingDelays(reaction_s=1.0)


def printing_step(printed: float) -> float:
    """Step in which a cell is printed: 0.1 m below 10 m, 5 m above 100 m, else 1 m."""
    return 0.1 if printed < 10 else 5.0 if printed >= 100 else 1.0


CELLS = [
    (a, v, printed)
    for a, row in TABLE_9.items()
    for v, printed in zip(SPEEDS_KMH, row, strict=True)
    if (a, v) != MISPRINT
]


@pytest.mark.acceptance("F-29")
@pytest.mark.parametrize(("deceleration", "speed_kmh", "printed"), CELLS)
def test_table_9(deceleration: float, speed_kmh: int, printed: float, record: Callable[..., None]) -> None:
    distance = float(stopping_distance(speed_kmh / 3.6, deceleration, ONE_SECOND))
    # the table is rounded to its step, but some cells are cut off to it (40.61 m is printed 40)
    step = printing_step(printed)
    record("less printed, in printed steps", (distance - printed) / step, "rounded or cut off: within -0.5 ... 1")
    assert abs(distance - printed) <= step / 2 or 0 <= distance - printed < step


@pytest.mark.acceptance("F-29")
def test_table_9_delay_row() -> None:
    for speed_kmh, printed in zip(SPEEDS_KMH, DELAY_ONLY, strict=True):
        distance = float(stopping_distance(speed_kmh / 3.6, np.inf, ONE_SECOND))
        assert abs(distance - printed) <= (0.05 if printed < 10 else 0.5)


@pytest.mark.acceptance("F-29")
def test_table_9_misprint_is_76_m(record: Callable[..., None]) -> None:
    distance = float(stopping_distance(100 / 3.6, 8.0, ONE_SECOND))
    record("8 m/s^2 from 100 km/h, m", distance, "76 (printed 79)")
    assert round(distance) == 76
    assert abs(distance - 79.0) > 2.0


def test_delays_combine_as_eq_117_and_118() -> None:
    delays = BrakingDelays(reaction_s=0.7, response_s=0.1, build_up_s=0.2)
    assert delays.without_deceleration_s == pytest.approx(0.9)
    assert float(stopping_time(20.0, 8.0, delays)) == pytest.approx(0.9 + 2.5)
    assert delays.within_legal_limit
    assert not BrakingDelays(response_s=0.3, build_up_s=0.13).within_legal_limit


# v_avg [km/h], s_avg [m], s_corr [m], nominal speed [km/h], tolerance (document 4.5: 0.1 %, two cells 1 %)
TABLES_12_AND_13 = [
    (106.823, 48.497, 42.107, 100.0, 0.011),
    (100.313, 40.553, 40.197, 100.0, 0.011),
    (102.193, 46.693, 44.700, 100.0, 0.001),
    (103.803, 44.497, 41.313, 100.0, 0.001),
    (80.147, 30.853, 30.743, 80.0, 0.001),
    (79.297, 29.667, 30.190, 80.0, 0.001),
]


@pytest.mark.acceptance("F-30")
@pytest.mark.parametrize(("measured", "distance", "printed", "nominal", "tolerance"), TABLES_12_AND_13)
def test_speed_correction(
    measured: float, distance: float, printed: float, nominal: float, tolerance: float, record: Callable[..., None]
) -> None:
    corrected = float(corrected_distance(distance, measured / 3.6, nominal / 3.6))
    record("over printed", corrected / printed, "0.989 ... 1.011")
    assert corrected == pytest.approx(printed, rel=tolerance)


def test_statistics_correct_each_run_before_averaging() -> None:
    speeds = np.array([27.0, 27.5, 28.0, 28.5, 29.0])
    distances = speeds**2 / (2 * 9.0)
    result = corrected_statistics(list(distances), list(speeds), 100 / 3.6)
    assert result.mean_m == pytest.approx((100 / 3.6) ** 2 / 18.0, rel=1e-12)
    assert result.standard_deviation_m == pytest.approx(0.0, abs=1e-12)
    assert result.valid
    assert not corrected_statistics([40.0, 42.0, 41.0], [27.8, 27.8, 27.8], 27.8).valid
    with pytest.raises(ValueError, match="as many speeds as distances"):
        corrected_statistics([40.0, 41.0], [27.8], 27.8)
