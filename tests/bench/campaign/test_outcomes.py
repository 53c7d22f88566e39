"""Outcome classes and intervals, on rows written by hand: each class has a run that is just inside it."""

import dataclasses
from typing import Any

import pytest

from bench.campaign.campaign_file import Hazard
from bench.campaign.classification import NO_VALUE_SEVERITY, Judgement, classify, severity
from bench.campaign.statistics import share
from bench.execution.job import DONE, LOST, RunRow

HAZARDS = [
    Hazard(id="distance", value="stopping_distance", at_most=1.2, of_fault_free=True),
    Hazard(id="yaw", value="yaw", at_most="10 deg"),
]


def row(distance: float | None = 40.0, yaw: float = 0.01, **seen: Any) -> RunRow:
    frames = {"crc_errors": 0, "repeated": 0, "wrong_sequence": 0, "wrong_length": 0, "lost": 0, "accepted": 9}
    observations = {
        "motion": "as before",
        "began_s": 1.0,
        "fault_code_s": None,
        "fault_codes": [],
        "frames": frames | seen.pop("frames", {}),
        "bus": {},
    }
    criteria = {"distance": {"value": distance, "unit": "m"}, "yaw": {"value": yaw, "unit": "rad"}}
    return RunRow("k", "s", 1, "h", DONE, "pass", criteria, {}, observations | seen)


def judged(found: RunRow) -> Judgement:
    return classify(found, row(), HAZARDS, same_within=0.02)


@pytest.mark.parametrize(
    ("found", "outcome", "noticed"),
    [
        (row(), "no_effect", ""),
        (row(motion="other"), "silent_harmless", ""),
        (row(distance=40.3, motion="other", bus={"error_frames": 3}), "corrected", "bus"),
        (row(distance=42.0, motion="other", bus={"error_frames": 3}), "silent_harmless", "bus"),
        (row(frames={"crc_errors": 2}), "corrected", "frame check"),
        (row(distance=42.0, motion="other", frames={"repeated": 2}), "degraded_safely", "frame check"),
        (row(fault_codes=[3], fault_code_s=1.03, motion="other"), "degraded_safely", "monitor"),
        (row(distance=48.01, motion="other"), "hazardous", ""),
        (row(distance=47.99, motion="other"), "silent_harmless", ""),
        (row(yaw=0.175, fault_codes=[3], fault_code_s=1.03), "hazardous", "monitor"),
        (row(distance=None, motion="other"), "hazardous", ""),
        (dataclasses.replace(row(), outcome=LOST), "bench_error", ""),
    ],
)
def test_outcome_of_a_run(found: RunRow, outcome: str, noticed: str) -> None:
    judgement = judged(found)
    assert (judgement.outcome, judgement.noticed) == (outcome, noticed)


def test_latency_counts_from_the_fault_to_the_fault_code() -> None:
    assert judged(row(fault_codes=[3], fault_code_s=1.25)).latency_s == pytest.approx(0.25)


def test_a_code_that_the_fault_free_run_stores_too_is_no_detection() -> None:
    before = row(fault_codes=[3])
    assert classify(row(fault_codes=[3], fault_code_s=0.1), before, HAZARDS, 0.02).outcome == "no_effect"


def test_severity_is_the_share_of_the_limit() -> None:
    assert severity(HAZARDS[0], row(distance=48.0), row()) == pytest.approx(1.0)
    assert severity(HAZARDS[0], row(distance=24.0), row()) == pytest.approx(0.5)
    assert severity(HAZARDS[0], row(distance=None), row()) == NO_VALUE_SEVERITY
    least = Hazard(id="distance", value="stopping_distance", at_least="50 m")
    assert severity(least, row(distance=40.0), row()) == pytest.approx(1.2)


def test_hazards_are_named_and_the_worst_counts() -> None:
    judgement = judged(row(distance=60.0, yaw=0.2))
    assert judgement.hazards == ("distance", "yaw")
    assert judgement.severity == pytest.approx(60.0 / 48.0)


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    # Wilson 1927, 95 %: Newcombe, Stat. Med. 17 (1998) 857, Table I, method 3
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_interval_is_that_of_newcombe_s_table(count: int, total: int, low: float, high: float) -> None:
    found = share(count, total)
    assert (found.low, found.high) == (pytest.approx(low, abs=5e-5), pytest.approx(high, abs=5e-5))


def test_of_nothing_nothing_is_known() -> None:
    assert (share(0, 0).low, share(0, 0).high) == (0.0, 1.0)
