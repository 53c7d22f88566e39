"""Fault codes of the emulated ECU: one table of what is watched, what follows, and how a fault heals.

``ecu_fault_code`` on the diagnostics channel is the first fault that is active, 0 for none.
"""

from dataclasses import dataclass
from typing import Literal

from bench.ecu.records import FAULT_CODES, SOURCES
from signals.wheels import WHEELS

TIMEOUT = 1
"""First of the codes "message missing", one per source in the order of ``SOURCES``."""
PROTECTION = 11
"""First of the codes "message refused" (CRC, counter or length wrong), one per source."""
MISSING_WHEEL = 21
IMPLAUSIBLE_WHEEL = 25
IMPLAUSIBLE_BRAKE = 31
IMPLAUSIBLE_INERTIAL = 32

Reaction = Literal["abs off", "no accelerometer"]
Healing = Literal["healthy drive", "key-on and healthy drive"]


@dataclass(frozen=True)
class Fault:
    """One fault code.

    Attributes
    ----------
    code, name, meaning
        Number on the diagnostics channel, short name, what was seen.
    reaction
        "abs off": lamp on, valves at rest, brake-force distribution where its inputs are sound. "no accelerometer": the
        reference speed goes on without it, no lamp (unless the calibration requires the sensor).
    healing
        What has to happen after the cause is gone.
    """

    code: int
    name: str
    meaning: str
    reaction: Reaction
    healing: Healing


def _message_fault(first: int, source: int, kind: str, meaning: str) -> Fault:
    reaction: Reaction = "no accelerometer" if SOURCES[source] == "inertial" else "abs off"
    text = f"{SOURCES[source].replace('_', ' ')} frames {meaning}"
    return Fault(first + source, f"{SOURCES[source]}_{kind}", text, reaction, "healthy drive")


def _wheel_fault(first: int, wheel: int, kind: str, meaning: str) -> Fault:
    name, text = f"wheel_{WHEELS[wheel]}_{kind}", f"wheel {WHEELS[wheel]}: {meaning}"
    return Fault(first + wheel, name, text, "abs off", "key-on and healthy drive")


_ALL = (
    *(_message_fault(TIMEOUT, s, "missing", "missing for too many periods") for s in range(len(SOURCES))),
    *(_message_fault(PROTECTION, s, "refused", "refused: CRC, counter or length") for s in range(len(SOURCES))),
    *(_wheel_fault(MISSING_WHEEL, w, "missing", "no pulses although the car moves") for w in range(4)),
    *(_wheel_fault(IMPLAUSIBLE_WHEEL, w, "implausible", "pulses contradict its frame or jump") for w in range(4)),
    Fault(
        IMPLAUSIBLE_BRAKE,
        "brake_implausible",
        "brake pressure without brake switch",
        "abs off",
        "key-on and healthy drive",
    ),
    Fault(
        IMPLAUSIBLE_INERTIAL,
        "inertial_implausible",
        "accelerometer out of range or against the wheels",
        "no accelerometer",
        "healthy drive",
    ),
)

FAULTS: dict[int, Fault] = {fault.code: fault for fault in _ALL}
"""All fault codes."""

if len(FAULTS) != len(_ALL) or max(FAULTS) >= FAULT_CODES:
    raise AssertionError("fault codes are not unique or do not fit the fault memory")
