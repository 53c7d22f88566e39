"""An independent witness: sigrok's CAN decoder reads frames that we put on the wire, field by field.

The decoder of Debian's libsigrokdecode takes remote frames with a length code, length codes above eight and some CAN FD
frames wrongly. Those are read by a copy that is edited when the test runs: number of data bytes, CRC-17 for 16 bytes,
sample point after a rate switch, end of stuffing. A second copy knows the CRC field of CAN FD that is not ISO's,
without stuff count.
"""

import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bench.cli import main
from can_fault_injector import Bus, Frame, Node
from can_fault_injector.fields import FD_LENGTHS
from can_fault_injector.waveform import IDLE_BITS, Wave, value_change_dump

COUNT = 2000
BIT_RATE, DATA_BIT_RATE = 500_000, 2_000_000
DECODERS = [Path(folder) / "libsigrokdecode/decoders/can" for folder in ("/usr/share", "/usr/local/share")]
INSTALLED = next((folder for folder in DECODERS if (folder / "pd.py").exists()), None)

pytestmark = pytest.mark.skipif(
    shutil.which("sigrok-cli") is None or INSTALLED is None,
    reason="needs sigrok-cli: apt-get install sigrok-cli",
)

INSTALLED_ONLY = {"PATH": "/usr/bin:/bin:/usr/local/bin"}
EDITS = [
    (r"dlc2len\(self\.dlc\) < 16", "dlc2len(self.dlc) <= 16"),
    (r"\(dlc2len\(self\.dlc\) \* 8\)", "(self.data_bytes() * 8)"),
    (r"range\(dlc2len\(self\.dlc\)\)", "range(self.data_bytes())"),
    (
        r"self\.set_fast_bitrate\(\)\n",
        "self.set_fast_bitrate()\n                self.dom_edge_snum = self.samplenum - self.sample_point\n",
    ),
    (r"self\.last_databit \+ 17", "self.last_databit + (1 if self.fd else 17)"),
    (r"id = 'can'", "id = 'canp'"),
    (
        r"    def is_stuff_bit\(self\):",
        "    def data_bytes(self):\n"
        "        remote = self.bits[12] if self.frame_type == 'standard' else self.rtr\n"
        "        return dlc2len(self.dlc) if self.fd else (0 if remote else min(self.dlc, 8))\n\n"
        "    def is_stuff_bit(self):",
    ),
]
NON_ISO_EDITS = [
    (r"id = 'canp'", "id = 'cann'"),
    (r"self\.crc_len = 27", "self.crc_len = 22"),  # CRC-17 and its 5 fixed stuff bits
    (r"self\.crc_len = 32", "self.crc_len = 27"),  # CRC-21 and its 6
]


@pytest.fixture(scope="module")
def edited_decoder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the edited copies of the decoder."""
    assert INSTALLED is not None
    folder = tmp_path_factory.mktemp("decoders")
    source = (INSTALLED / "pd.py").read_text(encoding="utf-8")
    for name, edits in (("canp", EDITS), ("cann", NON_ISO_EDITS)):
        shutil.copytree(INSTALLED, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for pattern, replacement in edits:
            source, found = re.subn(pattern, replacement, source)
            assert found, f"the installed decoder has no {pattern!r} any more"
        (folder / name / "pd.py").write_text(source, encoding="utf-8")
    return folder


def decode(frames: list[Frame], folder: Path, decoder: str, environment: dict[str, str]) -> list[list[str]]:
    """Lines that the decoder prints for each frame."""
    nodes = [Node(name, iso=frames[0].iso) for name in ("sender", "receiver")]
    bus = Bus(nodes, BIT_RATE, data_bit_rate=DATA_BIT_RATE)
    for frame in frames:
        bus.run(IDLE_BITS)
        bus.send("sender", frame)
        bus.run(1000, until_idle=True)
    bus.run(IDLE_BITS)
    dump = folder / "frames.vcd"
    dump.write_text(value_change_dump(Wave(bus.trace.bus, bus.trace.durations_ns)), encoding="ascii")
    return read_dump(dump, decoder, environment)


def read_dump(dump: Path, decoder: str, environment: dict[str, str]) -> list[list[str]]:
    """Lines that the decoder prints for each frame of a dump."""
    options = f"{decoder}:can_rx=can_rx:nominal_bitrate={BIT_RATE}:fast_bitrate={DATA_BIT_RATE}:sample_point=75"
    command = ["sigrok-cli", "-I", "vcd", "-i", str(dump), "-P", options, "-A", f"{decoder}=fields:stuff-bit"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, timeout=120)
    result: list[list[str]] = []
    for line in done.stdout.splitlines():
        text = line.partition(": ")[2]
        if text == "Start of frame":
            result.append([])
        elif result:
            result[-1].append(text)
    return result


def expected_crc(frame: Frame) -> str:
    """Classic: the CRC. CAN FD: the decoder prints stuff count, CRC and fixed stuff bits as one number."""
    names, bits = list(frame.bit_names()), frame.bits()
    wanted = ("crc.", "stuff_count.", "fixed_stuff.")
    value = int("".join(str(bit) for bit, name in zip(bits, names, strict=True) if name.startswith(wanted)), 2)
    if not frame.fd:
        return f"CRC-15 sequence: 0x{value:04x}"
    width = 17 if len(frame.data) <= 16 else 21
    return f"CRC-{width} sequence: 0x{value:0{4 if width == 17 else 6}x}"


def check(frame: Frame, lines: list[str]) -> None:
    identifier = next(line for line in lines if line.startswith("Full Identifier" if frame.extended else "Identifier:"))
    assert int(re.findall(r"0x([0-9a-f]+)", identifier)[0], 16) == frame.identifier
    assert f"Data length code: {frame.length_code}" in lines
    data = bytes(int(line.rpartition("0x")[2], 16) for line in lines if line.startswith("Data byte"))
    assert data == frame.data
    crc = next(line for line in lines if line.startswith("CRC-"))
    assert int(crc.rpartition("0x")[2], 16) == int(expected_crc(frame).rpartition("0x")[2], 16), crc
    assert crc.partition(":")[0] == expected_crc(frame).partition(":")[0]
    stuff_bits = sum(line in ("0", "1") for line in lines)
    assert stuff_bits == sum(name.startswith("stuff.") for name in frame.bit_names())
    assert "End of frame" in lines


def random_frames(kind: str) -> list[Frame]:
    generator = np.random.default_rng(11)
    frames = []
    for _ in range(COUNT):
        extended = bool(generator.integers(2))
        identifier = int(generator.integers(1 << 29 if extended else 0x7F0))
        fd, remote = kind.startswith("fd"), kind == "remote"
        length = 0 if remote else int(generator.choice(FD_LENGTHS) if fd else generator.integers(9))
        length = 8 if kind == "long_length_code" else length
        # zeros and ones only are what stuffing is about
        zeros, ones = bytes(length), b"\xff" * length
        data = (generator.bytes(length), generator.bytes(length), zeros, ones)[generator.integers(4)]
        code = {"remote": generator.integers(9), "long_length_code": generator.integers(9, 16)}.get(kind)
        frames.append(
            Frame(
                identifier,
                data,
                extended=extended,
                remote=remote,
                fd=fd,
                bit_rate_switch=kind.endswith("rate_switch"),
                error_state_indicator=fd and bool(generator.integers(2)),
                dlc=None if code is None else int(code),
                iso="non_iso" not in kind,
            )
        )
    return frames


def test_installed_decoder_reads_classic_data_frames(tmp_path: Path, witnessed: Callable[[str], None]) -> None:
    frames = random_frames("data")
    decoded = decode(frames, tmp_path, "can", INSTALLED_ONLY)
    assert len(decoded) == COUNT
    for frame, lines in zip(frames, decoded, strict=True):
        check(frame, lines)
    witnessed(f"{COUNT} data frames equal in sigrok's decoder as installed")


KINDS = ["data", "remote", "long_length_code", "fd", "fd_rate_switch", "fd_non_iso", "fd_non_iso_rate_switch"]


@pytest.mark.parametrize("kind", KINDS)
def test_edited_decoder_reads_every_kind_of_frame(
    kind: str, tmp_path: Path, edited_decoder: Path, witnessed: Callable[[str], None]
) -> None:
    frames = random_frames(kind)
    environment = {**INSTALLED_ONLY, "SIGROKDECODE_DIR": str(edited_decoder)}
    decoded = decode(frames, tmp_path, "cann" if "non_iso" in kind else "canp", environment)
    assert len(decoded) == COUNT
    for frame, lines in zip(frames, decoded, strict=True):
        check(frame, lines)
    witnessed(f"{COUNT} frames of kind {kind} equal in sigrok's decoder, edited")


def test_two_flips_of_a_waveform_file_make_another_frame_with_a_good_crc(tmp_path: Path) -> None:
    """207#0D with bits 25 and 43 flipped is 207#03 with its CRC 0x3C43 (canhack's frame builder), acknowledged."""
    dump = tmp_path / "wave.vcd"
    assert main(["inject", "--explain", "207#0D", "--flip", "bit.25", "--flip", "bit.43", "--vcd", str(dump)]) == 0
    (lines,) = read_dump(dump, "can", INSTALLED_ONLY)
    assert "Data byte 0: 0x03" in lines
    assert "CRC-15 sequence: 0x3c43" in lines
    assert "ACK slot: ACK" in lines


def test_rejected_frame_of_a_waveform_file_comes_again(tmp_path: Path) -> None:
    """ISO 11898-1: after a CRC error the receiver does not acknowledge, and the sender repeats the frame."""
    dump = tmp_path / "wave.vcd"
    assert main(["inject", "--explain", "207#0D", "--flip", "crc.14", "--vcd", str(dump)]) == 0
    first, second = read_dump(dump, "can", INSTALLED_ONLY)
    assert "ACK slot: NACK" in first
    assert "ACK slot: ACK" in second
    check(Frame(0x207, b"\x0d"), second)
