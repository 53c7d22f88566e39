"""Reading of YAML files: places, faults of syntax, merge keys, overlays, faults of validation all at once."""

from pathlib import Path
from typing import Literal

import pytest
from pydantic import Field, model_validator

from signals.errors import FieldError, FileFaults, InputError
from signals.quantities import FileModel, parameter
from signals.yaml_files import Document, Place, load_yaml, overlay, parse_yaml, validate, walk


class Brake(FileModel):
    pedal_force: float = parameter("N", low=0, high=1500)
    ramp: float = parameter("Pa/s", 4e7, low=1e5)


class Step(FileModel):
    name: str
    brake: Brake | None = None


class Car(FileModel):
    mass: float = parameter("kg", low=100, high=10000)
    drive: Literal["front", "rear"] = "rear"
    steps: list[Step] = Field(default_factory=list)
    gears: int = Field(5, ge=1, le=9)
    light: bool = False
    tyre: Brake | str = ""

    @model_validator(mode="after")
    def _no_light_trucks(self) -> "Car":
        if self.light and self.mass > 2000:
            raise FieldError("too heavy for a light car", at=("mass",), allowed="at most 2000 kg")
        return self


def faults(text: str) -> str:
    with pytest.raises(FileFaults) as caught:
        validate(parse_yaml(text, "car.yaml"), Car)
    return caught.value.message


def test_places_count_from_one() -> None:
    document = parse_yaml("mass: 1 t\nsteps:\n  - name: a\n    brake: {pedal_force: 3}\n", "car.yaml")
    assert document.data == {"mass": "1 t", "steps": [{"name": "a", "brake": {"pedal_force": 3}}]}
    assert document.place(("steps", 0, "brake", "pedal_force")) == Place("car.yaml", 4, 26)
    assert document.place(("steps", 0, "brake", "pedal_force"), key=True) == Place("car.yaml", 4, 13)
    assert document.place(("steps", 0, "absent")) == Place("car.yaml", 3, 5)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e3", 1000.0),
        ("0x120", 288),
        ("yes", "yes"),
        ("on", "on"),
        ("true", True),
        ("2024-01-01", "2024-01-01"),
        ("010", 10),
        ("1_000", 1000),
        ("~", None),
        ("'5'", "5"),
        ("-.5", -0.5),
        ("80 km/h", "80 km/h"),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    read = parse_yaml(f"a: {text}", "x").data["a"]
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "car.yaml:1:1  the file is empty"),
        ("a: 1\n\tb: 2", "car.yaml:2:1  not YAML: a tab in the indentation\n  allowed: spaces"),
        ("a: b: c", "car.yaml:1:5  not YAML: a ':' that starts no field"),
        ("a: [1, 2", "car.yaml:1:9  not YAML"),
        ("a: 1\n---\nb: 2", "not YAML: a second document"),
        ("a: *b", "car.yaml:1:4  not YAML: found undefined alias 'b'"),
        ("a: @b", "car.yaml:1:4  not YAML: found character '@'"),
        ("a: 1\nb: 2\na: 3", "car.yaml:3:1  a: stands here twice (first in line 1)"),
        ("a: !!python/name:os.system x", "car.yaml:1:4  a: found the tag"),
        ("a: &a [*a]", "an alias (*) that contains itself"),
        ("? [1]\n: 2", "a field needs a name"),
        ("<<: 3", "a merge key (<<) without a mapping"),
        ("a: \x07", "not YAML"),
    ],
)
def test_faults_of_syntax(text: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_yaml(text, "car.yaml")
    assert expected in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 6


def test_aliases_cannot_blow_up() -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 9)]
    with pytest.raises(InputError, match="too many values"):
        parse_yaml("\n".join(lines), "bomb.yaml")


def test_merge_keys() -> None:
    document = parse_yaml("a: &a {x: 1, y: 2}\nb:\n  <<: *a\n  y: 3\n", "car.yaml")
    assert document.data["b"] == {"y": 3, "x": 1}
    assert document.place(("b", "x")).line == 1


def test_missing_and_unreadable_files(tmp_path: Path) -> None:
    (tmp_path / "scenario.yaml").write_text("a: 1")
    (tmp_path / "binary.yaml").write_bytes(b"a: 1\nb: \xff\xfe\x00")
    with pytest.raises(InputError, match="no such file") as caught:
        load_yaml(tmp_path / "scenaro.yaml")
    assert "did you mean" in str(caught.value)
    with pytest.raises(InputError, match="is a folder"):
        load_yaml(tmp_path)
    with pytest.raises(InputError, match=r"binary.yaml:2:1  not a text file"):
        load_yaml(tmp_path / "binary.yaml")
    assert load_yaml(tmp_path / "scenario.yaml").data == {"a": 1}


def test_a_misspelt_required_field_is_one_fault() -> None:
    text = "mass: 1 t\nsteps:\n- name: brake\n  brake:\n    pedal_forse: 400"
    assert faults(text).splitlines() == [
        "car.yaml:5:5  steps[0].brake.pedal_forse: unknown field",
        "  found 400; did you mean pedal_force (0…1500 N)?",
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("drive: front", "car.yaml:1:1  mass: required field is missing\n  allowed: 100…10000 kg"),
        (
            "mass: 5 bar",
            "car.yaml:1:7  mass: wrong dimension, a quantity in Pa\n  found '5 bar'; allowed: a number in kg",
        ),
        ("mass: 5", "car.yaml:1:7  mass: out of range\n  found 5; allowed: 100…10000 kg"),
        ("mass: [1]", "car.yaml:1:7  mass: not a number\n  found a list of 1; allowed: 100…10000 kg"),
        ("mass: .nan", "car.yaml:1:7  mass: not a finite number"),
        ("mass:", "car.yaml:1:1  mass: not a number\n  found nothing"),
        ("mass: 1 t\ndrive: raer", "car.yaml:2:8  drive: unknown value\n  found 'raer'; did you mean rear?"),
        ("mass: 1 t\ngears: 2.5", "car.yaml:2:8  gears: not a whole number\n  found 2.5; allowed: 1…9"),
        ("mass: 1 t\ngears: 12", "car.yaml:2:8  gears: out of range\n  found 12; allowed: 1…9"),
        ("mass: 1 t\nlight: maybe", "car.yaml:2:8  light: not true or false\n  found 'maybe'"),
        ("mass: 1 t\nsteps: 3", "car.yaml:2:8  steps: not a list\n  found 3"),
        ("mass: 1 t\nsteps: [3]", "car.yaml:2:9  steps[0]: not a mapping of fields\n  found 3; allowed: fields: name"),
        (
            "mass: 1 t\ntyre: 3",
            "car.yaml:2:7  tyre: wrong kind of value\n  found 3; allowed: fields: pedal_force, ramp or a text",
        ),
        ("mass: 1 t\ntyre: {ramp: 1}", "car.yaml:2:1  tyre.pedal_force: required field is missing"),
        (
            "mass: 3 t\nlight: true",
            "car.yaml:1:7  mass: too heavy for a light car\n  found '3 t'; allowed: at most 2000",
        ),
        ("- 1", "car.yaml:1:1  the file is not a mapping of fields"),
        ("zzz: 1\nmass: 1 t", "car.yaml:1:1  zzz: unknown field\n  found 1; allowed: drive, steps, gears"),
    ],
)
def test_faults_name_place_found_and_allowed(text: str, expected: str) -> None:
    assert expected in faults(text)


class Pressure(FileModel):
    pressure: float = parameter("Pa", low=0, high=3e7)


class Stop(FileModel):
    brake: Brake | Pressure


def test_a_misspelt_field_of_another_kind_hides_what_that_kind_does_not_need() -> None:
    with pytest.raises(FileFaults) as caught:
        validate(parse_yaml("brake: {presure: 100 bar}", "stop.yaml"), Stop)
    assert caught.value.message.splitlines() == [
        "stop.yaml:1:9  brake.presure: unknown field",
        "  found '100 bar'; did you mean pressure (0…3e+07 Pa)?",
    ]


def test_all_faults_at_once_in_the_order_of_the_file() -> None:
    text = "gears: 0\nmas: 1 t\nsteps:\n- nam: a\n- name: b\n  brake: {pedal_force: 2 kN}"
    lines = [line for line in faults(text).splitlines() if line.startswith("car.yaml")]
    assert [line.split(":")[1] for line in lines] == ["1", "2", "4", "6"]


def test_an_overlay_keeps_the_place_of_every_value() -> None:
    base = parse_yaml("mass: 1 t\nsteps: [1, 2, 3]\ntyre: {pedal_force: 1, ramp: 2}", "base.yaml")
    over = parse_yaml("steps: [4]\ntyre: {ramp: 5}", "over.yaml")
    both = overlay(base, over)
    assert both.data == {"mass": "1 t", "steps": [4], "tyre": {"pedal_force": 1, "ramp": 5}}
    assert both.place(("mass",)).file == "base.yaml"
    assert both.place(("steps", 0)) == Place("over.yaml", 1, 9)
    assert both.place(("tyre", "pedal_force")).file == "base.yaml"
    assert ("steps", 2) not in both.values
    assert base.data["tyre"] == {"pedal_force": 1, "ramp": 2}


def test_walk_lists_the_leaves() -> None:
    assert list(walk({"a": [1, {"b": 2}]})) == [(("a", 0), 1), (("a", 1, "b"), 2)]


def test_value_at_a_path() -> None:
    document = Document("x", {"a": [1, 2]})
    assert document.value(("a", 1)) == 2
    with pytest.raises(KeyError):
        document.value(("a", 5))
