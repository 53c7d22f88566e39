"""Two loggers of several drives: one clock each, one log for all, another epoch, or a clock that begins anew each time.

The car is the one of ``kinematic_car``, its second logger records the speed over ground.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import kinematic_car as car
import numpy as np
import pytest
from hidden_car import WHEEL_SPEEDS, hidden_logs

from model_diagnosis.data import check_data, read_manoeuvres
from model_diagnosis.data.drive_clocks import check_drive_clocks
from model_diagnosis.data.geometry import geometry_of
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from signals.measured import load_channel_map
from signals.measured.channel_map import ChannelMap
from vehicle_model.vehicle_file import VehicleFile

KINDS = ("stop", "turn_brake", "accelerate")
STARTS_S = (1.1, 0.2, 0.7)
"""How long after the first logger the second one was started in each drive."""
Channels = dict[str, tuple[np.ndarray, np.ndarray]]
Read = Callable[..., list[Manoeuvre]]


@pytest.fixture
def read(tmp_path: Path, vehicle: VehicleFile, channel_map: ChannelMap) -> Read:
    """Manoeuvres of three drives, of which the second logger's clock is ``ahead_s`` on or begins at its start."""

    def made(
        *,
        ahead_s: float = 0.0,
        own_anew: bool = False,
        other_anew: bool = False,
        one_log: bool = False,
        kinds: Sequence[str] = KINDS,
        second: Sequence[str] = ("speed",),
        starts_s: Sequence[float] = STARTS_S,
    ) -> list[Manoeuvre]:
        random, others, paths = np.random.default_rng(12), [], []
        for k, (kind, start_s) in enumerate(zip(kinds, starts_s, strict=True)):
            driven = car.drive(kind, random)
            log = car.logged(driven, car.sensed(driven, random), random)
            other = {name: log.pop(name) for name in second}
            begin_s = 0.0 if own_anew else 60.0 * k
            paths.append(car.write_csv(tmp_path / f"{kind}.csv", moved(log, begin_s)))
            kept = {
                name: (stamps[stamps >= start_s], values[stamps >= start_s]) for name, (stamps, values) in other.items()
            }
            others.append(moved(kept, -start_s if other_anew else 60.0 * k + ahead_s))
        if one_log:
            others = [
                {name: tuple(map(np.concatenate, zip(*(one[name] for one in others), strict=True))) for name in second}
            ]
        names = ["gps"] if one_log else [f"{kind}_gps" for kind in kinds]
        paths += [car.write_csv(tmp_path / f"{name}.csv", one) for name, one in zip(names, others, strict=True)]
        return read_manoeuvres(paths, channel_map, vehicle)

    return made


def moved(log: Channels, later_s: float) -> Channels:
    return {name: (stamps + later_s, values) for name, (stamps, values) in log.items()}


def late_s(manoeuvre: Manoeuvre) -> float:
    """By how much the speed over ground is late against the wheels, by the least mean square of their difference.

    Slip makes it 0.17 s of 0 where the car accelerates.
    """
    wheels = car.RADIUS_M * np.max([manoeuvre.channels[f"wheel_speed_{w}"] for w in ("fl", "fr", "rl", "rr")], axis=0)
    reach, speed = 150, manoeuvre.channels["speed"]
    inner = slice(reach, len(wheels) - reach)
    misfit = [np.std((np.roll(speed, -shift) - wheels)[inner]) for shift in range(-reach, reach + 1)]
    return 0.01 * (int(np.argmin(misfit)) - reach)


def faults_of(manoeuvres: list[Manoeuvre]) -> dict[str, float | None]:
    return {f.channel: f.value for m in manoeuvres for f in m.reading_faults if f.kind == "clock_offset"}


@pytest.mark.parametrize("one_log", [False, True], ids=["a log per drive", "one log"])
@pytest.mark.parametrize("ahead_s", [0.0, 3600.0, -7.5], ids=["one clock", "another hour", "some seconds behind"])
def test_drives_have_the_other_loggers_speed(read: Read, ahead_s: float, one_log: bool) -> None:
    """-7.5 s: the second logger's log of one drive begins before the first logger's, and shares a part of its time."""
    manoeuvres = read(ahead_s=ahead_s, one_log=one_log)
    assert [m.name for m in manoeuvres] == list(KINDS)
    assert all("speed" in m.channels and "yaw_rate" in m.channels for m in manoeuvres)
    assert [late_s(m) for m in manoeuvres] == pytest.approx([0.0] * 3, abs=0.2)
    told = faults_of(manoeuvres)
    assert list(told.values()) == pytest.approx([ahead_s] if ahead_s else [], abs=0.2)


def test_logs_that_all_begin_at_zero_are_found_in_the_one_long_log(read: Read) -> None:
    manoeuvres = read(ahead_s=3600.0, own_anew=True, one_log=True)
    assert [late_s(m) for m in manoeuvres] == pytest.approx([0.0] * 3, abs=0.2)
    ahead_s = {f"{kind}.csv": -3600.0 - 60.0 * k for k, kind in enumerate(KINDS)}
    assert faults_of(manoeuvres) == pytest.approx(ahead_s, abs=0.2)


def test_logs_of_two_loggers_that_begin_anew_are_paired_by_their_names(read: Read) -> None:
    manoeuvres = read(own_anew=True, other_anew=True)
    assert [m.drive for m in manoeuvres] == [f"{kind}.csv, {kind}_gps.csv" for kind in KINDS]


def test_nothing_that_both_loggers_recorded_is_cut_off(read: Read) -> None:
    """A drive of 9 s has 9 s less the later start in common, though stamps of both go from 0 to less than that."""
    manoeuvres = read(own_anew=True, other_anew=True)
    starts_s = {f"{kind}_gps.csv": -start_s for kind, start_s in zip(KINDS, STARTS_S, strict=True)}
    assert {k: v for m in manoeuvres for k, v in m.set_back_s.items()} == pytest.approx(starts_s, abs=0.2)
    assert [late_s(m) for m in manoeuvres] == pytest.approx([0.0] * 3, abs=0.2)
    assert [m.duration_s for m in manoeuvres] == pytest.approx([9.0 - start_s for start_s in STARTS_S], abs=0.1)


def test_one_offset_of_all_drives_is_no_clock_of_each(read: Read) -> None:
    """Loggers that a trigger starts a second apart: one delay for all drives, found where all delays are."""
    assert not any(m.set_back_s for m in read(own_anew=True, other_anew=True, starts_s=(1.0,) * 3))


def test_another_offset_in_each_drive_is_told_by_lags_and_shifted(read: Read, vehicle: VehicleFile) -> None:
    """Lags of one drive alone: its twins tell some tens of milliseconds."""
    faults, repaired = check_data(read(own_anew=True, other_anew=True), vehicle)
    told = {fault.channel: fault.value for fault in faults if fault.kind == "clock_offset"}
    starts_s = {f"{kind}_gps.csv": -start_s for kind, start_s in zip(KINDS, STARTS_S, strict=True)}
    assert told == pytest.approx(starts_s, abs=0.08)
    assert [late_s(m) for m in repaired] == pytest.approx([0.0] * 3, abs=0.2)


def test_a_logger_of_all_speeds_is_never_left_out(read: Read, vehicle: VehicleFile) -> None:
    """At a steady speed nothing tells its offset, and without it there is nothing to replay: that is no repair."""
    second = ("speed", *WHEEL_SPEEDS)
    manoeuvres = read(own_anew=True, other_anew=True, kinds=("stop", "accelerate", "coast"), second=second)
    clocks, repaired = check_drive_clocks(manoeuvres, geometry_of(vehicle), vehicle, Replay)
    assert [clock.told for clock in clocks] == [True, True, False]
    assert [clock.fault().repaired for clock in clocks] == [True, True, False]
    assert all(set(second) <= set(m.channels) for m in repaired)


def test_a_log_of_another_drive_is_told(tmp_path: Path, vehicle: VehicleFile, channel_map: ChannelMap) -> None:
    """A speed that no log of the first logger goes with stays by itself, and that is no small fault of the data."""
    random, paths = np.random.default_rng(3), []
    for k, kind in enumerate(("stop", "turn_brake", "accelerate")):
        driven = car.drive(kind, random)
        log = car.logged(driven, car.sensed(driven, random), random)
        speed = {"speed": log.pop("speed")}
        if kind == "accelerate":
            paths.append(car.write_csv(tmp_path / "gps.csv", moved(speed, 900.0)))
        else:
            paths.append(car.write_csv(tmp_path / f"{kind}.csv", moved(log, 60.0 * k)))
    manoeuvres = read_manoeuvres(paths, channel_map, vehicle)
    assert ["speed" in m.channels for m in manoeuvres] == [False, False, True]
    (fault,) = {fault.message: fault for m in manoeuvres for fault in m.reading_faults}.values()
    assert (fault.kind, fault.channel, fault.repaired) == ("clock_offset", "gps.csv", False)
    assert "no time is shared with stop.csv and 1 more" in fault.message


@pytest.mark.nightly
def test_another_offset_in_each_drive_is_told_by_innovations_to_a_sample(tmp_path: Path) -> None:
    """The hidden car of the generator: stops tell the second logger's start to a sample, a steady speed tells none.

    On the coast, 25 m/s with 0.4 m/s², the rolling radius is off by a thousandth within 60 ms.
    """
    names = ("coast", "gentle_stops", "abs_stop", "sine_steer", "brake_in_turn", "accelerate_and_brake")
    starts_s = dict(zip(names, (1.208, 1.212, 0.773, 0.429, 0.081, 0.575), strict=True))
    vehicle, _ = hidden_logs(tmp_path, 4713, names[:1])
    paths = []
    for name, start_s in starts_s.items():
        head, *rows = [line.split(";") for line in (tmp_path / "logs" / f"{name}.csv").read_text().splitlines()]
        column = head.index("Speed [km/h]")
        own = [[cell for k, cell in enumerate(row) if k != column] for row in (head, *rows)]
        other = [[f"{float(row[0]) - start_s:.6f}", row[column]] for row in rows if float(row[0]) >= start_s]
        for file, table in ((f"{name}.csv", own), (f"{name}_gps.csv", [[head[0], head[column]], *other])):
            paths.append(tmp_path / file)
            paths[-1].write_text("\n".join(map(";".join, table)) + "\n")
    manoeuvres = read_manoeuvres(paths, load_channel_map(str(tmp_path / "channels.yaml")), vehicle)
    clocks, repaired = check_drive_clocks(manoeuvres, geometry_of(vehicle), vehicle, Replay)
    told = {clock.logger.removesuffix("_gps.csv"): clock for clock in clocks}
    assert not told.pop("sine_steer").told
    assert ["speed" in m.channels for m in repaired] == [m.name != "sine_steer" for m in repaired]
    faults = {name: clock.fault() for name, clock in told.items()}
    assert faults.pop("coast").value == pytest.approx(-starts_s["coast"], abs=2.0 * told["coast"].late.std_s)
    assert {name: fault.value for name, fault in faults.items()} == pytest.approx(
        {name: -starts_s[name] for name in names if name in faults}, abs=0.01
    )
    assert told["coast"].late.std_s == pytest.approx(0.06, rel=0.2)
    assert all(told[name].late.std_s < 0.015 for name in faults)
    assert len(faults) == 4
