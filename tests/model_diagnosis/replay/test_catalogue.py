"""The catalogue: complete records, every group, and every parameter at work in the replay."""

import numpy as np

from model_diagnosis.effects.catalogue import EFFECTS, effect
from model_diagnosis.effects.effect import Application, Group
from model_diagnosis.replay import Replay
from model_diagnosis.replay.deviations import RECORD_COLUMNS
from model_diagnosis.replay.hydraulic import HYDRAULIC_COLUMNS
from vehicle_model.vehicle_file import VehicleFile

_OF_THE_CAR = {
    Group.TYRE,
    Group.BRAKE,
    Group.HYDRAULICS,
    Group.SUSPENSION,
    Group.BODY,
    Group.AERODYNAMICS,
    Group.ROAD,
    Group.DRIVELINE,
    Group.STEERING,
}


def test_every_group_is_there_and_the_car_has_most_of_it() -> None:
    causes = [entry for entry in EFFECTS if not entry.name.startswith("form_")]
    assert {entry.group for entry in causes} == set(Group)
    assert sum(entry.group in _OF_THE_CAR for entry in causes) >= 45
    assert len(causes) >= 60


def test_records_are_complete_and_refer_to_each_other() -> None:
    names = [entry.name for entry in EFFECTS]
    assert len(set(names)) == len(names)
    for entry in EFFECTS:
        assert entry.equation, entry.name
        assert entry.signals, entry.name
        assert entry.separating_manoeuvre, entry.name
        assert set(entry.confounded_with) <= set(names), entry.name
        assert entry.name not in entry.confounded_with
        assert effect(entry.name) is entry
        if not entry.name.startswith("form_"):
            assert entry.source, entry.name


def test_neutral_lies_within_the_bounds_and_effects_are_wider_than_scatter() -> None:
    for entry in EFFECTS:
        for parameter in entry.parameters:
            assert parameter.low <= 0.0 <= parameter.high, entry.name
            assert parameter.low < parameter.high, entry.name
            assert 0.0 <= parameter.nuisance_std <= parameter.effect_std, entry.name


def test_every_parameter_of_the_car_changes_something_in_the_replay() -> None:
    tables = {"tyre_peak_shape.sliding_loss", "tyre_peak_shape.peak_slip"}
    for entry in EFFECTS:
        if entry.application is Application.PLANT:
            assert set(entry.columns) <= RECORD_COLUMNS | set(HYDRAULIC_COLUMNS) | tables, entry.name


def test_paths_of_the_catalogue_exist_in_a_vehicle_file(car: VehicleFile) -> None:
    """Through the nominal value: a factor on a path that does not exist would count from 1."""
    model = Replay(car, [])
    numbers = car.numbers()
    for column, parameter in zip(model.columns, model.parameters, strict=True):
        if parameter.vehicle_path and "*" not in parameter.vehicle_path:
            value, _, nominal = model.physical(column, 0.0)
            assert value == nominal
            found = numbers[parameter.vehicle_path]
            assert nominal == (found if found != 0.0 or not parameter.relative else 1.0), column


def test_owners_point_to_the_columns_effect(car: VehicleFile) -> None:
    model = Replay(car, [])
    for column, owner in zip(model.columns, model.owner, strict=True):
        assert column.startswith(f"{model.effects[owner].name}.")
    assert len(model.columns) == len(model.parameters) == len(model.owner)
    assert np.all(np.diff(model.owner) >= 0)
