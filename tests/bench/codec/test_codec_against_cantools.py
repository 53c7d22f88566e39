"""The compiled codec equals cantools, bit for bit, on every message."""

from pathlib import Path
from typing import Any

import cantools
import numpy as np
import pytest

from bench.codec.database import load_database, shipped_database
from bench.codec.kernels import pack, unpack
from bench.codec.layout import Carrier
from bench.codec.mapping_file import BUS_NAMES, MappingFile
from bench.codec.resolve import load_layout, resolve
from bench.codec.tables import build_tables

SAMPLES = 10_000

FOREIGN_DBC = """VERSION ""
BU_: CAR ABS
BO_ 256 MOTOROLA: 8 CAR
 SG_ A : 7|12@0- (0.01,-5) [0|0] "m/s" ABS
 SG_ B : 11|20@0+ (0.5,0) [0|0] "" ABS
 SG_ C : 39|3@0+ (1,0) [0|0] "" ABS
 SG_ D : 34|19@0- (-2,7) [0|0] "" ABS
BO_ 257 INTEL: 8 CAR
 SG_ A : 0|1@1+ (1,0) [0|0] "" ABS
 SG_ B : 1|31@1- (0.001,100) [0|0] "" ABS
 SG_ C : 35|29@1+ (3,1) [0|0] "" ABS
BO_ 2566844416 EXTENDED_MIXED: 8 ABS
 SG_ A : 3|9@1- (0.25,0) [-20|20] "" CAR
 SG_ B : 23|16@0+ (0.1,0) [0|6553.5] "" CAR
 SG_ C : 39|16@0- (1e-05,0) [0|0] "" CAR
BO_ 258 LONG_FD: 32 CAR
 SG_ A : 128|40@1- (0.001,0) [0|0] "" ABS
 SG_ B : 199|52@0+ (1,0) [0|0] "" ABS
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","StandardCAN_FD","ExtendedCAN_FD";
BA_DEF_DEF_ "VFrameFormat" "StandardCAN";
BA_ "VFrameFormat" BO_ 258 14;
"""  # noqa: E501


def shipped_carriers() -> list[tuple[Any, Carrier]]:
    database = cantools.database.load_file(str(shipped_database()))
    return [(database.get_message_by_name(c.message.name), c) for c in load_layout().carriers]


def random_physical(message: Any, carrier: Carrier, rng: np.random.Generator) -> dict[str, float]:
    """Uniform over the range of each signal, not on the grid of its resolution."""
    values = {}
    for carried in carrier.carried:
        signal = carried.signal
        low, high = sorted(raw * signal.scale + signal.offset for raw in (signal.raw_low, signal.raw_high))
        values[signal.name] = float(rng.uniform(low, high))
    for signal in message.signals:
        values.setdefault(signal.name, 0)
    return values


def compare_encoding_and_decoding(message: Any, carrier: Carrier, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tables = build_tables([carrier])
    values, decoded = np.zeros(len(BUS_NAMES)), np.zeros(len(BUS_NAMES))
    positions = {c.signal.name: BUS_NAMES.index(c.name) for c in carrier.carried}
    payload = np.zeros(64, np.uint8)
    length = carrier.message.length
    for _ in range(SAMPLES):
        physical = random_physical(message, carrier, rng)
        for name, position in positions.items():
            values[position] = physical[name]
        pack(payload, tables.messages[0], tables.signals, tables.payloads[0], values)
        expected = message.encode(physical, strict=False)
        assert payload[:length].tobytes() == expected
        noise = rng.bytes(length)
        payload[:length] = np.frombuffer(noise, np.uint8)
        unpack(payload, tables.messages[0], tables.signals, decoded)
        reference = message.decode(noise, decode_choices=False)
        assert {name: decoded[position] for name, position in positions.items()} == {
            name: reference[name] for name in positions
        }


@pytest.mark.parametrize(("message", "carrier"), shipped_carriers(), ids=lambda item: getattr(item, "name", ""))
def test_every_message_of_the_brake_bus(message: Any, carrier: Carrier) -> None:
    compare_encoding_and_decoding(message, carrier, carrier.message.identifier)


@pytest.mark.parametrize("name", ["MOTOROLA", "INTEL", "EXTENDED_MIXED", "LONG_FD"])
def test_byte_orders_signs_and_long_frames_of_foreign_databases(name: str, tmp_path: Path) -> None:
    file = tmp_path / "foreign.dbc"
    file.write_text(FOREIGN_DBC)
    database = load_database(file)
    message = database.message(name)
    assert message is not None
    sources = {ours: f"{name}.{signal.name}" for ours, signal in zip(BUS_NAMES, message.signals, strict=False)}
    mapping = MappingFile.model_validate(
        {"ecu": ["ABS"], "signals": sources, "messages": {name: {"cycle": 0.01}}}  # the file gives no cycle times
    )
    (carrier,) = resolve(database, mapping).carriers
    compare_encoding_and_decoding(cantools.database.load_file(str(file)).get_message_by_name(name), carrier, 7)
