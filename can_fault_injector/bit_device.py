"""A bit-banging injector on the real bus: disturbances spoken to it over a serial line, in an open protocol of text.

``docs/can_bit_device.md`` describes the protocol for whoever builds a device. The host's side is `BitDevice`; lines are
made and read by the functions before it, which a device's software may use too.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple, cast

from can_fault_injector.disturbance import Disturbance
from signals.errors import InputError, LinkError

PROTOCOL = 1
GREETING = ("bit-injector", str(PROTOCOL), "slots")
ANSWER_TIME_S = 1.0
_THOUSANDTHS = 1000
_NONE = "-"
_SET_WORDS = 13


class ProtocolFault(ValueError):
    """A line that is not of the protocol; ``code`` is what a device answers with ERR."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class Hit(NamedTuple):
    """A disturbance began on the device: its slot, how often so far, the device's clock in microseconds."""

    slot: int
    number: int
    time_us: int


def line(words: Sequence[str]) -> bytes:
    """Line with its checksum: the exclusive or of all bytes before the asterisk, two hexadecimal digits."""
    text = " ".join(words).encode("ascii")
    return text + b"*%02X\n" % reduce(int.__xor__, text, 0)


def words_of(received: bytes) -> list[str]:
    """Words of a line.

    Raises
    ------
    ProtocolFault
        If it is no text or its checksum is wrong.
    """
    text, asterisk, checksum = received.rstrip(b"\r\n").rpartition(b"*")
    try:
        right = bool(asterisk) and int(checksum, 16) == reduce(int.__xor__, text, 0)
        words = text.decode("ascii").split()
    except ValueError:
        right, words = False, []
    if not right or not words:
        raise ProtocolFault("checksum", f"no line of the protocol: {received!r}")
    return words


def set_words(slot: int, disturbance: Disturbance) -> list[str]:
    """Words that put a disturbance into a slot of the device.

    Raises
    ------
    InputError
        If it begins at a bit of the bus or a time, which a device does not count.
    """
    if disturbance.trigger_bit is not None or disturbance.from_time_s:
        raise InputError("bit device", found=f"at {disturbance.at}", allowed="a place in a frame, for example crc.14")
    place, _, number = str(disturbance.at).partition(".")
    identifier = _NONE if disturbance.identifier is None else f"{disturbance.identifier:X}"
    return [
        "SET",
        str(slot),
        disturbance.action,
        disturbance.tap,
        disturbance.node or _NONE,
        disturbance.reference or _NONE,
        f"{place}.{number or 0}",
        str(disturbance.length),
        str(round(disturbance.begin * _THOUSANDTHS)),
        str(round(disturbance.width * _THOUSANDTHS)),
        f"{identifier}/{disturbance.mask:X}",
        str(disturbance.skip),
        str(disturbance.repeat),
    ]


def disturbance_of(words: Sequence[str]) -> tuple[int, Disturbance]:
    """Slot and disturbance of the words of a SET line.

    Raises
    ------
    ProtocolFault
        If they are not what `set_words` makes.
    """
    if len(words) != _SET_WORDS or words[0] != "SET":
        raise ProtocolFault("words", f"SET has {_SET_WORDS} words, found {len(words)}")
    _, slot, action, tap, node, reference, place, length, begin, width, selection, skip, repeat = words
    identifier, _, mask = selection.partition("/")
    try:
        return int(slot), Disturbance(
            cast(Any, action),
            place,
            cast(Any, tap),
            None if node == _NONE else node,
            None if reference == _NONE else reference,
            None if identifier == _NONE else int(identifier, 16),
            int(mask, 16),
            int(skip),
            int(repeat),
            int(length),
            begin=int(begin) / _THOUSANDTHS,
            width=int(width) / _THOUSANDTHS,
        )
    except ValueError as error:
        raise ProtocolFault("value", str(error)) from None


@dataclass(frozen=True)
class Greeting:
    """What a device says of itself."""

    slots: int


class BitDevice:
    """Host's side of a bit-banging injector.

    Parameters
    ----------
    port : str
        Serial port, /dev/ttyACM0.
    baud_rate : int
        Without meaning for USB ports.

    Raises
    ------
    LinkError
        If the port cannot be opened or no device of this protocol answers.
    """

    def __init__(self, port: str, baud_rate: int = 115_200) -> None:
        import serial

        self.port = port
        try:
            self._serial = serial.Serial(port, baud_rate, timeout=ANSWER_TIME_S, write_timeout=ANSWER_TIME_S)
        except (serial.SerialException, OSError, ValueError) as error:
            raise LinkError(f"{port}: {error}", mend="check the name of the port and your rights on it") from None
        self.hits: list[Hit] = []
        answer = self.command("HELLO")
        if len(answer) != 4 or tuple(answer[:3]) != GREETING or not answer[3].isdecimal():
            self.close()
            raise LinkError(f"{port}: not a bit injector", found=" ".join(answer), allowed=" ".join(GREETING) + " N")
        self.greeting = Greeting(int(answer[3]))

    def __enter__(self) -> "BitDevice":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the port; what is armed stays armed."""
        self._serial.close()

    def command(self, *words: str) -> list[str]:
        """Send a line and wait for its answer; returns the words after OK.

        Raises
        ------
        LinkError
            If the device refuses, answers nonsense, or not at all.
        """
        self._serial.write(line(words))
        end = time.monotonic() + ANSWER_TIME_S
        while time.monotonic() < end:
            answer = self._read()
            if not answer:
                continue
            if answer[0] == "OK":
                return answer[1:]
            raise LinkError(f"{self.port}: the device refused {words[0]}", found=" ".join(answer[1:]))
        raise LinkError(f"{self.port}: no answer to {words[0]} within {ANSWER_TIME_S:g} s")

    def _read(self) -> list[str]:
        """Words of the next answer; hits in between are kept, nothing came: empty."""
        received = self._serial.readline()
        if not received.endswith(b"\n"):
            return []
        try:
            words = words_of(received)
        except ProtocolFault as fault:
            raise LinkError(f"{self.port}: {fault}") from None
        if words[0] != "HIT":
            return words
        if len(words) != 4 or not all(word.isdecimal() for word in words[1:]):
            raise LinkError(f"{self.port}: not a hit", found=" ".join(words))
        self.hits.append(Hit(*(int(word) for word in words[1:])))
        return []

    def load(self, disturbances: Sequence[Disturbance], bit_rate: float, data_bit_rate: float | None = None) -> None:
        """Replace what the device has by a list of disturbances; they act once it is armed.

        Raises
        ------
        InputError
            If there are more than the device has slots, or one is not for a device.
        LinkError
            As `command`.
        """
        if len(disturbances) > self.greeting.slots:
            raise InputError(
                f"{self.port}: too many disturbances", found=str(len(disturbances)), allowed=f"{self.greeting.slots}"
            )
        lines = [set_words(slot, disturbance) for slot, disturbance in enumerate(disturbances)]
        self.command("DISARM")
        self.command("CLEAR")
        self.command("RATE", f"{bit_rate:.0f}", f"{data_bit_rate or bit_rate:.0f}")
        for words in lines:
            self.command(*words)

    def arm(self) -> None:
        """Let the disturbances act from now on."""
        self.command("ARM")

    def disarm(self) -> None:
        """End all disturbances; the device is a plain wire."""
        self.command("DISARM")

    def counts(self) -> list[int]:
        """How often each disturbance began."""
        return [int(word) for word in self.command("HITS")]

    def wait(self, seconds: float) -> list[Hit]:
        """Hits that the device reported so far, after listening for some time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self._serial.in_waiting:
                self._read()
            else:
                time.sleep(0.01)
        return self.hits
