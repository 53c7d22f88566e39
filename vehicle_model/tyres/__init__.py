"""Tyres: ``read_tir`` for tyres of the Magic Formula, friction curves, and the forces inside the compiled plant."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vehicle_model.tyres.magic_formula_tyre import read_tir
    from vehicle_model.tyres.tyre import Tyre, TyreForces

__all__ = ["Tyre", "TyreForces", "read_tir"]


def __getattr__(name: str) -> Any:
    if name == "read_tir":
        from vehicle_model.tyres.magic_formula_tyre import read_tir

        return read_tir
    if name in ("Tyre", "TyreForces"):
        from vehicle_model.tyres import tyre

        return getattr(tyre, name)
    raise AttributeError(f"module 'vehicle_model.tyres' has no attribute {name!r}")
