"""What takes no part in the search: every sample of a drive on one side, once, in order; lags of the others."""

import kinematic_car as car
import numpy as np
import pytest
from hidden_car import drawn_logs

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.data.delay_checks import shifted
from model_diagnosis.data.holding_out import check_held_out, held_out_by_time
from model_diagnosis.data.liveliest import liveliest, liveliness
from model_diagnosis.replay import Replay
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


@pytest.fixture(scope="module")
def two_held_out(tmp_path_factory):
    """A car whose speed is 9 ms late: its two held-out drives say 36 ms by themselves, the six others nothing."""
    return drawn_logs(tmp_path_factory.mktemp("case"), 1000013, 115, folder="held_out")


def _samples_earlier(late, repaired):
    """By how many samples ``check_held_out`` took the speed earlier."""
    middle = slice(100, -100)
    same = [np.array_equal(np.roll(late, -k)[middle], repaired[middle]) for k in range(60)]
    return same.index(True)


@pytest.mark.parametrize(
    ("lag_s", "searched_s", "shift", "within"),
    [
        pytest.param(0.0, 0.0, 0, 0, id="nothing is that of the searched drives"),
        pytest.param(0.0, 0.02, 2, 0, id="shifted as the searched drives"),
        # 9 ms more than 0.3 s, mistaken by 27 ms
        pytest.param(0.3, 0.0, 31, 3, id="a lag of their own"),
        pytest.param(0.3, 0.32, 32, 0, id="a large one of the searched drives"),
    ],
)
def test_held_out_drives_have_the_lag_of_the_others_unless_it_is_another(
    two_held_out, lag_s, searched_s, shift, within
):
    vehicle, drives = two_held_out
    late = [shifted(one, ["speed"], -lag_s) for one in drives]
    searched = [LATE.model_copy(update={"value": searched_s})] if searched_s else []
    (first, *_) = check_held_out(late, searched, vehicle, Replay)
    earlier = _samples_earlier(late[0].channels["speed"], first.channels["speed"])
    assert earlier == pytest.approx(shift, abs=within)
    np.testing.assert_array_equal(first.channels["yaw_rate"], drives[0].channels["yaw_rate"])
