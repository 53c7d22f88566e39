"""Frames to bits and back, against an independent CRC library and published bit sequences."""

from collections.abc import Callable

import numpy as np
import pytest
from crccheck.crc import Crc15Can, Crc17CanFd, Crc21CanFd
from hypothesis import given, settings
from hypothesis import strategies as st

from can_fault_injector import Frame, ProtocolError
from can_fault_injector.bits import crc_parameters
from can_fault_injector.explain import explain
from can_fault_injector.notation import frame_text, parse_frame

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended, fd = draw(st.booleans()), draw(st.booleans())
    remote = not fd and draw(st.booleans())
    length = 0 if remote else draw(st.sampled_from(FD_LENGTHS if fd else FD_LENGTHS[:9]))
    # long runs of equal bits are what stuffing is about, so half of the payloads are nothing else
    data = draw(
        st.one_of(
            st.binary(min_size=length, max_size=length), st.sampled_from([b"\x00", b"\xff"]).map(lambda b: b * length)
        )
    )
    if remote:
        dlc = draw(st.integers(0, 15))
    else:
        dlc = draw(st.one_of(st.none(), st.integers(9, 15))) if not fd and length == 8 else None
    return Frame(
        draw(st.integers(0, (1 << (29 if extended else 11)) - 1)),
        data,
        extended=extended,
        remote=remote,
        fd=fd,
        bit_rate_switch=fd and draw(st.booleans()),
        error_state_indicator=fd and draw(st.booleans()),
        dlc=dlc,
        iso=not fd or draw(st.booleans()),
    )


@pytest.mark.acceptance("F-32")
@settings(max_examples=1500, deadline=None)
@given(frames())
def test_every_frame_survives_the_wire(frame: Frame) -> None:
    assert Frame.from_bits(frame.bits(), iso=frame.iso) == frame


def _crc_field(frame: Frame, name: str) -> int:
    bits = frame.bits()
    values = [int(bit) for bit, label in zip(bits, frame.bit_names(), strict=True) if label.startswith(name + ".")]
    return int("".join(map(str, values)), 2)


def _packed(bits: np.ndarray) -> bytes:
    """Bits padded with zeros on the left to whole bytes."""
    return np.packbits(np.concatenate([np.zeros(-len(bits) % 8, np.uint8), bits])).tobytes()


@pytest.mark.acceptance("F-32")
def test_ten_thousand_random_frames_of_every_kind_survive_the_wire(record: Callable[..., None]) -> None:
    generator = np.random.default_rng(32)
    different = 0
    for number in range(10_000):
        fd, extended = number % 2 == 1, bool(generator.integers(2))
        remote = not fd and number % 6 == 0
        length = 0 if remote else FD_LENGTHS[generator.integers(16 if fd else 9)]
        data = (generator.bytes(length), bytes(length), b"\xff" * length)[generator.integers(3)]
        switch, error_state, iso = (fd and bool(generator.integers(2)) for _ in range(3))
        identifier = int(generator.integers(1 << (29 if extended else 11)))
        code = int(generator.integers(16)) if remote else None
        frame = Frame(identifier, data, extended, remote, fd, switch, error_state, code, iso or not fd)
        different += Frame.from_bits(frame.bits(), iso=frame.iso) != frame
    record("frames of 10 000 that came back different", different, "0")
    assert different == 0


def test_fd01_crc_of_iso_starts_with_a_one_in_the_top_bit() -> None:
    """ISO 11898-1:2015 against the older CAN FD, start value 0: other CRCs, and no stuff count (FD11)."""
    for length, start in ((8, 1 << 16), (20, 1 << 20)):
        assert crc_parameters(True, length, True)[2] == start
        assert crc_parameters(True, length, False)[2] == 0
        iso, older = (Frame(0x123, bytes(length), fd=True, iso=kind) for kind in (True, False))
        assert _crc_field(iso, "crc") != _crc_field(older, "crc")
        assert "stuff_count.0" in set(iso.bit_names())
        assert "stuff_count.0" not in set(older.bit_names())


@pytest.mark.acceptance("F-32")
@settings(max_examples=300, deadline=None)
@given(frames())
def test_crc_equals_an_independent_library(frame: Frame) -> None:
    names = list(frame.bit_names())
    bits = frame.bits()
    if not frame.fd:
        plain = frame.bits(stuffed=False)
        end = next(field for field in frame.fields(stuffed=False) if field.name == "crc").start
        assert _crc_field(frame, "crc") == Crc15Can.calc(_packed(plain[:end]))
        return
    # the library starts at 0 where ISO 11898-1 starts with the top bit set: the same as inverting the first bit (SOF)
    covered = [i for i, name in enumerate(names) if not name.startswith(("fixed_stuff", "crc", "ack", "eof"))]
    stream = bits[covered].copy()
    if frame.iso:
        stream[0] ^= 1
    library = Crc17CanFd if len(frame.data) <= 16 else Crc21CanFd
    assert _crc_field(frame, "crc") == library.calc(_packed(stream))


@pytest.mark.acceptance("F-32")
def test_published_bit_sequence() -> None:
    """Id 0x207, data 0D: 55 bits, CRC 0x5E20, stuff bits at 8, 18, 44 (verified by four independent decoders)."""
    frame = Frame(0x207, b"\x0d")
    on_the_bus = frame.bits()
    on_the_bus[next(field.start for field in frame.fields() if field.name == "ack_slot")] = 0
    assert "".join(map(str, on_the_bus)) == "0010000010111000001010000110110111100010000011011111111"
    stuff = [i for i, name in enumerate(frame.bit_names()) if name.startswith("stuff")]
    assert stuff == [8, 18, 44]
    assert _crc_field(frame, "crc") == 0x5E20


@pytest.mark.parametrize(
    ("identifier", "data", "flips", "seen"),
    [
        (0x207, "0d", (25, 43), (0x207, "03")),
        (0x22D, "be80", (23, 48), (0x22D, "ae40")),
        (0x2BF, "a728a75dcee783f3", (32, 72), (0x2BF, "a7204ebb9dcf17f3")),
        (0x39E, "2b99c7f603a8b816", (71, 93), (0x39E, "2b99c7f603a8f82c")),
    ],
)
def test_known_double_flips_escape_the_crc(
    identifier: int, data: str, flips: tuple[int, int], seen: tuple[int, str]
) -> None:
    bits = Frame(identifier, bytes.fromhex(data)).bits()
    bits[list(flips)] ^= 1
    received = Frame.from_bits(bits)
    assert (received.identifier, received.data.hex()) == seen


def test_a_double_flip_can_change_identifier_and_length_code() -> None:
    bits = Frame(0x5CC, bytes.fromhex("8608f493299174a8")).bits()
    bits[[10, 45]] ^= 1
    received = Frame.from_bits(bits)
    assert (received.identifier, received.length_code) == (0x5CE, 12)


def test_no_single_flip_escapes() -> None:
    """Every flip is an error, except in the acknowledge slot and the last EOF bit, which are free."""
    frame = Frame(0x123, bytes(range(8)))
    bits = frame.bits()
    free = {i for i, name in enumerate(frame.bit_names()) if name in ("ack_slot.0", "eof.6")}
    for i in range(len(bits)):
        flipped = bits.copy()
        flipped[i] ^= 1
        if i in free:
            assert Frame.from_bits(flipped) == frame
        else:
            with pytest.raises(ProtocolError):
                Frame.from_bits(flipped)


def test_stuff_bits_that_the_rewritten_identifier_needs() -> None:
    """Enisz 2015, 5.2.4: 0x71D to 0x05D makes SOF + 0000 five dominant bits, so a stuff bit appears after id bit 4."""
    names = list(Frame(0x05D, b"\x00").bit_names())
    assert names[:6] == ["sof.0", "id.0", "id.1", "id.2", "id.3", "stuff.0"]
    assert "stuff.0" not in list(Frame(0x71D, b"\x00").bit_names())[:6]


def test_fd_has_no_dynamic_stuff_bit_after_the_data() -> None:
    """Rule FD05: data ending in five equal bits is followed by the fixed stuff bit at once, and none is counted."""
    names = list(Frame(0x100, b"\xaa\xe0", fd=True).bit_names())
    last_data = max(i for i, name in enumerate(names) if name.startswith("data."))
    assert names[last_data + 1] == "fixed_stuff.0"


@pytest.mark.parametrize(("length", "width", "fixed"), [(16, 17, 6), (20, 21, 7)])
def test_fixed_stuff_bits_and_crc_width(length: int, width: int, fixed: int) -> None:
    names = list(Frame(1, bytes(length), fd=True).bit_names())
    assert sum(name.startswith("fixed_stuff") for name in names) == fixed
    assert sum(name.startswith("crc.") for name in names) == width


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"identifier": 0x800}, "identifier"),
        ({"identifier": 1, "data": bytes(9)}, "data"),
        ({"identifier": 1, "data": bytes(9), "fd": True}, "data"),
        ({"identifier": 1, "remote": True, "fd": True}, "remote"),
        ({"identifier": 1, "bit_rate_switch": True}, "bit_rate_switch"),
        ({"identifier": 1, "dlc": 3}, "dlc"),
    ],
)
def test_impossible_frames_are_refused(arguments: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Frame(**arguments)  # type: ignore[arg-type]


@settings(max_examples=300, deadline=None)
@given(frames())
def test_every_frame_has_a_text(frame: Frame) -> None:
    assert parse_frame(frame_text(frame), frame.iso) == frame


@settings(max_examples=300, deadline=None)
@given(frames())
def test_rows_hold_every_bit_once(frame: Frame) -> None:
    explanation = explain(frame)
    assert [bit.position for bit in explanation.bits] == list(range(frame.bits().size))
    assert [bit.level for bit in explanation.bits] == frame.bits().tolist()
    data = explanation.as_data()
    assert data["length"] - data["stuff_bits"] - data["fixed_stuff_bits"] == frame.bits(stuffed=False).size
    assert parse_frame(data["frame"], frame.iso) == frame
