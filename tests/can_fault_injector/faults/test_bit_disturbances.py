"""Bit, node and wire disturbances in the engine: what the ECU gets, when, and what the error counters show.

The frame 0x120 with 12 34 56 00 has 80 bits on the wire; at 500 kbit/s a receiver has it at the last but one bit of
EOF, which begins 78 bits of 2 us after SOF. Counters follow the protocol: TEC +8 for an error, -1 for a success.
"""

import importlib.util
from pathlib import Path

import pytest

from can_fault_injector.frame import Frame

_SPEC = importlib.util.spec_from_file_location("engine_cases", Path(__file__).with_name("engine_cases.py"))
assert _SPEC is not None
CASES = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(CASES)
MS, fault, injector, through = CASES.MS, CASES.fault, CASES.injector, CASES.through

FRAME = Frame(0x120, b"\x12\x34\x56\x00")
BIT_NS = 2000
ON_TIME_NS = (FRAME.bits().size - 2) * BIT_NS


def once(disturbance: dict[str, object]):
    engine = injector(fault(disturbance, times=1))
    return engine, through(engine, [FRAME])


@pytest.mark.parametrize(
    "disturbance",
    [
        {"flip": {"at": "data.12"}},
        {"force": {"at": "crc_del", "level": "dominant"}},
        {"glitch": {"at": "data.0", "level": "recessive"}},
        {"crc_error": {}},
        {"form_error": {}},
        {"stuff_error": {}},
        {"bit_error": {}},
        {"error_flag": {}},
        {"ack_error": {}},
    ],
    ids=lambda disturbance: next(iter(disturbance)),
)
def test_one_error_is_corrected_by_repeating_the_frame(disturbance) -> None:
    engine, delivered = once(disturbance)
    assert [item.frame for item in delivered] == [FRAME]
    # the first attempt, an error flag of 6 bits, its delimiter of 8 and 3 bits of intermission at least
    assert delivered[0].time_ns > ON_TIME_NS + (6 + 8 + 3) * BIT_NS
    assert engine.error_counters("bench")[0] == 8 - 1
    assert engine.counts["errors_bench"] == 1
    assert engine.counts["frames_lost"] == 0


def test_the_glitch_that_misses_the_sample_point_is_not_noticed() -> None:
    """Sampled at 75 % of the bit: a pulse from 10 to 30 % changes nothing."""
    engine, delivered = once({"glitch": {"at": "data.0", "level": "recessive", "start": 0.1, "width": 0.2}})
    assert [item.frame for item in delivered] == [FRAME]
    assert engine.counts["errors_bench"] == 0


def test_a_fault_at_one_receiver_only() -> None:
    """The bystander rejects the frame, so the ECU gets it by the repetition, once."""
    engine = injector(fault({"flip": {"at": "data.12", "node": "bystander"}}, times=1))
    assert [item.frame for item in through(engine, [FRAME])] == [FRAME]
    assert engine.counts["errors_bystander"] == 1


def test_overload_frames_delay_the_next_frame_only() -> None:
    """Two overload frames of 6 + 8 bits, after a first bit of intermission each."""
    frames = [FRAME, Frame(0x121, b"\x00")]
    engine = injector(fault({"overload": {"frames": 2}}, id=0x120, times=1))
    delivered = through(engine, frames, period_ms=0.01)
    assert delivered[0].time_ns == ON_TIME_NS
    assert engine.error_counters("bench") == (0, 0)
    assert len(delivered) == 2
    second_alone = (frames[1].bits().size - 2) * BIT_NS
    gap_bits = (delivered[1].time_ns - ON_TIME_NS - second_alone) / BIT_NS
    assert gap_bits == pytest.approx(2 * (1 + 6 + 8) + 3 + 1, abs=1)


def test_double_receive_and_inconsistent_omission() -> None:
    """EO02 and EO03: the same rule gives a duplicate, or an omission if the sender does not repeat."""
    engine, delivered = once({"double_receive": {}})
    assert [item.frame for item in delivered] == [FRAME, FRAME]
    engine, delivered = once({"inconsistent_omission": {}})
    assert delivered == []
    assert engine.counts["frames_lost"] == 1
    assert engine.error_counters("bench")[0] == 8


def test_bus_off_attack_takes_32_attempts() -> None:
    """TEC +8 per attempt up to 256 (FC03, FC10); what the sender still wanted to send is lost."""
    engine, delivered = once({"bus_off_attack": {"at": "data.0"}})
    assert delivered == []
    assert engine.counts["errors_bench"] == 32
    assert engine.counts["frames_lost"] == 1
    kinds = [published.frame.classes for published in engine.published if published.node == "bench"]
    assert 0x040 in kinds  # CAN_ERR_BUSOFF


@pytest.mark.acceptance("F-33")
def test_the_documented_example_in_both_modes() -> None:
    """5.2.4 on the bus: raw is an error at the ECU until it is error passive; protocol-correct arrives as 0x05D."""
    diagnostics = Frame(0x71D, b"\x12\x34\x56\x00")
    raw = injector(fault({"rewrite_id": {"to": 0x05D, "mode": "raw"}}, id=0x71D, times=1))
    assert through(raw, [diagnostics]) == []
    assert raw.counts["errors_ecu"] >= 15
    correct = injector(fault({"rewrite_id": {"to": 0x05D}}, id=0x71D))
    assert [item.frame for item in through(correct, [diagnostics])] == [Frame(0x05D, diagnostics.data)]


def test_janus_two_contents_one_frame() -> None:
    """AUTOSAR's asymmetric information: the ECU reads another payload, nobody sees an error."""
    size = FRAME.bits().size
    other = next(
        bytes([number, 0x34, 0x56, 0x00])
        for number in range(256)
        if number != 0x12 and Frame(0x120, bytes([number, 0x34, 0x56, 0x00])).bits().size == size
    )
    engine, delivered = once({"janus": {"data": other.hex()}})
    assert [item.frame.data for item in delivered] == [other]
    assert not any(name.startswith("errors") for name in engine.counts)
    engine, delivered = once({"janus": {"data": "ffffffff"}})
    assert [item.frame for item in delivered] == [FRAME]
    assert any(event.what == "cannot" for event in engine.log)


def test_an_error_passive_sender_is_overwritten() -> None:
    engine, delivered = once({"spoof_error_passive": {"data": "00000000"}})
    assert delivered[0].frame.data == bytes(4)
    assert engine.error_counters("bench")[0] >= 128
    assert engine.counts["errors_ecu"] == 0


def during(disturbance: dict[str, object]):
    """Twelve frames, one per millisecond; the fault acts from 2 to 7 ms."""
    engine = injector(fault(disturbance, duration=0.005, **{"from": 0.002}))
    delivered = through(engine, [FRAME] * 12)
    times = [item.time_ns / MS for item in delivered if item.frame == FRAME and item.way == "to_ecu"]
    return engine, times


@pytest.mark.parametrize(
    "disturbance",
    [{"babbling_idiot": {}}, {"stuck_dominant": {}}, {"endless_overload": {}}],
    ids=lambda disturbance: next(iter(disturbance)),
)
def test_a_blocked_bus_passes_nothing_and_comes_back(disturbance) -> None:
    engine, times = during(disturbance)
    blocked = [time for time in times if 2.2 < time < 7.0]
    assert blocked == []
    assert len(times) == 12  # the frames waited in the sender's mailboxes
    if disturbance == {"endless_overload": {}}:
        assert engine.error_counters("bench") == (0, 0)


def test_bus_load_delays_and_loses_nothing() -> None:
    engine, times = during({"bus_load": {"load": 0.6, "id": 0x080}})
    assert len(times) == 12
    assert engine.counts["frames_lost"] == 0
    assert max(time - number for number, time in enumerate(times)) > 1.5 * ON_TIME_NS / MS


def test_node_faults() -> None:
    engine, times = during({"error_passive": {"node": "bench"}})
    assert len(times) == 12
    assert engine.error_counters("bench")[0] > 100
    engine, times = during({"bus_off": {"node": "bench"}})
    assert engine.counts["frames_lost"] >= 5
    assert not any(2.0 < time < 7.0 for time in times)
    # 128 x 11 recessive bits are 2.8 ms
    engine, times = during({"bus_off": {"node": "bench", "recovers": True}})
    assert min(time for time in times if time > 2.0) == pytest.approx(2.0 + 128 * 11 * BIT_NS / MS + 0.3, abs=0.5)
    for node in ("bench", "ecu"):
        for kind in ("reset", "off"):
            engine, times = during({kind: {"node": node}})
            assert not any(2.0 < time < 7.0 for time in times)
            assert len(times) == 7


def test_a_lone_sender_becomes_error_passive_and_stays_so() -> None:
    """FC15: with ECU and bystander off nobody acknowledges; 16 attempts to TEC 128, then no further count."""
    engine = injector(fault({"off": {"node": "ecu"}}), fault({"off": {"node": "bystander"}}))
    engine.stage.bus.configure("injector", silent=True)
    assert through(engine, [FRAME] * 3) == []
    assert engine.error_counters("bench")[0] == 128


@pytest.mark.acceptance("F-35")
@pytest.mark.parametrize("conductor", ["can_h", "can_l", "both"])
def test_f5_broken_conductors(conductor: str, record) -> None:
    """5.2.2 F5: with both open no frame is accepted; the ECU's transceiver tells of it."""
    engine, times = during({"open": {"conductor": conductor}})
    accepted = sum(2.0 < time < 7.0 for time in times)
    record("frames accepted with both conductors open", accepted if conductor == "both" else 0, "0")
    if conductor == "both":
        assert accepted == 0
    assert next(published.frame.classes for published in engine.published if published.node == "ecu") == 0x010
    assert [time for time in times if time > 7.5]


def test_a_short_between_the_conductors_silences_the_bus() -> None:
    _, times = during({"short": {"between": "can_h_to_can_l"}})
    assert not any(2.0 < time < 7.0 for time in times)


def test_error_frames_name_the_node_and_the_error() -> None:
    engine, _ = once({"bit_error": {"at": "data.0"}})
    bench = [published.frame for published in engine.published if published.node == "bench"]
    assert bench[0].data[2] & 0x80  # of the transmitter
    assert bench[0].data[3] == 0x0A  # in the data field
    assert bench[0].data[6] == 8


def test_the_same_seed_gives_the_same_bits() -> None:
    def run(seed: int):
        engine = injector(
            fault({"flip": {"at": "data.12"}}, probability=0.5), fault({"bus_load": {"load": 0.4}}), seed=seed
        )
        delivered = through(engine, [FRAME] * 50)
        return [(item.time_ns, item.frame) for item in delivered], dict(engine.counts)

    assert run(7) == run(7)
    assert run(7) != run(8)
