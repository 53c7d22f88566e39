"""Triggers and frame-level disturbances in the engine, each against what its description says."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from can_fault_injector.frame import Frame

_SPEC = importlib.util.spec_from_file_location("engine_cases", Path(__file__).with_name("engine_cases.py"))
assert _SPEC is not None
CASES = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(CASES)
MS, fault, frames_out, injector, through = CASES.MS, CASES.fault, CASES.frames_out, CASES.injector, CASES.through

NUMBERED = [Frame(0x120, bytes([number, 0])) for number in range(20)]


def numbers(frames: list[Frame]) -> list[int]:
    return [frame.data[0] for frame in frames]


def test_nothing_armed_passes_everything_at_once() -> None:
    engine = injector(fault({"drop": {}}, id=0x7FF))
    delivered = through(engine, NUMBERED)
    assert [item.frame for item in delivered] == NUMBERED
    assert [item.time_ns for item in delivered] == [number * MS for number in range(20)]


def test_drop_by_occurrence() -> None:
    """nth and every: the fifth frame, then each third one."""
    out = numbers(frames_out(injector(fault({"drop": {}}, nth=5, every=3)), NUMBERED))
    assert sorted(set(range(20)) - set(out)) == [4, 7, 10, 13, 16, 19]


def test_times_repeat_and_pause() -> None:
    """Two frames lost, 5 ms pause, two frames lost."""
    out = numbers(frames_out(injector(fault({"drop": {}}, times=2, repeat=2, pause=0.005)), NUMBERED))
    lost = sorted(set(range(20)) - set(out))
    assert lost[:2] == [0, 1]
    assert len(lost) == 4
    assert lost[2] - lost[1] == 6


def test_time_window_and_duration() -> None:
    out = numbers(frames_out(injector(fault({"drop": {}}, **{"from": 0.003, "until": 0.006})), NUMBERED))
    assert sorted(set(range(20)) - set(out)) == [3, 4, 5]
    out = numbers(frames_out(injector(fault({"drop": {}}, nth=3, duration=0.004)), NUMBERED))
    assert sorted(set(range(20)) - set(out)) == [2, 3, 4, 5]


def test_probability_is_drawn_by_the_seed() -> None:
    """Of 2000 frames at 25 % about 500 are hit: five standard deviations are 97."""
    many = [Frame(0x120, bytes([number % 256])) for number in range(2000)]
    lost = []
    for seed in (1, 1, 2):
        engine = injector(fault({"drop": {}}, probability=0.25), seed=seed)
        frames_out(engine, many, period_ms=0.25)
        lost.append(engine.counts["frames_withheld"])
    assert lost[0] == lost[1] != lost[2]
    assert abs(lost[0] - 500) < 97


def test_direction_identifier_mask_format_and_payload() -> None:
    engine = injector(
        fault({"drop": {}}, id=0x120, mask=0x7FE, extended=False, direction="to_ecu", payload={"byte": 0, "equals": 7})
    )
    frames = [
        Frame(0x120, b"\x07"),
        Frame(0x121, b"\x07"),
        Frame(0x122, b"\x07"),
        Frame(0x120, b"\x08"),
        Frame(0x120, b"\x07", extended=True),
    ]
    assert frames_out(engine, frames) == frames[2:]
    assert frames_out(injector(fault({"drop": {}}, direction="to_ecu")), frames, way="to_bench") == frames


def test_delay_keeps_the_order_and_ends_without_overtaking() -> None:
    """10 ms for five frames: the sixth waits behind them."""
    delivered = through(injector(fault({"delay": {"by": 0.010}}, times=5)), NUMBERED)
    assert numbers([item.frame for item in delivered]) == list(range(20))
    assert [item.time_ns for item in delivered[:5]] == [(number + 10) * MS for number in range(5)]
    assert delivered[5].time_ns == 14 * MS
    assert delivered[15].time_ns == 15 * MS


def test_jitter_stays_within_its_range() -> None:
    delivered = through(injector(fault({"delay": {"by": 0.002, "jitter": 0.0009}})), NUMBERED)
    late = np.array([item.time_ns - number * MS for number, item in enumerate(delivered)])
    assert late.min() >= 2 * MS
    assert late.max() <= 2.9 * MS
    assert len(set(late.tolist())) > 10


def test_duplicate_with_distance() -> None:
    delivered = through(injector(fault({"duplicate": {"copies": 2, "after": 0.004}}, nth=2, times=1)), NUMBERED[:3])
    assert [(item.frame.data[0], item.time_ns // MS) for item in delivered] == [(0, 0), (1, 1), (2, 2), (1, 5), (1, 9)]


@pytest.mark.parametrize("order", ["reversed", "shuffled"])
def test_reorder_in_windows(order: str) -> None:
    out = numbers(frames_out(injector(fault({"reorder": {"window": 4, "order": order}})), NUMBERED))
    assert len(out) == 20
    for first in range(0, 20, 4):
        assert sorted(out[first : first + 4]) == list(range(first, first + 4))
    assert out != list(range(20))
    if order == "reversed":
        assert out[:4] == [3, 2, 1, 0]


def test_replay_gives_the_frame_of_an_age() -> None:
    out = numbers(frames_out(injector(fault({"replay": {"age": 0.005}}, nth=11)), NUMBERED))
    assert out == [*range(10), *range(5, 10), *(number - 5 for number in range(15, 20))][:10] + out[10:]
    # the frame handed on 5 ms before: frame 5 at 10 ms; from 15 ms on that is itself a replayed one
    assert out[10:15] == [5, 6, 7, 8, 9]
    assert out[15:20] == [5, 6, 7, 8, 9]


def test_corrupt_masquerade_length_remote_identifier_freeze() -> None:
    frame = Frame(0x120, b"\x0f\x00")
    assert frames_out(injector(fault({"corrupt": {"byte": 1, "mask": 0x81}})), [frame])[0].data == b"\x0f\x81"
    changed = frames_out(injector(fault({"corrupt": {}})), [frame])[0].data
    assert sum(bin(a ^ b).count("1") for a, b in zip(changed, frame.data, strict=True)) == 1
    assert frames_out(injector(fault({"masquerade": {"data": "AB CD"}})), [frame])[0].data == b"\xab\xcd"
    assert frames_out(injector(fault({"wrong_length": {"length": 1}})), [frame])[0].data == b"\x0f"
    assert frames_out(injector(fault({"wrong_length": {"length": 4}})), [frame])[0].data == b"\x0f\x00\x00\x00"
    remote = frames_out(injector(fault({"to_remote": {}})), [frame])[0]
    assert (remote.remote, remote.length_code, remote.data) == (True, 2, b"")
    assert frames_out(injector(fault({"rewrite_id": {"to": 0x05D}})), [frame]) == [Frame(0x05D, frame.data)]
    assert numbers(frames_out(injector(fault({"freeze": {}}, nth=3)), NUMBERED[:6])) == [0, 1, 2, 2, 2, 2]


def test_spoof_after_each_frame_and_in_a_cycle() -> None:
    after = frames_out(injector(fault({"spoof": {"id": 0x99, "data": "01"}}, id=0x120, every=2)), NUMBERED[:4])
    assert [frame.identifier for frame in after] == [0x120, 0x99, 0x120, 0x120, 0x99, 0x120]
    engine = injector(fault({"spoof": {"id": 0x99, "cycle": 0.004}}, duration=0.010))
    delivered = through(engine, NUMBERED)
    assert [item.time_ns // MS for item in delivered if item.frame.identifier == 0x99] == [0, 4, 8]


def test_faults_act_one_after_the_other() -> None:
    engine = injector(fault({"rewrite_id": {"to": 0x7}}), fault({"corrupt": {"byte": 0, "mask": 1}}))
    assert frames_out(engine, [Frame(0x120, b"\x00")]) == [Frame(0x7, b"\x01")]
    assert engine.summary()["counts"]["frames_disturbed"] == 1


def test_the_log_says_what_happened() -> None:
    engine = injector(fault({"drop": {}}, name="lost", nth=2, times=1))
    through(engine, NUMBERED[:4])
    events = [(event.time_ns // MS, event.what, event.detail) for event in engine.log]
    assert events == [(1, "begins", ""), (1, "acts", "to_ecu 120#0100 -> nothing"), (2, "ends", "1 frames")]
    summary = engine.summary()["faults"][0]
    assert summary == {
        "name": "lost",
        "kind": "drop",
        "e2e": "loss",
        "realised_as": "frame_gateway",
        "runs": 1,
        "frames": 1,
        "first_s": 0.001,
    }
