"""Frames in the notation of can-utils, addresses of bits, and the explanation of a frame."""

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.cli import main
from can_fault_injector import Frame
from can_fault_injector.explain import explain
from can_fault_injector.notation import frame_text, parse_frame
from can_fault_injector.places import from_database_position, position_in, resolve
from signals.errors import InputError

SPEED = {"wheel_speed_fl": [7 - i for i in range(8)], "split": [15, 0]}


@pytest.mark.parametrize(
    ("text", "frame"),
    [
        ("123#DEADBEEF", Frame(0x123, bytes.fromhex("deadbeef"))),
        ("5AA#", Frame(0x5AA)),
        ("12345678#11.22", Frame(0x12345678, b"\x11\x22", extended=True)),
        ("7E0#R", Frame(0x7E0, remote=True, dlc=0)),
        ("7E0#R5", Frame(0x7E0, remote=True, dlc=5)),
        ("7E0#R8_E", Frame(0x7E0, remote=True, dlc=14)),
        ("123#0011223344556677_B", Frame(0x123, bytes.fromhex("0011223344556677"), dlc=11)),
        ("123##0", Frame(0x123, fd=True)),
        ("123##3AB", Frame(0x123, b"\xab", fd=True, bit_rate_switch=True, error_state_indicator=True)),
    ],
)
def test_notation_of_can_utils(text: str, frame: Frame) -> None:
    """The forms that can-utils' parse_canframe documents (flags of CAN FD: 1 = BRS, 2 = ESI, linux/can.h)."""
    assert parse_frame(text) == frame
    assert parse_frame(frame_text(frame)) == frame


@pytest.mark.parametrize(
    "text", ["", "12#00", "800#00", "123#0", "123#001122334455667788", "123##0" + 9 * "00", "xyz#1"]
)
def test_bad_frames_are_refused_with_an_example(text: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_frame(text)
    assert "123#DEADBEEF" in str(caught.value) or "two for each byte" in str(caught.value)


def test_known_frame() -> None:
    """Id 0x207, data 0D of the anchors: 55 bits, stuff bits at 8, 18 and 44, CRC 0x5E20."""
    explanation = explain(Frame(0x207, b"\x0d"))
    assert explanation.crc == 0x5E20
    assert [bit.position for bit in explanation.bits if bit.stuff] == [8, 18, 44]
    assert "55 bits (3 stuff bits), 58 with intermission, CRC-15 0x5E20" in explanation.summary()


def test_signal_bits_are_found_through_stuff_bits() -> None:
    """Bit 0 of a signal is its least significant one; data bits count in the order of transmission."""
    frame = Frame(0x000, b"\x01\x80")
    names = list(frame.bit_names())
    assert resolve("data.signal(wheel_speed_fl).bit 0", SPEED) == "data.7"
    assert position_in(frame, "data.signal(wheel_speed_fl).bit 0", SPEED) == names.index("data.7")
    assert position_in(frame, "data.signal(split).bit 1", SPEED) == names.index("data.0")
    assert [from_database_position(p) for p in (0, 7, 8, 15)] == [7, 0, 15, 8]
    assert position_in(frame, "stuff.1") == names.index("stuff.1")
    assert position_in(frame, "bit.25") == 25
    assert resolve("ack_slot") == "ack_slot.0"


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("nowhere.3", "FIELD.NUMBER"),
        ("data.signal(wheel_speed_f).bit 1", "wheel_speed_fl"),
        ("data.signal(split).bit 2", "0 to 1"),
        ("crc.15", "crc.0 to crc.14"),
        ("brs.0", "bits of sof"),
    ],
)
def test_wrong_places_say_what_is_allowed(place: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        position_in(Frame(0x123, b"\x01"), place, SPEED)
    assert words in str(caught.value)


def test_command_prints_bits_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    place = "data.signal(wheel_speed_fl).bit 5"
    arguments = ["inject", "--explain", "120#0011223344556677", "--at", place]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "00[1]00000[1]0" in text  # id 0x120: two stuff bits reach into the first byte
    assert "marked: bit 44, data.22 = wheel_speed_fl.5, level 1" in text
    assert main([*arguments, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["marked"] == [44]
    assert data["bits"][44] == {
        "position": 44,
        "level": 1,
        "name": "data.22",
        "stuff": False,
        "signal": "wheel_speed_fl.5",
    }
    assert main(["inject", "--explain", "12#"]) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--vcd", "no folder/wave.vcd"], "no folder/wave.vcd: no such file or directory"),
        (["--vcd", "wave.vcd", "--bit-rate", "0"], "allowed: 1000 to 2e+07 bit/s"),
    ],
)
def test_waveform_that_cannot_be_written_is_told(
    arguments: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["inject", "--explain", "207#0D", *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@settings(max_examples=50, deadline=None)
@given(st.text(max_size=20))
def test_any_text_is_a_frame_or_an_input_error(text: str) -> None:
    try:
        frame = parse_frame(text)
    except InputError:
        return
    assert parse_frame(frame_text(frame)) == frame
