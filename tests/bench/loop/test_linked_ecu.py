"""An ECU behind a link in real time: when it counts as there, and which of its frames belong to a run."""

import numpy as np
import pytest

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.mapping_file import BUS_NAMES
from bench.codec.tables import STATISTICS
from bench.links.frame import EXTENDED, make_frame, new_frames
from bench.links.registry import open_link
from bench.loop.ecu_sides import LinkedEcu
from signals.errors import RunError

TICKS_BEFORE_THE_CLOCK = 60_000
"""Some 20 000 frames of the ECU: more than any receive buffer takes that the link asks for (4 MiB, doubled)."""


def test_only_a_good_frame_of_its_own_says_that_the_ecu_is_there() -> None:
    codec, values = Codec.load(), np.zeros(len(BUS_NAMES))
    ecu_frames = codec.receiver("bench", values, np.zeros(len(AGE_NAMES)))
    strangers = np.concatenate([make_frame(0x555, bytes(8)), make_frame(0x210, bytes(8), flags=EXTENDED)])
    wrong_crc = make_frame(0x210, bytes([0xAA] * 8))
    with open_link("udp_loopback", role="bench") as link, open_link(link.text, role="ecu") as bus:
        side = LinkedEcu(link, first_answer_s=0.3)
        for others in (strangers, wrong_crc):
            bus.send(others, len(others))
            with pytest.raises(RunError, match="sent no frame within"):
                side.wait_until_heard(ecu_frames)
        frames = new_frames(64)
        transmitter = codec.transmitter("ecu", values)
        bus.send(frames, transmitter.due(100, frames))
        side.wait_until_heard(ecu_frames)


def test_preparations_that_overflow_the_receive_buffer_cost_no_frame_of_the_run() -> None:
    codec, values = Codec.load(), np.zeros(len(BUS_NAMES))
    receiver = codec.receiver("bench", values, np.zeros(len(AGE_NAMES)))
    transmitter, frames, heard = codec.transmitter("ecu", values), new_frames(64), new_frames(4096)
    with open_link("udp_loopback", role="bench") as link, open_link(link.text, role="ecu") as ecu:

        def ecu_sends(tick: int) -> None:
            count = transmitter.due(tick, frames)
            if count:
                ecu.send(frames, count)

        side = LinkedEcu(link, first_answer_s=1.0)
        for tick in range(TICKS_BEFORE_THE_CLOCK):
            ecu_sends(tick)
        side.prepare()
        for tick in range(100):
            ecu_sends(TICKS_BEFORE_THE_CLOCK + tick)
            receiver.accept(heard, side.receive(tick, heard), tick)
        assert link.statistics()["overflows"] > 0, "the buffer took everything: the test tells nothing"
    counted = receiver.statistics()["VALVE_PUMP"]
    assert counted == dict.fromkeys(STATISTICS, 0) | {"accepted": 20}
    assert receiver.rejected_frames == 0
