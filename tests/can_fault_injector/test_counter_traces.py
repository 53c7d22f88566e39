"""TEC and REC of every node after every bit, for the rules that are about flags, spaces, frames and formats.

Each case names a rule; its expected trace is a list of (bit, TEC, REC) at every change, worked out by hand from the
rules of fault confinement (Bosch CAN 2.0 part B, section 8), which themselves are in
``test_fault_confinement.py`` and ``test_fault_states.py``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import pytest
from crccheck.crc import Crc17CanFd

from can_fault_injector import Bus, Disturbance, Frame, Node

FRAME, WINNER = Frame(0x2AA, b"\x55\x0f"), Frame(0x2A9, b"\x55")
TWICE_STUFFED, LONG_CODE = Frame(0x078, b"\x01"), Frame(0x123, bytes(range(8)), dlc=12)
FD = Frame(0x123, b"\x42\x43", fd=True)
FD_PASSIVE = replace(FD, error_state_indicator=True)
NAMES = list(FRAME.bit_names())
START, PASSIVE = 4, 130
FLAG, DELIMITER, INTERMISSION, SUSPEND = 6, 8, 3, 8
EOF_6 = NAMES.index("eof.6")
END = START + len(NAMES)
"""First bit of the intermission of a frame that begins at ``START``."""
AGAIN = FLAG + DELIMITER + INTERMISSION
"""From the bit of an error to that before the next SOF, less one."""
AFTER_WINNER = START + len(list(WINNER.bit_names())) + INTERMISSION
"""First bit of a frame that follows the winner of an arbitration at once."""
ACKNOWLEDGED = Disturbance("dominant", "ack_slot", repeat=-1)
Steps = list[tuple[int, int, int]]


def at(name: str) -> int:
    return START + NAMES.index(name if "." in name else f"{name}.0")


def place(frame: Frame, name: str) -> int:
    """A bit of a frame that begins at ``START``."""
    return START + list(frame.bit_names()).index(name)


def again(error: int, name: str, extra: int = 0) -> int:
    """The same bit in the repetition after an error with one active flag."""
    return error + AGAIN + 1 + extra + at(name) - START


def seen_by(node: str, action: str, place: str, **more: object) -> Disturbance:
    return Disturbance(action, place, tap="receive", node=node, **more)  # type: ignore[arg-type]


def levels(frame: Frame = FRAME) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0
    return bits


@dataclass
class Case:
    """Nodes, what is sent from ``START`` on, what is disturbed, and the trace of each node."""

    expected: dict[str, Steps]
    disturbances: list[Disturbance] = field(default_factory=list)
    nodes: dict[str, dict[str, object]] = field(default_factory=dict)
    frames: list[tuple[str, Frame]] = field(default_factory=lambda: [("sender", FRAME)])
    driven: list[int] = field(default_factory=list)
    received: dict[str, list[Frame]] = field(default_factory=dict)


def run(case: Case, bits: int = 700) -> Bus:
    settings = {"sender": {}, "victim": {}, "other": {}} if not case.nodes else case.nodes
    bus = Bus([Node(name, **more) for name, more in settings.items()])  # type: ignore[arg-type]
    bus.run(START)
    for name, frame in case.frames:
        bus.send(name, frame)
    for disturbance in case.disturbances:
        bus.disturb(disturbance)
    bus.drive(case.driven, START)
    bus.run(bits)
    return bus


_slot = at("ack_slot")
CASES: dict[str, Callable[[], Case]] = {
    # the flag of the receiver that alone sees a dominant bit in EOF 4 reaches the others in EOF 5 (form), then theirs
    "eo01_form_error_in_eof_4": lambda: Case(
        {
            # TEC 8 at the flag of the victim, 7 after the repetition
            "sender": [(at("eof.4"), 8, 0), (again(at("eof.4"), "eof.6"), 7, 0)],
            # FC01; dominant right after its own flag, from the others: FC02
            "victim": [(at("eof.3"), 0, 1), (at("eof.3") + FLAG + 1, 0, 9), (again(at("eof.4"), "eof.5"), 0, 8)],
            "other": [(at("eof.4"), 0, 1), (again(at("eof.4"), "eof.5"), 0, 0)],
        },
        [seen_by("victim", "dominant", "eof.3")],
        received={"victim": [FRAME], "other": [FRAME]},
    ),
    "eo01_dominant_in_eof_7_of_a_receiver_counts_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        [seen_by("victim", "dominant", "eof.6")],
        received={"victim": [FRAME], "other": [FRAME]},
    ),
    "eo02_dominant_in_eof_7_of_the_sender_is_an_error_and_a_duplicate": lambda: Case(
        # receivers answer the flag with an overload frame: its first dominant bit is intermission 1
        {
            "sender": [(at("eof.6"), 8, 0), (again(at("eof.6"), "eof.6", 1), 7, 0)],
            "victim": [],
            "other": [],
        },
        [seen_by("sender", "dominant", "eof.6")],
        received={"victim": [FRAME, FRAME], "other": [FRAME, FRAME]},
    ),
    "eo02_dominant_in_intermission_1_repeats_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        [Disturbance("dominant", "intermission.0")],
        received={"victim": [FRAME], "other": [FRAME]},
    ),
    "eo03_error_at_eof_6_of_a_subset_is_a_duplicate_for_the_rest": lambda: Case(
        {
            "sender": [(at("eof.6"), 8, 0), (again(at("eof.6"), "eof.6"), 7, 0)],
            "victim": [(at("eof.5"), 0, 1), (at("eof.5") + FLAG + 1, 0, 9), (again(at("eof.6"), "eof.5"), 0, 8)],
            "other": [],
        },
        [seen_by("victim", "dominant", "eof.5")],
        received={"victim": [FRAME], "other": [FRAME, FRAME]},
    ),
    "eo03_sender_that_dies_leaves_an_omission": lambda: Case(
        {
            "sender": [(at("eof.6"), 8, 0)],
            "victim": [(at("eof.5"), 0, 1), (at("eof.5") + FLAG + 1, 0, 9)],
            "other": [],
        },
        [seen_by("victim", "dominant", "eof.5")],
        nodes={"sender": {"single_shot": True}, "victim": {}, "other": {}},
        received={"victim": [], "other": [FRAME]},
    ),
    "ov01_overload_frame_counts_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        [Disturbance("dominant", "intermission.1")],
        received={"other": [FRAME]},
    ),
    "ov02_dominant_at_the_end_of_an_overload_delimiter_counts_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        [Disturbance("dominant", "intermission.0"), Disturbance("dominant", "overload_delimiter.7")],
    ),
    "ef02_crc_and_form_error_count_once": lambda: Case(
        {"node": [(at("crc_del"), 0, 1)]},
        [Disturbance("dominant", at("crc_del")), Disturbance("flip", at("crc.13"))],
        nodes={"node": {}},
        frames=[],
        driven=levels()[: NAMES.index("crc_del.0") + 1],
    ),
    # the receivers find the third bit of the sender's flag to be the sixth equal one: nine dominant bits in all
    "ef03_superposed_flags_count_once_each": lambda: Case(
        {
            "sender": [(at("data.1"), 8, 0), (again(at("data.1"), "eof.6", 3), 7, 0)],
            "victim": [(at("data.1") + 3, 0, 1), (again(at("data.1"), "eof.5", 3), 0, 0)],
            "other": [(at("data.1") + 3, 0, 1), (again(at("data.1"), "eof.5", 3), 0, 0)],
        },
        [Disturbance("dominant", "data.1")],
    ),
    "ef04_dominant_bits_in_the_passive_flag_count_nothing": lambda: Case(
        {"node": [(START + 5, 0, PASSIVE + 1)]},
        nodes={"node": {"receive_errors": PASSIVE}},
        frames=[],
        driven=[*[0] * 6, 1, 0, 0, 0, 0, 0, *[1] * 30],
    ),
    "ef05_dominant_in_the_passive_flag_of_a_sender_is_no_bit_error": lambda: Case(
        {"sender": [(at("data.0"), PASSIVE + 8, 0)]},
        [Disturbance("flip", "data.0"), Disturbance("dominant", at("data.0") + 2, length=3)],
        nodes={"sender": {"transmit_errors": PASSIVE, "single_shot": True}},
    ),
    "ef06_passive_receiver_hurts_nobody": lambda: Case(
        # its flag is recessive: the frame goes on, is acknowledged by the other, and counts for the sender
        {"sender": [], "victim": [(_slot + 1, 0, PASSIVE + 1)], "other": []},
        [seen_by("victim", "flip", "crc.14")],
        nodes={"sender": {}, "victim": {"receive_errors": PASSIVE}, "other": {}},
        received={"victim": [], "other": [FRAME]},
    ),
    "be01_lost_arbitration_counts_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        frames=[("sender", FRAME), ("other", Frame(0x2A9, b"\x55"))],
        received={"victim": [Frame(0x2A9, b"\x55"), FRAME]},
    ),
    "st01_sixth_equal_bit_counts_one": lambda: Case(
        {"node": [(START + 5, 0, 1)]}, nodes={"node": {}}, frames=[], driven=[0] * 6
    ),
    "im01_frame_from_the_third_intermission_bit_counts_as_a_frame": lambda: Case(
        {"node": [(END - 2, 0, 4), (END + 2 + NAMES.index("eof.5"), 0, 3)]},
        nodes={"node": {"receive_errors": 5}},
        frames=[],
        driven=[*levels(), 1, 1, *levels()],
        received={"node": [FRAME, FRAME]},
    ),
    "im02_passive_former_sender_receives_in_suspend": lambda: Case(
        {"node": [(END - 1, PASSIVE - 1, 1), (END + 4 + NAMES.index("eof.5"), PASSIVE - 1, 0)]},
        [Disturbance("dominant", at("ack_slot"))],
        nodes={"node": {"transmit_errors": PASSIVE, "receive_errors": 1}},
        frames=[("node", FRAME)],
        driven=[*[1] * (END - START + 4), *levels()],
        received={"node": [FRAME]},
    ),
    "id01_frames_without_idle_each_count": lambda: Case(
        {"node": [(END - 2, 0, 1), (END + 3 + NAMES.index("eof.5"), 0, 0)]},
        nodes={"node": {"receive_errors": 2}},
        frames=[],
        driven=[*levels(), 1, 1, 1, *levels()],
        received={"node": [FRAME, FRAME]},
    ),
    "fc01x_bit_error_in_its_own_flag_counts_eight_only": lambda: Case(
        # +1 for the stuff error, +8 for the flag bit, no further +1
        {"node": [(START + 5, 0, 1), (START + 8, 0, 9)]},
        [Disturbance("recessive", START + 8)],
        nodes={"node": {}},
        frames=[],
        driven=[0] * 6,
    ),
    "fd09_protocol_exception_counts_nothing": lambda: Case(
        {"sender": [], "victim": [], "other": []},
        nodes={"sender": {}, "victim": {"fd": "tolerant"}, "other": {}},
        frames=[("sender", Frame(0x123, bytes(8), fd=True))],
        received={"victim": [], "other": [Frame(0x123, bytes(8), fd=True)]},
    ),
    "ef01_crc_error_counts_at_the_ack_delimiter": lambda: Case(
        {"node": [(at("ack_del"), 0, 1)]},
        [Disturbance("flip", at("crc.14"))],
        nodes={"node": {}},
        frames=[],
        driven=levels()[: NAMES.index("ack_del.0") + 1],
    ),
    "ef07_passive_sender_repeats_after_31_bits": lambda: Case(
        # six dominant bits of another node's flag after its own passive flag: below the eighth of FC06a
        {"sender": [(at("data.0"), PASSIVE + 8, 0), (again(at("data.0"), "eof.6", FLAG + SUSPEND), PASSIVE + 7, 0)]},
        [Disturbance("flip", "data.0"), Disturbance("dominant", at("data.0") + 7, length=6), ACKNOWLEDGED],
        nodes={"sender": {"transmit_errors": PASSIVE}},
    ),
    "ef07_sender_turned_passive_by_its_error_suspends": lambda: Case(
        {"sender": [(at("data.0"), 127 + 8, 0), (again(at("data.0"), "eof.6", SUSPEND), 127 + 7, 0)]},
        [Disturbance("flip", "data.0"), ACKNOWLEDGED],
        nodes={"sender": {"transmit_errors": 127}},
    ),
    "su01_passive_sender_counts_down_at_frames_eight_bits_further_apart": lambda: Case(
        {"sender": [(at("eof.6"), PASSIVE - 1, 0), (END + INTERMISSION + SUSPEND + EOF_6, PASSIVE - 2, 0)]},
        [ACKNOWLEDGED],
        nodes={"sender": {"transmit_errors": PASSIVE}},
        frames=[("sender", FRAME)] * 2,
    ),
    "su01_active_sender_counts_down_at_frames_without_suspension": lambda: Case(
        {"sender": [(at("eof.6"), 126, 0), (END + INTERMISSION + EOF_6, 125, 0)]},
        [ACKNOWLEDGED],
        nodes={"sender": {"transmit_errors": 127}},
        frames=[("sender", FRAME)] * 2,
    ),
    "su02_passive_loser_of_the_arbitration_does_not_suspend": lambda: Case(
        # first the winner is received, REC 9 to 8; then it sends at once
        {"sender": [(place(WINNER, "eof.5"), PASSIVE, 8), (AFTER_WINNER + EOF_6, PASSIVE - 1, 8)]},
        [ACKNOWLEDGED],
        nodes={"sender": {"transmit_errors": PASSIVE, "receive_errors": 9}},
        driven=levels(WINNER),
    ),
    "ar01_loser_counts_as_a_receiver_and_then_as_a_sender": lambda: Case(
        {
            "sender": [(place(WINNER, "eof.5"), 5, 4), (AFTER_WINNER + EOF_6, 4, 4)],
            "other": [(place(WINNER, "eof.6"), 6, 0)],
            "victim": [],
        },
        nodes={"sender": {"transmit_errors": 5, "receive_errors": 5}, "other": {"transmit_errors": 7}, "victim": {}},
        frames=[("sender", FRAME), ("other", WINNER)],
        received={"victim": [WINNER, FRAME], "sender": [WINNER], "other": [FRAME]},
    ),
    "st02_stuff_bit_after_a_stuff_bit_counts_as_a_good_frame": lambda: Case(
        {"node": [(place(TWICE_STUFFED, "eof.5"), 0, 1)]},
        nodes={"node": {"receive_errors": 2}},
        frames=[],
        driven=levels(TWICE_STUFFED),
        received={"node": [TWICE_STUFFED]},
    ),
    "fm01_length_code_above_eight_counts_as_a_good_frame": lambda: Case(
        {"node": [(place(LONG_CODE, "eof.5"), 0, 1)]},
        nodes={"node": {"receive_errors": 2}},
        frames=[],
        driven=levels(LONG_CODE),
        received={"node": [LONG_CODE]},
    ),
    "fd04_wrong_fixed_stuff_bit_counts_one_there": lambda: Case(
        {"node": [(place(FD, "fixed_stuff.2"), 0, 1)]},
        [Disturbance("flip", place(FD, "fixed_stuff.2"))],
        nodes={"node": {}},
        frames=[],
        driven=levels(FD)[: list(FD.bit_names()).index("fixed_stuff.2") + 1],
    ),
    "fd07_passive_sender_counts_down_and_shows_itself_in_esi": lambda: Case(
        {"sender": [(place(FD_PASSIVE, "eof.6"), 127, 0)], "victim": [(place(FD_PASSIVE, "eof.5"), 0, 4)]},
        nodes={"sender": {"transmit_errors": 128}, "victim": {"receive_errors": 5}},
        frames=[("sender", FD)],
        received={"victim": [FD_PASSIVE]},
    ),
}


def _good_fd(frame: Frame) -> Case:
    return Case(
        {"sender": [(place(frame, "eof.6"), 2, 0)], "victim": [(place(frame, "eof.5"), 0, 3)]},
        nodes={"sender": {"transmit_errors": 3, "iso": frame.iso}, "victim": {"receive_errors": 4, "iso": frame.iso}},
        frames=[("sender", frame)],
        received={"victim": [frame]},
    )


# both CRCs, with and without a change of rate, data that end in five equal bits (FD05)
for _length in (0, 8, 16, 20, 64):
    for _iso in (True, False):
        _frame = Frame(0x123, b"\xe0" * _length, fd=True, bit_rate_switch=_length > 8, iso=_iso)
        CASES[f"fd01_to_fd06_{_length}_bytes_{'iso' if _iso else 'non_iso'}"] = partial(_good_fd, _frame)


@pytest.mark.parametrize("name", CASES)
def test_trace(name: str) -> None:
    case = CASES[name]()
    bus = run(case)
    assert {node: bus.nodes[node].counter_steps for node in case.expected} == case.expected
    for node, frames in case.received.items():
        assert bus.nodes[node].received == frames


@pytest.mark.parametrize("late", [0, 1])
def test_fd10_acknowledgement_one_bit_late_counts_nothing(late: int) -> None:
    """A sender of CAN FD waits one bit more for the dominant bit (FD10): no counter moves."""
    frame = Frame(0x123, b"\x01", fd=True)
    slot = START + list(frame.bit_names()).index("ack_slot.0")
    bus = run(
        Case({}, [Disturbance("dominant", slot + late)], {"sender": {}}, [("sender", frame)]),
    )
    assert bus.nodes["sender"].counter_steps == []
    assert bus.nodes["sender"].errors == []


def test_fd11_iso_and_non_iso_count_errors_of_each_other() -> None:
    """A non-ISO receiver finds the stuff count where the CRC should be: one error a try, while nobody acknowledges."""
    frame = Frame(0x123, b"\x01", fd=True)
    case = Case({}, [], {"sender": {"single_shot": True}, "old": {"iso": False}}, [("sender", frame)])
    bus = run(case, 200)
    assert bus.nodes["old"].received == []
    assert set(bus.nodes["old"].errors) <= {"form", "crc", "stuff"}
    assert bus.nodes["old"].counter_steps[0][2] == 1
    assert bus.nodes["sender"].counter_steps[0][1] == 8


@pytest.mark.parametrize("length", [9, 10, 11, 13, 17, 63, 65])
def test_fd08_lengths_that_do_not_exist_are_refused(length: int) -> None:
    with pytest.raises(ValueError, match="data"):
        Frame(0x123, bytes(length), fd=True)


@pytest.mark.parametrize(("code", "length"), [(9, 12), (10, 16), (11, 20), (12, 24), (13, 32), (14, 48), (15, 64)])
def test_fd08_length_codes_and_no_remote_frames(code: int, length: int) -> None:
    frame = Frame(0x123, bytes(length), fd=True)
    assert frame.length_code == code
    assert frame.bits()[list(frame.bit_names()).index("rrs.0")] == 0
    with pytest.raises(ValueError, match="remote"):
        Frame(0x123, remote=True, fd=True)


def test_fd02_crc_covers_dynamic_stuff_bits_and_not_the_fixed_ones() -> None:
    """An independent CRC over SOF to data with dynamic stuff bits and the stuff count, without fixed stuff bits."""
    frame = Frame(0x123, b"\x00\x00", fd=True)
    names, bits = list(frame.bit_names()), frame.bits()
    covered = [i for i, name in enumerate(names) if not name.startswith(("fixed_stuff", "crc", "ack", "eof"))]
    assert any(names[i].startswith("stuff.") for i in covered)
    stream = [int(bits[i]) for i in covered]
    stream[0] ^= 1  # the library starts at 0 where ISO 11898-1 starts with the top bit set
    value = int("".join(map(str, stream)), 2).to_bytes(-(-len(stream) // 8))
    crc = int("".join(str(bits[i]) for i, name in enumerate(names) if name.startswith("crc.")), 2)
    assert crc == Crc17CanFd.calc(value)
