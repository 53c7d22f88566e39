import math
from typing import Any

import pytest

from bench.report.criteria_table import criterion_rows, tally
from bench.report.formatting import limits_text, metric_label, number, quantity, size_text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (5.0, "5"),
        (44.83, "44.83"),
        (44.8349, "44.83"),
        (-0.1312, "−0.1312"),
        (0.00001234, "1.23e−05"),
        (1234567.0, "1234567"),
        (math.inf, "∞"),
        (math.nan, "–"),
        (None, "–"),
        (True, "yes"),
        ("text", "text"),
    ],
)
def test_numbers_are_written_as_people_write_them(value: Any, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.2e7, "Pa", "120 bar"),
        (math.pi / 2, "rad", "90°"),
        (math.pi, "rad/s", "180°/s"),
        (8.61, "m/s^2", "8.61 m/s²"),
        (0.104, "1", "0.104"),
        (4e-6, "m^3", "4 cm³"),
    ],
)
def test_quantities_carry_the_unit_that_people_use(value: float, unit: str, text: str) -> None:
    assert quantity(value, unit) == text


@pytest.mark.parametrize(
    ("limits", "unit", "text"),
    [
        ([None, 47.5], "m", "≤ 47.5 m"),
        ([8.0, None], "m/s^2", "≥ 8 m/s²"),
        ([5e5, 2e6], "Pa", "5 … 20 bar"),
        ([1.0, 1.0], "1", "= 1"),
        ([None, None], "m", ""),
        (None, "m", ""),
    ],
)
def test_limits_read_as_a_condition(limits: Any, unit: str, text: str) -> None:
    assert limits_text(limits, unit) == text


@pytest.mark.parametrize(
    ("name", "label", "unit"),
    [
        ("stopping_distance_m", "stopping distance", "m"),
        ("mean_deceleration_m_s2", "mean deceleration", "m/s^2"),
        ("mfdd_m_s2", "MFDD", "m/s^2"),
        ("max_abs_yaw_rate_rad_s", "largest yaw rate", "rad/s"),
        ("lock_time_s", "lock time", "s"),
        ("slip_mean", "slip mean", "1"),
    ],
)
def test_metric_names_carry_their_unit(name: str, label: str, unit: str) -> None:
    assert metric_label(name) == (label, unit)


def test_sizes() -> None:
    assert [size_text(size) for size in (12, 48_300, 2_340_000)] == ["12 B", "48 kB", "2.3 MB"]


def test_worst_criterion_stands_first_and_every_text_is_there() -> None:
    base = {"requirement": "R 1", "unit": "s", "limits": [None, 0.1], "description": "lock", "source": ""}
    verdict = {
        "criteria": [
            {**base, "id": "good", "value": 0.04, "margin": 0.6, "verdict": "pass"},
            {**base, "id": "unclear", "value": None, "margin": None, "verdict": "inconclusive", "reason": "no ABS"},
            {
                **base,
                "id": "bad",
                "value": 0.131,
                "margin": -0.31,
                "verdict": "fail",
                "values": [0.131, 0.0, 0.02, 0.0],
            },
            {**base, "id": "never", "value": None, "margin": None, "verdict": "fail", "reason": "never reached"},
        ]
    }
    rows = criterion_rows(verdict)
    assert [row.name for row in rows] == ["bad", "never", "unclear", "good"]
    assert (rows[0].value, rows[0].limits, rows[0].margin) == ("0.131 s", "≤ 0.1 s", "−31 %")
    assert rows[0].wheels == "FL 0.131 s, FR 0 s, RL 0.02 s, RR 0 s"
    assert rows[1].value == "never reached"
    assert rows[2].reason == "no ABS"
    assert rows[3].margin == "+60 %"
    assert tally(verdict) == "4 criteria: 1 pass, 1 inconclusive, 2 fail"


def test_margin_of_zero_has_no_sign() -> None:
    row = criterion_rows({"criteria": [{"id": "x", "value": 1, "margin": 0.0, "limits": [None, 1], "verdict": "pass"}]})
    assert row[0].margin == "0 %"
