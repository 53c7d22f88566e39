"""Rating of ISO/TS 18571 against an independent implementation and against numbers worked by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from model_diagnosis.rating import Rating, grade, rate

TIME = np.arange(400) / 100.0
STOP = -8 * (1 - np.exp(-TIME / 0.3)) * np.exp(-(((TIME - 2.0) / 1.6) ** 4)) + 0.4 * np.sin(2 * np.pi * 3 * TIME)

REPLAYS = {
    "late": np.interp(TIME - 0.13, TIME, STOP),
    "weak": 0.8 * STOP,
    "offset": STOP + 1.5,
    "rough": STOP + 0.8 * np.sin(2 * np.pi * 7 * TIME),
    "other": -6 * np.sin(np.pi * TIME / 4) ** 2,
    "early_strong": 1.3 * np.interp(TIME + 0.31, TIME, STOP),
    "opposite": -STOP,
}

# objective-rating-metrics 1.3 (Graz University of Technology, openVT), unrounded: corridor, phase, magnitude, slope, R
ORACLE = {
    "late": (0.849311, 0.837500, 1.000000, 1.000000, 0.907224),
    "weak": (0.665857, 1.000000, 0.807751, 0.900000, 0.807893),
    "offset": (0.509583, 1.000000, 0.787795, 1.000000, 0.761392),
    "rough": (0.917854, 1.000000, 0.907043, 0.068460, 0.762242),
    "other": (0.247603, 0.937500, 0.465684, 0.578090, 0.495296),
    "early_strong": (0.364477, 0.612500, 0.716042, 0.850000, 0.581499),
    "opposite": (0.060861, 0.000000, 0.000000, 0.366360, 0.097616),
}


def scores(rating: Rating) -> tuple[float, ...]:
    return rating.corridor, rating.phase, rating.magnitude, rating.slope, rating.overall


@pytest.mark.parametrize("name", ORACLE)
def test_scores_are_those_of_an_independent_implementation(name: str) -> None:
    assert scores(rate(STOP, REPLAYS[name])) == pytest.approx(ORACLE[name], abs=1e-6)


def test_equal_curves_rate_one() -> None:
    assert scores(rate(STOP, STOP)) == (1.0, 1.0, 1.0, 1.0, 1.0)


def test_corridor_by_hand() -> None:
    """A quarter of the samples each at 0, 10, 27.5 and 60 % of the largest value off: 1, (40/45)², 0.5² and 0."""
    reference = np.zeros(100)
    reference[50] = 10.0
    model = reference + np.repeat([0.0, 1.0, 2.75, 6.0], 25)
    assert rate(reference, model).corridor == pytest.approx((1 + (40 / 45) ** 2 + 0.25 + 0) / 4, abs=1e-12)


@pytest.mark.parametrize(("late", "score"), [(0, 1.0), (10, 0.5), (19, 0.05), (20, 0.0)])
def test_phase_by_hand(late: int, score: float) -> None:
    """100 samples: a shift of 20 is as much as counts; a pulse that is late by n samples loses n/20."""
    place = np.arange(100.0)

    def pulse(centre: float) -> NDArray[np.float64]:
        return np.exp(-(((place - centre) / 3.0) ** 2))

    assert rate(pulse(40), pulse(40 + late)).phase == pytest.approx(score, abs=1e-12)
    assert rate(pulse(40 + late), pulse(40)).phase == pytest.approx(score, abs=1e-12)


def test_slope_by_hand() -> None:
    """A ramp half as steep has half the slope error of 2 allowed: 1 - 0.5/2."""
    assert rate(np.arange(50.0), 0.5 * np.arange(50.0)).slope == pytest.approx(0.75, abs=1e-12)


def test_magnitude_by_hand() -> None:
    """On constant curves warping changes nothing: 10 % too much is a fifth of the 50 % allowed."""
    assert rate(np.full(50, 10.0), np.full(50, 11.0)).magnitude == pytest.approx(0.8, abs=1e-12)


def test_grades_of_the_document() -> None:
    assert [grade(value) for value in (1.0, 0.94, 0.80, 0.58)] == ["excellent", "good", "fair", "poor"]


@pytest.mark.parametrize(
    ("measured", "replayed", "message"),
    [
        (np.zeros(30), np.zeros(31), "shape"),
        (np.zeros(10), np.zeros(10), "at least 20"),
        (np.zeros(30), np.full(30, np.nan), "not finite"),
    ],
)
def test_curves_that_cannot_be_rated(
    measured: NDArray[np.float64], replayed: NDArray[np.float64], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        rate(measured, replayed)
