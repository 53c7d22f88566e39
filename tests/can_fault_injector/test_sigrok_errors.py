"""A witness of errors: sigrok's decoder ``can2`` names stuff, CRC, form, ACK errors, flags, overload, duplicates.

It is packaged nowhere. With SIGROK_CAN2 naming a folder that holds ``can2/`` (github.com/kentindell/canhack, src/can2)
these tests run; else they are skipped and say so.
"""

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node, ProtocolError
from can_fault_injector.waveform import Wave, value_change_dump

FOLDER = os.environ.get("SIGROK_CAN2", "")
pytestmark = pytest.mark.skipif(
    shutil.which("sigrok-cli") is None or not (Path(FOLDER) / "can2" / "pd.py").exists(),
    reason="no decoder that knows error flags: SIGROK_CAN2 names no folder with can2 of kentindell/canhack",
)
COUNT = 80
IDLE = 16
"""Sequences of each kind, and recessive bits between them: more than the 11 of bus integration."""
BIT_TIME_NS, SAMPLES_PER_BIT = 2000, 20
ERROR_FRAME = ("Error flag", "Error delimiter")
EXPECTED = {
    "good": ("Received OK", "Transmitted OK"),
    "stuff": ("Stuff error", *ERROR_FRAME),
    # nobody acknowledges, and the flag begins where EOF should
    "crc": ("CRC mismatch", "ACK error", "Form error", *ERROR_FRAME),
    "ack": ("ACK error", "Form error", *ERROR_FRAME),
    "form": ("Form error", *ERROR_FRAME),
    "duplicate": ("Received OK", "Double receive", *ERROR_FRAME),
    "overload": ("Received OK", "Transmitted OK", "Overload", *ERROR_FRAME),
}
"""What the decoder says of each kind of sequence, in order."""
SAYINGS = ("Received", "Transmitted", "Stuff error", "CRC mismatch", "ACK error", "Form", "Double", "Overload", "Error")


def random_frame(generator: np.random.Generator) -> Frame:
    """A frame with at least one stuff bit."""
    extended = bool(generator.integers(2))
    length = int(generator.integers(1, 9))
    data = (generator.bytes(length), bytes(length))[generator.integers(2)]
    frame = Frame(int(generator.integers(1 << 29 if extended else 0x7F0)), data, extended=extended)
    return frame if "stuff.0" in set(frame.bit_names()) else random_frame(generator)


def levels_of(kind: str, frame: Frame) -> np.ndarray:
    """What the bus shows while the model's nodes send and disturb one frame."""
    bus = Bus([Node("sender", single_shot=True), *([] if kind == "ack" else ["receiver", "other"])])
    if kind == "crc":
        bus = Bus(["receiver", "other"])
        bus.drive(with_another_crc(frame))
    else:
        bus.send("sender", frame)
    places = {"stuff": "stuff.0", "form": "eof.3", "duplicate": "eof.6", "overload": "intermission.0"}
    if kind in places:
        bus.disturb(Disturbance("flip" if kind == "stuff" else "dominant", places[kind]))
    bus.run(600, until_idle=True)
    return bus.trace.bus


def with_another_crc(frame: Frame) -> np.ndarray:
    """Bits with one inverted CRC bit that leaves all stuff bits where they are."""
    bits, names = frame.bits(), list(frame.bit_names())
    for position in [i for i, name in enumerate(names) if name.startswith("crc.")]:
        changed = bits.copy()
        changed[position] ^= 1
        try:
            Frame.from_bits(changed)
        except ProtocolError as error:
            if error.kind == "crc" and stuffed_places(changed) == stuffed_places(bits):
                return changed
    pytest.fail("no CRC bit that may be inverted")


def stuffed_places(bits: np.ndarray) -> list[int]:
    """Where a receiver finds stuff bits up to the CRC delimiter."""
    run, before, found = 0, 2, []
    for position, level in enumerate(bits[:-10].tolist()):
        run = run + 1 if level == before else 1
        if run == 5:
            found.append(position + 1)
            run = 0
        before = level
    return found


def decode(sequences: list[np.ndarray], folder: Path) -> list[tuple[str, ...]]:
    """What can2 says of each of the sequences, which follow each other in one file."""
    gap = np.ones(IDLE, np.uint8)
    levels = np.concatenate([gap, *(part for sequence in sequences for part in (sequence, gap))])
    dump = folder / "errors.vcd"
    dump.write_text(value_change_dump(Wave(levels, np.full(levels.size, BIT_TIME_NS))), encoding="ascii")
    starts = np.cumsum([IDLE, *(sequence.size + IDLE for sequence in sequences)])
    options = "can2:canrx=can_rx:can-bitrate=500000:can-samplepoint=75"
    command = [
        "sigrok-cli",
        "-I",
        "vcd",
        "-i",
        str(dump),
        "-P",
        options,
        "-A",
        "can2=row-can-fields:row-can-warning",
        "--protocol-decoder-samplenum",
    ]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=True,
        env={"PATH": os.environ["PATH"], "SIGROKDECODE_DIR": FOLDER},
        timeout=300,
    )
    said: list[list[str]] = [[] for _ in sequences]
    for printed in done.stdout.splitlines():
        span, _, text = printed.partition(" can2-1: ")
        if text.startswith(SAYINGS):
            bit = int(span.partition("-")[0]) / SAMPLES_PER_BIT
            said[int(np.searchsorted(starts, bit + 0.5, side="right")) - 1].append(text.partition(" (")[0])
    return [tuple(lines) for lines in said]


def test_decoder_names_what_the_model_did(tmp_path: Path, witnessed: Callable[[str], None]) -> None:
    generator = np.random.default_rng(1)
    kinds = [kind for kind in EXPECTED for _ in range(COUNT)]
    sequences = [levels_of(kind, random_frame(generator)) for kind in kinds]
    for kind, said in zip(kinds, decode(sequences, tmp_path), strict=True):
        assert said == EXPECTED[kind]
    witnessed(f"{len(kinds)} sequences with errors, overload and duplicates named by can2 as they were made")
