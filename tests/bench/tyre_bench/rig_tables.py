"""Tables of a rig made from a known tyre, in the units and signs that rigs use."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vehicle_model.tyres.magic_formula_tyre import MagicFormula61, MagicFormulaTyre
from vehicle_model.tyres.tir_file import TirFile

TRUTH = {
    "FNOMIN": 3000.0,
    "UNLOADED_RADIUS": 0.3,
    "NOMPRES": 2e5,
    "LONGVL": 16.7,
    "PCX1": 1.6,
    "PDX1": 1.15,
    "PDX2": -0.12,
    "PEX1": 0.3,
    "PKX1": 24.0,
    "PKX3": 0.2,
    "RBX1": 12.0,
    "RBX2": 9.0,
    "RCX1": 1.05,
    "PCY1": 1.35,
    "PDY1": 1.05,
    "PDY2": -0.15,
    "PDY3": 2.0,
    "PEY1": -0.6,
    "PKY1": -19.0,
    "PKY2": 1.8,
    "PKY6": -0.8,
    "PHY1": 0.002,
    "PVY1": 0.01,
    "RBY1": 11.0,
    "RBY2": 8.0,
    "RCY1": 1.05,
    "QBZ1": 9.0,
    "QCZ1": 1.2,
    "QDZ1": 0.11,
    "QEZ1": -1.5,
    "QSX2": 0.7,
    "QSX3": 0.04,
}
LOADS = (1000.0, 2000.0, 3000.0, 4500.0)


def true_tyre() -> MagicFormulaTyre:
    """The tyre behind the tables."""
    tir = TirFile("truth")
    tir.numbers |= TRUTH
    return MagicFormula61(tir, combined_slip="weights")


def _table(slip: NDArray[np.float64], angle: NDArray[np.float64], camber: float, seed: int) -> NDArray[np.float64]:
    """Columns SL, SA deg, IA deg, P kPa, V km/h, FX, FY, FZ, MX, MZ with noise; FZ is negative."""
    random = np.random.default_rng(seed)
    load = np.repeat(LOADS, len(slip))
    slip, angle = np.tile(slip, len(LOADS)), np.tile(angle, len(LOADS))
    forces = true_tyre().forces(slip, angle, camber, load, 2e5, 16.7, check=False)
    count = len(load)

    def noisy(values: NDArray[np.float64], size: float) -> NDArray[np.float64]:
        return values + size * random.standard_normal(count)

    columns = [slip, np.degrees(angle), np.full(count, np.degrees(camber)), np.full(count, 200.0), np.full(count, 60.0)]
    columns += [noisy(forces.fx, 15.0), noisy(forces.fy, 15.0), -load, noisy(forces.mx, 1.0), noisy(forces.mz, 1.0)]
    return np.stack(columns, axis=1)


HEADER = "ET,SL,SA,IA,P,V,FX,FY,FZ,MX,MZ"


def write_tables(folder: Path, outliers: int = 0) -> list[Path]:
    """``drivebrake.csv`` and ``cornering.csv``; some rows of the first get forces that are none."""
    slips = np.concatenate([np.linspace(-0.25, 0.2, 45), np.linspace(0.2, -0.25, 45)])
    angles = np.concatenate([np.linspace(-0.2, 0.2, 45), np.linspace(0.2, -0.2, 45)])
    driven = [_table(slips, np.full(90, angle), 0.0, 10 + k) for k, angle in enumerate((0.0, -0.04, -0.08))]
    turned = [_table(np.zeros(90), angles, camber, 20 + k) for k, camber in enumerate((0.0, 0.03, 0.06))]
    written = []
    for name, parts in (("drivebrake", driven), ("cornering", turned)):
        rows = np.concatenate(parts)
        if name == "drivebrake" and outliers:
            places = np.random.default_rng(5).choice(len(rows), outliers, replace=False)
            rows[places, 5] += 4000.0
        rows = np.concatenate([0.01 * np.arange(len(rows))[:, None], rows], axis=1)
        file = folder / f"{name}.csv"
        np.savetxt(file, rows, delimiter=",", header=HEADER, comments="", fmt="%.6g")
        written.append(file)
    return written
