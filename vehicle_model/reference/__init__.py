"""The cars that the source documents define, behind the same interface as the MuJoCo car.

``SingleTrack`` is the longitudinal single-track car of the friction document's sections 2.4 and 2.5.
"""

from typing import Any

__all__ = ["SingleTrack"]


def __getattr__(name: str) -> Any:
    if name == "SingleTrack":
        from vehicle_model.reference.single_track import SingleTrack

        return SingleTrack
    raise AttributeError(f"module 'vehicle_model.reference' has no attribute {name!r}")
