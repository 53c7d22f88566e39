"""Coefficients of the Magic Formula as one record, under the names that ``.tir`` files use.

Book: Pacejka, Tire and Vehicle Dynamics, 3rd edition 2012, section 4.3 (equations 4.E1 to 4.E78). Version 5.2 is of its
2nd edition and of the PAC2002 tyre, 6.2 is 6.1 with the additions of the MF-Tyre/MF-Swift 6.2 manual.
"""

import numpy as np

VERSION_52, VERSION_61, VERSION_62 = 52.0, 61.0, 62.0


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split())


MODEL = _names("VERSION LONGVL UNLOADED_RADIUS FNOMIN NOMPRES INFLPRES")
"""What every formula needs; in SI units."""

SCALING = _names(
    "LFZO LCX LMUX LEX LKX LHX LVX LCY LMUY LEY LKY LHY LVY LTR LRES LXAL LYKA LVYKA LS LKYC LKZC LVMX LMX LMY "
    "LGAX LGAY LGAZ LKYG LSGKP LSGAL"
)
"""Scale factors; 1 where a file has none."""

LONGITUDINAL = _names(
    "PCX1 PDX1 PDX2 PDX3 PEX1 PEX2 PEX3 PEX4 PKX1 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2 PPX1 PPX2 PPX3 PPX4 "
    "RBX1 RBX2 RBX3 RCX1 REX1 REX2 RHX1"
)
LATERAL = _names(
    "PCY1 PDY1 PDY2 PDY3 PEY1 PEY2 PEY3 PEY4 PEY5 PKY1 PKY2 PKY3 PKY4 PKY5 PKY6 PKY7 PHY1 PHY2 PHY3 "
    "PVY1 PVY2 PVY3 PVY4 PPY1 PPY2 PPY3 PPY4 PPY5 "
    "RBY1 RBY2 RBY3 RBY4 RCY1 REY1 REY2 RHY1 RHY2 RVY1 RVY2 RVY3 RVY4 RVY5 RVY6"
)
ALIGNING = _names(
    "QBZ1 QBZ2 QBZ3 QBZ4 QBZ5 QBZ9 QBZ10 QCZ1 QDZ1 QDZ2 QDZ3 QDZ4 QDZ6 QDZ7 QDZ8 QDZ9 QDZ10 QDZ11 "
    "QEZ1 QEZ2 QEZ3 QEZ4 QEZ5 QHZ1 QHZ2 QHZ3 QHZ4 PPZ1 PPZ2 SSZ1 SSZ2 SSZ3 SSZ4"
)
OVERTURNING = _names("QSX1 QSX2 QSX3 QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX12 QSX13 QSX14 PPMX1")
ROLLING = _names("QSY1 QSY2 QSY3 QSY4 QSY5 QSY6 QSY7 QSY8")
RELAXATION = _names(
    "PTX1 PTX2 PTX3 PTY1 PTY2 LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS PCFX1 PCFX2 PCFX3 PCFY1 PCFY2 PCFY3"
)

DEVIATIONS = _names(
    "angle_in_side_force curvature_sign_of_angle curvature_unlimited residual_without_camber residual_cosine_twice "
    "denominator_plus_0_1 camber_raises_side_friction trail_sign_of_slip_ratio argument_clamped"
)
"""Departures of other programs from the book, 0 or 1; docs/models/tyres.md explains them."""

FIELDS = MODEL + SCALING + LONGITUDINAL + LATERAL + ALIGNING + OVERTURNING + ROLLING + RELAXATION + DEVIATIONS
TIR_RECORD = np.dtype([(name, "f8") for name in FIELDS])

COEFFICIENTS = frozenset(LONGITUDINAL + LATERAL + ALIGNING + OVERTURNING + ROLLING)
