"""Tyres of a tyre file behind the interface of ``Tyre``, evaluated by the very functions of the compiled plant."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.errors import InputError
from vehicle_model.tyres.coefficients import (
    SURFACE_FACTOR,
    SURFACE_SIZE,
    TYRE_SIZE,
    tir_tyre,
    write_tyre,
)
from vehicle_model.tyres.kernel import PREPARED_SIZE, across, along, prepare
from vehicle_model.tyres.tyre import Limits, Tyre
from vehicle_model.tyres.tyre_file import AnyTyre, TirTyre

_REFERENCE_SPEED = 60.0 / 3.6
_PRESSURE = 2.2e5


@njit(cache=True)
def _evaluate(
    row: NDArray[np.float64],
    surface: NDArray[np.float64],
    inputs: NDArray[np.float64],
    friction: float,
    prepared: NDArray[np.float64],
    forces: NDArray[np.float64],
) -> None:
    for k in range(inputs.shape[0]):
        kappa, load, speed = inputs[k, 0], inputs[k, 3], inputs[k, 5]
        forces[k, :] = 0.0
        if load <= 0.0:
            continue
        direction = -1.0 if speed < 0.0 else 1.0
        # slip S5 refers to the faster of rolling and travelling speed
        faster = 1.0 + abs(kappa) if kappa * direction > 0.0 else 1.0
        slip_x, slip_y = kappa / faster, -direction * math.tan(inputs[k, 1]) / faster
        prepare(row, surface, friction, load, speed, inputs[k, 2], prepared)
        force_x, _ = along(row, prepared, slip_x, slip_y)
        force_y, moment = across(row, prepared, slip_x, slip_y, force_x)
        forces[k, 0], forces[k, 1], forces[k, 4] = force_x, force_y, moment


class FormulaTyre(Tyre):
    """A tyre given by friction curves or by one of the formulas of a tyre file.

    Camber and pressure have no effect: these formulas do not know them. The speed acts where friction depends on it
    (full Burckhardt, Dugoff, LuGre); overturning and rolling moments are zero. Nothing is measured, so there are no
    limits.

    Parameters
    ----------
    tyre : file model
        Any but ``TirTyre`` (see ``tyre_of``).
    """

    def __init__(self, tyre: AnyTyre, name: str) -> None:
        if isinstance(tyre, TirTyre):
            raise InputError(f"{name}: a .tir file", mend="read it with vehicle_model.tyres.read_tir")
        self.name = name
        self.limits = Limits({})
        self._row, self._prepared = np.zeros(TYRE_SIZE), np.zeros(PREPARED_SIZE)
        self._surface = np.zeros(SURFACE_SIZE)
        self._surface[SURFACE_FACTOR] = 1.0
        write_tyre(tyre, self._row, right=False)

    @property
    def reference(self) -> tuple[float, float]:
        """A usual pressure, which has no effect, and 60 km/h."""
        return _PRESSURE, _REFERENCE_SPEED

    def evaluate(
        self, inputs: NDArray[np.float64], friction: float, mirrored: bool, forces: NDArray[np.float64]
    ) -> None:
        """Forces and moments row by row; these tyres are the same on both sides of the car."""
        _evaluate(self._row, self._surface, inputs, friction, self._prepared, forces)


def tyre_of(tyre: AnyTyre, name: str) -> Tyre:
    """The tyre of any entry of a tyre file; InputError if its ``.tir`` file is bad."""
    return tir_tyre(tyre) if isinstance(tyre, TirTyre) else FormulaTyre(tyre, name)
