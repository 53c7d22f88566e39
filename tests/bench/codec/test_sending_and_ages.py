"""When messages are sent, what becomes of odd values, and how old a decoded signal is."""

import numpy as np
import pytest

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.database import load_database
from bench.codec.mapping_file import BUS_NAMES
from bench.links.frame import ECU, TRANSMITTED, new_frames
from signals.catalogue import names

CODEC = Codec.load()


def position(name: str) -> int:
    return BUS_NAMES.index(name)


def through_the_bus(**signals: float) -> dict[str, float]:
    """Values as decoded after one cycle of all messages."""
    values, decoded, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    for name, value in signals.items():
        values[position(name)] = value
    transmitters = [CODEC.transmitter(role, values) for role in ("bench", "ecu")]
    receiver = CODEC.receiver("all", decoded, ages)
    frames = new_frames(64)
    for tick in range(20):
        for transmitter in transmitters:
            receiver.accept(frames, transmitter.due(tick, frames), tick)
    return {name: float(decoded[position(name)]) for name in signals}


def test_bus_names_are_the_bus_block_of_the_signal_vector() -> None:
    first = names().index("wheel_speed_fl")
    assert names()[first : first + len(BUS_NAMES)] == BUS_NAMES


@pytest.mark.parametrize("role", ["bench", "ecu"])
def test_each_message_is_sent_in_its_cycle_from_its_offset(role: str) -> None:
    transmitter = CODEC.transmitter(role, np.zeros(len(BUS_NAMES)))
    sent: dict[int, list[int]] = {}
    frames = new_frames(64)
    for tick in range(100):
        for frame in frames[: transmitter.due(tick, frames)]:
            sent.setdefault(int(frame["identifier"]), []).append(tick)
    own = [m for m in load_database().messages if (m.senders == ("ECU",)) == (role == "ecu")]
    assert sent == {m.identifier: list(range(m.offset_ms, 100, m.cycle_ms)) for m in own}


def test_frames_are_put_behind_those_already_there() -> None:
    transmitter = CODEC.transmitter("ecu", np.zeros(len(BUS_NAMES)), channel=1)
    frames = new_frames(8)
    assert transmitter.due(4, frames, start=3) == 2
    assert frames["identifier"].tolist() == [0, 0, 0, 0x210, 0x220, 0, 0, 0]
    assert set(frames["sender"][3:5]) == {ECU}
    assert set(frames["flags"][3:5]) == {TRANSMITTED}
    assert set(frames["channel"][3:5]) == {1}
    assert set(frames["timestamp_ns"][3:5]) == {4_000_000}


def test_a_message_of_a_skipped_tick_is_sent_late_and_then_on_time() -> None:
    transmitter = CODEC.transmitter("ecu", np.zeros(len(BUS_NAMES)))
    frames = new_frames(8)
    sent = [tick for tick in (0, 6, 7, 9, 14) if 0x210 in frames["identifier"][: transmitter.due(tick, frames)]]
    assert sent == [6, 9, 14]


def test_values_survive_within_half_a_resolution_step() -> None:
    wanted = {"wheel_speed_fl": 87.6543, "yaw_rate": -0.123456, "master_pressure": 87.654e5, "gear": 3.0}
    decoded = through_the_bus(**wanted)
    steps = {"wheel_speed_fl": 0.0025, "yaw_rate": 1e-4, "master_pressure": 500.0, "gear": 1.0}
    for name, value in wanted.items():
        assert abs(decoded[name] - value) <= 0.5 * steps[name] + 1e-12


def test_out_of_range_saturates_and_counters_wrap() -> None:
    decoded = through_the_bus(
        longitudinal_acceleration=-80.0,
        brake_pressure_rr=1e9,
        wheel_edge_count_fl=65536.0 * 3 + 17,
        wheel_edge_time_fl=2.5,
    )
    assert decoded["longitudinal_acceleration"] == pytest.approx(-32.768)
    assert decoded["brake_pressure_rr"] == pytest.approx(8191 * 4000 - 1e6)
    assert decoded["wheel_edge_count_fl"] == 17.0
    assert decoded["wheel_edge_time_fl"] == pytest.approx(2.5 - 2 * 1.048576, abs=0.6e-6)


def test_moduli_of_wrapping_signals() -> None:
    assert CODEC.modulus("wheel_edge_count_fl") == 65536.0
    assert CODEC.modulus("wheel_edge_time_fl") == pytest.approx(1.048576)
    assert CODEC.modulus("wheel_speed_fl") == np.inf
    with pytest.raises(KeyError):
        CODEC.modulus("no_such_signal")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_is_sent_as_the_start_value(value: float) -> None:
    assert through_the_bus(master_pressure=value)["master_pressure"] == 0.0


def test_ages_grow_every_tick_and_a_group_is_as_old_as_its_oldest_message() -> None:
    values, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    transmitter, receiver = CODEC.transmitter("bench", values), CODEC.receiver("ecu", values.copy(), ages)
    frames = new_frames(64)
    valve_pump = AGE_NAMES.index("age_valve_pump")
    ages[valve_pump] = 123.0
    inertial, edges = AGE_NAMES.index("age_inertial"), AGE_NAMES.index("age_wheel_edges")
    assert ages[inertial] == pytest.approx(1e6)
    seen = []
    for tick in range(20):
        receiver.accept(frames, transmitter.due(tick, frames), tick)
        seen.append((ages[inertial], ages[edges]))
    assert [age for age, _ in seen[3:13]] == pytest.approx([0, 1e-3, 2e-3, 3e-3, 4e-3] * 2)
    assert [age for _, age in seen[5:10]] == pytest.approx([4e-3, 4e-3, 1e-3, 2e-3, 3e-3])
    assert ages[valve_pump] == 123.0  # not heard by this receiver, so not written
    receiver.accept(frames, 0, 119)
    assert ages[inertial] == pytest.approx(0.101)


def test_reset_starts_over() -> None:
    values, ages = np.ones(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    transmitter, decoded = CODEC.transmitter("bench", values), np.zeros(len(BUS_NAMES))
    receiver = CODEC.receiver("ecu", decoded, ages)
    frames = new_frames(64)
    first = [bytes(frames[: transmitter.due(tick, frames)].tobytes()) for tick in range(30)]
    receiver.accept(frames, transmitter.due(30, frames), 30)
    transmitter.reset()
    receiver.reset()
    assert receiver.statistics()["BRAKE"]["accepted"] == 0
    assert not decoded.any()
    frames[:] = new_frames(1)
    assert [bytes(frames[: transmitter.due(tick, frames)].tobytes()) for tick in range(30)] == first


def ages_of_wheel_speeds(arrivals: list[int], dropped: tuple[int, ...] = ()) -> list[float]:
    """Age [s] of the wheel speeds at the arrival of each pair of frames 0x120 and 0x121, sent every 5 ms."""
    transmitter = CODEC.transmitter("bench", np.zeros(len(BUS_NAMES)))
    ages = np.zeros(len(AGE_NAMES))
    receiver = CODEC.receiver("ecu", np.zeros(len(BUS_NAMES)), ages, notes_lateness=True)
    sent, found = [], []
    for tick in range(5 * len(arrivals)):
        frames = new_frames(64)
        due = frames[: transmitter.due(tick, frames)]
        sent += [due[np.isin(due["identifier"], (0x120, 0x121))]] * (tick % 5 == 0)
    for number, arrival in enumerate(arrivals):
        if number not in dropped:
            receiver.accept(sent[number], 2, arrival)
            found.append(float(ages[AGE_NAMES.index("age_wheel_speed")]))
    return found


def test_frames_that_are_held_up_arrive_with_their_age() -> None:
    """From the eleventh on each comes 10 ms late: its age on arrival, less a drift of 0.1 % of the time."""
    arrivals = [max(5 * n, 205 if n >= 39 else 0) + (10 if 10 <= n < 39 else 0) for n in range(60)]
    ages = ages_of_wheel_speeds(arrivals)
    assert ages[:10] == [0.0] * 10
    assert ages[10:40] == pytest.approx([0.010] * 30, abs=0.0011)
    assert ages[42:] == [0.0] * 18


def test_frames_that_are_held_up_for_longer_than_the_counter_runs() -> None:
    """0.2 s are 40 frames, the counter wraps after 16; 50 frames forget 1 % of it, the resolution is 1 ms."""
    arrivals = [5 * n + (200 if n >= 10 else 0) for n in range(60)]
    assert ages_of_wheel_speeds(arrivals)[10:] == pytest.approx([0.2] * 50, abs=0.00325)


def test_lost_frames_and_a_slower_clock_are_not_lateness() -> None:
    assert max(ages_of_wheel_speeds([5 * n for n in range(60)], dropped=(7, 8, 9, 30))) == 0.0
    slower = [int(5 * n * 1.0008) for n in range(2000)]
    assert max(ages_of_wheel_speeds(slower)) <= 0.001
