"""What a run under faults has shown, made in the worker while its signals are still there."""

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

from signals.wheels import WHEELS

if TYPE_CHECKING:
    from bench.api import Run
    from bench.recording.arrays import RunArrays

MOTION = (
    "speed",
    "position_x",
    "position_y",
    "yaw_angle",
    *(f"true_wheel_speed_{wheel}" for wheel in WHEELS),
    *(f"true_brake_pressure_{wheel}" for wheel in WHEELS),
)
"""Signals of the car itself: a fault that leaves all of them as they are has had no effect."""
REFUSALS = ("crc_errors", "repeated", "wrong_sequence", "wrong_length")


def observe(run: "Run") -> dict[str, Any]:
    """Plain data for the row of a run.

    Returns
    -------
    dict
        ``motion``: hash of the car's motion; ``began_s``: first instant at which a fault was active, None if none was;
        ``fault_code_s``, ``fault_codes``: when the ECU first reported a fault, and all that it stored; ``frames``:
        counts of refused and lost frames at the ECU and at the bench; ``bus``: what the injector between them counted;
        ``phases``: start of each step of the manoeuvre, s; ``duration_s``: length of the run.
    """
    data, timing = run.data, run.data.timing
    ecu = timing.get("link", {}).get("ecu", {})
    injector = timing.get("injector", {})
    heard = [ecu.get("frames", {}), timing.get("frames_from_ecu", {})]
    return {
        "motion": motion_hash(data),
        "began_s": _began(data, injector),
        "fault_code_s": first_time(data, "ecu_fault_code"),
        "fault_codes": ecu.get("fault_codes", []),
        "frames": {name: _sum(heard, name) for name in (*REFUSALS, "lost", "accepted")},
        "bus": injector.get("counts", {}),
        "phases": {name: float(data.time[rows.start]) for name, rows in data.steps().items()},
        "duration_s": float(data.time[-1]) if len(data) else 0.0,
    }


def _began(data: "RunArrays", injector: dict[str, Any]) -> float | None:
    """First instant at which a fault did something: a fault of one frame may be over before the tick ends."""
    told = [fault["first_s"] for fault in injector.get("faults", []) if fault["first_s"] is not None]
    active = first_time(data, "faults_active")
    return min([*told, *([] if active is None else [active])], default=None)


def motion_hash(data: "RunArrays") -> str:
    """Equal for two runs exactly if the car moved the same, bit for bit."""
    whole = hashlib.blake2b(digest_size=12)
    for name in MOTION:
        if name in data:
            whole.update(data.array(name).tobytes())
    return whole.hexdigest()


def first_time(data: "RunArrays", signal: str) -> float | None:
    """First instant at which a signal is above zero, s; None if it never is."""
    if signal not in data:
        return None
    rows = np.flatnonzero(data.array(signal) > 0.5)
    return float(data.time[rows[0]]) if rows.size else None


def _sum(tables: list[dict[str, dict[str, int]]], name: str) -> int:
    return sum(counts.get(name, 0) for table in tables for counts in table.values())
