"""Campaign files: what they allow, and that every shipped one is good."""

from pathlib import Path

import pytest

from bench.campaign.campaign_file import CampaignFile
from bench.campaign.engine import read_campaign
from bench.campaign.fault_space import FaultSpace
from bench.scenario.locate import scenario_files
from signals.errors import FileFaults
from signals.yaml_files import parse_yaml, validate

HAZARDS = "hazards: [{id: distance, value: stopping_distance, at_most: 60 m}]"
SMALL = Path(__file__).parent / "small.yaml"


def faults_of(text: str) -> list[str]:
    with pytest.raises(FileFaults) as raised:
        validate(parse_yaml(text, "c.yaml"), CampaignFile)
    return [str(fault) for fault in raised.value.faults]


HEAD = """
scenario: stops/dry
hazards: [{id: distance, value: stopping_distance, at_most: 50 m}]
"""


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("faults: [{name: a, fault: {}}]", "faults need instants"),
        ("faults: [{name: a}]\ntimes: [1]", "one of three kinds"),
        ("faults: [{name: a, fault: {}, set: {}}]\ntimes: [1]", "one of three kinds"),
        ("faults: [{name: a, set: {}}, {name: a, set: {}}]", "stands here twice"),
        ("faults: [{name: a, set: {}}]\nstrategy: sampled", "number of runs"),
        ("faults: [{name: a, set: {}}]\nstrategy: {kind: exhaustive, runs: 5}", "every single fault is run"),
        ("faults: [{name: a, set: {}, grid: {x: []}}]", "no values"),
        ("faults: [{name: a, set: {}}]\nlimits: [{quantity: hazardous_runs}]", "no limit"),
        ("faults: [{name: a, set: {}}]\nlimits: [{quantity: hazardous_runs, fault: b, at_most: 0}]", "no such fault"),
    ],
)
def test_what_does_not_fit_is_told_with_its_place(text: str, told: str) -> None:
    faults = faults_of(HEAD + text)
    assert any(told in fault for fault in faults)
    assert all(fault.startswith("c.yaml:") for fault in faults)


def test_faults_of_an_entry_have_the_place_of_the_entry_in_the_campaign(tmp_path: Path) -> None:
    text = SMALL.read_text().replace("duration: 0.8 s", "durtion: 0.8 s").replace("pad_friction", "pad_frition")
    bad = tmp_path / "bad.yaml"
    bad.write_text(text.replace("../whole_runs", str(SMALL.parents[1] / "whole_runs")))
    with pytest.raises(FileFaults) as raised:
        read_campaign(bad)
    told = [(fault.line, fault.problem) for fault in raised.value.faults]
    lines = bad.read_text().splitlines()
    assert [lines[line - 1].split(":")[0].strip() for line, _ in told] == ["stimulus", "set"]
    assert "durtion" in told[0][1]
    assert "pad_frition" in told[1][1]


def test_a_level_that_no_run_can_have_is_refused_before_the_first_run(tmp_path: Path) -> None:
    entry = "fault: {trigger: {id: 0x122}, disturbance: {drop: {}}, requires: bit_model}"
    bad = tmp_path / "bad.yaml"
    bad.write_text(f"scenario: stops/dry\nfaults:\n  - name: lost\n    {entry}\ntimes: [0.5 s]\n{HAZARDS}")
    with pytest.raises(FileFaults) as raised:
        read_campaign(bad)
    (told,) = raised.value.faults
    assert (told.line, told.problem) == (4, "requires: drop requires bit_model")
    assert told.found == "here it is realised as frame_gateway"
    bad.write_text(bad.read_text().replace("bit_model", "frame_gateway"))
    read_campaign(bad)


@pytest.mark.parametrize("name", sorted(name for name in scenario_files() if name.startswith("campaigns/")))
def test_every_shipped_campaign_is_good(name: str) -> None:
    campaign = read_campaign(scenario_files()[name])
    assert campaign.title
    assert campaign.id == name
    assert FaultSpace(campaign).singles > 0


def test_values_of_a_grid_are_combined_and_put_where_the_path_says() -> None:
    text = """
faults:
  - name: late
    fault: {trigger: {id: 1}, disturbance: {delay: {by: 1 ms}}}
    grid: {disturbance.delay.by: [20 ms, 50 ms], trigger.id: {from: 288, to: 290, step: 2}}
times: {from: 0.5 s, to: 1.5 s, steps: 3}
seeds: {first: 4, count: 2}
"""
    space = FaultSpace(validate(parse_yaml(HEAD + text, "c.yaml"), CampaignFile))
    assert space.singles == 2 * 2 * 3 * 2
    last = space.injections[-1]
    assert last.entry == {"trigger": {"id": 290, "from": 1.5}, "disturbance": {"delay": {"by": "50 ms"}}}
    assert last.label == "late[by=50 ms,id=290]"
    assert (last.place.message, last.place.e2e, last.place.level) == ("0x122", "delay", "frame_gateway")
    assert {space.injections[number].text for number in space.neighbours(len(space.injections) - 1)} == {
        "late[by=20 ms,id=290] at 1.5 s",
        "late[by=50 ms,id=288] at 1.5 s",
        "late[by=50 ms,id=290] at 1 s",
    }


def test_the_key_of_a_run_stays_when_the_campaign_grows() -> None:
    few = "faults: [{name: b, set: {brakes.front.pad_friction: 0.2}}]"
    more = "faults: [{name: a, set: {body.mass: 1}}, {name: b, set: {brakes.front.pad_friction: 0.2}}]\nseeds: [5, 1]"
    small = FaultSpace(validate(parse_yaml(HEAD + few, "c.yaml"), CampaignFile))
    large = FaultSpace(validate(parse_yaml(HEAD + more, "c.yaml"), CampaignFile))
    assert small.key((0, (0,), 0)) == large.key((0, (1,), 1))
    keys = [large.key(point) for point in [*large.every_single(), *large.fault_free()]]
    assert len(set(keys)) == len(keys) == 2 * 2 + 2
