"""Each disturbance of a signal inside its frame: the value that a receiver then decodes, against cantools.

Frames of the front wheel speeds, one every 5 ms; resolution 0.0025 rad/s (dbc/brake_bus.dbc).
"""

from collections.abc import Callable
from typing import Any

import cantools
import numpy as np
import pytest

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.database import shipped_database
from bench.codec.mapping_file import BUS_NAMES
from bench.injection.contents import BusContents
from bench.injection.records import write_frame
from bench.links.frame import new_frames
from can_fault_injector.faults.engine import Injector
from can_fault_injector.faults.fault_file import Disturbance, FaultsFile
from can_fault_injector.faults.vocabulary import kinds
from can_fault_injector.frame import Frame

DATABASE = cantools.database.load_file(str(shipped_database()))
CODEC = Codec.load()
CONTENTS = BusContents(CODEC)
PERIOD_NS, RESOLUTION = 5_000_000, 0.0025
LEFT, RIGHT = "wheel_speed_fl", "wheel_speed_fr"

Wheels = tuple[float, float]


def sent(count: int) -> list[Frame]:
    """Protected frames in which the left wheel slows down and the right one turns at 50 rad/s."""
    bare = [CONTENTS.changed(Frame(0x120, bytes(6)), {LEFT: 60.0 - 0.5 * (k % 8), RIGHT: 50.0}) for k in range(count)]
    return [CONTENTS.protected(frame, counter=k % 16) for k, frame in enumerate(bare)]


def received(disturbance: dict[str, Any], count: int = 8, seed: int = 1) -> list[Frame]:
    faults = FaultsFile.model_validate({"faults": [{"disturbance": disturbance, "trigger": {"id": 0x120}}]}).faults
    engine, found = Injector(faults, contents=CONTENTS, seed=seed), []
    for k, frame in enumerate(sent(count)):
        engine.begin_step(k * PERIOD_NS)
        engine.put("to_ecu", frame, k * PERIOD_NS)
        found += [item.frame for item in engine.run((k + 1) * PERIOD_NS)]
    assert len(found) == count
    return found


def decoded(frames: list[Frame]) -> list[Wheels]:
    values = [DATABASE.decode_message(0x120, frame.data) for frame in frames]
    return [(float(value[LEFT]), float(value[RIGHT])) for value in values]


CASES: dict[str, tuple[dict[str, Any], Callable[[int, float, float], Wheels]]] = {
    "offset": ({"offset": {"signals": LEFT, "by": "-20 rad/s"}}, lambda k, left, right: (left - 20.0, right)),
    "offset_of_two": ({"offset": {"signals": [LEFT, RIGHT], "by": 3.0}}, lambda k, left, right: (left + 3, right + 3)),
    "offset_beyond_the_range": ({"offset": {"signals": RIGHT, "by": 1e4}}, lambda k, left, right: (left, 327.6775)),
    "stuck": ({"stuck": {"signals": LEFT}}, lambda k, left, right: (60.0, right)),
    "stuck_at_a_value": ({"stuck": {"signals": RIGHT, "at": "7 rad/s"}}, lambda k, left, right: (left, 7.0)),
    "ramp": ({"ramp": {"signals": LEFT, "rate": 100.0}}, lambda k, left, right: (left + 0.5 * k, right)),
    "ramp_to_a_limit": (
        {"ramp": {"signals": RIGHT, "rate": -100.0, "limit": 1.0}},
        lambda k, left, right: (left, right - min(0.5 * k, 1.0)),
    ),
    "unit_error": (
        {"unit_error": {"signals": LEFT, "factor": 3.6, "shift": "2 rad/s"}},
        lambda k, left, right: (3.6 * left + 2.0, right),
    ),
    "swap_wheels": ({"swap_wheels": {"signals": [LEFT, RIGHT]}}, lambda k, left, right: (right, left)),
}


def test_every_disturbance_of_a_signal_is_here() -> None:
    tested = {next(iter(disturbance)) for disturbance, _ in CASES.values()} | {"noise"}
    assert {kind.name for kind in kinds() if kind.group == "signal"} == tested <= set(Disturbance.model_fields)


@pytest.mark.parametrize("name", CASES)
def test_the_receiver_decodes_the_disturbed_value(name: str) -> None:
    disturbance, expected = CASES[name]
    before, after = decoded(sent(8)), decoded(received(disturbance))
    for k, ((left, right), wheels) in enumerate(zip(before, after, strict=True)):
        assert wheels == pytest.approx(expected(k, left, right), abs=RESOLUTION / 2 + 1e-9)


def test_noise_has_its_standard_deviation_and_comes_from_the_seed() -> None:
    disturbance = {"noise": {"signals": [LEFT, RIGHT], "standard_deviation": "2 rad/s"}}
    count = 4000
    added = np.array(decoded(received(disturbance, count))) - np.array(decoded(sent(count)))
    # five standard errors of the mean, of the standard deviation, of the correlation
    assert np.abs(added.mean(axis=0)).max() < 5 * 2.0 / np.sqrt(count)
    assert added.std(axis=0) == pytest.approx([2.0, 2.0], abs=5 * 2.0 / np.sqrt(2 * count))
    assert abs(np.corrcoef(added.T)[0, 1]) < 5 / np.sqrt(count)
    assert received(disturbance, 20) == received(disturbance, 20) != received(disturbance, 20, seed=2)


@pytest.mark.parametrize(("repair", "accepted"), [("none", 0), ("crc", 1), ("crc_and_counter", 1)])
@pytest.mark.parametrize("name", CASES)
def test_the_protection_tells_or_fits_as_the_fault_says(name: str, repair: str, accepted: int) -> None:
    kind, fields = next(iter(CASES[name][0].items()))
    frame = received({kind: {**fields, "repair": repair}}, count=4)[3]
    assert frame.data[1] & 0x0F == 3, "the alive counter is the sender's"
    record = new_frames(1)
    write_frame(record[0], frame, "to_ecu", 0, 0)
    receiver = CODEC.receiver("ecu", np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES)))
    assert receiver.accept(record, 1, 0) == accepted


def test_frames_without_the_signal_pass_unchanged() -> None:
    faults = FaultsFile.model_validate({"faults": [{"disturbance": {"offset": {"signals": LEFT, "by": 5.0}}}]}).faults
    engine = Injector(faults, contents=CONTENTS)
    engine.begin_step(0)
    others = [Frame(0x121, bytes(6)), Frame(0x120, b"\x00"), Frame(0x120, remote=True, dlc=6), Frame(0x7FF, bytes(8))]
    for frame in others:
        engine.put("to_ecu", frame, 0)
    assert [item.frame for item in engine.run(PERIOD_NS)] == others
