"""The cars that the source documents define, behind the same interface as the MuJoCo car.

``SingleTrack`` is the longitudinal single-track car of the friction document's sections 2.4 and 2.5, ``Planar`` the
planar car of the vehicle-state document's section 2.
"""

from typing import Any

__all__ = ["Planar", "SingleTrack"]


def __getattr__(name: str) -> Any:
    if name == "SingleTrack":
        from vehicle_model.reference.single_track import SingleTrack

        return SingleTrack
    if name == "Planar":
        from vehicle_model.reference.planar import Planar

        return Planar
    raise AttributeError(f"module 'vehicle_model.reference' has no attribute {name!r}")
