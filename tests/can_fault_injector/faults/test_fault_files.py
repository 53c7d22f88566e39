"""The fault vocabulary in files: what is accepted, what is refused with file, line and field."""

from pathlib import Path

import pytest

from can_fault_injector.faults.engine import Injector
from can_fault_injector.faults.fault_file import Disturbance, FaultsFile, load_faults
from can_fault_injector.faults.levels import E2E_CLASSES, LEVELS
from can_fault_injector.faults.vocabulary import kinds
from signals.errors import FileFaults, InputError

HEAD = "format: 1\nfaults:\n"


def load(tmp_path: Path, text: str) -> FaultsFile:
    path = tmp_path / "faults.yaml"
    path.write_text(HEAD + text)
    return load_faults(path)


def test_every_class_of_the_e2e_list_has_a_disturbance() -> None:
    """AUTOSAR RS_E2E 4.1: eleven communication faults."""
    assert len(E2E_CLASSES) == 11
    assert {kind.e2e for kind in kinds()} == set(E2E_CLASSES)


def test_every_kind_says_what_it_does_and_how_real_it_is() -> None:
    listed = list(kinds())
    assert len(listed) == len(Disturbance.model_fields) >= 40
    for kind in listed:
        assert kind.description.endswith((".", ")."))
        assert kind.realised_as in LEVELS
    assert {kind.group for kind in listed} == {"bit", "frame", "signal", "node", "wire"}


def test_units_names_and_defaults(tmp_path: Path) -> None:
    file = load(
        tmp_path,
        """
  - trigger: {id: 0x120, mask: 0x7FE, state: {signal: speed, below: 36 km/h}, from: 500 ms}
    disturbance: {delay: {by: 20 ms}}
    duration: 1 min
  - disturbance: {offset: {signals: brake_pressure_fl, by: 2 bar}}
""",
    )
    late, offset = file.faults
    assert (late.name, offset.name) == ("delay_1", "offset_2")
    assert late.trigger.state is not None
    assert late.trigger.state.below == pytest.approx(10.0)
    assert (late.trigger.start, late.duration) == (0.5, 60.0)
    assert offset.disturbance.offset is not None
    assert offset.disturbance.offset.by == pytest.approx(2e5)


@pytest.mark.parametrize(
    ("text", "line", "field", "words"),
    [
        ("  - disturbance: {dealy: {by: 1 s}}", 3, "faults[0].disturbance.dealy", "did you mean delay"),
        ("  - disturbance: {delay: {by: 20 km}}", 3, "faults[0].disturbance.delay.by", "wrong dimension"),
        ("  - disturbance: {delay: {by: 61 s}}", 3, "faults[0].disturbance.delay.by", "out of range"),
        ("  - disturbance: {flip: {at: crk.3}}", 3, "faults[0].disturbance.flip.at", "no place of a bit"),
        ("  - disturbance: {drop: {}, freeze: {}}", 3, "faults[0].disturbance", "exactly one"),
        ("  - trigger: {id: 0x120}", 3, "faults[0].disturbance", "required field is missing"),
        ("  - trigger: {id: 0x40000000}\n    disturbance: {drop: {}}", 3, "faults[0].trigger.id", "no identifier"),
        (
            "  - trigger: {from: 2 s, until: 1 s}\n    disturbance: {drop: {}}",
            3,
            "faults[0].trigger.until",
            "ends before",
        ),
        (
            "  - trigger: {payload: {signal: wheel_speed_xx, above: 1}}\n    disturbance: {drop: {}}",
            3,
            "faults[0].trigger.payload",
            "did you mean wheel_speed_",
        ),
        ("  - disturbance: {stuck: {signals: speed}}", 3, "faults[0].disturbance.stuck.signals", "unknown signal"),
        ("  - disturbance: {bus_off: {}}\n    times: 3", 4, "faults[0].times", "does not count frames"),
        ("  - disturbance: {drop: {}}\n    repeat: 3", 4, "faults[0].repeat", "never ends"),
        ("  - disturbance: {drop: {}}\n    requires: bits", 4, "faults[0].requires", "unknown value"),
        ("  - disturbance: {bus_off: {node: abs}}", 3, "faults[0].disturbance.bus_off.node", "bench, ecu"),
        (
            "  - name: a\n    disturbance: {drop: {}}\n  - name: a\n    disturbance: {drop: {}}",
            5,
            "faults[1].name",
            "two",
        ),
        ("  - disturbance: {masquerade: {data: 0x}}", 3, "faults[0].disturbance.masquerade.data", "form"),
    ],
)
def test_a_malformed_file_gives_file_line_and_field(tmp_path, text, line, field, words) -> None:
    with pytest.raises(FileFaults) as caught:
        load(tmp_path, text)
    messages = [str(fault) for fault in caught.value.faults]
    found = [fault for fault in caught.value.faults if fault.line == line and fault.field.startswith(field)]
    assert found, messages
    assert words in caught.value.message
    assert "faults.yaml" in caught.value.message


def test_a_level_that_cannot_be_had_is_refused_not_lowered() -> None:
    file = FaultsFile.model_validate(
        {"requires": "bit_model", "faults": [{"name": "flipped", "disturbance": {"flip": {"at": "crc.1"}}}]}
    )
    Injector(file.faults)
    with pytest.raises(InputError, match="flip requires bit_model"):
        Injector(file.faults, real_bus=True)
    frame_only = FaultsFile.model_validate({"requires": "bit_model", "faults": [{"disturbance": {"drop": {}}}]})
    with pytest.raises(InputError, match="drop requires bit_model"):
        Injector(frame_only.faults)
