"""Magic Formula 6.1 fitted to measurements of a rig: bounded, robust least squares, group by group of coefficients."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bench.tyre_bench.rig_data import INPUTS, MEASURED, FloatArray, RigData
from bench.tyre_bench.stages import STAGES, Stage, bounds_of
from signals.errors import InputError
from vehicle_model.tyres.magic_formula_tyre import MagicFormula61, MagicFormulaTyre
from vehicle_model.tyres.tir_file import TirFile
from vehicle_model.tyres.tyre import Limits

ROWS_PER_STAGE = 2500
"""Rows that every stage uses at most, drawn by chance."""

_STRAIGHT = 0.01
"""Slip angle [rad] below which a wheel counts as running straight."""

_OUTLIER = 0.15
"""Residual over the root mean square of the measured force from which a row counts less than its square."""

_PRIOR = 0.5
"""Weight of a coefficient's distance from its start, over its range: it decides only what the data do not."""

_COLUMN = {"fx": 0, "fy": 1, "mx": 2, "mz": 4}
_FEWEST_ROWS = 200

Progress = Callable[[str], None]


@dataclass
class Fit:
    """A fitted tyre.

    Attributes
    ----------
    tyre : MagicFormulaTyre
    stages : list of dict
        Title, force, rows, free coefficients and root mean square error after each stage.
    missing : list of str
        Stages for which there are no measurements; their coefficients keep usual values.
    at_bounds : list of str
        Coefficients that ended at a bound.
    """

    tyre: MagicFormulaTyre
    stages: list[dict[str, object]] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    at_bounds: list[str] = field(default_factory=list)


def fit_tyre(
    data: RigData,
    name: str,
    *,
    nominal_load: float | None = None,
    nominal_pressure: float | None = None,
    radius: float | None = None,
    seed: int = 0,
    rows_per_stage: int = ROWS_PER_STAGE,
    progress: Progress = lambda text: None,
) -> Fit:
    """Fit a tyre stage by stage.

    Parameters
    ----------
    data
        Measurements.
    name
        Name of the tyre.
    nominal_load, nominal_pressure, radius
        FNOMIN [N], NOMPRES [Pa], UNLOADED_RADIUS [m]; from the measurements where left out.
    seed, rows_per_stage
        Of the choice of rows; how many every stage uses at most.
    progress
        Called with a line for each stage.

    Raises
    ------
    InputError
        If there are too few rows, or no radius.
    """
    load = data.inputs[:, 3]
    if len(load) < _FEWEST_ROWS:
        raise InputError("too few measurements for a fit", found=f"{len(load)} rows", allowed=f"{_FEWEST_ROWS} or more")
    radius = radius or data.radius
    if not radius > 0.0:
        raise InputError("the measurements tell no radius", mend="give the unloaded radius: --radius 0.32")
    tir = TirFile(name)
    tir.numbers |= {
        "FNOMIN": nominal_load or float(np.round(np.percentile(load, 75.0), -1)),
        "NOMPRES": nominal_pressure or float(np.round(np.median(data.inputs[:, 4]), -3)),
        "UNLOADED_RADIUS": radius,
        "LONGVL": float(np.round(np.median(data.inputs[:, 5]), 2)),
    }
    tir.numbers |= {name: bounds_of(name)[0] for stage in STAGES for name in stage.coefficients}
    tir.texts["TYRESIDE"] = "LEFT"
    fit = Fit(MagicFormula61(tir, combined_slip="weights"))
    fit.tyre.limits = _limits(data)
    _run_stages(fit, data, np.random.default_rng(seed), rows_per_stage, progress)
    return fit


def _run_stages(fit: Fit, data: RigData, random: np.random.Generator, rows_per_stage: int, progress: Progress) -> None:
    free: list[str] = []
    for stage in STAGES:
        rows = rows_of(stage, data)
        if len(rows) < _FEWEST_ROWS:
            fit.missing.append(stage.title)
            continue
        free = [] if stage.fresh else free
        free += [name for name in stage.coefficients if _can_tell(name, data.inputs[rows])]
        if len(rows) > rows_per_stage:
            rows = np.sort(random.choice(rows, rows_per_stage, replace=False))
        error = _solve(fit, data.inputs[rows], data.measured[stage.force][rows], stage.force, free)
        fit.stages.append(
            {"stage": stage.title, "force": stage.force, "rows": len(rows), "free": len(free), "rms": error}
        )
        progress(f"{stage.title:<40} {len(free):>3} coefficients  rms {error:8.2f}")
    fit.at_bounds = sorted(set(fit.at_bounds))


def rows_of(stage: Stage, data: RigData) -> NDArray[np.intp]:
    """Rows of the measurements that tell a stage."""
    straight = np.abs(data.inputs[:, 1]) < _STRAIGHT
    chosen = {
        "straight": straight if data.driven.any() else data.driven,
        "cornering": ~data.driven,
        "driven": data.driven,
        "all": np.ones(len(straight), np.bool_),
        "all if driven": np.full(len(straight), data.driven.any()),
    }[stage.rows]
    return np.flatnonzero(chosen & np.isfinite(data.measured[stage.force]))


_NEEDS = {
    "inflation_pressure": ("PPX", "PPY", "PPZ", "PPMX"),
    "camber": (
        *("PDX3", "RBX3", "PDY3", "PEY4", "PEY5", "PKY3", "PKY5", "PKY6", "PKY7", "PVY3", "PVY4", "RBY4", "RVY3"),
        *("QBZ4", "QBZ5", "QDZ3", "QDZ4", "QDZ8", "QDZ9", "QDZ10", "QDZ11", "QEZ5", "QHZ3", "QHZ4", "SSZ3", "SSZ4"),
        *("QSX2", "PPMX"),
    ),
    "vertical_load": (
        *("PDX2", "PEX2", "PEX3", "PKX2", "PKX3", "PHX2", "PVX2", "REX2", "PDY2", "PEY2", "PKY2", "PKY4", "PHY2"),
        *("PVY2", "PVY4", "PKY7", "REY2", "RHY2", "RVY2", "QBZ2", "QBZ3", "QDZ2", "QEZ2", "QEZ3", "QHZ2", "QHZ4"),
        *("QDZ7", "QDZ9", "QDZ11", "SSZ4"),
    ),
}
_SPREAD = {"inflation_pressure": 5e3, "camber": 0.01, "vertical_load": 100.0}


def _can_tell(name: str, inputs: FloatArray) -> bool:
    """Whether the input that a coefficient belongs to changes in these rows."""
    for quantity, prefixes in _NEEDS.items():
        if any(name.startswith(prefix) for prefix in prefixes):
            values = inputs[:, INPUTS.index(quantity)]
            if float(np.percentile(values, 99.0) - np.percentile(values, 1.0)) < _SPREAD[quantity]:
                return False
    return True


def _solve(fit: Fit, inputs: FloatArray, measured: FloatArray, force: str, names: Sequence[str]) -> float:
    """Best values of the named coefficients; returns the root mean square error."""
    record = fit.tyre.record
    result = np.empty((len(inputs), 5))
    scale = max(float(np.sqrt(np.mean(measured**2))), 1e-9)
    table = np.array([bounds_of(name) for name in names])
    start, low, high = table.T
    size = high - low
    before = np.array([float(record[name][0]) for name in names])

    def write(values: FloatArray) -> None:
        for name, value in zip(names, values, strict=True):
            record[name] = value

    def residual(values: FloatArray) -> FloatArray:
        write(values)
        fit.tyre.evaluate(inputs, 1.0, False, result)
        return np.concatenate([(result[:, _COLUMN[force]] - measured) / scale, _PRIOR * (values - start) / size])

    inside = np.clip(before, low + 1e-6 * size, high - 1e-6 * size)
    solution = least_squares(
        residual,
        inside,
        bounds=(low, high),
        x_scale=0.1 * size,
        loss="soft_l1",
        f_scale=_OUTLIER,
        max_nfev=40,
        ftol=1e-5,
    )
    write(solution.x)
    fit.at_bounds += [name for name, side in zip(names, solution.active_mask, strict=True) if side != 0]
    fit.tyre.evaluate(inputs, 1.0, False, result)
    return float(np.sqrt(np.mean((result[:, _COLUMN[force]] - measured) ** 2)))


def _limits(data: RigData) -> Limits:
    """Ranges of the inputs in the measurements."""
    ranges = {}
    for place, quantity in enumerate(INPUTS[:5]):
        low, high = float(data.inputs[:, place].min()), float(data.inputs[:, place].max())
        ranges[quantity] = (low, high)
    return Limits(ranges)


def errors_of(tyre: MagicFormulaTyre, data: RigData) -> dict[str, dict[str, float]]:
    """Root mean square errors of a tyre on measurements: by kind of test (``driven``, ``cornering``), then by force."""
    result = np.empty((len(data.inputs), 5))
    tyre.evaluate(data.inputs, 1.0, False, result)
    errors: dict[str, dict[str, float]] = {}
    for kind, rows in (("driven", data.driven), ("cornering", ~data.driven)):
        by_force = {}
        for force in MEASURED:
            chosen = rows & np.isfinite(data.measured[force])
            if chosen.any():
                off = result[chosen, _COLUMN[force]] - data.measured[force][chosen]
                by_force[force] = float(np.sqrt(np.mean(off**2)))
        if by_force:
            errors[kind] = by_force
    return errors
