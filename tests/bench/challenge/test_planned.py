"""What a diagnosis proposes to record, as the hidden car records it."""

from pathlib import Path
from typing import Any

import pytest

from bench.challenge.generator import generate, record_further
from bench.challenge.planned import channel_of
from signals.measured import load_channel_map

SEED = 10_007


@pytest.mark.parametrize(
    ("proposal", "channel"),
    [("sensor:reference_pressure", "master_pressure"), ("sensor:speed", "speed"), ("hold_at_standstill", "")],
)
def test_a_proposed_sensor_is_a_channel_of_the_hidden_car(proposal: str, channel: str) -> None:
    assert channel_of(proposal) == channel


def test_the_second_gauge_of_the_brakes_is_recorded_where_it_is_proposed(tmp_path: Path) -> None:
    drawn_with: dict[str, Any] = {"seed": SEED, "family": "confounded", "generator": "first"}
    (case,) = generate(tmp_path / "cases", tmp_path / "sealed", count=1, **drawn_with)
    channel = channel_of("sensor:reference_pressure")
    assert channel not in load_channel_map(case / "channels.yaml").channels
    record_further(tmp_path / "more", index=0, script=None, channel=channel, **drawn_with)
    assert channel in load_channel_map(tmp_path / "more" / "channels.yaml").channels
