"""A measurement that is given twice is refused, whatever its file is called; two drives of one kind are not."""

from dataclasses import replace

import kinematic_car as car
import numpy as np
import pytest

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.data.repeated import refuse_repeats
from signals.errors import InputError


def _log(folder, name, seed, digits=None):
    random = np.random.default_rng(seed)
    driven = car.drive("stop", random)
    log = car.logged(driven, car.sensed(driven, random), random)
    if digits is not None:
        log = {channel: (np.round(time, digits), values) for channel, (time, values) in log.items()}
    return car.write_csv(folder / f"{name}.csv", log)


def test_a_copy_is_refused_with_stamps_of_another_resolution_too(tmp_path, vehicle, channel_map):
    logs = [_log(tmp_path, "monday", 7), _log(tmp_path, "exported", 7, digits=6)]
    with pytest.raises(InputError, match=r"exported\.csv.* the same measurement as monday\.csv"):
        refuse_repeats(read_manoeuvres(logs, channel_map, vehicle))


def test_two_stops_of_one_kind_are_two(tmp_path, vehicle, channel_map):
    logs = [_log(tmp_path, "monday", 7), _log(tmp_path, "tuesday", 8)]
    refuse_repeats(read_manoeuvres(logs, channel_map, vehicle))


def test_one_drive_whose_manoeuvres_repeat_to_the_digit_is_a_simulation(tmp_path, vehicle, channel_map):
    """Without noise, as of another simulator: the same pulse twice in one log are two manoeuvres."""
    (first,) = read_manoeuvres([_log(tmp_path, "monday", 7)], channel_map, vehicle)
    refuse_repeats([first, replace(first, start_s=first.start_s + 30.0)])
