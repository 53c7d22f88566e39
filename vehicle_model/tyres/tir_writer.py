"""Writing of ``.tir`` files: what is written reads back as the same record and the same limits."""

import math
from collections.abc import Sequence
from pathlib import Path

from signals.errors import InputError
from vehicle_model.tyres.magic_formula_record import (
    ALIGNING,
    DEVIATIONS,
    LATERAL,
    LONGITUDINAL,
    OVERTURNING,
    RELAXATION,
    ROLLING,
    SCALING,
)
from vehicle_model.tyres.magic_formula_tyre import LIMIT_NAMES, MagicFormulaTyre

_RANGES = {
    "inflation_pressure": "INFLATION_PRESSURE_RANGE",
    "vertical_load": "VERTICAL_FORCE_RANGE",
    "slip_ratio": "LONG_SLIP_RANGE",
    "slip_angle": "SLIP_ANGLE_RANGE",
    "camber": "INCLINATION_ANGLE_RANGE",
}


def write_tir(path: str | Path, tyre: MagicFormulaTyre, remarks: Sequence[str] = ()) -> Path:
    """Write a tyre of the Magic Formula; SI units, every coefficient with all its digits.

    Parameters
    ----------
    path
        The file; an existing one is replaced.
    remarks
        Lines of comment at the head.

    Raises
    ------
    InputError
        If the tyre departs from the book (``deviations``), which no ``.tir`` file can tell, or the file cannot be
        written.
    """
    record = tyre.record[0]
    switched = [name for name in DEVIATIONS if record[name] != 0.0]
    if switched:
        raise InputError(f"{path}: a .tir file cannot tell departures from the book", found=", ".join(switched))
    lines = [f"! {line}" for line in remarks]
    for section, entries in _sections(tyre):
        lines += [f"[{section}]", *(f"{name:<24} = {value}" for name, value in entries)]
    target = Path(path)
    try:
        target.write_text("\n".join(lines) + "\n", encoding="latin-1", errors="replace")
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    return target


def _sections(tyre: MagicFormulaTyre) -> list[tuple[str, list[tuple[str, str]]]]:
    record = tyre.record[0]

    def numbers(*names: str) -> list[tuple[str, str]]:
        return [(name, repr(float(record[name]))) for name in names]

    units = (("LENGTH", "meter"), ("FORCE", "newton"), ("ANGLE", "radians"), ("MASS", "kg"), ("TIME", "second"))
    carcass = [name for name in RELAXATION if not name.startswith("PT")]
    ranges = [
        (section, [(name, repr(limit)) for name, limit in _given(tyre, quantity)])
        for quantity, section in _RANGES.items()
    ]
    return [
        ("MDI_HEADER", [("FILE_TYPE", "'tir'"), ("FILE_VERSION", "3.0"), ("FILE_FORMAT", "'ASCII'")]),
        ("UNITS", [(name, f"'{unit}'") for name, unit in units]),
        (
            "MODEL",
            [("FITTYP", f"{tyre.version:.0f}"), ("TYRESIDE", f"'{tyre.measured_side}'"), *numbers("LONGVL")],
        ),
        ("DIMENSION", numbers("UNLOADED_RADIUS")),
        ("OPERATING_CONDITIONS", numbers("INFLPRES", "NOMPRES")),
        ("VERTICAL", numbers("FNOMIN")),
        ("STRUCTURAL", numbers(*carcass)),
        *((section, entries) for section, entries in ranges if entries),
        ("SCALING_COEFFICIENTS", numbers(*SCALING)),
        ("LONGITUDINAL_COEFFICIENTS", numbers(*LONGITUDINAL, "PTX1", "PTX2", "PTX3")),
        ("OVERTURNING_COEFFICIENTS", numbers(*OVERTURNING)),
        ("LATERAL_COEFFICIENTS", numbers(*LATERAL, "PTY1", "PTY2")),
        ("ROLLING_COEFFICIENTS", numbers(*ROLLING)),
        ("ALIGNING_COEFFICIENTS", numbers(*ALIGNING)),
    ]


def _given(tyre: MagicFormulaTyre, quantity: str) -> list[tuple[str, float]]:
    low, high = tyre.limits.ranges.get(quantity, (-math.inf, math.inf))
    names = LIMIT_NAMES[quantity]
    return [(name, limit) for name, limit in zip(names, (low, high), strict=True) if math.isfinite(limit)]
