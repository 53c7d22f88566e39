"""Help and words of `bench diagnose` and `bench vehicle fit`, and the catalogue that they print."""

import json

import pytest

from bench.cli import main
from model_diagnosis.effects.catalogue import EFFECTS


@pytest.mark.parametrize(
    "command",
    [
        "diagnose",
        "diagnose logs",
        "diagnose map",
        "diagnose explain",
        "diagnose effects",
        "diagnose plan",
        "diagnose challenge",
        "vehicle fit",
    ],
)
def test_every_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.split(), "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Example" in text
    assert f"bench {command}" in text


def test_the_help_of_the_group_shows_the_options_of_a_diagnosis(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "--help"]) == 0
    text = capsys.readouterr().out
    for word in ("LOG...", "--vehicle", "--channels", "--hold-out", "--out", "--json", "map", "explain", "plan"):
        assert word in text


def test_an_unknown_option_is_told_and_not_taken_for_a_log(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "--vehicel", "ekf_car", "log.csv"]) == 2
    assert "No such option: --vehicel" in capsys.readouterr().err


@pytest.mark.parametrize("name", [effect.name for effect in EFFECTS])
def test_every_effect_is_explained(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "explain", name]) == 0
    text = capsys.readouterr().out
    effect = next(effect for effect in EFFECTS if effect.name == name)
    assert effect.equation in text
    assert all(parameter.name in text for parameter in effect.parameters)
    assert main(["diagnose", "explain", name, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["confounded_with"] == list(effect.confounded_with)


def test_effects_of_a_group(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "effects", "brake_pad", "--json"]) == 0
    names = [effect["name"] for effect in json.loads(capsys.readouterr().out)]
    assert "brake_pad_friction" in names
    assert all("brake_pad" in name for name in names)


def test_the_python_interface_is_exported() -> None:
    import bench

    assert "diagnose" in bench.__all__
    assert bench.diagnose.__module__ == "bench.diagnosis.diagnosing"
