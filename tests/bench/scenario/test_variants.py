"""Variants: lists, grids, ranges, draws, and their combination."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from bench.scenario.documents import read_document
from bench.scenario.locate import find_scenario
from bench.scenario.resolution import resolve, variants_of
from bench.scenario.variants import Variants, expand
from signals.errors import InputError


def sets(data: dict[str, object]) -> list[dict[str, object]]:
    return [dict(variant.sets) for variant in expand(Variants.model_validate(data))]


def test_a_grid_is_every_combination_and_the_last_varies_fastest() -> None:
    assert sets({"grid": {"a": [1, 2], "b": ["x", "y"]}}) == [
        {"a": 1, "b": "x"},
        {"a": 1, "b": "y"},
        {"a": 2, "b": "x"},
        {"a": 2, "b": "y"},
    ]


def test_a_range_keeps_its_unit_and_both_ends() -> None:
    values = [
        entry["v"] for entry in sets({"range": {"parameter": "v", "from": "60 km/h", "to": "120 km/h", "steps": 4}})
    ]
    assert values == ["60 km/h", "80 km/h", "100 km/h", "120 km/h"]


def test_draws_repeat_with_their_seed() -> None:
    data = {
        "random": {
            "count": 200,
            "seed": 3,
            "parameters": {"m": {"normal": ["1300 kg", "50 kg"]}, "f": {"uniform": [0, 1]}},
        }
    }
    first, again = sets(data), sets(data)
    assert first == again
    masses = [float(str(entry["m"]).split()[0]) for entry in first]
    # mean and deviation of 200 draws: four standard errors
    assert abs(sum(masses) / 200 - 1300) < 4 * 50 / 200**0.5
    assert all(0 <= float(str(entry["f"])) <= 1 for entry in first)
    assert sets({**data, "random": {**data["random"], "seed": 4}}) != first


def test_kinds_are_combined() -> None:
    data = {"list": [{"name": "p", "set": {"x": 1}}, {"name": "q", "set": {"x": 2}}], "grid": {"y": [3, 4]}}
    assert [variant.name for variant in expand(Variants.model_validate(data))] == ["p,y=3", "p,y=4", "q,y=3", "q,y=4"]


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"grid": {"a": 3}},
        {"list": [{"name": "p", "set": {}}, {"name": "p", "set": {}}]},
        {"range": {"parameter": "v", "from": "1 m", "to": "2 s", "steps": 3}},
        {"random": {"count": 3, "parameters": {"m": {}}}},
        {"grid": {"a": list(range(1000)), "b": list(range(1000))}},
    ],
)
def test_what_is_refused(data: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Variants.model_validate(data)


def test_a_shipped_variant_resolves_by_name() -> None:
    scenario = resolve("friction/e11_zero_torque_z2", variant="e7")
    assert scenario.id == "friction/e11_zero_torque_z2[e7]"
    assert scenario.ecu.kind == "none"
    assert scenario.overrides["tyres.front.longitudinal.peak_friction"] == 0.70
    assert scenario.variants is None
    names = [entry.name for entry in variants_of(read_document(find_scenario("friction/e11_zero_torque_z2")))]
    assert names == ["e6", "e7", "e9", "e10"]
    with pytest.raises(InputError, match="variant"):
        resolve("friction/e11_zero_torque_z2", variant="e77")


def test_a_faulty_variant_is_placed_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("manoeuvre: {steps: [{name: a, release: true}]}\nvariants:\n  list: [{nme: x, set: {}}]\n")
    with pytest.raises(InputError, match=r"a.yaml:3:11  variants.list\[0\].nme: unknown field"):
        variants_of(read_document(path))
