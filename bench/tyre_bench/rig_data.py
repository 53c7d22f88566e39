"""Measurements of a tyre test rig in SI units and ISO signs, with what was found and converted on the way.

Columns are those of flat-belt rigs: SL (or SR) slip ratio, SA slip angle, IA camber, P pressure, V speed, FX FY FZ MX
MZ, RL loaded radius. Units and signs differ from rig to rig and are told by nobody, so they are judged from the
numbers; every judgement is reported, and each can be overruled.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from signals.errors import InputError
from signals.measured.channel_map import Clock
from signals.measured.raw_channels import missing_channel
from signals.measured.tables import csv_columns, read_csv
from signals.quantities import QuantityError, to_si

FloatArray = NDArray[np.float64]

INPUTS = ("slip_ratio", "slip_angle", "camber", "vertical_load", "inflation_pressure", "speed")
MEASURED = ("fx", "fy", "mx", "mz")
_COLUMNS = {
    "SA": "rad",
    "IA": "rad",
    "P": "Pa",
    "V": "m/s",
    "FX": "N",
    "FY": "N",
    "FZ": "N",
    "MX": "N m",
    "MZ": "N m",
    "RL": "m",
}
_REQUIRED = ("SA", "FX", "FY", "FZ")
_ENDINGS = (".csv", ".csv.gz", ".dat", ".txt")
_FREE_ROLLING = 0.02
"""Slip ratio below which a file's wheel counts as rolling freely throughout."""


@dataclass
class RigData:
    """Rows of measurements of all files.

    Attributes
    ----------
    inputs : shape (n, 6)
        Columns as in ``Tyre.evaluate``: slip ratio, slip angle, camber [rad], load [N], pressure [Pa], speed [m/s].
    measured : dict
        ``fx``, ``fy`` [N], ``mx``, ``mz`` [N m], shape (n,); not a number where a file has no such column.
    driven : shape (n,)
        True in rows of files whose wheel was braked or driven.
    radius : float
        Unloaded radius [m] from the loaded radius at vanishing load; 0 where no file has one.
    notes : list of str
        What was found and converted.
    """

    inputs: FloatArray
    measured: dict[str, FloatArray]
    driven: NDArray[np.bool_]
    radius: float
    notes: list[str] = field(default_factory=list)


def read_rig_data(
    paths: Sequence[str | Path], units: Mapping[str, str] | None = None, slip: str | None = None, sae: bool = False
) -> RigData:
    """Read the tables of a rig.

    Parameters
    ----------
    paths
        CSV files (gzipped or not), or folders of them.
    units
        Column → unit where the judgement from the numbers is wrong, e.g. ``{"P": "psi"}``.
    slip
        Column of the slip ratio; SL, or SR where there is no SL.
    sae
        Lateral signs are those of SAE J670 (y to the right): slip angle, side force and aligning moment turn round.

    Raises
    ------
    InputError
        If there is no file, a column is missing, or a unit is unknown.
    """
    files = _files(paths)
    parts = [_read_file(file, dict(units or {}), slip, sae) for file in files]
    radii = [part.radius for part in parts if part.radius > 0.0]
    notes = [note for part in parts for note in part.notes]
    if radii and max(radii) > 1.05 * min(radii):
        notes.append(
            f"loaded radii of the files differ: {min(radii):.4f} to {max(radii):.4f} m at no load; the least is used"
        )
    return RigData(
        np.concatenate([part.inputs for part in parts]),
        {name: np.concatenate([part.measured[name] for part in parts]) for name in MEASURED},
        np.concatenate([part.driven for part in parts]),
        min(radii, default=0.0),
        notes,
    )


def _files(paths: Sequence[str | Path]) -> list[Path]:
    found: list[Path] = []
    for given in map(Path, paths):
        inside = sorted(file for file in given.iterdir() if file.name.endswith(_ENDINGS)) if given.is_dir() else [given]
        if not inside:
            raise InputError(
                f"{given}: no table of a rig in this folder", allowed=f"files that end with {', '.join(_ENDINGS)}"
            )
        found += inside
    for file in found:
        if not file.is_file():
            raise InputError(f"{file}: no such file")
    return found


def _read_file(path: Path, units: dict[str, str], slip: str | None, sae: bool) -> RigData:
    names = list(csv_columns(path))
    slip = slip or next((name for name in ("SL", "SR") if name in names), None)
    if slip is None:
        raise missing_channel(path, "SL", names)
    for name in (*_REQUIRED, slip):
        if name not in names:
            raise missing_channel(path, name, names)
    wanted = [name for name in _COLUMNS if name in names]
    raw = read_csv(path, [slip, *wanted], Clock(column=names[0]))
    table = {name: values for name, (_, values) in raw.items()}
    good = np.all([np.isfinite(table[name]) for name in (slip, *_REQUIRED)], axis=0)
    table = {name: values[good] for name, values in table.items()}
    notes = [f"{int((~good).sum())} rows without a number left out"] if not good.all() else []
    si = {name: _in_si(path, name, table[name], units, notes) for name in wanted}
    return _rows(path, si, table[slip], slip, sae, notes)


def _rows(
    path: Path, si: dict[str, FloatArray], slip: FloatArray, slip_name: str, sae: bool, notes: list[str]
) -> RigData:
    count = len(slip)
    nothing = np.full(count, np.nan)
    load = si["FZ"]
    if np.median(load) < 0.0:
        load = -load
        notes.append("FZ is negative: the load is -FZ")
    slip, note = _slip_ratio(slip, slip_name, si["FX"], load)
    notes += [note] if note else []
    side = -1.0 if sae else 1.0
    angle, force_y = side * si["SA"], side * si["FY"]
    if float(np.mean(angle * force_y)) > 0.0:
        angle = -angle
        notes.append("a positive slip angle goes with a positive side force: the slip angle is turned round (ISO)")
    default_pressure = 2.2e5
    if "P" not in si:
        notes.append("no pressure (P): 2.2 bar assumed")
    camber, speed = si.get("IA", np.zeros(count)), si.get("V", np.full(count, 60.0 / 3.6))
    inputs = np.stack([slip, angle, camber, load, si.get("P", np.full(count, default_pressure)), speed], axis=1)
    moment = side * si["MZ"] if "MZ" in si else nothing
    measured = {"fx": si["FX"], "fy": force_y, "mx": si.get("MX", nothing), "mz": moment}
    driven = np.full(count, bool(np.percentile(np.abs(slip), 99) > _FREE_ROLLING))
    radius = float(np.polyfit(load, si["RL"], 1)[1]) if "RL" in si else 0.0
    return RigData(inputs, measured, driven, radius, [f"{path.name}: {note}" for note in notes])


def _slip_ratio(slip: FloatArray, name: str, force_x: FloatArray, load: FloatArray) -> tuple[FloatArray, str]:
    """Slip ratio; of columns in which -1 or a shifted zero stands for free rolling, a clear word."""
    if np.ptp(slip) < 0.05 and abs(float(np.median(slip)) + 1.0) < 0.05:
        return np.zeros_like(slip), f"{name} stays at -1, which stands for a freely rolling wheel: slip 0"
    if np.max(np.abs(slip)) > 3.0:
        slip = slip / 100.0
        return slip, f"{name} reaches {100.0 * np.max(np.abs(slip)):.0f}: taken as per cent"
    small = np.abs(slip) < 0.05
    if small.sum() > 50 and np.ptp(slip) > _FREE_ROLLING:
        slope, offset = np.polyfit(slip[small], force_x[small] / load[small], 1)
        if slope < 0.0:
            return -slip, f"a positive {name} goes with a negative FX: the slip ratio is turned round (ISO)"
        shift = -offset / slope
        if slope > 1.0 and abs(shift) > 0.01:
            return slip, (
                f"{name} is {shift:+.3f} where no force acts: it refers to another radius than that of free rolling "
                "(another column, e.g. SL, may be the slip ratio)"
            )
    return slip, ""


_JUDGED = {
    "SA": (("rad", 0.6), ("deg", np.inf)),
    "IA": (("rad", 0.3), ("deg", np.inf)),
    "P": (("bar", 15.0), ("psi", 60.0), ("kPa", 2000.0), ("Pa", np.inf)),
    "V": (("m/s", 35.0), ("km/h", np.inf)),
    "RL": (("m", 2.0), ("cm", 150.0), ("mm", np.inf)),
}
"""Units that a column may have, each up to the largest magnitude that is plausible in it."""


def _in_si(path: Path, name: str, values: FloatArray, units: dict[str, str], notes: list[str]) -> FloatArray:
    unit = units.get(name)
    if unit is None and name in _JUDGED:
        largest = float(np.nanpercentile(np.abs(values), 99.0))
        unit = next(unit for unit, limit in _JUDGED[name] if largest <= limit)
        notes.append(f"{name} up to {largest:.4g}: taken as {unit}")
    if unit is None:
        return values
    try:
        factor = to_si(f"1 {unit}", _COLUMNS[name])
    except QuantityError as error:
        raise InputError(f"{path}: unit of {name}: {error}") from None
    return values * factor
