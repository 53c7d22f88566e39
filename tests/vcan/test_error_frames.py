"""candump of can-utils reads the error frames of the bit model as what they are; the text is that of 2020.11 and later.

The table says which condition gives which bytes; ``tests/can_fault_injector/test_error_frames.py`` produces each with
the model.
"""

import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import can
import pytest

from can_fault_injector.error_frames import ERROR_FLAG

TABLE = json.loads((Path(__file__).parents[1] / "can_fault_injector" / "error_frames.json").read_text(encoding="utf-8"))
MARK = 0x7FF


def published(text: str) -> can.Message:
    identifier, _, data = text.partition("#")
    return can.Message(
        arbitration_id=int(identifier, 16) & ~ERROR_FLAG,
        is_error_frame=True,
        is_extended_id=False,
        data=bytes.fromhex(data),
    )


@pytest.fixture(scope="module")
def decoded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Lines that ``candump -e`` prints for each row of the table."""
    log = tmp_path_factory.mktemp("candump") / "log"
    command = ["stdbuf", "-oL", "candump", "-e", "vcan0,0:0,#FFFFFFFF"]
    with log.open("w") as file, can.Bus("vcan0", interface="socketcan") as bus:
        witness = subprocess.Popen(command, stdout=file)
        mark = can.Message(arbitration_id=MARK, is_extended_id=False)

        def wait_for(count: int) -> None:
            for _ in range(600):
                bus.send(mark)
                time.sleep(0.05)
                if log.read_text().count("vcan0") > count:
                    return
            pytest.fail("candump did not see the frames")

        wait_for(0)
        for row in TABLE.values():
            bus.send(published(row["frame"]))
        wait_for(len(TABLE) + 1)
        witness.terminate()
        witness.wait()
    blocks = [block for block in log.read_text().split("  vcan0  ")[1:] if "ERRORFRAME" in block]
    assert len(blocks) == len(TABLE)
    return {
        name: [line.strip() for line in block.rstrip().splitlines()[1:]]
        for name, block in zip(TABLE, blocks, strict=True)
    }


@pytest.mark.parametrize("name", TABLE)
def test_candump_prints_what_happened(name: str, decoded: dict[str, list[str]]) -> None:
    assert decoded[name] == TABLE[name]["candump"]


def test_at_least_twenty_different_texts(decoded: dict[str, list[str]], witnessed: Callable[[str], None]) -> None:
    assert len({tuple(lines) for lines in decoded.values()}) >= 20
    witnessed(f"{len(TABLE)} error frames decoded by candump as expected")
