"""Rules for can-gw: what it can do becomes cangw's arguments, what it cannot do is refused by name.

The forms are those of cangw's help; what the kernel does with them is tested in tests/vcan/test_can_gw.py.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from bench.cli import main
from can_fault_injector.can_gw import rules
from can_fault_injector.faults.fault_file import Fault
from signals.errors import InputError


def fault(disturbance: dict[str, Any], **more: Any) -> Fault:
    return Fault.model_validate({"name": "it", "disturbance": disturbance, **more})


def commands(*faults: Fault) -> list[str]:
    return [rule.command for rule in rules(faults, "vcan0", "vcan1")]


BACK = "cangw -A -s vcan1 -d vcan0 -e"


@pytest.mark.parametrize(
    ("disturbance", "trigger", "expected"),
    [
        (
            {"corrupt": {"byte": 2, "mask": 0x80}},
            {"id": 0x120},
            ["-f 120:C00007FF -m XOR:D:0.0.0000800000000000", "-f '120~C00007FF'"],
        ),
        (
            {"corrupt": {"data": "DEADBEEF"}},
            {"id": 0x120},
            ["-f 120:C00007FF -m SET:LD:0.4.DEADBEEF00000000", "-f '120~C00007FF'"],
        ),
        (
            {"masquerade": {"data": "01", "repair": "none"}},
            {"id": 0x12345},
            ["-f 80012345:DFFFFFFF -m SET:LD:0.1.0100000000000000", "-f '80012345~DFFFFFFF'"],
        ),
        (
            {"rewrite_id": {"to": 0x05D}},
            {"id": 0x71D},
            ["-f 71D:C00007FF -m SET:I:5D.0.0000000000000000", "-f '71D~C00007FF'"],
        ),
        (
            {"wrong_length": {"length": 3}},
            {"id": [0x120, 0x121]},
            ["-f 120:C00007FE -m SET:L:0.3.0000000000000000", "-f '120~C00007FE'"],
        ),
        (
            {"to_remote": {}},
            {"id": 0x100, "mask": 0x700},
            ["-f 100:C0000700 -m OR:I:40000000.0.0000000000000000", "-f '100~C0000700'"],
        ),
        ({"drop": {}}, {"id": 0x120}, ["-f '120~C00007FF'"]),
        ({"drop": {}}, {}, []),
    ],
)
def test_what_can_gw_can_do(disturbance: dict[str, Any], trigger: dict[str, Any], expected: list[str]) -> None:
    result = commands(fault(disturbance, trigger={**trigger, "direction": "to_ecu"}))
    assert result == [*(f"cangw -A -s vcan0 -d vcan1 -e {words}" for words in expected), BACK]


def test_each_direction_has_its_own_fault() -> None:
    first = fault({"drop": {}}, trigger={"id": 0x120, "direction": "to_ecu"})
    second = fault({"corrupt": {"byte": 0, "mask": 1}}, trigger={"id": 0x210, "direction": "to_bench"})
    assert commands(first, second) == [
        "cangw -A -s vcan0 -d vcan1 -e -f '120~C00007FF'",
        f"{BACK} -f 210:C00007FF -m XOR:D:0.0.0100000000000000",
        f"{BACK} -f '210~C00007FF'",
    ]


def test_without_faults_both_directions_are_forwarded() -> None:
    assert commands() == ["cangw -A -s vcan0 -d vcan1 -e", BACK]


@pytest.mark.parametrize(
    ("disturbance", "more", "word"),
    [
        ({"drop": {}}, {"trigger": {"nth": 3}}, "trigger.nth"),
        ({"drop": {}}, {"trigger": {"every": 2}}, "trigger.every"),
        ({"drop": {}}, {"trigger": {"probability": 0.5}}, "trigger.probability"),
        ({"drop": {}}, {"trigger": {"from": 1.0}}, "trigger.from"),
        ({"drop": {}}, {"trigger": {"until": 1.0}}, "trigger.until"),
        ({"drop": {}}, {"trigger": {"phase": "brake"}}, "trigger.phase"),
        ({"drop": {}}, {"trigger": {"state": {"signal": "speed", "below": 1.0}}}, "trigger.state"),
        ({"drop": {}}, {"trigger": {"payload": {"byte": 0, "equals": 1}}}, "trigger.payload"),
        ({"drop": {}}, {"trigger": {"event": "error_frame"}}, "trigger.event"),
        ({"drop": {}}, {"trigger": {"id": [0x120, 0x123]}}, "no single mask"),
        ({"drop": {}}, {"times": 1}, "times"),
        ({"drop": {}}, {"duration": 1.0}, "duration"),
        ({"corrupt": {"byte": 0, "mask": 1, "repair": "crc"}}, {}, "repair crc"),
        ({"corrupt": {"byte": 0, "mask": 1, "mode": "raw"}}, {}, "mode raw"),
        ({"corrupt": {}}, {}, "random bits"),
        ({"rewrite_id": {"to": 1, "mode": "raw"}}, {}, "mode raw"),
        ({"delay": {"by": 0.1}}, {}, "disturbance delay"),
        ({"duplicate": {}}, {}, "disturbance duplicate"),
        ({"flip": {"at": "crc.3"}}, {}, "disturbance flip"),
        ({"bus_off": {"node": "ecu"}}, {}, "disturbance bus_off"),
        ({"open": {}}, {}, "disturbance open"),
    ],
)
def test_the_rest_is_refused_by_name(disturbance: dict[str, Any], more: dict[str, Any], word: str) -> None:
    with pytest.raises(InputError) as caught:
        commands(fault(disturbance, **more))
    assert word in str(caught.value).splitlines()[0].partition(": ")[2]
    assert "AND, OR, XOR, SET" in str(caught.value)


def test_two_filters_in_one_direction_are_refused() -> None:
    with pytest.raises(InputError, match="second fault"):
        commands(*(fault({"drop": {}}, trigger={"id": identifier}) for identifier in (0x120, 0x130)))


def test_every_refused_fault_is_named() -> None:
    with pytest.raises(InputError, match=r"disturbance delay.*disturbance flip"):
        commands(fault({"delay": {"by": 0.1}}), fault({"flip": {"at": "crc.3"}}))


def test_command_line_prints_the_rules(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "faults.yaml"
    file.write_text("faults:\n  - {name: it, trigger: {id: 0x120, direction: to_ecu}, disturbance: {drop: {}}}\n")
    arguments = ["inject", "--from", "can0", "--to", "can1", str(file), "--can-gw"]
    assert main(arguments) == 0
    assert capsys.readouterr().out.splitlines() == [
        "cangw -A -s can0 -d can1 -e -f '120~C00007FF'",
        "cangw -A -s can1 -d can0 -e",
    ]
    assert main([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[1]["arguments"] == ["-s", "can1", "-d", "can0", "-e"]
    file.write_text("faults:\n  - {name: late, disturbance: {delay: {by: 20 ms}}}\n")
    assert main(arguments) == 2
    assert "late: disturbance delay" in capsys.readouterr().err
