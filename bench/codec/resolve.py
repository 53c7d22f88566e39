"""A database and a mapping file made into a layout, or all their disagreements reported at once."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bench.codec.database import Database, DbcMessage, DbcSignal, load_database
from bench.codec.layout import NEEDED_BY_ECU, NEEDED_FROM_ECU, Carried, Carrier, Layout
from bench.codec.mapping_file import BUS_NAMES, MappingFile, SignalSource, read_mapping
from signals.catalogue import catalogue
from signals.errors import Fault, FieldError, FileFaults, nearest_name
from signals.quantities import QuantityError, to_si

if TYPE_CHECKING:
    from signals.yaml_files import Document

EXACT_BITS = 52
"""Longest signal whose raw values a float64 carries exactly."""

_UNITS = {signal.name: signal.unit for signal in catalogue()}


def load_layout(dbc: str | Path | None = None, mapping: str | Path | None = None) -> Layout:
    """Read a database and a mapping and check that they make a closed loop.

    Parameters
    ----------
    dbc : path, optional
        CAN database; by default the mapping's, else the shipped ``brake_bus.dbc``.
    mapping : path, optional
        Mapping file; by default signals have our names and the node ``ECU`` is the ECU's.

    Raises
    ------
    InputError
        If a file is bad or a needed message or signal is absent.
    """
    document: Document | None = None
    settings = MappingFile()
    if mapping is not None:
        document, settings = read_mapping(mapping)
        if dbc is None and settings.dbc is not None:
            dbc = document.folder / settings.dbc
    layout = resolve(load_database(dbc), settings, document)
    layout.require("ecu", NEEDED_FROM_ECU, "to set the hydraulics")
    layout.require("bench", NEEDED_BY_ECU, "by any ABS ECU")
    return layout


def resolve(database: Database, mapping: MappingFile, document: "Document | None" = None) -> Layout:
    """Resolve every name of a mapping.

    Raises
    ------
    FileFaults
        With every name that the database lacks or cannot carry, at its line of ``document``.
    """
    resolver = _Resolver(database, mapping)
    layout = resolver.layout()
    if resolver.errors:
        raise FileFaults([_place(error, database, document) for error in resolver.errors], _shown(database, document))
    return layout


def _shown(database: Database, document: "Document | None") -> str:
    return database.path if document is None else document.file


def _place(error: FieldError, database: Database, document: "Document | None") -> Fault:
    if document is None:
        field = ".".join(str(part) for part in error.at)
        return Fault(database.path, 0, 0, field, error.problem, error.found, error.allowed, error.nearest)
    return document.fault(error.at, error.problem, found=error.found, allowed=error.allowed, nearest=error.nearest)


def _few(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 12 else ""


class _Resolver:
    """Looks up names; what it does not find goes into ``errors``."""

    def __init__(self, database: Database, mapping: MappingFile) -> None:
        self.database = database
        self.mapping = mapping
        self.errors: list[FieldError] = []

    def layout(self) -> Layout:
        database, mapping = self.database, self.mapping
        self._check_names("ecu", mapping.ecu, database.nodes, "node")
        known = [message.name for message in database.messages]
        self._check_names("also_send", mapping.also_send, known, "message")
        self._check_names("messages", list(mapping.messages), known, "message")
        carried: dict[str, list[Carried]] = {}
        for name, source in self._sources().items():
            found = self._find(name, source)
            if found is not None:
                carried.setdefault(found[0].name, []).append(self._carried(name, source, found[1]))
        carriers = [
            self._carrier(message, tuple(carried.get(message.name, ())))
            for message in database.messages
            if message.name in carried or message.name in mapping.also_send
        ]
        return Layout(database.path, database.bit_rate, tuple(carriers))

    def _check_names(self, field: str, names: Sequence[str], known: Sequence[str], what: str) -> None:
        for number, name in enumerate(names):
            if name not in known:
                at = (field, name) if field == "messages" else (field, number)
                self._unknown(at, what, name, known)

    def _unknown(self, at: tuple[str | int, ...], what: str, name: str, known: Sequence[str]) -> None:
        problem = f"the database {self.database.path} has no {what} {name}"
        self.errors.append(FieldError(problem, at=at, allowed=_few(known), nearest=nearest_name(name, known)))

    def _sources(self) -> dict[str, SignalSource]:
        """Sources of the mapping; without any, every signal that bears one of our names."""
        if self.mapping.signals:
            return dict(self.mapping.signals)
        return {
            signal.name: SignalSource(signal=f"{message.name}.{signal.name}")
            for message in self.database.messages
            for signal in message.signals
            if signal.name in BUS_NAMES
        }

    def _find(self, name: str, source: SignalSource) -> tuple[DbcMessage, DbcSignal] | None:
        at = ("signals", name)
        message_name, signal_name = source.signal.split(".")
        message = self.database.message(message_name)
        if message is None:
            self._unknown(at, "message", message_name, [message.name for message in self.database.messages])
            return None
        signal = message.signal(signal_name)
        if signal is None:
            known = [other.name for other in message.signals]
            self._unknown(at, f"signal of {message_name} called", signal_name, known)
            return None
        if signal.special or signal.length > EXACT_BITS:
            problem = f"{source.signal} is {signal.special or f'{signal.length} bits long'}"
            allowed = f"integer signals of at most {EXACT_BITS} bits outside multiplexed groups"
            self.errors.append(FieldError(problem, at=at, allowed=allowed))
            return None
        return message, signal

    def _carried(self, name: str, source: SignalSource, signal: DbcSignal) -> Carried:
        factor = 1.0
        if source.unit is not None:
            try:
                factor = to_si(f"1 {source.unit}", _UNITS[name])
            except QuantityError as error:
                allowed = f"a unit of the dimension {_UNITS[name]}"
                self.errors.append(
                    FieldError(error.problem, at=("signals", name, "unit"), found=source.unit, allowed=allowed)
                )
        return Carried(name, signal, source.scale * factor, source.offset)

    def _carrier(self, message: DbcMessage, carried: tuple[Carried, ...]) -> Carrier:
        settings = self.mapping.messages.get(message.name)
        cycle_ms, offset_ms, data_ids = message.cycle_ms, message.offset_ms, message.data_ids
        if settings is not None:
            cycle_ms = cycle_ms if settings.cycle is None else round(settings.cycle * 1e3)
            offset_ms = offset_ms if settings.offset is None else round(settings.offset * 1e3)
            data_ids = data_ids if settings.data_ids is None else tuple(settings.data_ids)
        from_ecu = any(sender in self.mapping.ecu for sender in message.senders)
        at = ("messages", message.name)
        if cycle_ms < 1 and not from_ecu:
            problem = "is to be sent, but the database gives no cycle time"
            allowed = f"messages: {{{message.name}: {{cycle: 10 ms}}}} in the mapping file"
            self.errors.append(FieldError(problem, at=at, allowed=allowed))
        if data_ids and message.length < 2:
            problem = "too short for AUTOSAR E2E Profile 2"
            self.errors.append(FieldError(problem, at=at, found=f"{message.length} bytes", allowed="at least 2 bytes"))
        return Carrier(message, from_ecu, cycle_ms, offset_ms, data_ids, carried)
