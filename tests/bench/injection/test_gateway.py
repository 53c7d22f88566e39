"""The injector between two links: what passes, what is disturbed, what is counted. Frames on buses in memory."""

import time
from pathlib import Path

import numpy as np
import pytest

from bench.codec.codec import Codec
from bench.injection.gateway import Gateway
from bench.injection.live import forward
from bench.links.frame import ERROR, make_frame, new_frames, payload
from bench.links.interface import Link
from bench.links.registry import open_link
from can_fault_injector.faults.fault_file import FaultsFile
from signals.errors import InputError


class Between:
    """A gateway, a bench on its left, an ECU on its right."""

    def __init__(self, kind: str, *faults: dict) -> None:
        self.links: list[Link] = []
        texts = [f"virtual:{side}{id(self)}" for side in "lr"] if kind == "virtual" else [kind, kind]
        left, self.bench = self._pair(texts[0], "ecu", "bench")
        right, self.ecu = self._pair(texts[1], "bench", "ecu")
        file = FaultsFile.model_validate({"faults": list(faults)}) if faults else None
        self.gateway = Gateway(left, right, file, Codec.load())

    def _pair(self, text: str, role: str, peer: str) -> tuple[Link, Link]:
        first = open_link(text, role=role)
        second = open_link(first.text, role=peer)
        self.links += [first, second]
        return first, second

    def pump(self, end: Link, expected: int, timeout_s: float = 5.0) -> np.ndarray:
        """Let the gateway work until an end has heard so many frames."""
        heard, into, count = time.monotonic() + timeout_s, new_frames(8192), 0
        while count < expected and time.monotonic() < heard:
            self.gateway.step()
            count += end.receive(into, count)
        for _ in range(20):
            self.gateway.step()
            count += end.receive(into, count)
        return into[:count]

    def close(self) -> None:
        for link in self.links:
            link.close()


def numbered(count: int, identifier: int = 0x321) -> np.ndarray:
    frames = new_frames(count)
    for number in range(count):
        frames[number : number + 1] = make_frame(identifier, number.to_bytes(4, "big"))
    return frames


@pytest.mark.parametrize("kind", ["virtual", "udp_loopback"])
def test_everything_passes_in_order_both_ways(kind: str) -> None:
    """More than a second of 1 Mbit/s at 100 % load: 5000 frames of 4 bytes, in bursts of 500."""
    between = Between(kind, {"trigger": {"id": 0x7FF}, "disturbance": {"drop": {}}})
    try:
        for sender, receiver in ((between.bench, between.ecu), (between.ecu, between.bench)):
            frames, heard = numbered(5000), []
            for first in range(0, 5000, 500):
                sender.send(frames[first : first + 500], 500)
                heard += [payload(frame) for frame in between.pump(receiver, 500)]
            assert heard == [payload(frame) for frame in frames]
        summary = between.gateway.summary()
        assert summary["received"] == summary["sent"] == {"to_ecu": 5000, "to_bench": 5000}
        assert summary["links"]["bench_side"] == {"send_refused": 0, "overflows": 0}
    finally:
        between.close()


def test_faults_act_in_their_direction_only() -> None:
    between = Between(
        "virtual", {"trigger": {"id": 0x321, "direction": "to_ecu", "every": 2}, "disturbance": {"drop": {}}}
    )
    try:
        between.bench.send(numbered(10), 10)
        assert [payload(frame)[3] for frame in between.pump(between.ecu, 5)] == [1, 3, 5, 7, 9]
        between.ecu.send(numbered(10), 10)
        assert len(between.pump(between.bench, 10)) == 10
    finally:
        between.close()


def test_a_flipped_bit_delays_the_frame_and_both_sides_get_error_frames() -> None:
    between = Between("virtual", {"trigger": {"id": 0x321}, "disturbance": {"flip": {"at": "data.5"}}, "times": 1})
    try:
        between.bench.send(numbered(1), 1)
        heard = between.pump(between.ecu, 2)
        assert [bool(flags & ERROR) for flags in heard["flags"]].count(False) == 1
        errors = heard[(heard["flags"] & ERROR) != 0]
        assert len(errors) == 1
        assert errors["data"][0, 7] == 1  # the ECU's receive error counter
        told = between.pump(between.bench, 1)
        assert told["data"][0, 6] == 8  # the bench's transmit error counter
    finally:
        between.close()


def test_signals_of_the_bus_reach_the_triggers() -> None:
    """The condition on a decoded signal: brake pressed."""
    state = {"signal": "wheel_speed_fl", "above": 5.0}
    between = Between("virtual", {"trigger": {"id": 0x321, "state": state}, "disturbance": {"drop": {}}})
    try:
        codec, values = Codec.load(), np.zeros(len(codec_names()))
        between.bench.send(numbered(1), 1)
        assert len(between.pump(between.ecu, 1)) == 1
        values[codec_names().index("wheel_speed_fl")] = 30.0
        records = new_frames(64)
        transmitter = codec.transmitter("bench", values)
        sent = sum(_send(between, records, transmitter.due(tick, records)) for tick in range(10))
        between.pump(between.ecu, sent)
        time.sleep(2e-3)  # triggers are asked once per millisecond
        between.gateway.step()
        between.bench.send(numbered(1), 1)
        assert len(between.pump(between.ecu, 1, timeout_s=0.2)) == 0
    finally:
        between.close()


def codec_names() -> tuple[str, ...]:
    from bench.codec.mapping_file import BUS_NAMES

    return tuple(BUS_NAMES)


def _send(between: Between, records: np.ndarray, count: int) -> int:
    if count:
        between.bench.send(records, count)
    return count


@pytest.mark.parametrize(
    ("trigger", "words"),
    [({"phase": "brake"}, "no such phase"), ({"state": {"signal": "speed", "below": 3}}, "unknown signal")],
)
def test_what_only_a_scenario_knows_is_refused(trigger, words) -> None:
    with pytest.raises(InputError, match=words):
        Between("virtual", {"trigger": trigger, "disturbance": {"drop": {}}})


def test_a_level_is_refused_on_hardware(tmp_path: Path) -> None:
    """A serial adapter is hardware: the pty stands for one that answers nothing."""
    import os
    import pty

    _, device = pty.openpty()
    faults = tmp_path / "faults.yaml"
    faults.write_text("faults:\n  - {disturbance: {flip: {at: crc.1}}, requires: bit_model}\n")
    with pytest.raises(InputError, match="requires bit_model"):
        forward(f"slcan:{os.ttyname(device)}", "virtual:right", faults, duration_s=0.1)
