"""Exhaustive sweeps of disturbed bits against what the rules say of each field."""

import numpy as np

from can_fault_injector import Bus, Disturbance, Frame
from can_fault_injector.sweep import ESCAPED, REJECTED, SAME, flip_pair_escapes, single_bit_outcomes, sweep_receivers

FRAME = Frame(0x123, bytes(range(8)))


def test_single_bits_never_escape() -> None:
    """Only the acknowledge slot and the last EOF bit are free (BE01, EO01); forcing the present level is no fault."""
    outcomes = single_bit_outcomes(FRAME)
    bits, names = FRAME.bits(), list(FRAME.bit_names())
    for i, name in enumerate(names):
        flipped = SAME if name in ("ack_slot.0", "eof.6") else REJECTED
        forced = [SAME if bits[i] == level else flipped for level in (0, 1)]
        assert outcomes[i].tolist() == [flipped, *forced], name
    assert not np.any(outcomes == ESCAPED)


def test_known_pair_of_flips_is_the_only_escape_of_its_frame() -> None:
    """Id 0x207, data 0D: of all pairs only bits 25 and 43 give another valid frame (data 03)."""
    pairs, escapes = flip_pair_escapes(Frame(0x207, b"\x0d"))
    assert pairs == 55 * 54 // 2
    assert escapes == [(25, 43)]


def test_known_pairs_are_found_in_long_frames() -> None:
    for identifier, data, pair in [
        (0x22D, "be80", (23, 48)),
        (0x2BF, "a728a75dcee783f3", (32, 72)),
        (0x5CC, "8608f493299174a8", (10, 45)),
        (0x39E, "2b99c7f603a8b816", (71, 93)),
    ]:
        assert pair in flip_pair_escapes(Frame(identifier, bytes.fromhex(data)))[1]


def test_receivers_get_every_frame_once_but_for_two_bits() -> None:
    """With whole nodes a disturbed bit at one receiver costs a repetition, but two bits are weak spots.

    A flipped FDF makes a CAN FD node take the frame for one of a later protocol, as the recessive first bit of DLC
    stands where res is expected: it waits for idle without an error flag (FD09) and misses the frame. The flag after
    the last but one EOF bit reaches the others in the last one: they have the frame and get it again (EO03).
    """
    sweep = sweep_receivers(FRAME)
    names = list(FRAME.bit_names())
    flips = sweep.copies[: len(names), 0]
    for victim in range(3):
        others = [i for i in range(3) if i != victim]
        assert [names[i] for i in np.flatnonzero(flips[:, victim, victim] != 1)] == ["r0.0"]
        assert flips[names.index("r0.0"), victim].tolist() == [0 if i == victim else 1 for i in range(3)]
        for other in others:
            assert [names[i] for i in np.flatnonzero(flips[:, victim, other] != 1)] == ["eof.5"]
            assert flips[names.index("eof.5"), victim, other] == 2


def test_sender_counts_one_error_and_one_success_for_each_disturbed_bit() -> None:
    """A flag that begins inside the arbitration field makes the sender lose arbitration instead (TEC unchanged)."""
    sweep = sweep_receivers(FRAME)
    names = list(FRAME.bit_names())
    end_of_arbitration = names.index("rtr.0")
    for i, name in enumerate(names):
        errors = set(sweep.transmit_errors[i, 0].tolist())
        if i < end_of_arbitration:
            assert errors in ({0}, {7}), name
        else:
            # the last EOF bit gives an overload frame, FDF see above
            assert errors == ({0} if name in ("eof.6", "r0.0") else {7}), name


def test_forcing_the_level_that_is_there_changes_nothing() -> None:
    sweep = sweep_receivers(FRAME)
    bits = FRAME.bits()
    slot = list(FRAME.bit_names()).index("ack_slot.0")
    for i, bit in enumerate(bits):
        action = 2 if bit and i != slot else 1
        assert np.all(sweep.transmit_errors[i, action] == 0)
        assert np.all(sweep.bits_run[i, action] == len(bits) + 3)


def test_escapes_stand_on_an_acknowledged_bus() -> None:
    """A stuff bit that becomes data shifts the end of the frame by one: the dominant slot is then where the recessive
    delimiter must be, so only frames of the same length can escape (Tran 1999: about 1e-7 of all pairs)."""
    generator = np.random.default_rng(3)
    pairs = 0
    for _ in range(400):
        frame = Frame(int(generator.integers(0x800)), generator.bytes(8))
        tried, escapes = flip_pair_escapes(frame)
        pairs += tried
        for pair in escapes:
            bits = frame.bits()
            bits[list(pair)] ^= 1
            assert Frame.from_bits(bits).bits().size == bits.size
    assert pairs > 2_000_000


def test_a_reading_that_ends_early_is_no_escape_among_nodes() -> None:
    """Bit 78 flipped shortens what is read by a bit, bit 103 hides the dominant slot: reading alone would accept it.

    Its receiver acknowledges a bit too early, in the delimiter of the CRC: a form error of the sender, whose error flag
    ends both frames. Bit 103 then hides the slot of the repetition: the receiver misses its own acknowledgement there.
    """
    frame = Frame(0x560, bytes.fromhex("616bcffc8ba8e9f4"))
    bits = frame.bits()
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0
    bits[[78, 103]] ^= 1
    read = Frame.from_bits(bits)
    assert read.data != frame.data
    assert read.bits().size == bits.size - 1
    assert (78, 103) not in flip_pair_escapes(frame)[1]
    bus = Bus(["sender", "hit", "bystander"])
    for bit in (78, 103):
        bus.disturb(Disturbance("flip", f"bit.{bit}", tap="receive", node="hit"))
    bus.send("sender", frame)
    bus.run(1000, until_idle=True)
    assert bus.nodes["sender"].errors == ["form", "form"]
    assert bus.nodes["hit"].errors == ["form", "bit"]
    assert bus.nodes["hit"].received == bus.nodes["bystander"].received == [frame]
