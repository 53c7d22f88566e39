"""Signals and protection of the bus's messages, as the injector asks for them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bench.codec.codec import Codec
from bench.codec.database import bit_positions
from bench.codec.kernels import extract_bits, insert_bits, profile2_crc, raw_value
from bench.codec.layout import Carried, Carrier
from bench.codec.mapping_file import BUS_NAMES
from bench.codec.tables import build_tables, by_identifier
from can_fault_injector.frame import Frame
from can_fault_injector.places import SignalBits, from_database_position

_COUNTER_BYTE, _COUNTER_BITS = 1, 0x0F


class BusContents:
    """Contents of frames by the CAN database of a run; see `can_fault_injector.faults.contents.Contents`.

    Parameters
    ----------
    codec : Codec
        Its layout says which message carries which signal, and how it is protected.
    """

    def __init__(self, codec: Codec) -> None:
        carriers = by_identifier(codec.layout.carriers)
        tables = build_tables(carriers, BUS_NAMES)
        self._carriers: dict[tuple[int, bool], Carrier] = {}
        self._rows = {}
        row = 0
        for carrier in carriers:
            key = (carrier.message.identifier, carrier.message.extended)
            self._carriers[key] = carrier
            for carried in carrier.carried:
                self._rows[key, carried.name] = tables.signals[row]
                row += 1

    def _carrier(self, frame: Frame) -> Carrier | None:
        """Message of a frame, None if it is unknown or too short for it."""
        carrier = self._carriers.get((frame.identifier, frame.extended))
        if carrier is None or frame.remote or len(frame.data) < carrier.message.length:
            return None
        return carrier

    @staticmethod
    def _value(carried: Carried, data: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> float:
        signal = carried.signal
        raw = extract_bits(data, signal.start, signal.length, int(signal.big_endian), int(signal.signed))
        return float((raw * signal.scale + signal.offset) * carried.scale + carried.offset)

    def decode(self, frame: Frame) -> Mapping[str, float]:
        """Signals in a frame by their catalogue names, SI; none of an unknown or short frame."""
        carrier = self._carrier(frame)
        if carrier is None:
            return {}
        data = np.frombuffer(frame.data, np.uint8)
        return {carried.name: self._value(carried, data) for carried in carrier.carried}

    def changed(self, frame: Frame, values: Mapping[str, float]) -> Frame:
        """The frame with other values of some of its signals, saturated as a sender would."""
        carrier = self._carrier(frame)
        if carrier is None:
            return frame
        data = np.frombuffer(frame.data, np.uint8).copy()
        for carried in carrier.carried:
            if carried.name not in values:
                continue
            signal = carried.signal
            for bit in bit_positions(signal.start, signal.length, signal.big_endian):
                data[bit >> 3] &= 255 - (1 << (bit & 7))
            row = self._rows[(frame.identifier, frame.extended), carried.name]
            raw = raw_value(float(values[carried.name]), row)
            insert_bits(data, signal.start, signal.length, int(signal.big_endian), raw)
        return replace(frame, data=data.tobytes())

    def counter(self, frame: Frame) -> int | None:
        """Alive counter of a protected message."""
        carrier = self._carrier(frame)
        return None if carrier is None or not carrier.data_ids else frame.data[_COUNTER_BYTE] & _COUNTER_BITS

    def protected(self, frame: Frame, counter: int | None = None) -> Frame:
        """The frame with its checksum made anew (E2E Profile 2), and with another alive counter if one is given."""
        carrier = self._carrier(frame)
        if carrier is None or not carrier.data_ids:
            return frame
        data = np.frombuffer(frame.data, np.uint8).copy()
        if counter is not None:
            data[_COUNTER_BYTE] = (int(data[_COUNTER_BYTE]) & ~_COUNTER_BITS) | (counter & _COUNTER_BITS)
        data_id = carrier.data_ids[int(data[_COUNTER_BYTE]) & _COUNTER_BITS]
        data[0] = profile2_crc(data, carrier.message.length, data_id)
        return replace(frame, data=data.tobytes())

    def signal_bits(self, frame: Frame) -> SignalBits | None:
        """Where the bits of the message's signals lie, by the catalogue's and by the database's names."""
        carrier = self._carriers.get((frame.identifier, frame.extended))
        if carrier is None:
            return None
        bits: dict[str, list[int]] = {}
        for carried in carrier.carried:
            signal = carried.signal
            positions = bit_positions(signal.start, signal.length, signal.big_endian)
            bits[carried.name] = bits[signal.name] = [from_database_position(position) for position in positions]
        return bits
