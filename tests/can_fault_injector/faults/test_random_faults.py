"""Property: whatever frames and faults come together, the engine raises nothing and keeps its books.

More than 10 000 frames and fault lists, counted: frame and signal faults, then bit, node and wire faults too;
and fault files whose contents make no sense.
"""

import importlib.util
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from bench.codec.codec import Codec
from bench.injection.contents import BusContents
from can_fault_injector.faults.fault_file import Disturbance, FaultsFile
from can_fault_injector.frame import Frame
from signals.errors import FileFaults
from signals.yaml_files import parse_yaml, validate

_SPEC = importlib.util.spec_from_file_location("engine_cases", Path(__file__).with_name("engine_cases.py"))
assert _SPEC is not None
CASES = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(CASES)
MS = CASES.MS
CONTENTS = BusContents(Codec.load())

short_times = st.floats(0.0, 0.01)
payloads = st.binary(max_size=8).map(bytes.hex)
places = st.one_of(
    st.builds("{}.{}".format, st.sampled_from(["id", "data", "crc", "eof", "stuff", "dlc", "bit"]), st.integers(0, 70)),
    st.sampled_from(["sof", "ack_slot", "ack_del", "crc_del", "intermission.1", "data.signal(wheel_speed_fl).bit 5"]),
)
repairs = st.sampled_from(["none", "crc", "crc_and_counter"])
nodes = st.sampled_from(["bench", "ecu", "bystander"])
signals = st.sampled_from(["wheel_speed_fl", "wheel_speed_fr", "yaw_rate", "pump"])
values = st.floats(-1e3, 1e3)


def kind(name: str, **fields: Any) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({name: st.fixed_dictionaries(fields)})


FRAME_KINDS = st.one_of(
    kind("drop"),
    kind("duplicate", copies=st.integers(1, 4), after=short_times),
    kind("delay", by=short_times, jitter=short_times),
    kind("reorder", window=st.integers(2, 5), order=st.sampled_from(["reversed", "shuffled"])),
    kind("replay", age=st.floats(0.001, 0.01), repair=repairs),
    kind("corrupt", repair=repairs),
    kind("corrupt", byte=st.integers(0, 63), mask=st.integers(1, 255)),
    kind("wrong_length", length=st.integers(0, 8)),
    kind("rewrite_id", to=st.integers(0, 0x1FFFFFFF)),
    kind("to_remote"),
    kind("masquerade", data=payloads, repair=repairs),
    kind("spoof", id=st.integers(0, 0x7FF), data=payloads, repair=repairs),
    kind(
        "spoof",
        id=st.integers(0, 0x7FF),
        cycle=st.floats(0.0005, 0.01),
        direction=st.sampled_from(["both", "to_bench"]),
    ),
    kind("freeze", repair=repairs),
    kind("offset", signals=signals, by=values),
    kind("stuck", signals=signals),
    kind("ramp", signals=signals, rate=values, limit=values),
    kind("noise", signals=signals, standard_deviation=values),
    kind("unit_error", signals=signals, factor=values),
    kind("swap_wheels", signals=st.just(["wheel_speed_fl", "wheel_speed_fr"])),
)
BIT_KINDS = st.one_of(
    kind("flip", at=places, length=st.integers(1, 20), tap=st.sampled_from(["receive", "transmit", "bus"])),
    kind("flip", at=places, node=nodes, every_attempt=st.booleans()),
    kind("force", at=places, level=st.sampled_from(["dominant", "recessive"])),
    kind("glitch", at=places, level=st.sampled_from(["dominant", "recessive"]), width=st.floats(0.0, 1.0)),
    kind("stuff_error", number=st.integers(0, 5)),
    kind("crc_error", bit=st.integers(0, 14)),
    kind("form_error", field=st.sampled_from(["crc_del", "ack_del", "eof"])),
    kind("ack_error"),
    kind("bit_error", at=places),
    kind("error_flag", at=places),
    kind("overload", frames=st.integers(1, 3)),
    kind("endless_overload"),
    kind("double_receive"),
    kind("inconsistent_omission", node=nodes),
    kind("janus", data=payloads),
    kind("bus_off_attack"),
    kind("rewrite_id", to=st.integers(0, 0x7FF), mode=st.just("raw")),
    kind("corrupt", mode=st.just("raw")),
    kind("spoof_error_passive", data=payloads),
    kind("babbling_idiot", id=st.integers(0, 0x7FF)),
    kind("bus_load", load=st.floats(0.01, 1.0)),
    kind("error_passive", node=nodes),
    kind("bus_off", node=nodes, recovers=st.booleans()),
    kind("reset", node=nodes),
    kind("off", node=nodes, acknowledges=st.booleans()),
    kind("open", conductor=st.sampled_from(["can_h", "can_l", "both"])),
    kind("short", between=st.sampled_from(["can_h_to_can_l", "can_h_to_ground", "can_l_to_battery"])),
    kind("stuck_dominant"),
)
TRIGGERS = st.fixed_dictionaries(
    {},
    optional={
        "id": st.integers(0, 0x7FF),
        "mask": st.sampled_from([0, 0x7FF, 0x1FFFFFFF]),
        "direction": st.sampled_from(["to_ecu", "to_bench", "both"]),
        "nth": st.integers(1, 4),
        "every": st.integers(1, 3),
        "probability": st.floats(0.0, 1.0),
        "payload": st.fixed_dictionaries({"byte": st.integers(0, 63), "equals": st.integers(0, 255)}),
        "event": st.sampled_from(["frame", "error_frame"]),
        "extended": st.booleans(),
    },
)
IDENTIFIERS = st.sampled_from([0x000, 0x120, 0x121, 0x7FF])


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended, remote = draw(st.booleans()), draw(st.booleans())
    if remote:
        return Frame(draw(IDENTIFIERS), remote=True, dlc=draw(st.integers(0, 15)), extended=extended)
    return Frame(draw(IDENTIFIERS), draw(st.binary(max_size=8)), extended=extended)


def faults(of: st.SearchStrategy[dict[str, Any]]) -> st.SearchStrategy[list[dict[str, Any]]]:
    limits = st.fixed_dictionaries({}, optional={"duration": st.floats(0.0005, 0.01)})
    parts = {"trigger": TRIGGERS, "disturbance": of}
    one = st.tuples(st.fixed_dictionaries(parts), limits).map(lambda pair: {**pair[0], **pair[1]})
    return st.lists(one, min_size=1, max_size=3)


def run_through(listed: list[dict[str, Any]], sent: list[tuple[str, Frame]], steps: int) -> None:
    engine = CASES.injector(*listed, contents=CONTENTS)
    delivered, last = [], 0
    for number in range(steps):
        engine.begin_step(number * MS)
        for way, frame in sent[number * 2 : number * 2 + 2]:
            engine.put(way, frame, number * MS)
        delivered += engine.run((number + 1) * MS)
        assert all(item.time_ns >= 0 for item in delivered)
    assert engine.counts["frames"] == len(sent[: 2 * steps])
    assert engine.counts["frames_disturbed"] <= engine.counts["frames"]
    for item in delivered:
        assert item.way in ("to_ecu", "to_bench")
        assert item.time_ns <= steps * MS + last
    for node in ("bench", "ecu", "bystander"):
        transmit, receive = engine.error_counters(node)
        assert 0 <= transmit <= 264
        assert 0 <= receive <= 255


WAYS = st.sampled_from(["to_ecu", "to_bench"])
SENT = st.lists(st.tuples(WAYS, frames()), min_size=2, max_size=8)
RELAXED = {"deadline": None, "suppress_health_check": list(HealthCheck), "derandomize": True}


def test_ten_thousand_random_frames_and_fault_lists() -> None:
    cases = 0

    @settings(max_examples=2500, **RELAXED)
    @given(faults(FRAME_KINDS), SENT)
    def frame_faults(listed, sent) -> None:
        nonlocal cases
        cases += 1 + len(sent)
        run_through(listed, sent, steps=8)

    @settings(max_examples=700, **RELAXED)
    @given(faults(st.one_of(BIT_KINDS, BIT_KINDS, FRAME_KINDS)), SENT)
    def bit_faults(listed, sent) -> None:
        nonlocal cases
        cases += 1 + len(sent)
        run_through(listed, sent, steps=5)

    frame_faults()
    bit_faults()
    assert cases > 10_000


NAMES = ["trigger", "disturbance", "id", "mask", "times", "duration", "requires", "by", "at", *Disturbance.model_fields]
NONSENSE = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**40), 2**40), st.text("abc .:{}[]-#0x", max_size=8), values),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(NAMES), inner, max_size=4)),
    max_leaves=8,
)


@settings(max_examples=400, **RELAXED)
@given(st.lists(NONSENSE, min_size=1, max_size=3))
def test_nonsense_is_refused_with_its_place(entries) -> None:
    """Every refusal names file, line and field; nothing else is raised."""
    try:
        FaultsFile.model_validate({"faults": entries})
        return
    except ValidationError:
        pass
    text = "faults:\n" + "".join(f"  - {_flow(entry)}\n" for entry in entries)
    with pytest.raises(FileFaults) as caught:
        validate(parse_yaml(text, "faults.yaml"), FaultsFile)
    assert all(fault.file == "faults.yaml" for fault in caught.value.faults)
    assert all(fault.line > 0 for fault in caught.value.faults)


def _flow(value: Any) -> str:
    """A value as YAML in one line."""
    import json

    return json.dumps(value, allow_nan=False)
