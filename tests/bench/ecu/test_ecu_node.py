"""The ECU as a node on the bus: schedule, determinism, a lone ECU fed with recorded frames, a bus without pulses."""

from typing import Any

import numpy as np
import pytest

from bench.codec.codec import Codec
from bench.ecu.node import EcuNode
from bench.links.frame import new_frames

VALVE_PUMP, ABS_STATUS, DIAGNOSTICS = 0x210, 0x220, 0x71D


def eventful_drive(car: Any) -> None:
    """Driving, ABS control with a cycling wheel, a missing message, recovery."""
    car.drive(0.5, 25.0)
    for dip in (18.0, 24.0, 17.0, 24.0, 16.0):
        car.drive(0.08, (dip, 24.0, dip + 2.0, 23.0), master_bar=120, acceleration=-8.0)
    car.drive(0.1, 20.0, master_bar=120, drop=("BRAKE",))
    car.drive(1.5, 20.0)
    car.drive(0.2, (12.0, 18.0, 18.0, 18.0), master_bar=120, acceleration=-8.0)


def answers(car: Any) -> bytes:
    return b"".join(frames.tobytes() for frames in car.log)


def test_frames_keep_the_schedule_of_the_database(can_car: Any) -> None:
    car = can_car()
    car.drive(1.0, 10.0)
    sent = np.concatenate(car.log)
    for identifier, period, offset in ((VALVE_PUMP, 5, 4), (ABS_STATUS, 20, 4), (DIAGNOSTICS, 10, 9)):
        ticks = sent["tick"][sent["identifier"] == identifier]
        assert list(ticks) == list(range(offset, 1000, period))
    assert set(np.unique(sent["identifier"])) == {VALVE_PUMP, ABS_STATUS, DIAGNOSTICS}


def test_valves_answer_pulses_of_the_same_cycle(can_car: Any) -> None:
    # pulses are sent in ticks 1 and 2 of a cycle, seen in 2 and 3; the task runs in tick 4 and its frame leaves at once
    car = can_car()
    car.drive(0.8, 20.0)
    start = car.tick
    assert start % 5 == 0
    car.drive(0.1, (8.0, 20.0, 20.0, 20.0), master_bar=100)
    sent = np.concatenate(car.log[start:])
    valves = sent[sent["identifier"] == VALVE_PUMP]
    first_release = next(frame["tick"] for frame in valves if frame["data"][2] & 1)
    assert first_release - start <= 34  # two cycles for a speed from new pulses, one more for the brake message


def test_same_frames_give_the_same_answers(can_car: Any) -> None:
    cars = [can_car() for _ in range(2)]
    for car in cars:
        eventful_drive(car)
    assert answers(cars[0]) == answers(cars[1])


def test_lone_ecu_fed_with_recorded_frames_gives_the_same_valve_frames(can_car: Any) -> None:
    car = can_car()
    eventful_drive(car)
    lone = EcuNode("sensitive", Codec.load())
    out, again = new_frames(64), []
    for tick, frames in enumerate(car.frames_to_ecu):
        again.append(out[: lone.tick(tick, frames, len(frames), out)].copy())
    assert b"".join(frames.tobytes() for frames in again) == answers(car)
    valves = np.concatenate(again)
    assert len(np.unique(valves["data"][valves["identifier"] == VALVE_PUMP][:, 2])) > 3  # and something happened


def test_calibrations_differ_in_what_they_do(can_car: Any) -> None:
    sensitive, coarse = can_car("sensitive"), can_car("coarse")
    for car in (sensitive, coarse):
        eventful_drive(car)
    assert answers(sensitive) != answers(coarse)


def test_silent_ecu_sends_nothing(can_car: Any) -> None:
    car = can_car(silent=True)
    car.drive(0.3, 20.0)
    assert sum(len(frames) for frames in car.log) == 0


def test_skipped_ticks_are_made_up_once(can_car: Any) -> None:
    node = EcuNode("sensitive", Codec.load())
    out, nothing = new_frames(64), new_frames(1)
    node.tick(0, nothing, 0, out)
    sent = node.tick(103, nothing, 0, out)
    assert sorted(out["identifier"][:sent]) == [VALVE_PUMP, ABS_STATUS, DIAGNOSTICS]
    assert node.tick(104, nothing, 0, out) == 2  # back on the schedule


@pytest.fixture
def plain_bus(tmp_path: Any) -> Codec:
    """A bus that carries wheel speeds and the valves only."""
    path = tmp_path / "mapping.yaml"
    signals = [f"  wheel_speed_{w}: WHEEL_SPEED_{'FRONT' if w[0] == 'f' else 'REAR'}.wheel_speed_{w}" for w in WHEELS]
    signals += [f"  valve_{v}_{w}: VALVE_PUMP.valve_{v}_{w}" for v in ("inlet", "outlet") for w in WHEELS]
    path.write_text("format: 1\nsignals:\n" + "\n".join([*signals, "  pump: VALVE_PUMP.pump"]) + "\n")
    return Codec.load(mapping=path)


WHEELS = ("fl", "fr", "rl", "rr")


def test_bus_without_pulses_and_brake_message(plain_bus: Codec) -> None:
    node = EcuNode("sensitive", plain_bus)
    values = np.zeros(200)
    heard = np.zeros(200)
    send = plain_bus.transmitter("bench", values)
    hear = plain_bus.receiver("bench", heard, np.zeros(20))
    to_ecu, from_ecu, waiting = new_frames(64), new_frames(64), 0
    released = False
    for tick in range(1500):
        values[0:4] = 20.0 / 0.278
        if tick > 1000:
            values[0] = max(20.0 - 0.05 * (tick - 1000), 5.0) / 0.278
        answered = node.tick(tick, to_ecu, waiting, from_ecu)
        waiting = send.due(tick, to_ecu)
        hear.accept(from_ecu, answered, tick)
        released = released or (tick > 1000 and node.controller.records[1][0]["outlet"][0] == 1)
    assert node.controller.records[1][0]["first_fault"] == 0
    assert released
