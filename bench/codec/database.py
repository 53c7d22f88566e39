"""What the bench needs to know of a CAN database, read with cantools and kept as plain records.

Importing cantools costs half a second (it brings python-can and, with it, a data-analysis stack), so the parsed records
are kept in the user's cache folder under the hash of the file: only the first process that meets a database pays.
"""

import hashlib
import json
import os
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from signals.compile_cache import cache_root
from signals.errors import InputError

_CACHE_FORMAT = 1


@dataclass(frozen=True)
class DbcSignal:
    """One signal of a message.

    Attributes
    ----------
    start, length, big_endian, signed
        Place of the bits; ``start`` counts as a DBC file does (Motorola: the most significant bit).
    scale, offset, unit
        physical = raw × scale + offset, in ``unit``.
    raw_low, raw_high
        Limits of the raw value, from the file's range where it gives one, else from the number of bits.
    raw_start
        Raw value before anybody has set the signal (GenSigStartValue).
    wraps
        True for a counter that starts again at zero instead of saturating (attribute Wraps).
    special
        "float" or "multiplexed" for what the compiled codec does not carry, else "".
    """

    name: str
    start: int
    length: int
    big_endian: bool
    signed: bool
    scale: float
    offset: float
    unit: str
    raw_low: int
    raw_high: int
    raw_start: int
    wraps: bool
    special: str


@dataclass(frozen=True)
class DbcMessage:
    """One message: identifier, payload length in bytes, cycle, sending nodes, and the 16 data ids of AUTOSAR E2E
    Profile 2 where it is protected."""

    name: str
    identifier: int
    extended: bool
    fd: bool
    bit_rate_switch: bool
    length: int
    cycle_ms: int
    offset_ms: int
    senders: tuple[str, ...]
    data_ids: tuple[int, ...]
    start_payload: bytes
    signals: tuple[DbcSignal, ...]

    def signal(self, name: str) -> DbcSignal | None:
        """Signal of that name, or None."""
        return next((signal for signal in self.signals if signal.name == name), None)


@dataclass(frozen=True)
class Database:
    """A CAN database: where it came from, its nodes, its messages by ascending identifier."""

    path: str
    bit_rate: int
    nodes: tuple[str, ...]
    messages: tuple[DbcMessage, ...]

    def message(self, name: str) -> DbcMessage | None:
        """Message of that name, or None."""
        return next((message for message in self.messages if message.name == name), None)


def shipped_database() -> Path:
    """Path of ``brake_bus.dbc``: in the installed package, else beside the sources."""
    installed = Path(str(resources.files("bench"))) / "data" / "dbc" / "brake_bus.dbc"
    return installed if installed.exists() else Path(__file__).resolve().parents[2] / "dbc" / "brake_bus.dbc"


def load_database(path: str | Path | None = None) -> Database:
    """Read a CAN database (DBC, KCD, SYM, ARXML: whatever cantools reads).

    Raises
    ------
    InputError
        If the file is missing or is no CAN database.
    """
    file = Path(path) if path is not None else shipped_database()
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: {error.strerror or error}", mend="give the path of a CAN database (.dbc)") from None
    cached = _cache_file(content, file.suffix)
    records = _read_cache(cached)
    if records is None:
        records = _parse(file)
        _write_cache(cached, records)
    return _from_records(str(file), records)


def _parse(file: Path) -> dict[str, Any]:
    from cantools import database

    try:
        parsed = database.load_file(str(file), strict=True)
    except Exception as error:  # cantools raises its own, textparser's and plain ValueErrors
        reason = " ".join(str(error).split())
        raise InputError(
            f"{file}: not a usable CAN database: {reason}", mend="see what cantools reads: dbc, kcd, sym"
        ) from None
    if not hasattr(parsed, "messages"):
        raise InputError(f"{file}: a diagnostics database, not a CAN database", mend="give a .dbc, .kcd or .sym file")
    attributes = getattr(parsed.dbc, "attributes", None) or {}
    bit_rate = int(attributes["Baudrate"].value) if "Baudrate" in attributes else 0
    bus_rates = [bus.baudrate for bus in parsed.buses if bus.baudrate]
    return {
        "bit_rate": bit_rate or (int(bus_rates[0]) if bus_rates else 500_000),
        "nodes": [node.name for node in parsed.nodes],
        "messages": [
            _message(m, file) for m in sorted(parsed.messages, key=lambda m: (m.is_extended_frame, m.frame_id))
        ],
    }


def _message(message: Any, file: Path) -> dict[str, Any]:
    attributes = dict(message.dbc.attributes) if message.dbc is not None else {}

    def attribute(name: str) -> Any:
        return attributes[name].value if name in attributes else None

    data_ids = _data_ids(str(attribute("E2EDataIdList") or ""), message.name, file)
    return {
        "name": message.name,
        "identifier": message.frame_id,
        "extended": bool(message.is_extended_frame),
        "fd": bool(message.is_fd),
        "bit_rate_switch": bool(message.is_fd and str(attribute("CANFD_BRS")) == "1"),
        "length": message.length,
        "cycle_ms": int(message.cycle_time or 0),
        "offset_ms": int(attribute("GenMsgStartDelayTime") or 0),
        "senders": list(message.senders),
        "data_ids": data_ids,
        "start_payload": _start_payload(message).hex(),
        "signals": [_signal(signal, message) for signal in message.signals],
    }


def _data_ids(text: str, message: str, file: Path) -> list[int]:
    try:
        ids = [int(word, 16) for word in text.split()]
    except ValueError:
        ids = [-1]
    if ids and (len(ids) != 16 or not all(0 <= value <= 255 for value in ids)):
        raise InputError(
            f"{file}: {message}: attribute E2EDataIdList",
            found=repr(text),
            allowed="16 hexadecimal bytes, one for each value of the counter",
            mend='for example BA_ "E2EDataIdList" BO_ 288 "9B 13 …" (Profile 2 of AUTOSAR E2E)',
        )
    return ids


def _start_payload(message: Any) -> bytes:
    """Payload of start values (zero where the file gives none); multiplexed parts stay zero."""
    data = bytearray(message.length)
    for signal in message.signals:
        if signal.is_float or signal.multiplexer_ids is not None:
            continue
        raw = int(signal.raw_initial or 0)
        for bit in bit_positions(signal.start, signal.length, signal.byte_order == "big_endian"):
            data[bit >> 3] |= (raw & 1) << (bit & 7)
            raw >>= 1
    return bytes(data)


def bit_positions(start: int, length: int, big_endian: bool) -> list[int]:
    """Bit positions (byte × 8 + bit) of a signal from its least significant bit on."""
    if not big_endian:
        return list(range(start, start + length))
    position, bits = start, []
    for _ in range(length):
        bits.append(position)
        position = position - 1 if position & 7 else position + 15
    return bits[::-1]


def _signal(signal: Any, message: Any) -> dict[str, Any]:
    scale, offset = float(signal.scale), float(signal.offset)
    lowest = -(1 << (signal.length - 1)) if signal.is_signed else 0
    highest = (1 << (signal.length - int(signal.is_signed))) - 1
    limits = []
    for limit, fallback in ((signal.minimum, lowest), (signal.maximum, highest)):
        raw = fallback if limit is None or signal.is_float else round((float(limit) - offset) / scale)
        limits.append(min(max(raw, lowest), highest))
    limits.sort()  # a negative scale turns them round
    attributes = dict(signal.dbc.attributes) if signal.dbc is not None else {}
    wraps = "Wraps" in attributes and attributes["Wraps"].value in (1, "1", "yes")
    multiplexed = signal.multiplexer_ids is not None or signal.is_multiplexer
    return {
        "name": signal.name,
        "start": signal.start,
        "length": signal.length,
        "big_endian": signal.byte_order == "big_endian",
        "signed": bool(signal.is_signed),
        "scale": scale,
        "offset": offset,
        "unit": signal.unit or "",
        "raw_low": limits[0],
        "raw_high": limits[1],
        "raw_start": 0 if signal.is_float else int(signal.raw_initial or 0),
        "wraps": wraps,
        "special": "float" if signal.is_float else ("multiplexed" if multiplexed else ""),
    }


def _from_records(path: str, records: dict[str, Any]) -> Database:
    messages = []
    for record in records["messages"]:
        fields = dict(record)
        fields["signals"] = tuple(DbcSignal(**signal) for signal in record["signals"])
        fields["senders"] = tuple(record["senders"])
        fields["data_ids"] = tuple(record["data_ids"])
        fields["start_payload"] = bytes.fromhex(record["start_payload"])
        messages.append(DbcMessage(**fields))
    return Database(path, records["bit_rate"], tuple(records["nodes"]), tuple(messages))


def _cache_file(content: bytes, suffix: str) -> Path:
    fields = ",".join([*DbcMessage.__dataclass_fields__, *DbcSignal.__dataclass_fields__])
    digest = hashlib.sha256(f"{_CACHE_FORMAT};{fields};{suffix};".encode() + content).hexdigest()[:24]
    return cache_root() / "databases" / f"{digest}.json"


def _read_cache(file: Path) -> dict[str, Any] | None:
    try:
        records = json.loads(file.read_text())
    except (OSError, ValueError):
        return None
    return records if isinstance(records, dict) else None


def _write_cache(file: Path, records: dict[str, Any]) -> None:
    """Best effort: a read-only home only costs the time to parse again."""
    scratch = file.with_suffix(f".{os.getpid()}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_text(json.dumps(records))
        scratch.replace(file)
    except OSError:
        return
