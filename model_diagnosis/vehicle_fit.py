"""Calibrates a vehicle on logs of a healthy car, so that a diagnosis of this car starts from it and not from its type.

Every parameter of the car may be off by its stated scatter, nothing else: the base fit of the diagnosis (model
discrepancy anchor, section 3.4). What the logs say of a parameter takes the place of the file's value, and what they
leave open that of its scatter.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from threadpoolctl import threadpool_limits

from model_diagnosis.data.checks import check_data
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.extension.car_change import change_of, is_of_the_car
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import ReplayBase
from model_diagnosis.replay.choosing import replay_class
from model_diagnosis.result import DataFault
from vehicle_model.vehicle_file import Scatter, VehicleFile

INFORMED = 0.7
"""A parameter is calibrated where the logs leave at most this share of its scatter open."""
LEAST_SCATTER = 0.25
"""Share of the stated scatter that always stays: a fit knows its own noise, not what the model leaves out."""
FAR_OFF = 3.0
INTERVAL_STDS = 1.645
FAILURES = frozenset({"circuit_failure"})
"""No properties of a healthy car, whatever the fit says of them."""


@dataclass(frozen=True)
class Calibrated:
    """One parameter of the car.

    Attributes
    ----------
    effect : of the catalogue that changes it
    values : dotted path -> value, SI units
    nominal : dotted path -> value of the file that the fit began with
    low, high : dotted path -> ends of the 90 % interval
    scatters_off : how far it is from the file, in stated scatters
    scatter : what is left, relative to the value where ``relative``, else in its unit
    """

    effect: str
    values: dict[str, float]
    nominal: dict[str, float]
    low: dict[str, float]
    high: dict[str, float]
    scatters_off: float
    scatter: Scatter


@dataclass(frozen=True)
class VehicleFit:
    """Calibrated parameters, the most informed first, and what was noticed.

    Attributes
    ----------
    misfit : signal -> root mean squared residual over the sensor's noise, by the file and by the fit
    far_off : effects whose parameter is more than three scatters off: the car may not be healthy
    """

    calibrated: list[Calibrated]
    misfit: dict[str, tuple[float, float]]
    faults: list[DataFault]

    @property
    def far_off(self) -> list[str]:
        """Effects whose parameter is more than three scatters off."""
        return [one.effect for one in self.calibrated if abs(one.scatters_off) > FAR_OFF]


def fit_vehicle(
    manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, progress: Callable[[str, float], None] | None = None
) -> VehicleFit:
    """Calibrate a vehicle on manoeuvres of a healthy car.

    Raises
    ------
    InputError
        If nothing of the data can be compared with a replay.
    """
    model = replay_class(manoeuvres)
    with threadpool_limits(1, user_api="blas"):  # replays share the processors already
        faults, repaired = check_data(manoeuvres, vehicle, model)
        replay = model(vehicle, repaired)
        base = fit_base(replay, Priors.of(replay.parameters, in_common=False), progress)
    problem, theta = base.problem, base.nothing.theta
    quadratic = problem.quadratic(base.at_nothing, problem.rows(theta), theta)
    _, covariance = quadratic.posterior(ratios(problem, ()))
    left = problem.scale * np.sqrt(np.diag(covariance))
    calibrated = []
    for column, parameter in enumerate(replay.parameters):
        effect, stated = replay.effects[replay.owner[column]], parameter.nuisance_std
        informed = stated > 0.0 and left[column] <= INFORMED * stated
        healthy = not effect.discrete and effect.name not in FAILURES
        if informed and healthy and parameter.vehicle_path and is_of_the_car(effect):
            open_std = max(float(left[column]), LEAST_SCATTER * stated)
            calibrated.append(_calibrated(vehicle, replay, column, float(theta[column]), open_std, stated))
    calibrated.sort(key=lambda one: -abs(one.scatters_off))
    return VehicleFit(calibrated, _misfit(replay, theta), faults)


def _calibrated(
    vehicle: VehicleFile, replay: ReplayBase, column: int, deviation: float, left: float, stated: float
) -> Calibrated:
    parameter, effect = replay.parameters[column], replay.effects[replay.owner[column]]
    reach = INTERVAL_STDS * left
    at = {
        shift: dict(change_of(vehicle, effect, {parameter.name: deviation + shift}).parameters)
        for shift in (-reach, 0.0, reach)
    }
    numbers = vehicle.numbers(parameter.vehicle_path.partition(".")[0])
    nominal = {path: value for path, value in numbers.items() if fnmatchcase(path, parameter.vehicle_path)}
    values = at[0.0] or nominal
    return Calibrated(
        effect=effect.name,
        values=values,
        nominal={path: numbers[path] for path in values},
        low={path: min(at[-reach].get(path, value), at[reach].get(path, value)) for path, value in values.items()},
        high={path: max(at[-reach].get(path, value), at[reach].get(path, value)) for path, value in values.items()},
        scatters_off=deviation / stated,
        scatter=Scatter(std=left, kind="relative" if parameter.relative else "absolute"),
    )


def _misfit(replay: ReplayBase, theta: np.ndarray) -> dict[str, tuple[float, float]]:
    sums: dict[str, list[float]] = {}
    weights = replay.weights()
    for place, deviations in enumerate((np.zeros(len(replay.columns)), theta)):
        for number, residual in enumerate(replay.residuals(deviations)):
            for column, signal in enumerate(replay.signals(number)):
                entry = sums.setdefault(signal, [0.0, 0.0, 0.0])
                entry[place] += float(np.sum(residual[:, column] ** 2))
                entry[2] += float(np.sum(weights[number][:, column] > 0.0)) if place == 0 else 0.0
    return {
        signal: (
            float(np.sqrt(before / max(count, 1.0))) / replay.sensor_std(signal),
            float(np.sqrt(after / max(count, 1.0))) / replay.sensor_std(signal),
        )
        for signal, (before, after, count) in sums.items()
    }
