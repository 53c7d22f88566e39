"""Tyre files: one model per formula for the front and the rear tyres, and the contact state at low speed."""

import math
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel, parameter
from vehicle_model.tyres.tmeasy_file import TMeasyAligning, TMeasyDirection

_ASSUMED = "assumed: usual for a passenger car tyre"
LONGEST_RELAXATION = 2.0
"""Largest relaxation length [m]."""

_ELASTIC = "slip stiffness over contact stiffness if left out"


class MagicFormulaCurve(FileModel):
    """Friction over slip: D sin(C arctan(B s - E (B s - arctan(B s)))) (eq. 7; E = 0: eq. 88)."""

    peak_friction: float = parameter("1", low=0.0, high=3.0, description="D; k0 of the friction document")
    shape: float = parameter("1", low=0.1, high=3.0, description="C; k1 of eq. 88")
    stiffness: float = parameter("1", low=0.1, high=500.0, description="B; k2 of eq. 88")
    curvature: float = parameter("1", 0.0, low=-20.0, high=1.0, description="E; 0 in eq. 88")

    def slope(self, load: float) -> float:
        """Slope at zero slip over the load."""
        return self.stiffness * self.shape * self.peak_friction


class LoadDependentCurve(FileModel):
    """Force over slip by eq. 5 with coefficients that depend on the load F in newtons (eq. 6).

    C = a0; D = a1 F^2 + a2 F; B C D = (a3 F^2 + a4 F) exp(-a5 F); E = a6 F^2 + a7 F + a8.
    """

    a0: float = parameter("1", low=0.1, high=3.0, description="shape C")
    a1: float = parameter("1/N", low=-1e-3, high=1e-3, description="peak D by the load squared")
    a2: float = parameter("1", low=0.0, high=3.0, description="peak D by the load")
    a3: float = parameter("1/N", low=-0.1, high=0.1, description="slope B C D by the load squared")
    a4: float = parameter("1", low=0.0, high=500.0, description="slope B C D by the load")
    a5: float = parameter("1/N", 0.0, low=-1e-3, high=1e-2, description="decay of the slope with the load")
    a6: float = parameter("1/N^2", 0.0, low=-1e-6, high=1e-6, description="curvature E by the load squared")
    a7: float = parameter("1/N", 0.0, low=-1e-2, high=1e-2, description="curvature E by the load")
    a8: float = parameter("1", 0.0, low=-20.0, high=1.0, description="curvature E")

    def slope(self, load: float) -> float:
        """Slope at zero slip over the load."""
        return (self.a3 * load + self.a4) * math.exp(-self.a5 * load)


class BurckhardtCurve(FileModel):
    """Friction over slip: (c1 (1 - exp(-c2 s)) - c3 s) exp(-c4 s v) (1 - c5 Fz^2) (eq. 10; c4 = c5 = 0: eq. 9)."""

    c1: float = parameter("1", low=0.0, high=3.0, description="friction level")
    c2: float = parameter("1", low=1.0, high=1000.0, description="initial stiffness")
    c3: float = parameter("1", low=0.0, high=2.0, description="falling branch")
    c4: float = parameter("s/m", 0.0, low=0.0, high=0.1, neutral=0.0, description="influence of speed")
    c5: float = parameter("1/N^2", 0.0, low=0.0, high=1e-8, neutral=0.0, description="influence of load")

    def slope(self, load: float) -> float:
        """Slope at zero slip over the load."""
        return self.c1 * self.c2 - self.c3


def _curve_kind(value: Any) -> str:
    if not isinstance(value, dict):
        return type(value).__name__ if isinstance(value, FileModel) else "MagicFormulaCurve"
    if value.keys() & {"c1", "c2", "c3"}:
        return "BurckhardtCurve"
    return "LoadDependentCurve" if value.keys() & {"a0", "a1", "a2"} else "MagicFormulaCurve"


def _side_curve_kind(value: Any) -> str:
    kind = _curve_kind(value)
    return "MagicFormulaCurve" if kind == "BurckhardtCurve" else kind


_Curve = Annotated[
    Annotated[MagicFormulaCurve, Tag("MagicFormulaCurve")]
    | Annotated[LoadDependentCurve, Tag("LoadDependentCurve")]
    | Annotated[BurckhardtCurve, Tag("BurckhardtCurve")],
    Discriminator(_curve_kind),
]
_SideCurve = Annotated[
    Annotated[MagicFormulaCurve, Tag("MagicFormulaCurve")] | Annotated[LoadDependentCurve, Tag("LoadDependentCurve")],
    Discriminator(_side_curve_kind),
]


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

    longitudinal: _Curve
    lateral: _SideCurve
    combined_slip: Literal["similarity", "kamm"] = "similarity"
    load_sensitivity: float = parameter(
        "1", 0.0, low=-0.5, high=0.8, neutral=0.0, description="c in friction (1 - c (Fz / nominal load - 1))"
    )
    nominal_load: float = parameter(
        "N", 3500.0, low=100.0, high=1e5, description="used with the load sensitivity", source=_ASSUMED
    )
    relaxation_length_longitudinal: float = parameter(
        "m", 0.0, low=0.0, high=LONGEST_RELAXATION, neutral=0.0, description="lag of the slip"
    )
    relaxation_length_lateral: float = parameter(
        "m", 0.0, low=0.0, high=LONGEST_RELAXATION, neutral=0.0, description="lag of the slip"
    )
    pneumatic_trail: float = parameter(
        "m", 0.03, low=0.0, high=0.2, description="at small slip, falling to zero at the peak", source=_ASSUMED
    )
    contact: Contact = Contact()

    def slopes(self) -> tuple[float, float]:
        """Slopes of force over slip at zero slip, over the nominal load: longitudinal and lateral."""
        lateral = self.longitudinal if isinstance(self.longitudinal, BurckhardtCurve) else self.lateral
        return self.longitudinal.slope(self.nominal_load), lateral.slope(self.nominal_load)


class _FormulaFile(FileModel):
    """What tyres of the other formulas have in common."""

    formula: str
    nominal_load: float = parameter("N", 3500.0, low=100.0, high=1e5, description="", source=_ASSUMED)
    relaxation_length_longitudinal: float | None = parameter(
        "m", None, low=0.0, high=LONGEST_RELAXATION, neutral=0.0, description=f"lag of the slip; {_ELASTIC}"
    )
    relaxation_length_lateral: float | None = parameter(
        "m", None, low=0.0, high=LONGEST_RELAXATION, neutral=0.0, description=f"lag of the slip; {_ELASTIC}"
    )
    contact: Contact = Contact()

    @model_validator(mode="after")
    def _fill_relaxation(self) -> "_FormulaFile":
        for name, length in zip(("longitudinal", "lateral"), self.elastic_lengths(), strict=True):
            if getattr(self, f"relaxation_length_{name}") is None:
                object.__setattr__(self, f"relaxation_length_{name}", min(length, LONGEST_RELAXATION))
        return self

    def slopes(self) -> tuple[float, float]:
        """Slopes of force over slip at zero slip, over the nominal load: longitudinal and lateral."""
        raise NotImplementedError

    def elastic_lengths(self) -> tuple[float, float]:
        """Way [m] that the contact needs to wind up: slip stiffness over the stiffness of the standing tyre."""
        along, across = self.slopes()
        contact = self.contact
        return (
            along * self.nominal_load / contact.longitudinal_stiffness,
            across * self.nominal_load / contact.lateral_stiffness,
        )


class TMeasyTyre(_FormulaFile):
    """TMeasy (eqs 11 to 22); forces quadratic in the load, slips linear (Rill), road friction scales F and s."""

    formula: Literal["tmeasy"]
    longitudinal: TMeasyDirection
    lateral: TMeasyDirection
    aligning: TMeasyAligning

    def slopes(self) -> tuple[float, float]:
        """Slopes over the nominal load."""
        return self.longitudinal.nominal.slope / self.nominal_load, self.lateral.nominal.slope / self.nominal_load


class DugoffTyre(_FormulaFile):
    """Dugoff's tyre (1969): one friction for both directions, falling with the sliding speed."""

    formula: Literal["dugoff"]
    friction: float = parameter("1", low=0.0, high=3.0, description="mu0, at no sliding speed")
    friction_reduction: float = parameter(
        "s/m", 0.0, low=0.0, high=0.05, neutral=0.0, description="e_r in mu = mu0 (1 - e_r v_slide)"
    )
    slip_stiffness: float = parameter("1", low=0.5, high=200.0, description="C_s over the load")
    cornering_stiffness: float = parameter("1/rad", low=0.5, high=200.0, description="C_alpha over the load")
    pneumatic_trail: float = parameter("m", 0.03, low=0.0, high=0.2, description="at small slip", source=_ASSUMED)

    def slopes(self) -> tuple[float, float]:
        """Slopes over the nominal load."""
        return self.slip_stiffness, self.cornering_stiffness


class FialaTyre(_FormulaFile):
    """Fiala's tyre: parabola along, cubic across, friction falling linearly with slip; the Kamm ellipse combines."""

    formula: Literal["fiala"]
    static_friction: float = parameter("1", low=0.0, high=3.0, description="U_max, at no slip")
    sliding_friction: float = parameter("1", low=0.0, high=3.0, description="U_min, at slip 1")
    slip_stiffness: float = parameter("1", low=0.5, high=200.0, description="C_slip over the load")
    cornering_stiffness: float = parameter("1/rad", low=0.5, high=200.0, description="C_alpha over the load")
    width: float = parameter("m", 0.2, low=0.0, high=1.0, description="of the contact, arm of the aligning moment")

    @model_validator(mode="after")
    def _ordered(self) -> "FialaTyre":
        if self.sliding_friction > self.static_friction:
            raise FieldError("above the static one", at=("sliding_friction",), allowed="at most static_friction")
        return self

    def slopes(self) -> tuple[float, float]:
        """Slopes over the nominal load."""
        return self.slip_stiffness, self.cornering_stiffness


_LUMPING = 7.0 / 6.0
"""kappa L of the average lumped model (Deur 2001; Velenis, Tsiotras 2005)."""


class _BristleTyre(_FormulaFile):
    """Bristles of an average lumped model, which leave the contact with the rolling speed."""

    contact_length: float = parameter("m", 0.2, low=0.02, high=1.0, description="L of the contact")
    stiffness_longitudinal: float = parameter("1/m", low=1.0, high=5000.0, description="sigma0 along, over the load")
    stiffness_lateral: float = parameter("1/m", low=1.0, high=5000.0, description="sigma0 across, over the load")
    pneumatic_trail: float = parameter("m", 0.03, low=0.0, high=0.2, description="at small slip", source=_ASSUMED)

    @property
    def renewal(self) -> float:
        """kappa [1/m]: deflection lost per rolled metre."""
        return _LUMPING / self.contact_length

    def slopes(self) -> tuple[float, float]:
        """Slopes over the nominal load."""
        return self.stiffness_longitudinal / self.renewal, self.stiffness_lateral / self.renewal

    def elastic_lengths(self) -> tuple[float, float]:
        """The bristles' own lag at small slip, 1 / kappa."""
        return 1.0 / self.renewal, 1.0 / self.renewal


class LuGreTyre(_BristleTyre):
    """LuGre (Canudas de Wit et al. 2003), average lumped: friction falls from static to Coulomb with sliding speed."""

    formula: Literal["lugre"]
    static_friction: float = parameter("1", low=0.0, high=5.0, description="mu_s")
    coulomb_friction: float = parameter("1", low=0.0, high=3.0, description="mu_c")
    stribeck_speed: float = parameter("m/s", low=0.01, high=100.0, description="v_s")
    viscous_friction: float = parameter("s/m", 0.0, low=0.0, high=0.1, description="sigma2")

    @model_validator(mode="after")
    def _friction_ordered(self) -> "LuGreTyre":
        if self.coulomb_friction > self.static_friction:
            raise FieldError("above the static one", at=("coulomb_friction",), allowed="at most static_friction")
        return self


class DahlTyre(_BristleTyre):
    """Dahl's bristles, average lumped: constant friction, so that no force falls with slip."""

    formula: Literal["dahl"]
    friction: float = parameter("1", low=0.0, high=3.0, description="Coulomb friction")


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
    relaxation_length_longitudinal: float | None = parameter(
        "m",
        None,
        low=0.0,
        high=LONGEST_RELAXATION,
        neutral=0.0,
        description="lag of the slip; that of the .tir file if left out",
    )
    relaxation_length_lateral: float | None = parameter(
        "m",
        None,
        low=0.0,
        high=LONGEST_RELAXATION,
        neutral=0.0,
        description="lag of the slip; that of the .tir file if left out",
    )
    contact: Contact = Contact()


FORMULAS: dict[str, type[FileModel]] = {
    "tmeasy": TMeasyTyre,
    "dugoff": DugoffTyre,
    "fiala": FialaTyre,
    "lugre": LuGreTyre,
    "dahl": DahlTyre,
}


def _check_formula(value: Any) -> Any:
    if not isinstance(value, (dict, FileModel)):
        raise FieldError(
            "not a mapping of fields", found=repr(value), allowed="{longitudinal, lateral}, {tir}, {formula}"
        )
    if isinstance(value, dict) and "formula" in value and str(value["formula"]) not in FORMULAS:
        allowed = f"{', '.join(FORMULAS)}; or longitudinal and lateral curves, or tir, without formula"
        raise FieldError("unknown formula", at=("formula",), allowed=allowed)
    return value


def _kind(value: Any) -> str:
    if not isinstance(value, dict):
        return type(value).__name__
    if "formula" in value:
        return FORMULAS[str(value["formula"])].__name__
    return "TirTyre" if "tir" in value else "CurveTyre"


AnyTyre = CurveTyre | TirTyre | TMeasyTyre | DugoffTyre | FialaTyre | LuGreTyre | DahlTyre
_Tyre = Annotated[
    Annotated[CurveTyre, Tag("CurveTyre")]
    | Annotated[TirTyre, Tag("TirTyre")]
    | Annotated[TMeasyTyre, Tag("TMeasyTyre")]
    | Annotated[DugoffTyre, Tag("DugoffTyre")]
    | Annotated[FialaTyre, Tag("FialaTyre")]
    | Annotated[LuGreTyre, Tag("LuGreTyre")]
    | Annotated[DahlTyre, Tag("DahlTyre")],
    Discriminator(_kind),
    BeforeValidator(_check_formula),
]


class TyrePair(FileModel):
    """Tyres of the front and the rear axle."""

    front: _Tyre
    rear: _Tyre


class TyreFile(TyrePair):
    """A tyre file on its own, named in a vehicle file by its path."""

    format: Literal[1]
    name: str
    description: str = ""
    sources: dict[str, str] = Field(default_factory=dict)
