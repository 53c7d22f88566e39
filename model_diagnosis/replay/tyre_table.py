"""The vehicle's own tyre as a short form that costs three dozen nanoseconds: fitted to it when a replay is made.

Shape: friction over its peak as a function of the slip over the slip at the peak, g(rho), one table for each direction
and axle, sampled from the compiled tyre of the plant at the wheel's static load (braking side along, mean of both sides
across). Load: peak friction and slip stiffness are linear in the load, fitted between 0.4 and 1.8 of the static load.
Combined slip: similarity, the force along the slip vector whose parts are divided by the slips at the peaks. For a
curve tyre with similarity this is the plant's tyre itself; for other formulas ``TyreForm.error`` tells how far.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.replay.record import CELLS
from model_diagnosis.replay.state import STATE_RECORD
from model_diagnosis.replay.tyre_step import tyre_forces
from vehicle_model.tyres.coefficients import SURFACE_FACTOR, SURFACE_SIZE, TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PREPARED_SIZE, across, along, prepare
from vehicle_model.tyres.tyre_file import AnyTyre

FloatArray = NDArray[np.float64]

_SPEED_M_S = 15.0
_LOADS = (0.4, 0.7, 1.0, 1.4, 1.8)
_SMALL_SLIP = 1e-4
_MONOTONE_SHARE = 0.98


@dataclass(frozen=True)
class Direction:
    """One direction of a tyre.

    Attributes
    ----------
    peak, peak_slip : peak friction and the slip at it, at the reference load
    load_loss, stiffness_loss : relative loss of peak friction and of stiffness per relative rise of the load
    table : (CELLS + 1, 2) friction over its peak, and its derivative by the table's variable times a cell's width
    """

    peak: float
    peak_slip: float
    load_loss: float
    stiffness_loss: float
    table: FloatArray


@dataclass(frozen=True)
class TyreForm:
    """Short form of one tyre.

    Attributes
    ----------
    reference_load : N
    friction_stiffens : exponent of the friction in the slip stiffness, 1 for curves, 0 for Magic Formula files
    error : largest difference of the force from the tyre's own over a grid of combined slips and loads, over the load
    """

    longitudinal: Direction
    lateral: Direction
    reference_load: float
    friction_stiffens: float
    error: float


class _Sampler:
    """Forces of the plant's compiled tyre."""

    def __init__(self, tyre: AnyTyre) -> None:
        self._row = np.zeros(TYRE_SIZE)
        write_tyre(tyre, self._row, right=False)
        self._surface = np.zeros(SURFACE_SIZE)
        self._surface[SURFACE_FACTOR] = 1.0
        self._prepared = np.zeros(PREPARED_SIZE)

    def forces(self, slip_x: float, slip_y: float, load: float, friction: float = 1.0) -> tuple[float, float]:
        prepare(self._row, self._surface, friction, load, _SPEED_M_S, 0.0, self._prepared)
        force_x, _ = along(self._row, self._prepared, slip_x, slip_y)
        force_y, _ = across(self._row, self._prepared, slip_x, slip_y, force_x)
        return force_x, force_y

    def braking(self, slip: float, load: float, friction: float = 1.0) -> float:
        return -self.forces(-slip, 0.0, load, friction)[0] / load

    def cornering(self, slip: float, load: float, friction: float = 1.0) -> float:
        left, right = self.forces(0.0, slip, load, friction)[1], self.forces(0.0, -slip, load, friction)[1]
        return 0.5 * (left - right) / load

    def aligning(self, slip: float, load: float) -> float:
        prepare(self._row, self._surface, 1.0, load, _SPEED_M_S, 0.0, self._prepared)
        return across(self._row, self._prepared, 0.0, slip, 0.0)[1]


def _peak(values: FloatArray, slips: FloatArray) -> tuple[float, float]:
    """Peak friction and its slip, refined by a parabola; a curve that never falls has it where it is nearly level."""
    best = int(np.argmax(values))
    if best >= len(slips) - 1:
        best = int(np.argmax(values >= _MONOTONE_SHARE * values[-1]))
        return float(values[best]), float(slips[best])
    curvature = np.polyfit(slips[best - 1 : best + 2] - slips[best], values[best - 1 : best + 2], 2)
    shift = -0.5 * curvature[1] / curvature[0]
    return float(np.polyval(curvature, shift)), float(slips[best] + shift)


def _direction(friction: "_Curve", load: float) -> Direction:
    slips = np.concatenate([np.geomspace(1e-3, 0.02, 60), np.linspace(0.0202, 1.0, 1500)])
    peak, peak_slip = _peak(np.array([friction(slip, load) for slip in slips]), slips)
    peaks, stiffness = [], []
    for share in _LOADS:
        near = np.linspace(0.3 * peak_slip, min(3.0 * peak_slip, 1.0), 200)
        peaks.append(_peak(np.array([friction(slip, share * load) for slip in near]), near)[0])
        stiffness.append(friction(_SMALL_SLIP, share * load))
    rise = np.array(_LOADS) - 1.0
    losses = [-float(rise @ (np.array(values) / values[2] - 1.0) / (rise @ rise)) for values in (peaks, stiffness)]
    return Direction(peak, peak_slip, losses[0], losses[1], _table(friction, load, peak, peak_slip))


def _table(friction: "_Curve", load: float, peak: float, peak_slip: float) -> FloatArray:
    grid = np.linspace(0.0, 1.0, CELLS + 1)
    values = np.empty(CELLS + 1)
    for k, variable in enumerate(grid):
        slip = min(variable / max(1.0 - variable, 1e-9) * peak_slip, 1.0)
        values[k] = friction(slip, load) / peak if k else 0.0
    slopes = np.gradient(values, edge_order=2)
    # exact at no slip: there the slope is the slip stiffness
    slopes[0] = friction(_SMALL_SLIP, load) / _SMALL_SLIP * peak_slip / peak / CELLS
    return np.stack([values, slopes], axis=1)


class _Curve:
    """Friction over slip in one direction."""

    def __init__(self, sampler: _Sampler, lateral: bool) -> None:
        self._evaluate = sampler.cornering if lateral else sampler.braking

    def __call__(self, slip: float, load: float, friction: float = 1.0) -> float:
        return self._evaluate(slip, load, friction)


def fit_tyre(tyre: AnyTyre, load: float) -> TyreForm:
    """Short form of a tyre at its wheel's static load [N]."""
    sampler = _Sampler(tyre)
    longitudinal, lateral = _Curve(sampler, lateral=False), _Curve(sampler, lateral=True)
    along_form, across_form = _direction(longitudinal, load), _direction(lateral, load)
    ratio = longitudinal(_SMALL_SLIP, load, 0.8) / longitudinal(_SMALL_SLIP, load, 1.0)
    stiffens = float(np.log(ratio) / np.log(0.8))
    form = TyreForm(along_form, across_form, load, stiffens, 0.0)
    return TyreForm(along_form, across_form, load, stiffens, _largest_error(form, sampler))


def trail_of(tyre: AnyTyre, load: float) -> float:
    """Pneumatic trail [m] at small slip."""
    sampler = _Sampler(tyre)
    return -sampler.aligning(1e-3, load) / (sampler.cornering(1e-3, load) * load)


def _largest_error(form: TyreForm, sampler: _Sampler) -> float:
    worst = 0.0
    for load in (0.6 * form.reference_load, form.reference_load, 1.4 * form.reference_load):
        for slip_x in (-1.0, -0.3, -0.1, -0.05, -0.02, 0.0):
            for slip_y in (0.0, 0.02, 0.06, 0.15):
                exact = np.array(sampler.forces(slip_x, slip_y, load))
                difference = np.array(short_forces(form, slip_x, slip_y, load)) - exact
                worst = max(worst, float(np.abs(difference).max()) / load)
    return worst


def short_forces(form: TyreForm, slip_x: float, slip_y: float, load: float) -> tuple[float, float]:
    """Forces [N] of the short form, as the compiled step computes them."""
    rise = load / form.reference_load - 1.0
    peaks, slips = [], []
    for direction in (form.longitudinal, form.lateral):
        friction = 1.0 - direction.load_loss * rise
        peaks.append(direction.peak * friction * load)
        slips.append(direction.peak_slip * friction / (1.0 - direction.stiffness_loss * rise))
    state = np.zeros(1, STATE_RECORD)
    state[0]["table"][0] = form.longitudinal.table, form.lateral.table
    force_x, force_y, _, _ = tyre_forces(state[0], 0, slip_x / slips[0], slip_y / slips[1], peaks[0], peaks[1])
    return float(force_x), float(force_y)
