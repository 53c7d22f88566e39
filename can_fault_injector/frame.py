"""A CAN frame and its bits on the wire."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from can_fault_injector import decoding
from can_fault_injector import fields as f
from can_fault_injector.bits import encode


class ProtocolError(ValueError):
    """What a receiver finds wrong with a bit sequence.

    Attributes
    ----------
    kind : str
        "stuff", "crc", "form" or "truncated".
    position : int
        Bit at which it shows, SOF is 0.
    """

    def __init__(self, kind: str, position: int) -> None:
        super().__init__(f"{kind} error at bit {position}")
        self.kind = kind
        self.position = position


class Field(NamedTuple):
    """A field of the bit sequence: bits ``start`` to ``stop`` - 1, stuff bits inside it included."""

    name: str
    start: int
    stop: int


@dataclass(frozen=True)
class Frame:
    """A classic CAN or CAN FD frame.

    Parameters
    ----------
    identifier : int
        11 bits, or 29 bits of an extended frame.
    data : bytes
        Payload; CAN FD allows the lengths 0–8, 12, 16, 20, 24, 32, 48 and 64.
    extended, remote, fd : bool
        Kind of frame; CAN FD has no remote frames.
    bit_rate_switch, error_state_indicator : bool
        Bits BRS and ESI of CAN FD.
    dlc : int, optional
        Data length code where the payload does not give it: of a remote frame, or 9 to 15 with 8 bytes of classic CAN.
    iso : bool
        CAN FD of ISO 11898-1:2015; False for the older variant without stuff bit count.

    Raises
    ------
    ValueError
        If a value does not fit the kind of frame.
    """

    identifier: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False
    fd: bool = False
    bit_rate_switch: bool = False
    error_state_indicator: bool = False
    dlc: int | None = None
    iso: bool = True

    def __post_init__(self) -> None:
        limit = 0x1FFFFFFF if self.extended else 0x7FF
        if not 0 <= self.identifier <= limit:
            raise ValueError(f"identifier: found {self.identifier:#x}, allowed: 0 to {limit:#x}")
        if self.remote and (self.fd or self.data):
            raise ValueError("remote frame: found CAN FD or data, allowed: classic CAN without data")
        if not self.fd and (self.bit_rate_switch or self.error_state_indicator):
            raise ValueError("bit_rate_switch and error_state_indicator: allowed only in CAN FD")
        allowed = f.FD_LENGTHS if self.fd else range(9)
        if len(self.data) not in allowed:
            raise ValueError(f"data: found {len(self.data)} bytes, allowed: {', '.join(map(str, allowed))}")
        if self.dlc is not None:
            self._check_dlc(self.dlc)

    def _check_dlc(self, dlc: int) -> None:
        if not 0 <= dlc <= 15:
            raise ValueError(f"dlc: found {dlc}, allowed: 0 to 15")
        fits = self.remote or f.FD_LENGTHS[dlc] == len(self.data) or (not self.fd and dlc > 8 and len(self.data) == 8)
        if not fits:
            raise ValueError(f"dlc: found {dlc} with {len(self.data)} data bytes; they do not belong together")

    @property
    def length_code(self) -> int:
        """Data length code on the wire."""
        return f.FD_LENGTHS.index(len(self.data)) if self.dlc is None else self.dlc

    def encoded(self, stuffed: bool = True) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.int16]]:
        """Levels of :meth:`bits`, and of each bit the field code (``fields``) and the number inside the field."""
        payload = np.zeros(64, np.uint8)
        payload[: len(self.data)] = np.frombuffer(self.data, np.uint8)
        bits, codes = np.empty(f.MAX_BITS, np.uint8), np.empty(f.MAX_BITS, np.uint8)
        numbers = np.empty(f.MAX_BITS, np.int16)
        count = encode(
            self.identifier,
            self.extended,
            self.remote,
            self.fd,
            self.bit_rate_switch,
            self.error_state_indicator,
            self.length_code,
            payload,
            len(self.data),
            self.iso,
            stuffed,
            bits,
            codes,
            numbers,
        )
        return bits[:count], codes[:count], numbers[:count]

    def bits(self, stuffed: bool = True) -> NDArray[np.uint8]:
        """Levels from SOF to the last EOF bit, 1 = recessive, the acknowledge slot as the sender drives it (1)."""
        return self.encoded(stuffed)[0]

    def fields(self, stuffed: bool = True) -> list[Field]:
        """Fields of :meth:`bits` in order; a stuff bit belongs to the field of the bit before it."""
        _, codes, _ = self.encoded(stuffed)
        result: list[Field] = []
        for position, code in enumerate(codes):
            name = f.FIELD_NAMES[code]
            if result and (code == f.STUFF or result[-1].name == name or self._inside_crc(code, codes, position)):
                result[-1] = result[-1]._replace(stop=position + 1)
            else:
                result.append(Field(name, position, position + 1))
        return result

    @staticmethod
    def _inside_crc(code: int, codes: NDArray[np.uint8], position: int) -> bool:
        """A fixed stuff bit inside the stuff count or the CRC, not the one between two fields."""
        following = codes[position + 1] if position + 1 < codes.size else code
        return bool(code == f.FIXED_STUFF and position > 0 and codes[position - 1] == following)

    def bit_names(self) -> Iterator[str]:
        """Name of every bit of ``bits()``: ``sof.0``, ``id.3``, ``stuff.1``, ``crc.14``, ``eof.6``."""
        _, codes, numbers = self.encoded(True)
        for code, number in zip(codes, numbers, strict=True):
            yield f"{f.FIELD_NAMES[code]}.{number}"

    @classmethod
    def from_bits(cls, bits: NDArray[np.uint8], iso: bool = True) -> "Frame":
        """Frame that a receiver reads from a stuffed bit sequence beginning with SOF.

        Raises
        ------
        ProtocolError
            With kind and position of the first error.
        """
        payload = np.zeros(64, np.uint8)
        result = np.zeros(decoding.RESULT_SIZE, np.int64)
        error = decoding.decode(np.ascontiguousarray(bits, np.uint8), iso, payload, result)
        if error:
            raise ProtocolError(f.ERROR_NAMES[error], int(result[decoding.RESULT_POSITION]))
        fd = bool(result[decoding.RESULT_FD])
        data = payload[: result[decoding.RESULT_LENGTH]].tobytes()
        dlc = int(result[decoding.RESULT_DLC])
        remote = bool(result[decoding.RESULT_REMOTE])
        return cls(
            identifier=int(result[decoding.RESULT_IDENTIFIER]),
            data=data,
            extended=bool(result[decoding.RESULT_EXTENDED]),
            remote=remote,
            fd=fd,
            bit_rate_switch=bool(result[decoding.RESULT_BRS]),
            error_state_indicator=bool(result[decoding.RESULT_ESI]),
            dlc=dlc if remote or (not fd and dlc > 8) else None,
            iso=iso,
        )
