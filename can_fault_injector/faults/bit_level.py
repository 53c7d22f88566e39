"""Disturbances of single bits, of the frame's rules, and of flags: only a model of bits, or a device, can do them."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from can_fault_injector.faults.levels import DisturbanceModel, E2EClass, Group, Level, NodeName
from can_fault_injector.node_state import PLACES
from signals.quantities import parameter

_PLACE = re.compile(r"(?P<field>[a-z_0-9]+?)(\.\d+)?|data\.signal\([^()]+\)\.bit[ .]\d+")
_EXAMPLES = "crc.14, ack_slot, stuff.2, eof.6, data.signal(wheel_speed_fl).bit 5"


def _check_place(value: str) -> str:
    match = _PLACE.fullmatch(value)
    if match is None or (match["field"] is not None and match["field"] not in PLACES):
        raise ValueError(f"no place of a bit: found {value!r}, allowed: FIELD.NUMBER, for example {_EXAMPLES}")
    return value


Place = Annotated[str, AfterValidator(_check_place)]
Tap = Literal["receive", "transmit", "bus"]
_TAP = (
    "receive: what a node sees (default: the controller behind the injector); transmit: what it sends; bus: everybody"
)
_NODE = "node of the tap; without it the receiver behind the injector, or the sender"
_SLOWEST, _FASTEST = 10e3, 1e6


class BitDisturbance(DisturbanceModel):
    """Base of the disturbances of bits."""

    group: ClassVar[Group] = "bit"
    e2e: ClassVar[E2EClass] = "corruption"
    realised_as: ClassVar[Level] = "bit_model"


class _AtPlace(BitDisturbance):
    at: Place = Field(description=f"first bit: {_EXAMPLES}")
    length: int = Field(default=1, ge=1, le=10_000, description="number of bits")
    tap: Tap = Field(default="receive", description=_TAP)
    node: NodeName | None = Field(default=None, description=_NODE)
    every_attempt: bool = Field(default=False, description="the repetitions of the frame are disturbed too")


class Flip(_AtPlace):
    """Bits inverted."""


class Force(_AtPlace):
    """Bits forced dominant or recessive; recessive over dominant needs a cut line, which the injector is in series."""

    level: Literal["dominant", "recessive"] = Field(description="level that is forced")


class Glitch(_AtPlace):
    """Pulse shorter than a bit: it counts only where the sample point of the node lies in it."""

    level: Literal["dominant", "recessive"] = Field(description="level of the pulse")
    start: float = parameter("1", 0.5, low=0.0, high=1.0, description="begin within the bit, 0 to 1")
    width: float = parameter("1", 0.3, low=0.0, high=1.0, description="length in bits")


class StuffError(BitDisturbance):
    """The receiver behind the injector sees six equal bits: a stuff bit is inverted."""

    number: int = Field(default=0, ge=0, le=200, description="which stuff bit of the frame, counted from 0")
    node: NodeName | None = Field(default=None, description=_NODE)


class CrcError(BitDisturbance):
    """A bit of the CRC is inverted at the receiver behind the injector."""

    bit: int = Field(default=14, ge=0, le=20, description="bit of the CRC in the order of transmission")
    node: NodeName | None = Field(default=None, description=_NODE)


class FormError(BitDisturbance):
    """A bit that has to be recessive is seen dominant."""

    field: Literal["crc_del", "ack_del", "eof"] = Field(default="ack_del", description="field of the bit")
    bit: int = Field(default=0, ge=0, le=6, description="bit of the field")
    tap: Tap = Field(default="bus", description=_TAP)
    node: NodeName | None = Field(default=None, description=_NODE)


class AckError(BitDisturbance):
    """The sender does not see the acknowledgement: its error flag makes everybody drop the frame, which it repeats."""

    e2e: ClassVar[E2EClass] = "delay"


class BitError(BitDisturbance):
    """The sender reads back another level than it sent."""

    at: Place = Field(default="data.0", description=f"the bit: {_EXAMPLES}")


class ErrorFlag(BitDisturbance):
    """Six dominant bits of another node's error flag."""

    e2e: ClassVar[E2EClass] = "delay"
    at: Place = Field(default="data.0", description="first bit of the flag")


class Overload(BitDisturbance):
    """Overload frames after the frame: the next one has to wait."""

    e2e: ClassVar[E2EClass] = "delay"
    frames: int = Field(default=1, ge=1, le=1000, description="overload frames in a row")


class EndlessOverload(BitDisturbance):
    """Overload frames without end, as long as the fault lasts: the bus is frozen, no error counter moves."""

    e2e: ClassVar[E2EClass] = "blocking"
    continuous: ClassVar[bool] = True


class DoubleReceive(BitDisturbance):
    """Dominant at the last bit of EOF for the sender: receivers have the frame, the sender repeats it."""

    e2e: ClassVar[E2EClass] = "repetition"


class InconsistentOmission(BitDisturbance):
    """Error at the last but one bit of EOF of one receiver while the sender gives the frame up: the others have it."""

    e2e: ClassVar[E2EClass] = "received_by_a_subset"
    node: NodeName | None = Field(default=None, description="receiver that misses the frame; by default the far side")


class Janus(BitDisturbance):
    """One frame, two contents: receivers that sample early read another payload than those that sample late."""

    e2e: ClassVar[E2EClass] = "asymmetric_information"
    data: str = Field(
        pattern=r"^([0-9A-Fa-f]{2}){0,8}$",
        description="payload that the controller behind the injector reads, hexadecimal; its length and number of "
        "stuffed bits are those of the original",
    )


class InLineDevice(BitDisturbance):
    """The device in series, changing nothing (F1 of the friction document): each edge leaves it later (Table 7)."""

    e2e: ClassVar[E2EClass] = "delay"
    figures: ClassVar[Mapping[str, tuple[str, str]]] = MappingProxyType(
        {
            "delay": ("s", "delay of the edge at the start of the frame"),
            "delay_share": ("1", "that delay in bit times"),
            "window_overlap": ("1", "1 if the sampling windows of both sides, 50 % to 80 % of the bit, overlap"),
            "passed_late": ("1", "1 if the acknowledgement is back in time for a sample at 80 % of the bit"),
            "passed_early": ("1", "1 if it is back in time for a sample at 50 % of the bit"),
            "frame_time": ("s", "duration of the frame: what a gateway of whole frames delays by at least"),
        }
    )
    bit_rate: float = parameter(
        "Hz", low=_SLOWEST, high=_FASTEST, description="bits per second of the line that is looked at (Table 7)"
    )


class BusOffAttack(BitDisturbance):
    """Every attempt to send the frame is destroyed until its sender is bus-off."""

    e2e: ClassVar[E2EClass] = "loss"
    at: Place = Field(default="data.0", description="bit that the sender reads back wrong")
