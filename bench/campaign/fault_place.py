"""Where in a frame a fault acts, and of which class it is: what coverage and heat maps are made of."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bench.campaign.campaign_file import FaultEntry

_BIT = re.compile(r"^(?P<field>[a-z_0-9]+?)\.(?P<bit>\d+)$")


@dataclass(frozen=True)
class Place:
    """Field and bit of a fault on the bus.

    Attributes
    ----------
    message : str
        Identifier in hexadecimal, several joined; empty for any frame.
    field : str
        Field of the frame, or ``signal NAME``; empty if it acts on whole frames.
    bit : int or None
        Bit of the field in the order of transmission.
    disturbance : str
        Kind of disturbance, "stimulus" or "set".
    e2e : str
        Class of E2E faults, empty if it is none.
    level : str
        Level at which it is realised, empty for what is no fault of the bus.
    """

    message: str = ""
    field: str = ""
    bit: int | None = None
    disturbance: str = ""
    e2e: str = ""
    level: str = ""


def place_of(entry: FaultEntry, values: Mapping[str, Any]) -> Place:
    """Place of an entry with its values put in."""
    if entry.kind != "fault":
        target = str(values.get("target", "")) or ", ".join(values)
        return Place(field=f"signal {target}", disturbance=entry.kind, e2e=entry.e2e)
    from can_fault_injector.faults.vocabulary import kind_named

    disturbance = values.get("disturbance")
    name = next(iter(disturbance), "") if isinstance(disturbance, dict) else ""
    try:
        kind = kind_named(name)
    except KeyError:
        return Place()  # the file's own check tells what is wrong
    settings = disturbance[name] if isinstance(disturbance, dict) and isinstance(disturbance[name], dict) else {}
    field, bit = _field_and_bit(name, settings)
    return Place(_message(values), field, bit, name, entry.e2e or kind.e2e, kind.realised_as)


def _message(values: Mapping[str, Any]) -> str:
    trigger = values.get("trigger")
    identifiers = trigger.get("id") if isinstance(trigger, dict) else None
    numbers = identifiers if isinstance(identifiers, list) else [identifiers]
    return "+".join(f"0x{number:X}" for number in numbers if isinstance(number, int))


def _field_and_bit(name: str, settings: Mapping[str, Any]) -> tuple[str, int | None]:
    if isinstance(settings.get("byte"), int):
        mask = settings.get("mask")
        first = 7 - mask.bit_length() + 1 if isinstance(mask, int) and mask else 0
        return "data", 8 * settings["byte"] + first
    if "signals" in settings:
        signals = settings["signals"]
        return "signal " + (signals if isinstance(signals, str) else ", ".join(map(str, signals))), None
    match = _BIT.match(str(settings.get("at", "")))
    if match is not None:
        return match["field"], int(match["bit"])
    if name == "crc_error":
        return "crc", int(settings.get("bit", 14))
    if name == "form_error":
        return str(settings.get("field", "ack_del")), int(settings.get("bit", 0))
    return str(settings.get("at", "")), None
