"""Checks of ``.tir`` files before anything is compiled: which formula, what is missing, what is absurd."""

from pathlib import Path

from signals.errors import Fault, FileFaults, InputError
from vehicle_model.tyres.magic_formula_record import COEFFICIENTS, VERSION_52, VERSION_61, VERSION_62
from vehicle_model.tyres.tir_file import TirFile, missing, read_tir_file

_REQUIRED = {
    "VERTICAL": ("FNOMIN",),
    "DIMENSION": ("UNLOADED_RADIUS",),
    "LONGITUDINAL_COEFFICIENTS": ("PCX1", "PDX1", "PKX1"),
    "LATERAL_COEFFICIENTS": ("PCY1", "PDY1", "PKY1", "PKY2"),
}
_ALIASES = {"IP": "INFLPRES", "IP_NOM": "NOMPRES", "QPZ1": "PPZ1", "QPZ2": "PPZ2", "QPX1": "PPMX1"}
_PLAUSIBLE = {
    "FNOMIN": (10.0, 2e5),
    "UNLOADED_RADIUS": (0.02, 3.0),
    "PCX1": (0.05, 3.5),
    "PDX1": (-10.0, 10.0),
    "PKX1": (0.5, 500.0),
    "PCY1": (0.05, 3.5),
    "PDY1": (-10.0, 10.0),
    "PKY1": (-500.0, 500.0),
    "PKY2": (0.01, 1000.0),
    "LONGVL": (0.01, 500.0),
    **dict.fromkeys(("ALPMIN", "ALPMAX"), (-1.6, 1.6)),
    **dict.fromkeys(("CAMMIN", "CAMMAX"), (-1.6, 1.6)),
    **dict.fromkeys(("LFZO", "LMUX", "LMUY", "LKX", "LKY", "LCX", "LCY"), (0.01, 100.0)),
}
_PRESSURES = ("NOMPRES", "INFLPRES", "PRESMAX")
_PASCALS = (5e3, 3e6)
"""Plausible pressures; 0 stands for a pressure that a file does not give."""

_RANGES = (("KPUMIN", "KPUMAX"), ("ALPMIN", "ALPMAX"), ("CAMMIN", "CAMMAX"), ("FZMIN", "FZMAX"), ("PRESMIN", "PRESMAX"))
_BY_FITTYP = {
    5: VERSION_52,
    6: VERSION_52,
    51: VERSION_52,
    52: VERSION_52,
    60: VERSION_61,
    61: VERSION_61,
    62: VERSION_62,
}


def read_checked(path: str | Path) -> TirFile:
    """Read a file and refuse it unless it is a Magic Formula that the bench knows.

    Names of PAC2002 files for the same coefficients become those of the Magic Formula.

    Raises
    ------
    InputError
        If the file cannot be read, is of another formula, lacks coefficients or has absurd ones.
    """
    tir = read_tir_file(path)
    for old, new in _ALIASES.items():
        if old in tir.numbers:
            tir.numbers[new] = tir.numbers.pop(old)
            tir.lines[new] = tir.lines.pop(old)
    version_of(tir)
    _check(tir)
    return tir


def version_of(tir: TirFile) -> float:
    """Version of the formula (``VERSION_52`` …); InputError if the file says none or another."""
    file_format = tir.texts.get("PROPERTY_FILE_FORMAT", "").upper()
    if file_format == "PAC2002":
        return VERSION_52
    fitted = tir.numbers.get("FITTYP")
    if fitted is not None and int(fitted) in _BY_FITTYP:
        return _BY_FITTYP[int(fitted)]
    allowed = "FITTYP 5, 6, 51, 52 (5.2), 60, 61 (6.1), 62 (6.2), or PROPERTY_FILE_FORMAT 'PAC2002'"
    name = "FITTYP" if "FITTYP" in tir.lines else "PROPERTY_FILE_FORMAT"
    if name not in tir.lines:
        raise InputError(f"{tir.path}: section [MODEL] does not say which formula", allowed=allowed)
    found = f"{fitted:g}" if fitted is not None else repr(file_format or "nothing")
    raise FileFaults([tir.fault(name, "unknown formula", found=found, allowed=allowed)], tir.path)


def _check(tir: TirFile) -> None:
    faults: list[Fault] = missing(tir, _REQUIRED)
    for name, (low, high) in _PLAUSIBLE.items():
        value = tir.numbers.get(name)
        if value is not None and not low <= value <= high:
            faults.append(tir.fault(name, "absurd value", found=f"{value:g}", allowed=f"{low:g}…{high:g}"))
    faults += [*_pressure_faults(tir), *_range_faults(tir)]
    for name, first, second in tir.repeated:
        if name in COEFFICIENTS or name in _PLAUSIBLE:
            faults.append(
                tir.fault(name, f"given twice with different values, first in line {first}, then in {second}")
            )
    for name in COEFFICIENTS & tir.numbers.keys():
        if not abs(tir.numbers[name]) < 1e6:
            faults.append(tir.fault(name, "absurd value", found=f"{tir.numbers[name]:g}", allowed="below 1e6"))
    for name in COEFFICIENTS & tir.texts.keys():
        faults.append(tir.fault(name, "not a number", found=repr(tir.texts[name])))
    if faults:
        raise FileFaults(faults, tir.path)


def _pressure_faults(tir: TirFile) -> list[Fault]:
    """Pressures that are none in pascals: programs that ask for SI still meet files in bar, psi or kPa."""
    low, high = _PASCALS
    return [
        tir.fault(name, "absurd value, pressures are in Pa", found=f"{value:g}", allowed=f"{low:g}…{high:g}")
        for name in _PRESSURES
        if (value := tir.numbers.get(name, 0.0)) != 0.0 and not low <= value <= high
    ]


def _range_faults(tir: TirFile) -> list[Fault]:
    """Ranges whose ends are turned round; two equal ends stand for a range that a file does not give."""
    return [
        tir.fault(high, "below the other end of its range", found=f"{top:g}", allowed=f"more than {low} = {bottom:g}")
        for low, high in _RANGES
        if (bottom := tir.numbers.get(low)) is not None and (top := tir.numbers.get(high)) is not None and top < bottom
    ]
