"""Where the signals of a database's message lie in the data field, as the fault injector counts its bits."""

from bench.codec.database import Database, DbcMessage, bit_positions
from can_fault_injector.places import from_database_position


def signal_bits(message: DbcMessage) -> dict[str, list[int]]:
    """Of each signal the numbers of its bits in the data field, least significant first."""
    return {
        signal.name: [
            from_database_position(position)
            for position in bit_positions(signal.start, signal.length, signal.big_endian)
        ]
        for signal in message.signals
    }


def message_of(database: Database, identifier: int, extended: bool) -> DbcMessage | None:
    """Message with an identifier, or None."""
    return next((m for m in database.messages if (m.identifier, m.extended) == (identifier, extended)), None)
