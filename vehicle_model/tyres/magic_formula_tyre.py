"""Tyres of the Magic Formula with the coefficients of a ``.tir`` file."""

import math
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.errors import unknown_name
from vehicle_model.plant_record import Record
from vehicle_model.tyres.magic_formula_coefficients import COEFFICIENT_RECORD, coefficients
from vehicle_model.tyres.magic_formula_forces import (
    aligning_moment,
    ellipse_forces,
    overturning_moment,
    plane_forces,
    rolling_moment,
)
from vehicle_model.tyres.magic_formula_record import (
    DEVIATIONS,
    FIELDS,
    SCALING,
    TIR_RECORD,
    VERSION_52,
    VERSION_61,
    VERSION_62,
)
from vehicle_model.tyres.relaxation import lengths_of_6x, lengths_of_52
from vehicle_model.tyres.tir_check import read_checked, version_of
from vehicle_model.tyres.tir_file import TirFile
from vehicle_model.tyres.tyre import Limits, Tyre

CombinedSlip = Literal["auto", "weights", "ellipse"]

LIMIT_NAMES = {
    "slip_ratio": ("KPUMIN", "KPUMAX"),
    "slip_angle": ("ALPMIN", "ALPMAX"),
    "camber": ("CAMMIN", "CAMMAX"),
    "vertical_load": ("FZMIN", "FZMAX"),
    "inflation_pressure": ("PRESMIN", "PRESMAX"),
}
"""Names in a ``.tir`` file of the range of each input."""


@njit(cache=True)
def _evaluate(
    p: Record,
    c: Record,
    inputs: NDArray[np.float64],
    friction: float,
    ellipse: bool,
    mirrored: bool,
    forces: NDArray[np.float64],
) -> None:
    """Rows of (slip ratio, slip angle, camber, load, pressure, speed) to rows of (Fx, Fy, Mx, My, Mz)."""
    side = -1.0 if mirrored else 1.0
    for k in range(inputs.shape[0]):
        kappa, angle, camber = inputs[k, 0], side * inputs[k, 1], side * inputs[k, 2]
        load, pressure, speed = inputs[k, 3], inputs[k, 4], inputs[k, 5]
        if load <= 0.0:
            forces[k, :] = 0.0
            continue
        direction = -1.0 if speed < 0.0 else 1.0
        alpha = direction * (angle if p.VERSION == VERSION_52 else math.tan(angle))  # 4.E3
        coefficients(p, c, load, camber, pressure, friction)
        if ellipse:
            force_x, force_y = ellipse_forces(p, c, kappa, alpha, angle)
        else:
            force_x, force_y = plane_forces(p, c, kappa, alpha, angle)
        forces[k, 0] = force_x
        forces[k, 1] = side * force_y
        forces[k, 2] = side * overturning_moment(p, load, camber, pressure, force_y)
        forces[k, 3] = rolling_moment(p, load, camber, pressure, speed, force_x)
        forces[k, 4] = side * direction * aligning_moment(p, c, kappa, alpha, angle, force_x, force_y)


class MagicFormulaTyre(Tyre):
    """A tyre of the Magic Formula; its subclasses are the versions.

    Parameters
    ----------
    tir : TirFile
        Coefficients; see ``read_tir``.
    combined_slip : {"auto", "weights", "ellipse"}
        The formula's own weights, or a friction ellipse; "auto" takes the ellipse where a file has no weights.
    deviations : sequence of str
        Departures of another program from the book that shall be reproduced (``DEVIATIONS``).
    scale : mapping, optional
        Scale factors (LMUX, LKY, …) that replace those of the file.

    Raises
    ------
    InputError
        If a deviation or a scale factor is unknown.
    """

    version: ClassVar[float]

    def __init__(
        self,
        tir: TirFile,
        *,
        combined_slip: CombinedSlip = "auto",
        deviations: tuple[str, ...] = (),
        scale: dict[str, float] | None = None,
    ) -> None:
        self.name = Path(tir.path).stem
        self.record = np.zeros(1, TIR_RECORD)
        self._coefficients = np.zeros(1, COEFFICIENT_RECORD)
        self.measured_side = tir.texts.get("TYRESIDE", "UNKNOWN").upper()
        self._fill(tir, deviations, scale or {})
        has_weights = any(tir.numbers.get(name, 0.0) != 0.0 for name in ("RBX1", "RBY1"))
        self.uses_ellipse = combined_slip == "ellipse" or (combined_slip == "auto" and not has_weights)
        self.limits = _limits(tir)

    def _fill(self, tir: TirFile, deviations: tuple[str, ...], scale: dict[str, float]) -> None:
        p = self.record[0]
        for name in SCALING:
            p[name] = 1.0
        p["PKY4"], p["LONGVL"] = 2.0, 10.0
        values = tir.numbers
        for name, value in values.items():
            if name in FIELDS:
                p[name] = value
        for name, value in scale.items():
            if name not in SCALING:
                raise unknown_name("scale factor", name, SCALING)
            p[name] = value
        if "LIP" in values:
            p["NOMPRES"] *= values["LIP"]
        p["VERSION"] = self.version
        if p["INFLPRES"] <= 0.0:
            p["INFLPRES"] = p["NOMPRES"]
        for name in deviations:
            if name not in DEVIATIONS:
                raise unknown_name("deviation", name, DEVIATIONS)
            p[name] = 1.0

    @property
    def reference(self) -> tuple[float, float]:
        """Inflation pressure [Pa] and speed [m/s] of the file."""
        return float(self.record["INFLPRES"][0]), float(self.record["LONGVL"][0])

    def evaluate(
        self, inputs: NDArray[np.float64], friction: float, mirrored: bool, forces: NDArray[np.float64]
    ) -> None:
        """Forces and moments row by row (see ``Tyre.evaluate``)."""
        _evaluate(self.record[0], self._coefficients[0], inputs, friction, self.uses_ellipse, mirrored, forces)

    def stiffnesses(self, vertical_load: float, inflation_pressure: float | None = None) -> tuple[float, float]:
        """Slopes of the pure curves at zero slip: dFx/dslip ratio [N] and dFy/dslip angle [N/rad]."""
        pressure = float(self.record["INFLPRES"][0]) if inflation_pressure is None else inflation_pressure
        c = self._coefficients[0]
        coefficients(self.record[0], c, vertical_load, 0.0, pressure, 1.0)
        return float(c["stiffness_x"]), float(c["stiffness_y"])

    def relaxation_lengths(self, vertical_load: float, inflation_pressure: float | None = None) -> tuple[float, float]:
        """Longitudinal and lateral relaxation length [m] at a load; 0 where the file tells nothing.

        5.2: PTX, PTY; 6.x: slip stiffness over the carcass stiffness (Pacejka 2012, 7.7 with PCFX, PCFY).
        """

        def p(name: str) -> float:
            return float(self.record[name][0])

        if self.version == VERSION_52:
            return lengths_of_52(p, vertical_load)
        pressure = p("INFLPRES") if inflation_pressure is None else inflation_pressure
        return lengths_of_6x(p, vertical_load, pressure, *self.stiffnesses(vertical_load, pressure))


class MagicFormula52(MagicFormulaTyre):
    """Magic Formula 5.2 (Pacejka 2006; the PAC2002 tyre of Adams is the same but for its pressure terms)."""

    version = VERSION_52


class MagicFormula61(MagicFormulaTyre):
    """Magic Formula 6.1 (Pacejka 2012), turn slip off."""

    version = VERSION_61


class MagicFormula62(MagicFormulaTyre):
    """Magic Formula 6.2: 6.1 with more terms in the overturning moment."""

    version = VERSION_62


_KINDS: dict[float, type[MagicFormulaTyre]] = {
    VERSION_52: MagicFormula52,
    VERSION_61: MagicFormula61,
    VERSION_62: MagicFormula62,
}


def _limits(tir: TirFile) -> Limits:
    ranges, places = {}, {}
    for quantity, (low, high) in LIMIT_NAMES.items():
        at_least, at_most = tir.numbers.get(low, -math.inf), tir.numbers.get(high, math.inf)
        ranges[quantity] = (at_least, at_most) if at_least < at_most else (-math.inf, math.inf)
        lines = [
            f"{name} in line {tir.lines[name]}" for name in (low, high) if name in tir.numbers and name in tir.lines
        ]
        if lines:
            places[quantity] = f"{tir.path}: {', '.join(lines)}"
    return Limits(ranges, places)


def read_tir(
    path: str | Path,
    *,
    combined_slip: CombinedSlip = "auto",
    deviations: tuple[str, ...] = (),
    scale: dict[str, float] | None = None,
) -> MagicFormulaTyre:
    """Read a ``.tir`` file of Magic Formula 5.2, 6.1 or 6.2 or of PAC2002 into a tyre.

    Parameters
    ----------
    path
        The file; SI units.
    combined_slip, deviations, scale
        See ``MagicFormulaTyre``.

    Raises
    ------
    InputError
        If the file cannot be read, is of another formula, lacks coefficients or has absurd ones.
    """
    tir = read_checked(path)
    kind = _KINDS[version_of(tir)]
    return kind(tir, combined_slip=combined_slip, deviations=deviations, scale=scale)
