"""Groups of Magic Formula coefficients in the order in which measurements determine them, with start and bounds.

The order is that of Pacejka 2012, section 4.3: pure slip at first, its change with load, camber and pressure, then
combined slip, then the moments. Bounds keep a curve that data do not determine a plausible tyre.
"""

from dataclasses import dataclass
from typing import Literal

Force = Literal["fx", "fy", "mx", "mz"]
Rows = Literal["straight", "cornering", "driven", "all if driven", "all"]


@dataclass(frozen=True)
class Stage:
    """Coefficients that become free; those of earlier stages of the same force stay free with them.

    Attributes
    ----------
    force
        What is compared.
    rows
        Measurements that tell: ``straight`` without slip angle, ``cornering`` without slip ratio, ``driven`` all rows
        of drive/brake tests, ``all``, and all of them provided that some are of drive/brake tests.
    coefficients
        Names of a ``.tir`` file.
    fresh : bool
        The coefficients of earlier stages are held from here on.
    """

    title: str
    force: Force
    rows: Rows
    coefficients: tuple[str, ...]
    fresh: bool = False


def _stage(title: str, force: Force, rows: Rows, names: str, *, fresh: bool = False) -> Stage:
    return Stage(title, force, rows, tuple(names.split()), fresh)


STAGES = (
    _stage("longitudinal", "fx", "straight", "PCX1 PDX1 PEX1 PKX1 PHX1 PVX1", fresh=True),
    _stage("longitudinal with load", "fx", "straight", "PDX2 PEX2 PEX3 PEX4 PKX2 PKX3 PHX2 PVX2"),
    _stage("longitudinal with camber and pressure", "fx", "straight", "PDX3 PPX1 PPX2 PPX3 PPX4"),
    _stage("longitudinal at slip angles", "fx", "all if driven", "RBX1 RBX2 RBX3 RCX1 REX1 REX2 RHX1", fresh=True),
    _stage("lateral", "fy", "cornering", "PCY1 PDY1 PEY1 PKY1 PKY2 PHY1 PVY1", fresh=True),
    _stage("lateral with load", "fy", "cornering", "PDY2 PEY2 PEY3 PHY2 PVY2 PKY4"),
    _stage("lateral with camber", "fy", "cornering", "PDY3 PEY4 PEY5 PKY3 PKY5 PKY6 PKY7 PVY3 PVY4"),
    _stage("lateral with pressure", "fy", "cornering", "PPY1 PPY2 PPY3 PPY4 PPY5"),
    _stage("lateral at slip ratios", "fy", "driven", "RBY1 RBY2 RBY3 RCY1 REY1 REY2 RHY1 RHY2", fresh=True),
    _stage("lateral at slip ratios with camber", "fy", "driven", "RBY4 RVY1 RVY2 RVY3 RVY4 RVY5 RVY6"),
    _stage("aligning", "mz", "cornering", "QBZ1 QCZ1 QDZ1 QEZ1 QHZ1 QDZ6 QBZ9 QBZ10", fresh=True),
    _stage("aligning with load", "mz", "cornering", "QBZ2 QBZ3 QDZ2 QEZ2 QEZ3 QEZ4 QHZ2 QDZ7"),
    _stage(
        "aligning with camber and pressure",
        "mz",
        "cornering",
        "QBZ4 QBZ5 QDZ3 QDZ4 QDZ8 QDZ9 QDZ10 QDZ11 QEZ5 QHZ3 QHZ4 PPZ1 PPZ2",
    ),
    _stage("aligning at slip ratios", "mz", "driven", "SSZ1 SSZ2 SSZ3 SSZ4", fresh=True),
    _stage("overturning", "mx", "all", "QSX1 QSX2 QSX3 PPMX1", fresh=True),
)

# start, lowest, highest
BOUNDS: dict[str, tuple[float, float, float]] = {
    "PCX1": (1.5, 1.05, 1.95),
    "PDX1": (1.2, 0.1, 4.0),
    "PEX1": (0.2, -5.0, 1.0),
    "PKX1": (25.0, 2.0, 150.0),
    "PCY1": (1.4, 1.05, 1.95),
    "PDY1": (1.2, 0.1, 4.0),
    "PEY1": (0.2, -5.0, 1.0),
    "PKY1": (-20.0, -150.0, -2.0),
    "PKY2": (1.5, 0.2, 10.0),
    "PKY4": (2.0, 1.0, 3.0),
    "RBX1": (12.0, 1.0, 100.0),
    "RBX2": (10.0, -60.0, 60.0),
    "RBX3": (0.0, -5e3, 5e3),
    "RCX1": (1.0, 0.5, 2.0),
    "RBY1": (10.0, 1.0, 100.0),
    "RBY2": (10.0, -60.0, 60.0),
    "RBY4": (0.0, -5e3, 5e3),
    "RCY1": (1.0, 0.5, 2.0),
    "RVY4": (10.0, 0.0, 100.0),
    "RVY5": (1.9, 0.5, 3.0),
    "RVY6": (10.0, 0.0, 60.0),
    "QBZ1": (8.0, 0.3, 60.0),
    "QCZ1": (1.2, 1.05, 2.0),
    "QDZ1": (0.12, 0.0, 0.6),
    "QEZ1": (-1.0, -20.0, 1.0),
    "QBZ9": (10.0, 0.0, 100.0),
    "QBZ10": (0.0, -20.0, 20.0),
}
_FAMILIES: tuple[tuple[str, float], ...] = (
    ("PHX PHY RHX RHY RBY3", 0.2),
    ("QHZ", 2.0),
    ("PVX PVY1 PVY2", 0.3),
    ("PVY3 PVY4 PDX2 PDY2 QDZ2 QDZ6 QDZ7 SSZ QSX1", 3.0),
    ("PEX PEY2 PEY3 REX REY QEZ2 QEZ3 QEZ4 PKX3 RVY", 10.0),
    ("PDX3 PDY3 PKY3 QDZ PKY6 PKY7 QSX PPMX PPX PPY PPZ QBZ", 40.0),
    ("PKX2 PEY PKY5 QEZ5", 100.0),
)


def bounds_of(name: str) -> tuple[float, float, float]:
    """Start, lowest and highest value of a coefficient; symmetric about 0 where the table gives only a family."""
    if name in BOUNDS:
        return BOUNDS[name]
    for family, size in _FAMILIES:
        if any(name.startswith(prefix) for prefix in family.split()):
            return 0.0, -size, size
    raise KeyError(name)
