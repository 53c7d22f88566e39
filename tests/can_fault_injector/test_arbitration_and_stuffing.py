"""Arbitration, stuffing, tolerated formats and CAN FD on the bus of protocol nodes (rules AR, ST, FM, FD)."""

import random

import fault_tester
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from can_fault_injector import Bus, Disturbance, Frame, Node

START = 4


def stream(frame: Frame, acknowledged: bool = False, **changed: int) -> list[int]:
    """Levels as a sender alone on its wire drives them."""
    return fault_tester.levels(frame, acknowledged, **changed)


def restuffed(frame: Frame, name: str, level: int) -> list[int]:
    """Levels of a classic frame with one information bit before the CRC changed, CRC and stuff bits made to fit."""
    plain = frame.bits(stuffed=False)
    labels = [f"{field.name}.{i}" for field in frame.fields(stuffed=False) for i in range(field.stop - field.start)]
    plain[labels.index(name)] = level
    end = labels.index("crc.0")
    register = 0
    for bit in plain[:end]:
        register = ((register << 1) ^ (0x4599 if (register >> 14) ^ int(bit) else 0)) & 0x7FFF
    information = [*map(int, plain[:end]), *[(register >> (14 - i)) & 1 for i in range(15)]]
    result: list[int] = []
    for bit in information:
        result.append(bit)
        run = 0
        for previous in reversed(result):
            if previous != bit:
                break
            run += 1
        if run == 5:
            result.append(1 - bit)
    return [*result, 1, 1, 1, *[1] * 7]


def receiver(levels: list[int], **settings_: object) -> Bus:
    bus = Bus([Node("node", **settings_)])  # type: ignore[arg-type]
    bus.drive(levels, START)
    bus.run(START + len(levels) + 40)
    return bus


def kinds(bus: Bus, name: str) -> list[str]:
    return [event.kind for event in bus.events if event.node == name]


STANDARD_PAIRS = [
    (high & ~(1 << bit), high) for bit in range(11) for high in (0x7FF, 0x555 | (1 << bit), 0x2AA | (1 << bit))
]


@pytest.mark.parametrize(("low", "high"), STANDARD_PAIRS)
def test_ar01_loss_at_every_bit_of_the_standard_identifier(low: int, high: int) -> None:
    winner, loser = Frame(low, b"\x01"), Frame(high, b"\x02")
    bus = Bus(["a", "b"])
    bus.send("a", loser)
    bus.send("b", winner)
    bus.run(600, until_idle=True)
    assert bus.nodes["a"].received == [winner]
    assert bus.nodes["b"].received == [loser]
    assert kinds(bus, "a").count("arbitration_lost") == 1
    lost = next(event.bit for event in bus.events if event.kind == "arbitration_lost")
    bits = zip(winner.bits(), loser.bits(), strict=False)
    assert lost == next(i for i, (one, other) in enumerate(bits) if one != other)
    assert [step for view in bus.nodes.values() for step in view.counter_steps] == []


@pytest.mark.parametrize("bit", range(29))
def test_ar01_loss_at_every_bit_of_the_extended_identifier(bit: int) -> None:
    base = 0x15555555
    winner = Frame(base & ~(1 << bit), b"\x01", extended=True)
    loser = Frame(base | (1 << bit), b"\x02", extended=True)
    bus = Bus(["a", "b"])
    bus.send("a", loser)
    bus.send("b", winner)
    bus.run(800, until_idle=True)
    assert (bus.nodes["a"].received, bus.nodes["b"].received) == ([winner], [loser])
    assert bus.nodes["a"].errors == bus.nodes["b"].errors == []


@pytest.mark.parametrize(
    ("winner", "loser"),
    [
        (Frame(0x155, b"\x01"), Frame(0x155, remote=True, dlc=1)),  # RTR
        (Frame(0x155, b"\x01"), Frame(0x155 << 18, b"\x02", extended=True)),  # SRR
        (Frame(0x155, remote=True, dlc=1), Frame(0x155 << 18, b"\x02", extended=True)),  # IDE
        (Frame(0x5555555, b"\x01", extended=True), Frame(0x5555555, extended=True, remote=True, dlc=1)),  # extended RTR
    ],
)
def test_ar01_loss_at_rtr_srr_and_ide(winner: Frame, loser: Frame) -> None:
    bus = Bus(["a", "b", "c"])
    bus.send("a", loser)
    bus.send("b", winner)
    bus.run(800, until_idle=True)
    assert bus.nodes["c"].received == [winner, loser]
    assert bus.nodes["a"].errors == bus.nodes["b"].errors == []


def test_ar01_two_senders_of_one_identifier_end_in_a_bit_error() -> None:
    bus = Bus(["a", "b"])
    bus.send("a", Frame(0x155, b"\x01"))
    bus.send("b", Frame(0x155, b"\x00"))
    bus.run(200)
    assert "bit" in bus.nodes["a"].errors


def test_ar01_the_lowest_of_many_identifiers_wins_every_time() -> None:
    generator = random.Random(7)
    identifiers = generator.sample(range(0x7F0), 20)
    bus = Bus([f"n{i}" for i in range(20)] + ["listener"])
    for i, identifier in enumerate(identifiers):
        bus.send(f"n{i}", Frame(identifier, bytes([i])))
    bus.run(5000, until_idle=True)
    assert [frame.identifier for frame in bus.nodes["listener"].received] == sorted(identifiers)


@pytest.mark.parametrize("level", [0, 1])
@pytest.mark.parametrize("name", ["id", "id_ext", "dlc", "data", "crc"])
def test_st01_sixth_equal_bit_in_every_stuffed_field(name: str, level: int) -> None:
    frame = Frame(0x0AAAAAAA, b"\xa5\x5a\xa5", extended=True)
    at = {label: i for i, label in enumerate(frame.bit_names())}[f"{name}.0"]
    head = stream(frame)[:at]
    while head and head[-1] == level:
        head.pop()
    run = [level] * 6
    bus = receiver([*head, *run])
    error = next(event for event in bus.events if event.kind == "error")
    assert (error.error, error.bit) == ("stuff", START + len(head) + 5)


def _ending_in_a_stuff_bit() -> Frame:
    for value in range(65536):
        frame = Frame(0x155, value.to_bytes(2, "big"))
        names = list(frame.bit_names())
        if names[names.index("crc_del.0") - 1].startswith("stuff"):
            return frame
    raise AssertionError


def test_st01_stuff_bit_after_the_last_crc_bit() -> None:
    frame = _ending_in_a_stuff_bit()
    names = list(frame.bit_names())
    at = names.index("crc_del.0") - 1
    good = receiver(stream(frame))
    assert good.nodes["node"].received == [frame]
    levels = stream(frame)[: at + 1]
    levels[at] ^= 1
    bad = receiver(levels)
    error = next(event for event in bad.events if event.kind == "error")
    assert (error.error, error.bit) == ("stuff", START + at)


def test_st02_stuff_bits_count_towards_the_next_run() -> None:
    """Five equal bits, their stuff bit and four more like it give another one: identifier 0000 0111 100."""
    frame = Frame(0x078, b"\x01")
    names = list(frame.bit_names())
    assert names[5] == "stuff.0"
    assert names[10] == "stuff.1"
    assert receiver(stream(frame)).nodes["node"].received == [frame]


SENT_STUFFED = [
    Frame(0x078, b"\x01"),
    Frame(0x000, bytes(8)),
    Frame(0x7FF, b"\xff" * 8),
    Frame(0x01E07800, b"\x0f\x83\xc1", extended=True),
    Frame(0x1FFFFFFF, b"\xff" * 8, extended=True),
    _ending_in_a_stuff_bit(),
]


@pytest.mark.parametrize("frame", SENT_STUFFED, ids=str)
def test_st02_sender_puts_stuff_bits_after_five_equal_bits(frame: Frame) -> None:
    """Runs of five, stuff bits that begin a run, a stuff bit after the CRC: the wire has the frame's bits only."""
    bus = Bus(["sender", "receiver"])
    bus.send("sender", frame)
    bus.run(300, until_idle=True)
    levels = stream(frame, acknowledged=True)
    assert bus.trace.bus[: len(levels)].tolist() == levels
    stuffed = [i for i, name in enumerate(frame.bit_names()) if name.startswith("stuff.")]
    assert stuffed
    for i in stuffed:
        assert levels[i - 5 : i] == [1 - levels[i]] * 5
    assert bus.nodes["receiver"].received == [frame]
    assert bus.nodes["sender"].counter_steps == bus.nodes["receiver"].counter_steps == []


@pytest.mark.parametrize("name", ["srr.0", "r1.0", "r0.0"])
def test_fm01_non_nominal_reserved_bits_of_extended_frames(name: str) -> None:
    frame = Frame(0x12345678, b"\x42", extended=True)
    level = 0 if name == "srr.0" else 1
    bus = receiver(restuffed(frame, name, level), fd="classic")
    assert bus.nodes["node"].received == [frame]
    assert bus.nodes["node"].errors == []


def test_fm01_recessive_r0_of_a_standard_frame_at_a_classic_node() -> None:
    frame = Frame(0x123, b"\x42")
    assert receiver(restuffed(frame, "r0.0", 1), fd="classic").nodes["node"].received == [frame]


@pytest.mark.parametrize("dlc", range(9, 16))
def test_fm01_length_codes_above_eight(dlc: int) -> None:
    frame = Frame(0x123, bytes(range(8)), dlc=dlc)
    assert receiver(stream(frame)).nodes["node"].received == [frame]


FD_LENGTHS = (0, 1, 7, 8, 12, 16, 20, 24, 32, 48, 64)


@pytest.mark.parametrize("iso", [True, False])
@pytest.mark.parametrize("length", FD_LENGTHS)
def test_fd01_to_fd05_frames_of_every_length_cross_the_bus(length: int, iso: bool) -> None:
    generator = random.Random(length)
    bus = Bus([Node("a", iso=iso), Node("b", iso=iso)], data_bit_rate=2e6)
    frames = [
        Frame(
            generator.randrange(1 << 29),
            generator.choice([generator.randbytes(length), bytes(length), b"\xff" * length]),
            extended=True,
            fd=True,
            bit_rate_switch=bool(i % 2),
            iso=iso,
        )
        for i in range(6)
    ]
    for frame in frames:
        bus.send("a", frame)
    bus.run(20_000, until_idle=True)
    assert bus.nodes["b"].received == frames
    assert bus.nodes["a"].errors == bus.nodes["b"].errors == []


def test_fd04_wrong_fixed_stuff_bit_is_a_form_error() -> None:
    frame = Frame(0x123, b"\x42\x43", fd=True)
    names = list(frame.bit_names())
    for number in range(6):
        at = names.index(f"fixed_stuff.{number}")
        levels = stream(frame)[: at + 1]
        levels[at] ^= 1
        error = next(event for event in receiver(levels).events if event.kind == "error")
        assert (error.error, error.bit) == ("form", START + at)


def test_fd06_only_the_data_phase_is_fast() -> None:
    """500 kbit/s and 2 Mbit/s: bits from ESI to the last CRC bit take 0.5 us, all others 2 us."""
    frame = Frame(0x123, bytes(range(8)), fd=True, bit_rate_switch=True)
    names = list(frame.bit_names())
    fast = names.index("crc_del.0") - names.index("brs.0") - 1
    bus = Bus(["a", "b"], 500e3, data_bit_rate=2e6)
    bus.send("a", frame)
    bits = bus.run(1000, until_idle=True)
    assert bus.time_s == pytest.approx((bits - fast) * 2e-6 + fast * 0.5e-6, abs=1e-12)


def test_fd07_error_passive_sender_shows_it_in_esi() -> None:
    frame = Frame(0x123, b"\x01", fd=True)
    bus = Bus([Node("a", transmit_errors=128), "b"])
    bus.send("a", frame)
    bus.send("a", frame)
    bus.run(1000, until_idle=True)
    assert [item.error_state_indicator for item in bus.nodes["b"].received] == [True, False]


def test_fd09_tolerant_node_waits_and_then_takes_part() -> None:
    frame, classic = Frame(0x123, bytes(32), fd=True), Frame(0x100, b"\x01")
    bus = Bus(["a", "b", Node("tolerant", fd="tolerant")])
    bus.send("a", frame)
    bus.run(1500, until_idle=True)
    bus.send("a", classic)
    bus.run(1500, until_idle=True)
    assert bus.nodes["tolerant"].received == [classic]
    assert kinds(bus, "tolerant")[0] == "protocol_exception"
    assert bus.nodes["tolerant"].counter_steps == []


def test_fd09_recessive_res_bit() -> None:
    frame = Frame(0x123, b"\x01", fd=True)
    at = list(frame.bit_names()).index("res.0")
    levels = stream(frame)
    levels[at] = 1
    bus = receiver(levels[: at + 1])
    assert kinds(bus, "node") == ["protocol_exception"]
    assert not np.any(bus.trace.driven == 0)


def test_fd10_acknowledgement_of_two_bits() -> None:
    frame = Frame(0x123, b"\x01", fd=True)
    levels = stream(frame, acknowledged=True)
    levels.insert(list(frame.bit_names()).index("ack_del.0"), 0)
    assert receiver(levels).nodes["node"].received == [frame]
    classic = Frame(0x123, b"\x01")
    levels = stream(classic, acknowledged=True, ack_del_0=0)
    assert receiver(levels[: list(classic.bit_names()).index("ack_del.0") + 1]).nodes["node"].errors == ["form"]


def test_fd10_sender_accepts_a_late_acknowledgement() -> None:
    frame = Frame(0x123, b"\x01", fd=True)
    bus = Bus(["node"])
    bus.send("node", frame)
    bus.disturb(Disturbance("dominant", "ack_del"))
    bus.run(300, until_idle=True)
    assert kinds(bus, "node") == ["started", "transmitted"]


def test_fd10_crc_error_flag_begins_four_bits_after_the_crc() -> None:
    frame = Frame(0x123, b"\x01", fd=True)
    names = list(frame.bit_names())
    levels = stream(frame)
    levels[names.index("crc.16")] ^= 1
    bus = receiver(levels)
    error = next(event for event in bus.events if event.kind == "error")
    assert (error.error, error.bit) == ("crc", START + names.index("crc.16") + 4)


def test_fd11_iso_and_non_iso_nodes_reject_each_other() -> None:
    for iso in (True, False):
        bus = Bus([Node("a", iso=iso), Node("b", iso=not iso)])
        bus.send("a", Frame(0x123, b"\x01\x02", fd=True, iso=iso))
        bus.run(2000)
        assert bus.nodes["b"].received == []
        assert set(bus.nodes["b"].errors) <= {"crc", "form", "stuff"}
        assert bus.nodes["a"].transmit_errors >= 8


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended, fd = draw(st.booleans()), draw(st.booleans())
    remote = not fd and draw(st.booleans())
    length = 0 if remote else draw(st.sampled_from(FD_LENGTHS if fd else (0, 1, 4, 8)))
    data = draw(st.one_of(st.binary(min_size=length, max_size=length), st.just(bytes(length))))
    return Frame(
        draw(st.integers(0, (1 << (29 if extended else 11)) - 1)),
        data,
        extended=extended,
        remote=remote,
        fd=fd,
        bit_rate_switch=fd and draw(st.booleans()),
        error_state_indicator=fd and draw(st.booleans()),
        dlc=draw(st.integers(0, 15)) if remote else None,
    )


@settings(max_examples=200, deadline=None)
@given(st.lists(frames(), min_size=1, max_size=4), st.integers(0, 800), st.sampled_from(["flip", "dominant"]))
def test_every_frame_arrives_in_spite_of_a_disturbed_bit(sent: list[Frame], bit: int, action: str) -> None:
    """Whatever one bit of the bus is hit, each frame arrives once; a hit in the last EOF bit may double it (EO02)."""
    bus = Bus(["a", "b"], trace=False)
    for frame in sent:
        bus.send("a", frame)
    bus.disturb(Disturbance(action, bit))  # type: ignore[arg-type]
    bus.run(20_000, until_idle=True)
    received = bus.nodes["b"].received
    without_one = [received[:i] + received[i + 1 :] for i in range(1, len(received)) if received[i] == received[i - 1]]
    assert received == sent or sent in without_one


@pytest.mark.parametrize("count_change", [0, 0b0110])
def test_fd03_wrong_stuff_bit_count_with_a_fitting_crc_is_a_crc_error(count_change: int) -> None:
    """The count is compared with the stuff bits seen, not only covered by the CRC; 0b0110 keeps its parity."""
    frame = Frame(0x123, b"\x00\x42", fd=True)
    bits = [int(bit) for bit in frame.bits()]
    start = list(frame.bit_names()).index("fixed_stuff.0")
    count = [bits[start + 1 + i] ^ (count_change >> (3 - i) & 1) for i in range(4)]
    register = 1 << 16
    for bit in [*bits[:start], *count]:
        register = ((register << 1) ^ (0x1685B if (register >> 16) ^ bit else 0)) & 0x1FFFF
    sequence = [*count, *[(register >> (16 - i)) & 1 for i in range(17)]]
    levels = bits[:start]
    for i, bit in enumerate(sequence):
        if i % 4 == 0:
            levels.append(1 - levels[-1])
        levels.append(bit)
    bus = receiver([*levels, *[1] * 10])
    assert bus.nodes["node"].received == ([] if count_change else [frame])
    assert bus.nodes["node"].errors == (["crc"] if count_change else [])
