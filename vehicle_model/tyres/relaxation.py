"""Relaxation lengths from the coefficients of a ``.tir`` file, in plain Python for file schemas and tyres alike."""

import math
from collections.abc import Callable

from vehicle_model.tyres.magic_formula_record import VERSION_52
from vehicle_model.tyres.tir_check import read_checked, version_of
from vehicle_model.tyres.tir_file import TirFile
from vehicle_model.tyres.tyre_file import LONGEST_RELAXATION, TirTyre

Coefficient = Callable[[str], float]
"""Value of a coefficient by its name; 0 (1 for a scale factor) where a file has none."""


def lengths_of_52(p: Coefficient, load: float) -> tuple[float, float]:
    """Longitudinal and lateral relaxation length [m] at a load [N] from PTX and PTY (PAC2002); 0 without them."""
    nominal = p("FNOMIN") * p("LFZO")
    dfz = (load - nominal) / nominal
    along = (p("PTX1") + p("PTX2") * dfz) * math.exp(p("PTX3") * dfz)
    along *= load * p("UNLOADED_RADIUS") / nominal * p("LSGKP")
    across = 0.0
    if p("PTY2") != 0.0:
        across = p("PTY1") * math.sin(2.0 * math.atan(load / (p("PTY2") * nominal)))
        across *= p("UNLOADED_RADIUS") * p("LFZO") * p("LSGAL")
    return along, across


def lengths_of_6x(
    p: Coefficient, load: float, pressure: float, slip_stiffness: float, cornering_stiffness: float
) -> tuple[float, float]:
    """The same from slip stiffnesses over the carcass's (Pacejka 2012, 7.7); 0 where a file gives no carcass."""
    nominal = p("FNOMIN") * p("LFZO")
    dfz = (load - nominal) / nominal
    dpi = (pressure - p("NOMPRES")) / p("NOMPRES") if p("NOMPRES") > 0.0 else 0.0
    lengths = []
    for stiffness, carcass, letter in (
        (slip_stiffness, p("LONGITUDINAL_STIFFNESS"), "X"),
        (cornering_stiffness, p("LATERAL_STIFFNESS"), "Y"),
    ):
        first, second, third = (p(f"PCF{letter}{number}") for number in (1, 2, 3))
        carcass *= (1.0 + first * dfz + second * dfz * dfz) * (1.0 + third * dpi)
        lengths.append(abs(stiffness) / carcass if carcass > 0.0 else 0.0)
    return lengths[0], lengths[1]


def nominal_stiffnesses(p: Coefficient) -> tuple[float, float]:
    """Slip stiffness [N] and cornering stiffness [N/rad] at nominal load and pressure without camber (4.E15, 4.E25)."""
    nominal = p("FNOMIN") * p("LFZO")
    steepness = p("PKY4") or 2.0
    return (
        nominal * p("PKX1") * p("LKX"),
        nominal * p("PKY1") * math.sin(steepness * math.atan(1.0 / p("PKY2"))) * p("LKY"),
    )


def nominal_lengths(
    tir: TirFile, *, before_6: bool, stiffness_along: float, stiffness_across: float
) -> tuple[float, float]:
    """Relaxation lengths [m] at nominal load; from the standing tyre's stiffnesses [N/m] where the file has no others.

    Parameters
    ----------
    before_6 : bool
        The file is of version 5.2 or PAC2002.
    stiffness_along, stiffness_across : N/m
        Of the contact at standstill.
    """

    def p(name: str) -> float:
        return tir.numbers.get(name, 1.0 if name.startswith("L") and not name.endswith("STIFFNESS") else 0.0)

    slip, cornering = nominal_stiffnesses(p)
    load = p("FNOMIN") * p("LFZO")
    given = lengths_of_52(p, load) if before_6 else lengths_of_6x(p, load, p("NOMPRES"), slip, cornering)
    return given[0] or abs(slip) / stiffness_along, given[1] or abs(cornering) / stiffness_across


def fill_in(tyre: TirTyre) -> None:
    """Give a tyre the relaxation lengths of its ``.tir`` file where its entry leaves them out."""
    if tyre.relaxation_length_longitudinal is not None and tyre.relaxation_length_lateral is not None:
        return
    tir = read_checked(tyre.tir)
    contact = tyre.contact
    along, across = nominal_lengths(
        tir,
        before_6=version_of(tir) == VERSION_52,
        stiffness_along=contact.longitudinal_stiffness,
        stiffness_across=contact.lateral_stiffness,
    )
    for name, length in (("relaxation_length_longitudinal", along), ("relaxation_length_lateral", across)):
        if getattr(tyre, name) is None:
            object.__setattr__(tyre, name, min(length, LONGEST_RELAXATION))
