"""Disturbances of whole frames: dropped, late, twice, changed, made up."""

from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from can_fault_injector.faults.levels import DisturbanceModel, E2EClass, Group, Level
from can_fault_injector.faults.trigger import EXTENDED_MASK, STANDARD_MASK, Direction
from signals.errors import FieldError
from signals.quantities import parameter

Repair = Literal["none", "crc", "crc_and_counter"]
_REPAIR = (
    "none: the protection of the message tells of the change; crc: its checksum is made anew; crc_and_counter: the "
    "alive counter goes on from the last frame too"
)
Mode = Literal["protocol_correct", "raw"]
_MODE = (
    "protocol_correct: the frame is built anew, its CRC and stuff bits are right; raw: only these bits change on the "
    "wire, the receiver finds a stuff, CRC or form error"
)


def _hexadecimal(value: object) -> object:
    return value.replace(" ", "") if isinstance(value, str) else value


Payload = Annotated[str, BeforeValidator(_hexadecimal), Field(pattern=r"^([0-9A-Fa-f]{2}){0,64}$")]


class FrameDisturbance(DisturbanceModel):
    """Base of the disturbances of frames."""

    group: ClassVar[Group] = "frame"
    realised_as: ClassVar[Level] = "frame_gateway"


class Drop(FrameDisturbance):
    """The frame is not handed on; its sender sees it acknowledged."""

    e2e: ClassVar[E2EClass] = "loss"


class Duplicate(FrameDisturbance):
    """The frame is handed on again."""

    e2e: ClassVar[E2EClass] = "repetition"
    copies: int = Field(default=1, ge=1, le=1000, description="further copies")
    after: float = parameter("s", 0.0, low=0.0, high=60.0, description="time from one copy to the next")


class Delay(FrameDisturbance):
    """The frame is handed on later; frames of one identifier stay in order."""

    e2e: ClassVar[E2EClass] = "delay"
    by: float = parameter("s", low=0.0, high=60.0, description="how much later")
    jitter: float = parameter("s", 0.0, low=0.0, high=60.0, description="random part, drawn evenly from 0 to this")


class Reorder(FrameDisturbance):
    """Frames are collected and handed on in another order."""

    e2e: ClassVar[E2EClass] = "incorrect_sequence"
    window: int = Field(default=2, ge=2, le=100, description="number of frames that change places")
    order: Literal["reversed", "shuffled"] = Field(default="reversed", description="new order")


class Replay(FrameDisturbance):
    """An older frame of the same identifier is handed on in place of the present one, protection and all."""

    e2e: ClassVar[E2EClass] = "repetition"
    age: float = parameter("s", 0.1, low=0.001, high=60.0, description="how old the replayed frame is")
    repair: Repair = Field(default="none", description=_REPAIR)


class Corrupt(FrameDisturbance):
    """Bits of the payload are changed."""

    e2e: ClassVar[E2EClass] = "corruption"
    byte: int | None = Field(default=None, ge=0, le=63, description="byte, from 0; without it a random one")
    mask: int | None = Field(default=None, ge=1, le=0xFF, description="bits to invert; without it one random bit")
    data: Payload | None = Field(default=None, description="whole new payload, hexadecimal, in place of the above")
    repair: Repair = Field(default="none", description=_REPAIR)
    mode: Mode = Field(default="protocol_correct", description=_MODE)

    @model_validator(mode="after")
    def _one(self) -> "Corrupt":
        if self.data is not None and (self.byte is not None or self.mask is not None):
            raise FieldError("a new payload leaves nothing to invert", at=("data",), allowed="data, or byte and mask")
        return self


class WrongLength(FrameDisturbance):
    """The frame has another data length code; payload is cut or filled with zeros."""

    e2e: ClassVar[E2EClass] = "corruption"
    length: int = Field(ge=0, le=8, description="payload bytes")


class RewriteId(FrameDisturbance):
    """The frame gets another identifier (F4 of the friction document, 5.2.4: 0x71D to 0x05D)."""

    e2e: ClassVar[E2EClass] = "incorrect_addressing"
    to: int = Field(ge=0, le=EXTENDED_MASK, description="new identifier, of as many bits as the frame has")
    mode: Mode = Field(default="protocol_correct", description=_MODE)


class ToRemote(FrameDisturbance):
    """The data frame becomes a remote frame of the same length: its contents are lost."""

    e2e: ClassVar[E2EClass] = "loss"


class _MadeUp(FrameDisturbance):
    """A frame that the injector makes up."""

    id: int = Field(ge=0, le=EXTENDED_MASK, description="identifier of the frame that is sent")
    extended: bool = Field(default=False, description="identifier of 29 bits")
    data: Payload = Field(default="", description="payload, hexadecimal")
    repair: Repair = Field(
        default="none", description="crc_and_counter gives the frame the protection that its message has; see corrupt"
    )

    @model_validator(mode="after")
    def _identifier(self) -> "_MadeUp":
        limit = EXTENDED_MASK if self.extended else STANDARD_MASK
        if self.id > limit:
            raise FieldError("no identifier", at=("id",), found=f"{self.id:#x}", allowed=f"0…{limit:#x}")
        return self


class Masquerade(FrameDisturbance):
    """The frame is replaced by one that somebody else made up in its sender's name."""

    e2e: ClassVar[E2EClass] = "masquerade"
    data: Payload = Field(description="payload, hexadecimal")
    repair: Repair = Field(default="crc_and_counter", description=_REPAIR)


class Spoof(_MadeUp):
    """A made-up frame right after each matching frame, or in a cycle of its own."""

    e2e: ClassVar[E2EClass] = "insertion"
    cycle: float | None = parameter(
        "s", None, low=0.0001, high=60.0, description="time between frames; without it one after each matching frame"
    )
    direction: Direction = Field(default="to_ecu", description="who receives it")

    @property
    def lasts(self) -> bool:
        """In a cycle of its own it waits for no frame."""
        return self.cycle is not None


class SpoofErrorPassive(FrameDisturbance):
    """The sender is driven error passive; then the injector overwrites its frames, and its flags hurt nobody."""

    e2e: ClassVar[E2EClass] = "masquerade"
    realised_as: ClassVar[Level] = "bit_model"
    data: Payload = Field(description="payload that receivers get, hexadecimal")
    repair: Repair = Field(default="crc_and_counter", description=_REPAIR)


class BabblingIdiot(FrameDisturbance):
    """A node sends frames of the highest priority without a pause: nobody else gets the bus."""

    e2e: ClassVar[E2EClass] = "blocking"
    realised_as: ClassVar[Level] = "bit_model"
    continuous: ClassVar[bool] = True
    id: int = Field(default=0x000, ge=0, le=STANDARD_MASK, description="identifier of the frames")
    data: Payload = Field(default="0000000000000000", description="payload, hexadecimal")


class BusLoad(FrameDisturbance):
    """Further frames fill the bus up to a load; the others are late as arbitration has it."""

    e2e: ClassVar[E2EClass] = "delay"
    realised_as: ClassVar[Level] = "bit_model"
    continuous: ClassVar[bool] = True
    load: float = parameter("1", low=0.01, high=1.0, description="share of bus time with the injector's frames in it")
    id: int = Field(default=0x080, ge=0, le=STANDARD_MASK, description="identifier of the frames: their priority")


class Freeze(FrameDisturbance):
    """The contents stand still from the first matching frame on; the frames keep coming."""

    e2e: ClassVar[E2EClass] = "repetition"
    repair: Repair = Field(default="crc_and_counter", description=_REPAIR)
