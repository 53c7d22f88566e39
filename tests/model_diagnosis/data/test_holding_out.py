"""The second part of each drive kept apart: every sample on one side, once, in order."""

import kinematic_car as car
import numpy as np
import pytest

from model_diagnosis.data import holding_out, read_manoeuvres
from model_diagnosis.data.delay_checks import shifted
from model_diagnosis.data.holding_out import check_held_out, held_out_by_time
from model_diagnosis.data.liveliest import liveliest, liveliness
from model_diagnosis.result import DataFault
from signals.errors import InputError

LATE = DataFault(kind="clock_offset", channel="speed", unit="s", repaired=True, message="speed is late")


@pytest.fixture
def two_drives(tmp_path, vehicle, channel_map):
    """A drive of 50 s that reading cuts in two, and one of 9 s."""
    random = np.random.default_rng(11)
    paths = []
    for name, kind, seconds in (("long", "slalom", 50.0), ("short", "stop", 9.0)):
        driven = car.drive(kind, random, seconds)
        log = car.logged(driven, car.sensed(driven, random), random)
        paths.append(car.write_csv(tmp_path / f"{name}.csv", log))
    return read_manoeuvres(paths, channel_map, vehicle)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
def test_every_drive_gives_its_last_share(two_drives, share):
    searched, held_out = held_out_by_time(two_drives, share)
    for drive in ("long.csv", "short.csv"):
        whole = [m for m in two_drives if m.drive == drive]
        before = [m for m in searched if m.drive == drive]
        after = [m for m in held_out if m.drive == drive]
        samples = sum(m.samples for m in whole)
        assert sum(m.samples for m in after) == pytest.approx(share * samples, abs=1)
        for channel in ("speed", "yaw_rate"):
            joined = np.concatenate([m.channels[channel] for m in [*before, *after]])
            np.testing.assert_array_equal(joined, np.concatenate([m.channels[channel] for m in whole]))
        assert max(m.start_s + m.duration_s for m in before) < min(m.start_s for m in after)
        assert all(m.time[0] == 0.0 for m in after)
    names = [m.name for m in [*searched, *held_out]]
    assert len(set(names)) == len(names)


def test_a_piece_too_short_for_a_manoeuvre_stays_with_the_rest(two_drives):
    """10 % of 9 s are less than the 2 s of a manoeuvre: the short drive is searched whole."""
    searched, held_out = held_out_by_time(two_drives, 0.1)
    assert {m.drive for m in held_out} == {"long.csv"}
    short = next(m for m in searched if m.drive == "short.csv")
    assert short is next(m for m in two_drives if m.drive == "short.csv")


def test_a_share_that_leaves_one_side_empty_is_refused(two_drives):
    short = [m for m in two_drives if m.drive == "short.csv"]
    with pytest.raises(InputError, match="to measure the gain on"):
        held_out_by_time(short, 0.1)
    with pytest.raises(InputError, match="to search"):
        held_out_by_time(short, 0.9)
    with pytest.raises(InputError, match="above 0 and below 1"):
        held_out_by_time(short, 1.0)


def test_the_liveliest_manoeuvres_are_searched_in_their_order(tmp_path, vehicle, channel_map):
    random = np.random.default_rng(12)
    paths = []
    for kind in ("coast", "stop", "slalom", "turn_brake"):
        driven = car.drive(kind, random)
        paths.append(car.write_csv(tmp_path / f"{kind}.csv", car.logged(driven, car.sensed(driven, random), random)))
    manoeuvres = read_manoeuvres(paths, channel_map, vehicle)
    of = {m.name: m for m in manoeuvres}
    assert min(manoeuvres, key=liveliness) is of["coast"]
    assert liveliest(manoeuvres, 100.0) == manoeuvres
    assert [m.name for m in liveliest(manoeuvres, 28.0)] == ["stop", "slalom", "turn_brake"]
    assert len(liveliest(manoeuvres, 5.0)) == 1  # never nothing
    with pytest.raises(InputError, match="above 0 s"):
        liveliest(manoeuvres, 0.0)


@pytest.mark.parametrize(
    ("here_s", "there_s", "shift"),
    [(0.036, None, 0), (0.201, 0.183, 18), (None, 0.04, 4), (0.2, None, 20), (0.05, 0.28, 5)],
)
def test_held_out_drives_have_the_lag_of_the_others_unless_it_is_another(
    two_drives, monkeypatch, here_s, there_s, shift
):
    """``here_s`` is what the held-out drives tell alone, ``there_s`` what the others do; 50 ms tell them apart."""

    def late(delay_s):
        return [] if delay_s is None else [LATE.model_copy(update={"value": delay_s})]

    def repaired(manoeuvres, *_):
        return late(here_s), [shifted(one, ["speed"], here_s or 0.0) for one in manoeuvres]

    monkeypatch.setattr(holding_out, "check_data", repaired)
    (first, *_) = check_held_out(two_drives, late(there_s), vehicle=None)
    middle = slice(100, -100)
    moved = np.roll(two_drives[0].channels["speed"], -shift)
    np.testing.assert_array_equal(first.channels["speed"][middle], moved[middle])
    np.testing.assert_array_equal(first.channels["yaw_rate"], two_drives[0].channels["yaw_rate"])
