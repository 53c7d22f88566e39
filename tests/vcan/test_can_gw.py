"""The kernel's can-gw with the rules that we generate, set by the real cangw."""

import shutil
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import can
import pytest

from can_fault_injector.can_gw import Rule, rules
from can_fault_injector.faults.fault_file import Fault

pytestmark = pytest.mark.skipif(shutil.which("cangw") is None, reason="needs cangw: apt-get install can-utils")
END = 0x7FE


def cangw(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["cangw", *arguments], capture_output=True, text=True, check=False)


@pytest.fixture(autouse=True)
def no_rules() -> Iterator[None]:
    if cangw("-F").returncode:
        pytest.skip("no can-gw here: modprobe can-gw, as root")
    yield
    cangw("-F")


def install(generated: list[Rule]) -> None:
    for rule in generated:
        done = cangw("-A", *rule.arguments())
        assert done.returncode == 0, f"{rule.command}: {done.stderr}"


def fault(disturbance: dict[str, Any], **trigger: Any) -> Fault:
    return Fault.model_validate({"name": "it", "disturbance": disturbance, "trigger": trigger})


def frame(identifier: int, data: str = "0011223344556677", extended: bool = False) -> can.Message:
    return can.Message(arbitration_id=identifier, data=bytes.fromhex(data), is_extended_id=extended)


def passed(sent: list[can.Message], source: str = "vcan0", destination: str = "vcan1") -> list[tuple[int, str, bool]]:
    """What comes out at the destination, up to a last frame that the rules let through."""
    with can.Bus(destination, interface="socketcan") as receiver, can.Bus(source, interface="socketcan") as sender:
        for message in (*sent, frame(END, "")):
            sender.send(message)
        result = []
        end = time.monotonic() + 30
        while time.monotonic() < end:
            message = receiver.recv(1.0)
            if message is None:
                continue
            if message.arbitration_id == END:
                return result
            result.append((message.arbitration_id, bytes(message.data).hex(), message.is_remote_frame))
    pytest.fail("the frame that marks the end did not come")


OTHER = (0x121, "0011223344556677", False)
TRAFFIC = [frame(0x120), frame(0x121), frame(0x120)]


@pytest.mark.parametrize(
    ("disturbance", "expected"),
    [
        ({"corrupt": {"byte": 2, "mask": 0x80}}, (0x120, "0011a23344556677", False)),
        ({"corrupt": {"data": "DEADBEEF"}}, (0x120, "deadbeef", False)),
        ({"masquerade": {"data": "0102", "repair": "none"}}, (0x120, "0102", False)),
        ({"rewrite_id": {"to": 0x05D}}, (0x05D, "0011223344556677", False)),
        ({"wrong_length": {"length": 3}}, (0x120, "001122", False)),
        ({"to_remote": {}}, (0x120, "", True)),
        ({"drop": {}}, None),
    ],
)
def test_the_kernel_does_what_the_fault_says(
    disturbance: dict[str, Any], expected: tuple[int, str, bool] | None
) -> None:
    install(rules([fault(disturbance, id=0x120, direction="to_ecu")], "vcan0", "vcan1"))
    hit = [expected] if expected else []
    assert passed(TRAFFIC) == [*hit, OTHER, *hit]
    # the way back is untouched
    assert passed(TRAFFIC[:1], "vcan1", "vcan0") == [(0x120, "0011223344556677", False)]


def test_extended_identifiers_and_masks_select_what_they_say() -> None:
    install(rules([fault({"drop": {}}, id=0x12345, direction="to_ecu")], "vcan0", "vcan1"))
    sent = [frame(0x12345, extended=True), frame(0x12346, extended=True), frame(0x345)]
    assert [row[0] for row in passed(sent)] == [0x12346, 0x345]
    cangw("-F")
    install(rules([fault({"drop": {}}, id=[0x120, 0x121], direction="to_ecu")], "vcan0", "vcan1"))
    assert [row[0] for row in passed([frame(identifier) for identifier in range(0x11F, 0x123)])] == [0x11F, 0x122]


def test_modifications_act_in_the_fixed_order_and_or_xor_set() -> None:
    """Given in the opposite order, cangw and the kernel still do AND, OR, XOR, SET."""
    changes = ("SET:L:0.2.0000000000000000", "XOR:D:0.0.0300000000000000", "OR:D:0.0.0100000000000000")
    install([Rule("vcan0", "vcan1", "", (*changes, "AND:D:0.0.F0FFFFFFFFFFFFFF"))])
    # 0x5A & 0xF0 = 0x50; | 0x01 = 0x51; ^ 0x03 = 0x52
    with can.Bus("vcan1", interface="socketcan") as receiver, can.Bus("vcan0", interface="socketcan") as sender:
        sender.send(frame(0x120, "5aff11"))
        message = receiver.recv(10.0)
    assert message is not None
    assert bytes(message.data) == b"\x52\xff"


def test_the_default_hop_limit_breaks_a_chain_of_two_rules() -> None:
    """max_hops is 1: what one rule forwarded is not forwarded again, so both directions never make a loop."""
    made = subprocess.run(["ip", "link", "add", "vcan2", "type", "vcan"], capture_output=True, check=False)
    if made.returncode:
        pytest.skip("cannot make a third link here")
    try:
        subprocess.run(["ip", "link", "set", "vcan2", "up"], check=True)
        install([Rule("vcan0", "vcan1"), Rule("vcan1", "vcan2")])
        with (
            can.Bus("vcan1", interface="socketcan") as middle,
            can.Bus("vcan2", interface="socketcan") as end,
            can.Bus("vcan0", interface="socketcan") as sender,
        ):
            sender.send(frame(0x120))
            first = middle.recv(10.0)
            assert first is not None
            assert first.arbitration_id == 0x120
            assert end.recv(0.5) is None
            # what begins in the middle is one hop from the end
            middle.send(frame(0x130))
            last = end.recv(10.0)
            assert last is not None
            assert last.arbitration_id == 0x130
    finally:
        subprocess.run(["ip", "link", "del", "vcan2"], check=False)
