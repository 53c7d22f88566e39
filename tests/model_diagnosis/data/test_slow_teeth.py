"""Wheel speeds of a tone ring, timed between teeth: below one tooth per sample the value stands still by itself."""

from pathlib import Path

import numpy as np
import pytest

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.data.sample_values import check_random_hold
from model_diagnosis.data.samples import Samples, read_samples
from signals.errors import InputError
from signals.measured import load_channel_map
from vehicle_model import load_vehicle

TEETH, PERIOD_S, RESOLUTION_RAD_S = 48, 0.005, 0.005
FIRST_RAD_S, LAST_RAD_S, DURATION_S = 90.0, 5.0, 10.0
HELD = 0.2


def _stop(held: float) -> Samples:
    """A wheel that slows down evenly, as its ring's edges tell it; a share of the samples repeats the one before."""
    random = np.random.default_rng(11)
    rate = (LAST_RAD_S - FIRST_RAD_S) / DURATION_S
    pitch = 2.0 * np.pi / TEETH
    turned = FIRST_RAD_S * DURATION_S + 0.5 * rate * DURATION_S**2
    angles = pitch * np.arange(1, int(turned / pitch))
    edges = (np.sqrt(FIRST_RAD_S**2 + 2.0 * rate * angles) - FIRST_RAD_S) / rate
    speeds = np.concatenate(([FIRST_RAD_S], pitch / np.diff(edges))) + random.normal(0.0, 0.1, len(edges))
    time = PERIOD_S * np.arange(10, int(DURATION_S / PERIOD_S))
    values = RESOLUTION_RAD_S * np.round(speeds[np.searchsorted(edges, time, side="right") - 1] / RESOLUTION_RAD_S)
    for row in np.flatnonzero(random.random(len(values)) < held):
        values[row] = values[row - 1]
    return Samples("wheel_speed_fl", "rad/s", time, values, np.ones(len(values), dtype=np.bool_), "speed", "log.csv")


def test_a_wheel_slower_than_its_teeth_has_lost_no_frame() -> None:
    """Below 26 rad/s (48 teeth, 5 ms) samples repeat: a twentieth of this stop and more."""
    stop = _stop(0.0)
    assert np.mean(np.diff(stop.values) == 0.0) > 0.05
    checked, faults = check_random_hold(stop)
    assert not faults
    assert checked.valid.all()


def test_frames_that_are_held_above_are_still_named() -> None:
    _, (fault,) = check_random_hold(_stop(HELD))
    # 1400 of the 2000 samples are above 31 rad/s: three standard deviations of a share of a fifth
    assert fault.value == pytest.approx(HELD, abs=3.0 * np.sqrt(HELD * (1.0 - HELD) / 1400))


def test_a_wheel_slower_than_a_tooth_in_5_ms_is_left_out_where_the_map_tells_its_teeth(tmp_path: Path) -> None:
    """2 pi / (48 * 5 ms) = 26.2 rad/s; the other wheel, whose teeth nobody told, counts down to the end."""
    random = np.random.default_rng(13)
    time = 0.01 * np.arange(800)
    speed = np.linspace(95.0, 15.0, len(time))
    fl, fr, ax = (speed + random.normal(0.0, 0.05, len(time)) for _ in range(3))
    table = np.column_stack([time, fl, fr, ax - speed - 2.8])
    np.savetxt(tmp_path / "stop.csv", table, delimiter=",", header="t,fl,fr,ax", comments="", fmt="%.5f")
    channel_map = tmp_path / "map.yaml"
    channel_map.write_text(
        "clock: {column: t}\nchannels:\n"
        "  wheel_speed_fl: {source: fl, teeth: 48}\n  wheel_speed_fr: {source: fr}\n"
        "  longitudinal_acceleration: {source: ax}\n"
    )
    (stop,) = read_manoeuvres([tmp_path / "stop.csv"], load_channel_map(channel_map), load_vehicle("ekf_car"))
    slow = stop.channels["wheel_speed_fl"] < 2.0 * np.pi / (TEETH * 0.005)
    assert 50 < np.sum(slow) < 200
    assert not np.any(stop.weight("wheel_speed_fl")[slow])
    assert np.all(stop.weight("wheel_speed_fl")[~slow] == 1.0)
    assert np.all(stop.weight("wheel_speed_fr") == 1.0)


def test_of_a_speed_timed_between_teeth_a_constant_lag_is_left_at_every_speed(tmp_path: Path) -> None:
    """Edges between the last one and the last one 5 ms ago, over their time (docs/models/sensors.md): a mean over 5 ms
    that ended half a tooth ago. Half of the 5 ms is left; as logged it is late by 3.2 ms at 90 rad/s and 4.6 at 31.
    """
    rate, window_s = -60.0, 0.005
    pitch = 2.0 * np.pi / TEETH
    angles = pitch * np.arange(1, int((31.0**2 - FIRST_RAD_S**2) / (2.0 * rate) / pitch))
    edges = (np.sqrt(FIRST_RAD_S**2 + 2.0 * rate * angles) - FIRST_RAD_S) / rate
    time = np.arange(0.02, edges[-1], 0.0007)  # all ages of the last tooth
    last, before = (np.searchsorted(edges, at, side="right") - 1 for at in (time, time - window_s))
    table = np.column_stack([time, (last - before) * pitch / (edges[last] - edges[before])])
    np.savetxt(tmp_path / "stop.csv", table, delimiter=",", header="t,fl", comments="", fmt="%.7f")
    (tmp_path / "map.yaml").write_text("clock: {column: t}\nchannels:\n  wheel_speed_fl: {source: fl, teeth: 48}\n")
    channel_map = load_channel_map(tmp_path / "map.yaml")
    told = read_samples(tmp_path / "stop.csv", channel_map, load_vehicle("ekf_car"))["wheel_speed_fl"]
    lag_s = (told.values - (FIRST_RAD_S + rate * told.time)) / -rate
    for fastest, slowest in ((90.0, 70.0), (40.0, 31.0)):
        there = (told.values < fastest) & (told.values > slowest)
        assert np.mean(lag_s[there]) == pytest.approx(0.5 * window_s, abs=1e-4)


def test_only_wheels_have_teeth(tmp_path: Path) -> None:
    channel_map = tmp_path / "map.yaml"
    channel_map.write_text("channels:\n  yaw_rate: {source: r, teeth: 48}\n")
    with pytest.raises(InputError, match=r"yaw_rate.*teeth"):
        load_channel_map(channel_map)
