"""Tyres by what a user types: a .tir file, a tyre file, or the name of a shipped one, with the axle behind a colon."""

from dataclasses import dataclass
from pathlib import Path

from signals.errors import InputError
from vehicle_model.tyres.formula_tyre import tyre_of
from vehicle_model.tyres.magic_formula_tyre import MagicFormulaTyre, read_tir
from vehicle_model.tyres.tyre import Tyre
from vehicle_model.tyres.tyre_file import TirTyre
from vehicle_model.vehicle_file import load_tyres

_AXLES = ("front", "rear")


@dataclass(frozen=True)
class Source:
    """A tyre with its name and the load [N] at which it is shown."""

    name: str
    formula: str
    tyre: Tyre
    nominal_load: float


def load_source(text: str) -> Source:
    """The tyre of ``sedan.tir``, ``tmeasy``, ``my_tyres.yaml`` or ``my_tyres.yaml:rear``.

    Raises
    ------
    InputError
        If there is no such tyre, or its file has faults.
    """
    if text.lower().endswith(".tir"):
        return _of_tir(Path(text).stem, read_tir(text))
    path, colon, axle = text.rpartition(":")
    if not colon or axle not in _AXLES:
        path, axle = text, "front"
    entry = getattr(load_tyres(path), axle)
    name = Path(path).stem + (":rear" if axle == "rear" else "")
    tyre = tyre_of(entry, name)
    if isinstance(entry, TirTyre):
        if not isinstance(tyre, MagicFormulaTyre):
            raise InputError(f"{text}: not a tyre of the Magic Formula")
        return _of_tir(name, tyre)
    formula = getattr(entry, "formula", "") or f"curves, {entry.combined_slip}"
    return Source(name, formula, tyre, entry.nominal_load)


def _of_tir(name: str, tyre: MagicFormulaTyre) -> Source:
    record = tyre.record[0]
    return Source(name, f"Magic Formula {tyre.version / 10.0:.1f}", tyre, float(record["FNOMIN"] * record["LFZO"]))
