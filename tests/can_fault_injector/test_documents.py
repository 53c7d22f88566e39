"""The Python in the documents of the CAN model does what the comments beside it say."""

import re
from pathlib import Path
from typing import Any

from can_fault_injector import Frame

FOLDER = Path(__file__).parents[2] / "docs"


def blocks(name: str) -> list[dict[str, Any]]:
    """Names that each Python block of a document leaves behind."""
    text = (FOLDER / name).read_text(encoding="utf-8")
    left = []
    for block in re.findall(r"```python\n(.*?)```", text, re.S):
        names: dict[str, Any] = {}
        exec(compile(block, name, "exec"), names)
        left.append(names)
    return left


def test_can_bits() -> None:
    first, second = blocks("can_bits.md")
    assert first["bus"].nodes["ecu"].errors == ["crc"]
    assert {"crc.14", "ack_del.0"} & {event.place for event in first["bus"].events}
    assert first["bus"].nodes["logger"].received == [Frame(0x120, bytes(6))]
    assert second["bus"].nodes["early"].received == [second["early"]]
    assert second["bus"].nodes["early"].errors == []


def test_can_wire_faults() -> None:
    (only,) = blocks("can_wire_faults.md")
    assert only["bus"].nodes["bench"].state == "error_passive"
