"""Tyre files: the curves of the front and the rear tyres, and the contact state at low speed."""

from typing import Literal

from pydantic import Field

from signals.quantities import FileModel, parameter

_ASSUMED = "assumed: usual for a passenger car tyre"


class MagicFormulaCurve(FileModel):
    """Friction over slip: D sin(C arctan(B s - E (B s - arctan(B s)))) (eq. 7; E = 0: eq. 88)."""

    peak_friction: float = parameter("1", low=0.0, high=3.0, description="D; k0 of the friction document")
    shape: float = parameter("1", low=0.1, high=3.0, description="C; k1 of eq. 88")
    stiffness: float = parameter("1", low=0.1, high=500.0, description="B; k2 of eq. 88")
    curvature: float = parameter("1", 0.0, low=-20.0, high=1.0, description="E; 0 in eq. 88")


class BurckhardtCurve(FileModel):
    """Friction over slip: (c1 (1 - exp(-c2 s)) - c3 s) exp(-c4 s v) (1 - c5 Fz^2) (eq. 10; c4 = c5 = 0: eq. 9)."""

    c1: float = parameter("1", low=0.0, high=3.0, description="friction level")
    c2: float = parameter("1", low=1.0, high=1000.0, description="initial stiffness")
    c3: float = parameter("1", low=0.0, high=2.0, description="falling branch")
    c4: float = parameter("s/m", 0.0, low=0.0, high=0.1, neutral=0.0, description="influence of speed")
    c5: float = parameter("1/N^2", 0.0, low=0.0, high=1e-8, neutral=0.0, description="influence of load")


class Contact(FileModel):
    """Elastic contact patch: bristles that carry the force at standstill."""

    longitudinal_stiffness: float = parameter("N/m", 3e5, low=1e4, high=5e6, description="", source=_ASSUMED)
    lateral_stiffness: float = parameter("N/m", 2e5, low=1e4, high=5e6, description="", source=_ASSUMED)
    damping: float = parameter("N s/m", 8e3, low=0.0, high=1e5, description="in both directions", source=_ASSUMED)
    full_below: float = parameter(
        "m/s", 0.5, low=0.05, high=5.0, description="speed below which only the bristles act", source="numerical"
    )
    none_above: float = parameter(
        "m/s", 1.0, low=0.1, high=10.0, description="speed above which only the curve acts", source="numerical"
    )


class CurveTyre(FileModel):
    """A tyre given by a friction curve for each direction.

    The longitudinal curve may be a Magic Formula or Burckhardt's; Burckhardt's acts along the resultant slip in both
    directions, so that ``lateral`` is not read then.
    """

    longitudinal: MagicFormulaCurve | BurckhardtCurve
    lateral: MagicFormulaCurve
    combined_slip: Literal["similarity", "kamm"] = "similarity"
    load_sensitivity: float = parameter(
        "1", 0.0, low=0.0, high=0.8, neutral=0.0, description="c in friction (1 - c (Fz / nominal load - 1))"
    )
    nominal_load: float = parameter(
        "N", 3500.0, low=100.0, high=1e5, description="used with the load sensitivity", source=_ASSUMED
    )
    relaxation_length_longitudinal: float = parameter(
        "m", 0.0, low=0.0, high=2.0, neutral=0.0, description="lag of the slip"
    )
    relaxation_length_lateral: float = parameter(
        "m", 0.0, low=0.0, high=2.0, neutral=0.0, description="lag of the slip"
    )
    pneumatic_trail: float = parameter(
        "m", 0.03, low=0.0, high=0.2, description="at small slip, falling to zero at the peak", source=_ASSUMED
    )
    contact: Contact = Contact()


class TirTyre(FileModel):
    """A tyre of the Magic Formula from a ``.tir`` file; its path starts from the file that names it."""

    tir: str
    combined_slip: Literal["auto", "weights", "ellipse"] = "auto"
    inflation_pressure: float | None = parameter(
        "Pa", None, low=1e4, high=2e6, description="that of the .tir file if left out"
    )
    longitudinal_friction_scale: float = parameter(
        "1", 1.0, low=0.0, high=3.0, neutral=1.0, description="on the friction of the .tir file, as LMUX"
    )
    lateral_friction_scale: float = parameter(
        "1", 1.0, low=0.0, high=3.0, neutral=1.0, description="on the friction of the .tir file, as LMUY"
    )
    slip_stiffness_scale: float = parameter(
        "1", 1.0, low=0.05, high=5.0, neutral=1.0, description="on the slope of the .tir file, as LKX"
    )
    cornering_stiffness_scale: float = parameter(
        "1", 1.0, low=0.05, high=5.0, neutral=1.0, description="on the slope of the .tir file, as LKY"
    )
    relaxation_length_longitudinal: float = parameter(
        "m", 0.0, low=0.0, high=2.0, neutral=0.0, description="lag of the slip"
    )
    relaxation_length_lateral: float = parameter(
        "m", 0.0, low=0.0, high=2.0, neutral=0.0, description="lag of the slip"
    )
    contact: Contact = Contact()


class TyrePair(FileModel):
    """Tyres of the front and the rear axle."""

    front: CurveTyre | TirTyre
    rear: CurveTyre | TirTyre


class TyreFile(TyrePair):
    """A tyre file on its own, named in a vehicle file by its path."""

    format: Literal[1]
    name: str
    description: str = ""
    sources: dict[str, str] = Field(default_factory=dict)
