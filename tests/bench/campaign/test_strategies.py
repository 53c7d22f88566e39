"""Strategies on a made-up landscape of severity, whose hazardous points are known beforehand."""

from pathlib import Path

import pytest

from bench.campaign.adaptive import smallest_failing_sets
from bench.campaign.campaign_file import CampaignFile
from bench.campaign.fault_space import FaultSpace, Point
from bench.campaign.strategy import Result, strategy_of
from signals.yaml_files import parse_yaml, validate

SPACE = """
scenario: stops/dry
faults:
  - name: a
    stimulus: {target: valve_outlet_fl, step: 0}
    grid: {step: {from: 0, to: 39}, duration: {from: 1, to: 10}}
  - name: b
    stimulus: {target: valve_outlet_fr, step: 0}
    grid: {step: {from: 0, to: 39}, duration: {from: 1, to: 10}}
times: {from: 0 s, to: 4 s, steps: 21}
hazards: [{id: distance, value: stopping_distance, at_most: 50 m}]
"""


def space_of(strategy: str) -> FaultSpace:
    return FaultSpace(validate(parse_yaml(f"{SPACE}\nstrategy: {strategy}", "c.yaml"), CampaignFile))


def hill(space: FaultSpace, point: Point) -> Result:
    """Severity falls with the distance from step 30, duration 8, time 10 of fault a; some 2 % are hazardous."""
    best = 0.0
    for item in space.injections_of(point):
        step, duration, time = item.position
        away = abs(step - 30) / 10 + abs(duration - 7) / 4 + abs(time - 10) / 8
        best = max(best, (1.6 if item.name == "a" else 0.9) - 0.6 * away)
    return Result(best, best > 1.0)


def run(space: FaultSpace, landscape=hill) -> dict[Point, Result]:  # type: ignore[no-untyped-def]
    strategy, known = strategy_of(space), {}
    while batch := strategy.next(known):
        assert not set(batch) & set(known), "no point twice"
        assert len(set(batch)) == len(batch)
        known |= {point: landscape(space, point) for point in batch}
    return known


def hazardous(known: dict[Point, Result]) -> int:
    return sum(result.hazardous for result in known.values())


def test_exhaustive_runs_every_single_fault_once() -> None:
    space = space_of("exhaustive")
    known = run(space)
    assert len(known) == space.singles == 2 * 40 * 10 * 21


def test_a_sample_has_the_share_of_the_whole() -> None:
    every = run(space_of("exhaustive"))
    truth = hazardous(every) / len(every)
    sample = run(space_of("{kind: sampled, runs: 4000, seed: 3}"))
    assert len(sample) == 4000
    # 4 standard deviations of a sample without replacement
    tolerance = 4 * (truth * (1 - truth) / 4000) ** 0.5
    assert hazardous(sample) / 4000 == pytest.approx(truth, abs=tolerance)


def test_a_sample_of_a_small_space_ends_with_the_space() -> None:
    text = SPACE.replace("to: 39", "to: 1").replace("to: 10}", "to: 1}").replace("steps: 21", "steps: 2")
    space = FaultSpace(validate(parse_yaml(f"{text}\nstrategy: {{kind: sampled, runs: 1000}}", "c.yaml"), CampaignFile))
    assert len(run(space)) == space.singles == 2 * 2 * 2


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_adaptive_search_finds_ten_times_as_many_hazards_as_uniform_draws(seed: int) -> None:
    adaptive = run(space_of(f"{{kind: adaptive, runs: 600, seed: {seed}}}"))
    uniform = run(space_of(f"{{kind: sampled, runs: 600, seed: {seed}}}"))
    assert len(adaptive) == len(uniform) == 600
    assert hazardous(adaptive) >= 10 * hazardous(uniform)
    assert max(result.severity for result in adaptive.values()) == pytest.approx(1.6)


def test_the_same_results_lead_to_the_same_batches() -> None:
    text = "{kind: adaptive, runs: 300, seed: 5, faults_at_once: 2}"
    assert list(run(space_of(text))) == list(run(space_of(text)))


def pair(space: FaultSpace, point: Point) -> Result:
    """Hazardous only if faults of both kinds last longer than 5; more faults do not make it better."""
    long = {item.name for item in space.injections_of(point) if item.position[1] > 4}
    return Result(0.4 + 0.35 * len(long), len(long) == 2)


def test_sets_of_faults_are_made_as_small_as_they_can_be() -> None:
    space = space_of("{kind: adaptive, runs: 500, seed: 2, faults_at_once: 4}")
    known = run(space, pair)
    found = smallest_failing_sets(known)
    assert found
    assert len(found[0][1]) == 2
    assert {item.name for item in space.injections_of(found[0])} == {"a", "b"}


def test_the_file_of_the_landscape_has_the_share_that_the_tests_count_on() -> None:
    every = run(space_of("exhaustive"))
    assert 0.01 < hazardous(every) / len(every) < 0.04


def test_shipped_search_has_a_space_far_larger_than_its_budget() -> None:
    from bench.scenario.locate import scenario_files

    path = scenario_files()["campaigns/valve_bits_search"]
    campaign = validate(parse_yaml(Path(path).read_text(), str(path)), CampaignFile)
    assert FaultSpace(campaign).singles > 20 * (campaign.strategy.runs or 0)
