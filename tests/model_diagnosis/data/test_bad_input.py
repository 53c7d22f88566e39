"""Bad input ends in clear words: what is missing, too short, full of gaps, constant."""

import kinematic_car as car
import numpy as np
import pytest

from model_diagnosis.data import check_data, read_manoeuvres
from model_diagnosis.data.faults import decides
from signals.errors import InputError
from signals.measured.channel_map import ChannelMap


def _log(tmp_path, vehicle, change=None, kind="stop", name="log", seed=7):
    random = np.random.default_rng(seed)
    driven = car.drive(kind, random)
    log = car.logged(driven, car.sensed(driven, random), random)
    return car.write_csv(tmp_path / f"{name}.csv", change(log) if change else log)


def test_missing_channel_says_what_is_lost_and_decides_nothing(tmp_path, vehicle, channel_map):
    path = _log(tmp_path, vehicle, lambda log: {n: v for n, v in log.items() if n != "yaw_rate"})
    faults, _ = check_data(read_manoeuvres([path], channel_map, vehicle), vehicle)
    assert [(f.kind, f.channel) for f in faults] == [("missing_channel", "yaw_rate")]
    assert "cornering stiffness" in faults[0].message
    assert not decides(faults[0])


def test_no_motion_at_all_is_refused(tmp_path, vehicle):
    path = _log(tmp_path, vehicle)
    only_pressure = ChannelMap(channels={"brake_pressure_fl": {"source": "brake_pressure_fl"}})
    with pytest.raises(InputError, match="no channel that the car's motion shows in"):
        read_manoeuvres([path], only_pressure, vehicle)


def test_too_short_log_is_refused(tmp_path, vehicle, channel_map):
    path = _log(tmp_path, vehicle, lambda log: {n: (t[:120], y[:120]) for n, (t, y) in log.items()})
    with pytest.raises(InputError, match="too short for a diagnosis"):
        read_manoeuvres([path], channel_map, vehicle)


def test_no_log_and_missing_file_are_refused(tmp_path, vehicle, channel_map):
    with pytest.raises(InputError, match="no log given"):
        read_manoeuvres([], channel_map, vehicle)
    with pytest.raises(InputError, match="no such log"):
        read_manoeuvres([tmp_path / "absent.csv"], channel_map, vehicle)


def test_a_fifth_of_the_frames_lost_is_named_and_weighed(tmp_path, vehicle, channel_map):
    keep = np.random.default_rng(3).random(5000) > 0.2
    path = _log(tmp_path, vehicle, lambda log: {n: (t[keep[: len(t)]], y[keep[: len(t)]]) for n, (t, y) in log.items()})
    manoeuvres = read_manoeuvres([path], channel_map, vehicle)
    faults, _ = check_data(manoeuvres, vehicle)
    assert [f.kind for f in faults] == ["frame_drop_hold"]
    assert faults[0].value == pytest.approx(0.2, abs=0.04)


def test_two_recordings_in_one_file_are_refused(tmp_path, vehicle, channel_map):
    path = _log(
        tmp_path,
        vehicle,
        lambda log: {n: (np.concatenate((t, t)), np.concatenate((y, y))) for n, (t, y) in log.items()},
    )
    with pytest.raises(InputError, match="jumps back"):
        read_manoeuvres([path], channel_map, vehicle)


def test_all_constant_channels_are_named(tmp_path, vehicle, channel_map):
    path = _log(tmp_path, vehicle, lambda log: {n: (t, 0.0 * y + 5.0) for n, (t, y) in log.items()})
    faults, manoeuvres = check_data(read_manoeuvres([path], channel_map, vehicle), vehicle)
    dead = {f.channel for f in faults if f.kind == "constant_channel"}
    assert {"speed", "wheel_speed_fl", "longitudinal_acceleration"} <= dead
    assert not any(name in m.channels for m in manoeuvres for name in dead)


def test_loggers_of_one_drive_are_joined_and_their_clock_offset_found(tmp_path, vehicle, channel_map):
    """Two files of different channels; the second logger's clock is 0.4 s ahead."""
    paths = []
    for kind in ("stop", "accelerate", "turn_brake"):
        for part, names in (("a", None), ("b", ("speed",))):

            def own(log, names=names):
                chosen = {n: v for n, v in log.items() if (n in names if names else n != "speed")}
                return {n: (t + (0.4 if names else 0.0), y) for n, (t, y) in chosen.items()}

            paths.append(_log(tmp_path, vehicle, own, kind, f"{kind}_{part}", seed=11))
    manoeuvres = read_manoeuvres(paths, channel_map, vehicle)
    assert len(manoeuvres) == 3
    assert all(m.origins["speed"].endswith("_b.csv") for m in manoeuvres)
    faults, _ = check_data(manoeuvres, vehicle)
    offset = [f for f in faults if f.kind == "clock_offset"]
    assert len(offset) == 1
    assert offset[0].value == pytest.approx(0.4, abs=0.02)
