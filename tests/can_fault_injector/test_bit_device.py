"""The serial protocol of a bit-banging injector, spoken over a pty with a stand-in of the device's side.

The stand-in is written from docs/can_bit_device.md: it reads lines, keeps slots, and lets the bit model do what a
device would do to the wires, so that a fault has the same effect through the serial line as without it.
"""

import json
import os
import pty
import threading
import tty
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.cli import main
from can_fault_injector import Bus, Disturbance, Frame
from can_fault_injector.bit_device import BitDevice, ProtocolFault, disturbance_of, line, set_words, words_of
from can_fault_injector.bit_device_export import disturbances
from can_fault_injector.disturbance import ACTIONS, TAPS
from can_fault_injector.faults.fault_file import Fault
from signals.errors import InputError, LinkError

SLOTS = 8
FRAME = Frame(0x120, bytes.fromhex("1234567890abcdef"))


class StandIn:
    """Device's side: answers on a pty, and a bus of two nodes in place of the wires."""

    def __init__(self) -> None:
        self.host, device = pty.openpty()
        tty.setraw(device)
        self.path = os.ttyname(device)
        self._device = device
        self.bus = Bus(["bench", "ecu"])
        self.bus.run(20)  # compiles: afterwards it answers in time
        self.slots: dict[int, Disturbance] = {}
        self.armed: dict[int, int] = {}
        self.rates: list[str] = []
        self.noise = b""
        self.lines: list[str] = []
        self.frames_when_armed = 0
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        buffer = b""
        while True:
            try:
                buffer += os.read(self.host, 4096)
            except OSError:
                return
            while b"\n" in buffer:
                received, _, buffer = buffer.partition(b"\n")
                if received == b"stop":
                    return
                os.write(self.host, self.noise + line(self._answer(received)))
                if self.armed and self.frames_when_armed:
                    frames, self.frames_when_armed = self.frames_when_armed, 0
                    self.traffic(frames)

    def _answer(self, received: bytes) -> list[str]:
        try:
            words = words_of(received)
            self.lines.append(" ".join(words))
            return ["OK", *self._do(words)]
        except ProtocolFault as fault:
            return ["ERR", fault.code, *str(fault).split()]

    def _do(self, words: list[str]) -> list[str]:
        match words[0]:
            case "HELLO":
                return ["bit-injector", "1", "slots", str(SLOTS)]
            case "RATE":
                self.rates = words[1:]
            case "CLEAR":
                self.slots.clear()
            case "SET":
                slot, disturbance = disturbance_of(words)
                if slot >= SLOTS:
                    raise ProtocolFault("slot", f"found {slot}")
                self.slots[slot] = disturbance
            case "ARM":
                self.armed = {slot: self.bus.disturb(disturbance) for slot, disturbance in self.slots.items()}
            case "DISARM":
                for number in self.armed.values():
                    self.bus.withdraw(number)
                self.armed = {}
            case "HITS":
                return [str(self.bus.hits(self.armed[slot])) if slot in self.armed else "0" for slot in self.slots]
            case _:
                raise ProtocolFault("command", words[0])
        return []

    def traffic(self, frames: int = 3) -> None:
        """Something on the wires; every hit is reported at once."""
        before = dict.fromkeys(self.armed, 0)
        for _ in range(frames):
            self.bus.send("bench", FRAME)
            self.bus.run(2000, until_idle=True)
            for slot, number in self.armed.items():
                for count in range(before[slot] + 1, self.bus.hits(number) + 1):
                    os.write(self.host, line(["HIT", str(slot), str(count), str(round(self.bus.time_s * 1e6))]))
                before[slot] = self.bus.hits(number)

    def close(self) -> None:
        os.write(self._device, b"stop\n")
        self._thread.join(5)
        os.close(self.host)
        os.close(self._device)


@pytest.fixture
def stand_in() -> Iterator[StandIn]:
    device = StandIn()
    yield device
    device.close()


def fault(disturbance: dict[str, Any], **more: Any) -> Fault:
    return Fault.model_validate({"name": "it", "disturbance": disturbance, **more})


@st.composite
def any_disturbance(draw: st.DrawFn) -> Disturbance:
    tap = draw(st.sampled_from(TAPS))
    begin = draw(st.integers(0, 900))
    return Disturbance(
        draw(st.sampled_from(ACTIONS)),  # type: ignore[arg-type]
        draw(st.sampled_from(["crc.14", "stuff.2", "ack_slot.0", "error_delimiter.3", "bit.25"])),
        tap,  # type: ignore[arg-type]
        node=None if tap == "bus" else draw(st.sampled_from([None, "ecu", "bench"])),
        reference=draw(st.sampled_from([None, "ecu"])),
        identifier=draw(st.one_of(st.none(), st.integers(0, 0x1FFFFFFF))),
        mask=draw(st.integers(0, 0x1FFFFFFF)),
        skip=draw(st.integers(0, 100)),
        repeat=draw(st.sampled_from([-1, 1, 7])),
        length=draw(st.integers(1, 100)),
        begin=begin / 1000,
        width=draw(st.integers(1, 1000 - begin)) / 1000,
    )


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 99), any_disturbance())
def test_every_disturbance_survives_the_line(slot: int, disturbance: Disturbance) -> None:
    assert disturbance_of(words_of(line(set_words(slot, disturbance)))) == (slot, disturbance)


def test_a_line_is_what_the_document_says() -> None:
    """The example of docs/can_bit_device.md, its checksum computed by hand: exclusive or of "ARM" is 0x5E."""
    assert line(["ARM"]) == b"ARM*5E\n"
    disturbance = Disturbance("flip", "crc.14", "receive", "ecu", identifier=0x120, mask=0x7FF)
    assert " ".join(set_words(0, disturbance)) == "SET 0 flip receive ecu - crc.14 1 0 1000 120/7FF 0 1"


@pytest.mark.parametrize("received", [b"", b"ARM", b"ARM*00\n", b"ARM*5E5E\n", b"\xff\xff*00\n", b"*00\n", b"ARM*zz\n"])
def test_lines_with_a_wrong_checksum_are_noticed(received: bytes) -> None:
    with pytest.raises(ProtocolFault):
        words_of(received)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=60))
def test_any_bytes_are_a_line_or_a_fault(received: bytes) -> None:
    try:
        words = words_of(received)
    except ProtocolFault:
        return
    assert words_of(line(words)) == words


def test_a_list_of_faults_acts_through_the_serial_line_as_without_it(stand_in: StandIn) -> None:
    """Flipped CRC bit at the ECU for two frames from the second on: same events, counters, and reported hits."""
    faults = [
        fault({"crc_error": {"bit": 3}}, trigger={"id": 0x120, "nth": 2, "direction": "to_ecu"}, times=2),
        fault({"overload": {}}, trigger={"id": 0x120, "direction": "to_ecu"}, times=1),
    ]
    with BitDevice(stand_in.path) as device:
        device.load(disturbances(faults), 500e3)
        device.arm()
        stand_in.traffic()
        hits = device.wait(0.3)
        assert device.counts() == [2, 1]
    assert [(hit.slot, hit.number) for hit in sorted(hits)] == [(0, 1), (0, 2), (1, 1)]
    assert stand_in.rates == ["500000", "500000"]
    direct = Bus(["bench", "ecu"])
    direct.run(20)
    for disturbance in disturbances(faults):
        direct.disturb(disturbance)
    for _ in range(3):
        direct.send("bench", FRAME)
        direct.run(2000, until_idle=True)
    assert stand_in.bus.events == direct.events
    assert stand_in.bus.nodes["ecu"].errors.count("crc") + stand_in.bus.nodes["ecu"].errors.count("form") >= 2


def test_disarmed_the_device_is_a_plain_wire(stand_in: StandIn) -> None:
    with BitDevice(stand_in.path) as device:
        device.load([Disturbance("flip", "data.0", "bus", repeat=-1)], 500e3)
        device.arm()
        device.disarm()
        stand_in.traffic()
        assert device.wait(0.2) == []
    assert stand_in.bus.nodes["ecu"].received == [FRAME] * 3


def test_command_line_hands_a_fault_file_to_the_device(
    stand_in: StandIn, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``bench inject --device``: signals are resolved through the CAN database, hits are told, counts at the end."""
    file = tmp_path / "faults.yaml"
    file.write_text(
        "faults:\n  - name: it\n    trigger: {id: 0x120, direction: to_ecu}\n"
        "    disturbance: {flip: {at: data.signal(wheel_speed_fl).bit 5}}\n    times: 2\n",
        encoding="utf-8",
    )
    stand_in.frames_when_armed = 3
    arguments = ["inject", "--device", stand_in.path, str(file), "--duration", "0.3", "--json"]
    assert main(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["counts"] == [2]
    assert [hit["number"] for hit in result["hits"]] == [1, 2]
    assert "SET 0 flip receive ecu - data.22 1 0 1000 120/1FFFFFFF 0 2" in stand_in.lines
    assert main(["inject", "--device", str(tmp_path / "none"), str(file)]) == 4
    assert "error:" in capsys.readouterr().err


def test_what_a_device_refuses_is_an_error_with_its_words(stand_in: StandIn) -> None:
    with BitDevice(stand_in.path) as device:
        with pytest.raises(LinkError, match="refused SET"):
            device.command("SET", "0")
        with pytest.raises(LinkError, match="refused REBOOT"):
            device.command("REBOOT")
        with pytest.raises(InputError, match="too many"):
            device.load([Disturbance("flip", "data.0")] * (SLOTS + 1), 500e3)
        with pytest.raises(InputError, match="bit device"):
            device.load([Disturbance("flip", 17)], 500e3)
        stand_in.noise = b"\xfe\xff\n"
        with pytest.raises(LinkError, match="no line of the protocol"):
            device.command("HITS")


def test_something_else_on_the_port_is_noticed(stand_in: StandIn, tmp_path: Any) -> None:
    stand_in._do = lambda words: ["modem"]  # type: ignore[method-assign]
    with pytest.raises(LinkError, match="not a bit injector"):
        BitDevice(stand_in.path)
    with pytest.raises(LinkError):
        BitDevice(str(tmp_path / "nothing"))


@pytest.mark.parametrize(
    ("disturbance", "expected"),
    [
        ({"flip": {"at": "crc.3"}}, ["flip receive ecu - crc.3"]),
        ({"force": {"at": "eof.2", "level": "dominant", "tap": "bus"}}, ["dominant bus - - eof.2"]),
        ({"stuff_error": {}}, ["flip receive ecu - stuff.0"]),
        ({"form_error": {}}, ["dominant bus - - ack_del.0"]),
        ({"ack_error": {}}, ["recessive receive bench - ack_slot.0"]),
        ({"bit_error": {"at": "data.3"}}, ["flip receive bench - data.3"]),
        ({"error_flag": {}}, ["dominant bus - - data.0"]),
        ({"double_receive": {}}, ["dominant receive bench - eof.6"]),
        ({"bus_off_attack": {}}, ["flip receive bench - data.0"]),
        ({"endless_overload": {}}, ["dominant bus - - intermission.0"]),
        (
            {"corrupt": {"byte": 1, "mask": 0x81, "mode": "raw"}},
            ["flip receive ecu - data.8", "flip receive ecu - data.15"],
        ),
        ({"rewrite_id": {"to": 0x121, "mode": "raw"}}, ["flip receive ecu - id.10"]),
    ],
)
def test_faults_of_bits_become_slots(disturbance: dict[str, Any], expected: list[str]) -> None:
    made = disturbances([fault(disturbance, trigger={"id": 0x120, "direction": "to_ecu"})])
    assert [" ".join(set_words(0, item)[2:7]) for item in made] == expected


def test_a_glitch_is_a_pulse_on_the_device_and_not_a_bit() -> None:
    made = disturbances([fault({"glitch": {"at": "data.3", "level": "dominant", "start": 0.2, "width": 0.3}})])
    assert {(item.action, item.at, item.begin, item.width) for item in made} == {("dominant", "data.3", 0.2, 0.3)}
    with pytest.raises(InputError, match="beyond the bit"):
        disturbances([fault({"glitch": {"at": "data.3", "level": "dominant", "start": 0.8, "width": 0.3}})])


@pytest.mark.parametrize(
    ("disturbance", "more", "word"),
    [
        ({"drop": {}}, {}, "disturbance drop"),
        ({"janus": {"data": "00"}}, {}, "disturbance janus"),
        ({"open": {}}, {}, "disturbance open"),
        ({"corrupt": {"byte": 0, "mask": 1}}, {}, "mode protocol_correct"),
        ({"corrupt": {"mode": "raw"}}, {}, "contents"),
        ({"flip": {"at": "crc.3"}}, {"trigger": {"probability": 0.5}}, "probability"),
        ({"flip": {"at": "crc.3"}}, {"trigger": {"from": 1.0}}, "trigger.from"),
        ({"flip": {"at": "crc.3"}}, {"trigger": {"id": [1, 2]}}, "several identifiers"),
        ({"flip": {"at": "crc.3"}}, {"duration": 1.0}, "duration"),
        ({"flip": {"at": "data.signal(wheel_speed_fl).bit 5"}}, {"trigger": {"id": 1}}, "layout"),
    ],
)
def test_other_faults_are_refused_by_name(disturbance: dict[str, Any], more: dict[str, Any], word: str) -> None:
    with pytest.raises(InputError, match=word):
        disturbances([fault(disturbance, **more)])
