"""The process that compiles ECU and estimators beside the car."""

import subprocess
import sys

import pytest

from bench.loop.compile_apart import Helper
from bench.scenario.resolution import resolve

MODULE = [sys.executable, "-m", "bench.loop.compile_apart"]


@pytest.mark.parametrize("ecu", ["emulated", "inprocess", "none"])
def test_it_goes_through_a_scenario_as_text(ecu: str) -> None:
    scenario = resolve("friction/e4_abs_dry_95", {"ecu.kind": ecu})
    text = scenario.model_dump_json(by_alias=True)
    ended = subprocess.run(MODULE, input=text, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "ecu\n", "")


def test_a_helper_that_dies_is_no_hindrance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    helper = Helper(resolve("stops/dry"))
    helper.wait_for_ecu()
    helper.wait()
