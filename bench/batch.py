"""Many cars through one scenario, on all cores.

>>> import bench.batch
>>> cars = bench.batch.varied_cars("stops/dry", 64, {"body.mass": "5 %", "brakes.front.pad_friction": "10 %"}, seed=1)
>>> result = bench.batch.run_batch(cars)  # in a script: below `if __name__ == "__main__":`
>>> result.rows[0].metrics["stopping_distance_m"], result.real_time_factor

Each car is a resolved scenario of its own with other overrides, so that a single row can be run again as it was.
"""

import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.api import Run
from bench.execution.job import DONE, RunRow, job_of
from bench.execution.pool import WorkerPool
from bench.scenario.documents import Sets
from bench.scenario.resolution import resolve
from bench.scenario.schema import ScenarioFile
from signals.errors import InputError, unknown_name
from signals.quantities import QuantityError, range_text, to_si
from vehicle_model.parameters import ParameterInfo, set_parameter
from vehicle_model.road_file import road_parameter_table
from vehicle_model.vehicle_file import Scatter, load_vehicle, parameter_table

PURPOSE = 7201
"""Second word of the seeds, so that no other purpose draws the same numbers."""
_MOST_DRAWS = 100


@dataclass(frozen=True)
class BatchResult:
    """What a batch gave.

    Attributes
    ----------
    rows : tuple of RunRow
        In the order of the scenarios.
    workers : int
    wall_s : float
        From the first job to the last row, without the start of the workers.
    start_s : float
        Start of the workers: processes, imports, compiled code.
    """

    rows: tuple[RunRow, ...]
    workers: int
    wall_s: float
    start_s: float

    @property
    def simulated_s(self) -> float:
        """Time that passed in all runs together."""
        return sum(float(row.observations.get("simulated_s", 0.0)) for row in self.rows)

    @property
    def real_time_factor(self) -> float:
        """Simulated time over the time that the batch took."""
        return self.simulated_s / self.wall_s if self.wall_s > 0.0 else 0.0

    @property
    def runs_per_hour(self) -> float:
        """Runs in an hour at the batch's pace."""
        return 3600.0 * len(self.rows) / self.wall_s if self.wall_s > 0.0 else 0.0

    def figures(self) -> dict[str, tuple[float, float, float, float]]:
        """Mean, standard deviation, smallest and largest of each metric that is a number, over the runs that ended."""
        values: dict[str, list[float]] = {}
        for row in self.rows:
            for name, value in row.metrics.items() if row.outcome == DONE else ():
                if isinstance(value, (int, float)):
                    values.setdefault(name, []).append(float(value))
        return {
            name: (
                float(np.mean(found)),
                float(np.std(found, ddof=1)) if len(found) > 1 else 0.0,
                float(np.min(found)),
                float(np.max(found)),
            )
            for name, found in values.items()
        }


def varied_cars(
    scenario: str | Path,
    count: int,
    scatter: Mapping[str, float | str] | None = None,
    *,
    seed: int = 1,
    vehicles: Sequence[str] = (),
    sets: Sets = (),
) -> list[ScenarioFile]:
    """Scenarios of ``count`` cars that differ as series cars do.

    Parameters
    ----------
    scenario
        Path or id.
    scatter : mapping, optional
        Dotted path of car or road → standard deviation of a normal distribution: ``"5 %"`` of the value, or a number
        or text with a unit. On top of what the vehicle file declares in its section ``scatter``. A value outside the
        parameter's range is drawn again.
    vehicles
        Cars to take in turn; by default the scenario's.
    sets
        Changes that all cars have, as for ``--set``.

    Raises
    ------
    InputError
        If the scenario has faults, there is no such parameter, or a deviation is no number of its dimension.
    """
    if count < 1:
        raise InputError(f"{count} cars", allowed="at least 1")
    bases = [resolve(scenario, sets, vehicle=vehicle) for vehicle in vehicles] or [resolve(scenario, sets)]
    drawn = [_Draws(base, scatter or {}, seed, count) for base in bases]
    cars = []
    for number in range(count):
        base, draws = bases[number % len(bases)], drawn[number % len(bases)]
        values = {path: float(column[number]) for path, column in draws.values.items()}
        of_the_car = {path: value for path, value in values.items() if not path.startswith("road.")}
        road = base.road.model_copy(deep=True)
        for path in values.keys() - of_the_car.keys():
            set_parameter(road, path, values[path], "road.")
        update = {"overrides": {**base.overrides, **of_the_car}, "road": road, "seed": base.seed + number}
        cars.append(base.model_copy(update=update))
    return cars


class _Draws:
    """Values of every parameter that scatters, one per car."""

    def __init__(self, base: ScenarioFile, scatter: Mapping[str, float | str], seed: int, count: int) -> None:
        vehicle = load_vehicle(base.vehicle)
        known = {info.path: info for info in (*parameter_table(vehicle), *road_parameter_table(base.road))}
        deviations = {path: _declared(known, path, entry) for path, entry in vehicle.scatter.items()}
        deviations |= {path: _deviation(known, path, given) for path, given in scatter.items()}
        self.values = {}
        for path, deviation in deviations.items():
            centre = float(base.overrides.get(path, known[path].value))
            # a generator per parameter: another parameter beside it leaves its numbers as they are
            generator = np.random.default_rng([seed, PURPOSE, zlib.crc32(path.encode())])
            self.values[path] = _draw(generator, centre, deviation, known[path], count)


def _known(known: Mapping[str, ParameterInfo], path: str) -> ParameterInfo:
    if path not in known:
        raise unknown_name("parameter", path, tuple(known))
    return known[path]


def _declared(known: Mapping[str, ParameterInfo], path: str, entry: Scatter) -> float:
    info = _known(known, path)
    return entry.std * abs(info.value) if entry.kind == "relative" else entry.std


def _deviation(known: Mapping[str, ParameterInfo], path: str, given: float | str) -> float:
    info = _known(known, path)
    relative = isinstance(given, str) and given.strip().endswith("%")
    try:
        number = to_si(given, "1" if relative else info.unit)
    except QuantityError as error:
        raise InputError(f"scatter of {path}: {error}") from None
    if number < 0.0:
        raise InputError(f"scatter of {path}", found=str(given), allowed="not negative")
    return number * abs(info.value) if relative else number


def _draw(
    generator: np.random.Generator, centre: float, deviation: float, info: ParameterInfo, count: int
) -> "np.typing.NDArray[np.float64]":
    low = -np.inf if info.low is None else info.low
    high = np.inf if info.high is None else info.high
    values = generator.normal(centre, deviation, count)
    for _ in range(_MOST_DRAWS):
        outside = (values < low) | (values > high)
        if not outside.any():
            return np.asarray(values)
        values[outside] = generator.normal(centre, deviation, int(outside.sum()))
    raise InputError(
        f"scatter of {info.path}: nearly all values are out of range",
        found=f"{centre:g} ± {deviation:g}",
        allowed=range_text(info.unit, info.low, info.high),
    )


def run_batch(
    scenarios: Sequence[ScenarioFile],
    *,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> BatchResult:
    """Run scenarios in warm worker processes.

    Parameters
    ----------
    workers : int, optional
        By default one per core that this process may use.
    progress : callable, optional
        Receives the number of runs that are done and that of all.
    """
    jobs = [job_of(scenario, key=str(number)) for number, scenario in enumerate(scenarios)]
    if not jobs:
        return BatchResult((), workers or 0, 0.0, 0.0)
    rows: dict[str, RunRow] = {}
    began = time.perf_counter()
    with WorkerPool(workers, jobs[0], observe=_observe) as pool:
        pool.start()
        started = time.perf_counter()
        for row in pool.run(jobs):
            rows[row.key] = row
            if progress is not None:
                progress(len(rows), len(jobs))
        ended = time.perf_counter()
        used = pool.workers
    return BatchResult(tuple(rows[job.key] for job in jobs), used, ended - started, started - began)


def _observe(run: Run) -> dict[str, Any]:
    return {"simulated_s": float(run.data.time[-1]) if len(run.data.time) else 0.0}


def row_table(scenarios: Sequence[ScenarioFile], rows: Sequence[RunRow]) -> list[dict[str, Any]]:
    """A flat mapping per run: what was varied, the verdict, and every metric that is one number."""
    settings = [{**scenario.overrides, **scenario.road.numbers()} for scenario in scenarios]
    varied = sorted({path for values in settings for path, value in values.items() if value != settings[0].get(path)})
    table = []
    for scenario, values, row in zip(scenarios, settings, rows, strict=True):
        entry: dict[str, Any] = {
            "car": row.key,
            "scenario": row.scenario,
            "vehicle": Path(scenario.vehicle).stem,
            "seed": row.seed,
            "scenario_hash": row.scenario_hash,
            "outcome": row.outcome,
            "verdict": row.verdict,
            "reason": row.reason,
        }
        entry |= {path: values.get(path) for path in varied}
        entry |= {name: value for name, value in row.metrics.items() if isinstance(value, (int, float))}
        table.append(entry)
    return table
