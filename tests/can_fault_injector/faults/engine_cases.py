"""Helpers of the engine's tests: a fault list in, frames through, what came out."""

from collections.abc import Sequence
from typing import Any

from can_fault_injector.faults.bit_stage import Delivered
from can_fault_injector.faults.engine import Injector
from can_fault_injector.faults.fault_file import FaultsFile
from can_fault_injector.frame import Frame

MS = 1_000_000


def injector(*faults: dict[str, Any], **options: Any) -> Injector:
    """An injector with some faults, given as in a file."""
    return Injector(FaultsFile.model_validate({"faults": list(faults)}).faults, **options)


def fault(disturbance: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A fault as in a file; what is not a field of a fault belongs to its trigger."""
    own = {key: more.pop(key) for key in ("name", "times", "duration", "repeat", "pause", "requires") if key in more}
    return {"disturbance": disturbance, "trigger": more, **own}


def through(
    engine: Injector, frames: Sequence[Frame], *, period_ms: float = 1.0, way: str = "to_ecu", after_ms: int = 20
) -> list[Delivered]:
    """Send a frame in each period; time goes on in steps of 1 ms. Returns what was delivered."""
    period_ns = round(period_ms * MS)
    delivered, waiting = [], list(frames)
    end = len(waiting) * period_ns + after_ms * MS
    sent = 0
    for now in range(0, end, MS):
        engine.begin_step(now)
        while waiting and sent * period_ns < now + MS:
            engine.put(way, waiting.pop(0), sent * period_ns)
            sent += 1
        delivered += engine.run(now + MS)
    return delivered


def frames_out(engine: Injector, frames: Sequence[Frame], **options: Any) -> list[Frame]:
    """Frames that the receiver behind the injector got."""
    return [item.frame for item in through(engine, frames, **options)]
