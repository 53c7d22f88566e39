"""The in-line device bit by bit: functions F1–F4 and F8 of the friction document 5.2.2, states 5.2.3, example 5.2.4."""

import numpy as np
import pytest

from can_fault_injector.frame import Frame, ProtocolError
from can_fault_injector.gateway import InlineGateway, State

IDLE_BEFORE, IDLE_AFTER = 12, 60


def passed(gateway: InlineGateway, *frames: Frame) -> np.ndarray:
    """What leaves the device for some frames, idle bus before, between and after them."""
    levels = [1] * IDLE_BEFORE
    for frame in frames:
        levels += [*frame.bits(), *[1] * IDLE_AFTER]
    return np.array([gateway.step(int(level)) for level in levels], np.uint8)


def random_frame(generator: np.random.Generator) -> Frame:
    extended, remote = generator.random() < 0.5, generator.random() < 0.2
    identifier = int(generator.integers(2**29 if extended else 2**11))
    length = int(generator.integers(9))
    # long runs of equal bits: many stuff bits
    data = b"" if remote else bytes(generator.choice([0, 0xFF, 0x0F, 0x1F, 0xAA], length).tolist())
    return Frame(identifier, data, extended=extended, remote=remote, dlc=length if remote else None)


@pytest.mark.acceptance("F-33")
def test_f1_f8_every_kind_of_frame_passes_unchanged(record) -> None:
    generator = np.random.default_rng(33)
    frames = [random_frame(generator) for _ in range(300)]
    for mode in ("raw", "protocol_correct"):
        gateway = InlineGateway({}, mode=mode)
        sent = [1] * IDLE_BEFORE
        for frame in frames:
            sent += [*frame.bits(), *[1] * IDLE_AFTER]
        assert (passed(gateway, *frames) == sent).all()
        assert gateway.frames == len(frames)
        assert gateway.state is State.WAIT_SOF
    record("frames passed unchanged", 300, "300 of 300")


@pytest.mark.acceptance("F-33")
def test_f4_the_documented_example_needs_a_further_stuff_bit(record) -> None:
    """5.2.4: 0x71D to 0x05D; SOF and four dominant bits are five, so a stuff bit follows identifier bit 4."""
    original, wanted = Frame(0x71D, b"\x12\x34\x56"), Frame(0x05D, b"\x12\x34\x56")
    gateway = InlineGateway.rewriting(0x71D, 0x05D, "protocol_correct")
    out = passed(gateway, original)
    size = wanted.bits().size
    assert (out[IDLE_BEFORE : IDLE_BEFORE + size] == wanted.bits()).all()
    assert out[IDLE_BEFORE + size :].all()
    names, before = list(wanted.bit_names()), list(original.bit_names())
    assert names[:6] == ["sof.0", "id.0", "id.1", "id.2", "id.3", "stuff.0"]
    assert before[5] == "id.4"
    record("position of the further stuff bit", names.index("stuff.0"), "5: after SOF and identifier bits 1 to 4")


@pytest.mark.acceptance("F-33")
def test_f2_raw_rewriting_is_an_error_at_the_receiver() -> None:
    """5.2.4: a bit-for-bit rewriter changes bits 1, 2, 3 and 5 only; the receiver eats bit 5 as a stuff bit."""
    original = Frame(0x71D, b"\x12\x34\x56")
    out = passed(InlineGateway.rewriting(0x71D, 0x05D, "raw"), original)[IDLE_BEFORE:][: original.bits().size]
    assert np.flatnonzero(out != original.bits()).tolist() == [1, 2, 3, 5]
    with pytest.raises(ProtocolError):
        Frame.from_bits(out)


@pytest.mark.acceptance("F-33")
def test_f3_only_frames_with_the_identifier_are_changed() -> None:
    """A change of the payload goes by the whole identifier."""
    gateway = InlineGateway({"data.0": 1}, identifier=0x123, mode="protocol_correct", lag_bits=8)
    others, meant = Frame(0x122, b"\x01"), Frame(0x123, b"\x01")
    out = passed(gateway, others, meant)
    first = np.flatnonzero(out == 0)[0]
    assert Frame.from_bits(out[first : first + others.bits().size]) == others
    second = first + others.bits().size + IDLE_AFTER
    assert Frame.from_bits(out[second : second + Frame(0x123, b"\x81").bits().size]) == Frame(0x123, b"\x81")


def test_bits_of_the_identifier_are_changed_before_all_of_it_is_known() -> None:
    """0x71C begins like 0x71D: its first bits are changed too, and the last one is not (raw: an error)."""
    other = Frame(0x71C, b"\x12\x34\x56")
    out = passed(InlineGateway.rewriting(0x71D, 0x05D, "raw"), other)[IDLE_BEFORE:][: other.bits().size]
    assert np.flatnonzero(out != other.bits()).tolist() == [1, 2, 3, 5]


def test_any_identifier_can_become_any_other_with_a_lag() -> None:
    """Protocol-correct rewriting equals the frame built anew, whatever stuff bits come and go."""
    generator = np.random.default_rng(4)
    for _ in range(300):
        identifier, to = (int(number) for number in generator.integers(2**11, size=2))
        data = bytes(generator.choice([0, 0xFF, 0x0F, 0xAA], int(generator.integers(9))).tolist())
        gateway = InlineGateway.rewriting(identifier, to, "protocol_correct", lag_bits=6)
        out = passed(gateway, Frame(identifier, data))
        wanted = Frame(to, data).bits()
        first = IDLE_BEFORE + 6
        assert (out[first : first + wanted.size] == wanted).all()
        assert gateway.underruns == 0


def test_it_waits_for_an_idle_bus_after_start_and_after_an_error() -> None:
    """5.2.3: 11 recessive bits before a start bit counts; a stuff error sends it back to the beginning."""
    gateway = InlineGateway({})
    for level in (1,) * 10 + (0,) + (1,) * 10:
        gateway.step(level)
        assert gateway.state is State.WAIT_IDLE
    gateway.step(1)
    assert gateway.state is State.WAIT_SOF
    states = []
    for level in (0,) * 6:
        gateway.step(level)
        states.append(gateway.state)
    assert states == [State.ID] * 5 + [State.INIT]


def test_states_in_their_order() -> None:
    gateway = InlineGateway({})
    order = []
    for level in [1] * 11 + list(Frame(0x123, b"\x55").bits()):
        gateway.step(int(level))
        if not order or order[-1] is not gateway.state:
            order.append(gateway.state)
    expected = ["WAIT_IDLE", "WAIT_SOF", "ID", "CONTROL", "DLC", "DATA", "CRC", "CRC_DELIMITER", "ACK", "ACK_DELIMITER"]
    assert [state.name for state in order] == [*expected, "END"]


def test_a_new_length_needs_the_raw_mode() -> None:
    with pytest.raises(ValueError, match="DLC or CRC"):
        InlineGateway({"dlc.0": 1}, mode="protocol_correct")
