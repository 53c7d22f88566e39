"""The shipped examples of what CAN itself lets through, run by the injector; and readings of flipped bits."""

import json
from importlib import resources

import pytest

from bench.cli import main
from can_fault_injector import Frame
from can_fault_injector.explain import reading
from can_fault_injector.faults.engine import Injector
from can_fault_injector.faults.fault_file import FaultsFile, load_faults

FOLDER = resources.files("can_fault_injector") / "examples"
MS = 1_000_000


def delivered(name: str, frames: list[Frame]) -> list[Frame]:
    """What the ECU gets of frames that the bench sends, one in each millisecond."""
    faults: FaultsFile = load_faults(str(FOLDER / f"{name}.yaml"))
    engine = Injector(faults.faults)
    out = []
    for step in range(len(frames) + 20):
        engine.begin_step(step * MS)
        if step < len(frames):
            engine.put("to_ecu", frames[step], step * MS)
        out += [item.frame for item in engine.run((step + 1) * MS)]
    return out


def test_escape_of_two_flips() -> None:
    """Anchors: id 0x207, data 0D, bits 25 and 43 flipped is accepted as 03; other frames pass as they are."""
    other = Frame(0x208, b"\x0d")
    assert delivered("escape_of_two_flips", [Frame(0x207, b"\x0d"), other]) == [Frame(0x207, b"\x03"), other]


def test_duplicate_by_the_last_eof_bit() -> None:
    """EO02: every frame arrives twice."""
    frames = [Frame(0x120, bytes([number])) for number in range(3)]
    assert delivered("duplicate_by_the_last_eof_bit", frames) == [frame for frame in frames for _ in range(2)]


def test_omission_by_the_last_but_one_eof_bit() -> None:
    """EO03: the ECU gets nothing although the bystander got all (Rufino 1998)."""
    frames = [Frame(0x120, bytes([number])) for number in range(3)]
    assert delivered("omission_by_the_last_but_one_eof_bit", frames) == []


def test_every_example_is_tested() -> None:
    names = {entry.name.partition(".")[0] for entry in FOLDER.iterdir() if entry.name.endswith(".yaml")}
    assert names == {
        "escape_of_two_flips",
        "duplicate_by_the_last_eof_bit",
        "omission_by_the_last_but_one_eof_bit",
    }


@pytest.mark.parametrize(
    ("text", "flips", "words"),
    [
        ("207#0D", ["bit.25", "bit.43"], "accepts 207#03, WITH OTHER CONTENT"),
        ("5CC#8608F493299174A8", ["bit.10", "bit.45"], "accepts 5CE#"),
        ("207#0D", ["eof.6"], "accepts 207#0D, as it was sent"),
        ("207#0D", ["stuff.0"], "rejects it: stuff error at bit 8"),
        ("207#0D", ["crc_del"], "rejects it: form error at bit 45"),
    ],
)
def test_command_says_what_a_receiver_reads(
    text: str, flips: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["inject", "--explain", text, *(word for place in flips for word in ("--flip", place))]
    assert main(arguments) == 0
    assert words in capsys.readouterr().out
    assert main([*arguments, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["reading"]
    assert (data["accepted"] is None) == ("rejects" in words)
    assert len(data["flipped"]) == len(flips)


def test_reading_of_can_fd_follows_its_kind() -> None:
    frame = Frame(0x123, b"\x01\x02", fd=True, iso=False)
    assert reading(frame, ()).accepted == frame
    assert reading(frame, ("fixed_stuff.1",)).error == "form"
