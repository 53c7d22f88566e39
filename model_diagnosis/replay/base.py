"""What the replays of a car and of a wheel on a rig share: columns, numbers of the car by deviation, residuals."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.conditions import CONDITIONS
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.processors import threads_here
from model_diagnosis.replay.columns import Columns
from model_diagnosis.replay.derived import derive
from model_diagnosis.replay.deviations import RECORD_COLUMNS, change_record
from model_diagnosis.replay.inputs import SLOWEST_M_S, reference_speed
from model_diagnosis.replay.limit import NEAR_SHARE, used_share
from model_diagnosis.replay.nominal import NominalCar
from model_diagnosis.replay.parameters import nominal_value, values_of
from model_diagnosis.replay.sensors import own_noise
from model_diagnosis.replay.tyre_shape import shaped_tables
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

STEP_SHARE = 0.001
"""Step of a finite difference over the effect's width: a replay is smooth, and of the residuals that a wrong form
leaves, even a slope that is a few percent off promises what no step holds."""

_CARS_KEPT = 512
_OF_THE_CAR = RECORD_COLUMNS.difference(CONDITIONS)
"""Columns of the record that are the same in all manoeuvres; nothing is derived from the others."""


class PreparedData(Protocol):
    """What every replay keeps of a manoeuvre."""

    @property
    def signals(self) -> tuple[str, ...]:
        """Compared signals, the columns of the arrays."""

    @property
    def measured(self) -> FloatArray:
        """(n, c)."""

    @property
    def weights(self) -> FloatArray:
        """(n, c), 0 where a sample counts for nothing."""


class ReplayBase(ABC):
    """Replay of manoeuvres by numbers of a vehicle file that deviations change.

    Attributes
    ----------
    columns : (p) names ``<effect>.<parameter>``, then those of single manoeuvres
    parameters : (p) of the columns, bounds and scatter as for this vehicle
    owner : (p,) index into ``effects``
    prepared : what stays the same of each manoeuvre
    car : the vehicle without deviations
    mapped : ``map``, by threads where there are several; not to be called from within
    """

    prepared: Sequence[PreparedData]

    def __init__(
        self,
        vehicle: VehicleFile,
        manoeuvres: Sequence[Manoeuvre],
        columns: Columns,
        car: NominalCar,
        threads: int | None = None,
    ) -> None:
        self.vehicle = vehicle
        self.manoeuvres = tuple(manoeuvres)
        self.car = car
        self._values = values_of(vehicle)
        self._set_columns(columns)
        threads = threads or threads_here()
        self.mapped: Callable[..., Iterable[Any]] = ThreadPoolExecutor(threads).map if threads > 1 else map
        # every manoeuvre of a sweep asks for the same cars
        self._cars = lru_cache(maxsize=_CARS_KEPT)(self._make_car)
        self._tables = lru_cache(maxsize=_CARS_KEPT)(self._make_tables)

    @abstractmethod
    def predict(self, theta: FloatArray, m: int) -> FloatArray:
        """Prediction (n, c) of each sample of manoeuvre ``m`` from those before it."""

    @abstractmethod
    def free_run(self, theta: FloatArray, m: int, horizon_s: float | None = None) -> FloatArray:
        """Run (n, c) without corrections; with ``horizon_s`` it restarts so often at what was measured."""

    @abstractmethod
    def states(self, theta: FloatArray, m: int) -> dict[str, FloatArray]:
        """States over which residuals are looked at, name -> (n,)."""

    @abstractmethod
    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        """Derivatives of the prediction by the deviations, (n, c, len(columns)) of each manoeuvre."""

    @abstractmethod
    def corrections(self, m: int) -> FloatArray:
        """(c, k) change of each of k states of an observer by one unit of each compared signal's residual."""

    def _set_columns(self, columns: Columns) -> None:
        self._columns, self.effects, self.columns = columns, columns.effects, columns.names
        self.parameters, self.owner = columns.parameters, columns.owner

    @property
    def tyre_error(self) -> tuple[float, float]:
        """Largest difference of the replay's tyre force from the vehicle's tyre over the load, front and rear."""
        return self.car.tyre_error

    def signals(self, m: int) -> tuple[str, ...]:
        """Compared signals of manoeuvre ``m``, the columns of its arrays."""
        return self.prepared[m].signals

    def weights(self) -> list[FloatArray]:
        """Weights (n, c) of each manoeuvre: 0 where a sample is missing, below 4 m/s, or says nothing."""
        return [prepared.weights for prepared in self.prepared]

    def measured(self, m: int) -> FloatArray:
        """Measured signals (n, c) of manoeuvre ``m``."""
        return self.prepared[m].measured

    def moving(self, m: int) -> NDArray[np.bool_]:
        """True (n,) where manoeuvre ``m`` is driven at 4 m/s or more."""
        return reference_speed(self.manoeuvres[m], self.vehicle) >= SLOWEST_M_S

    @cached_property
    def limit_approached(self) -> bool:
        """True where half of the tyres' friction, or of the slip at its peak, was used at any time."""
        record, neutral = self.car.record[0], np.zeros(len(self.columns))
        return any(
            used_share(record, one.channels, self.states(neutral, m), self.moving(m)) >= NEAR_SHARE
            for m, one in enumerate(self.manoeuvres)
        )

    def car_at(self, theta: FloatArray) -> np.void:
        """Numbers of the car (``REPLAY_RECORD``) at deviations theta, those of single manoeuvres left out."""
        entry: np.void = self._record_at(self.deviations_at(theta))[0]
        return entry

    def _record_at(self, deviations: Mapping[str, float]) -> NDArray[np.void]:
        own = tuple([pair for pair in deviations.items() if pair[0] in _OF_THE_CAR])
        conditions = {name: deviations[name] for name in CONDITIONS if name in deviations}
        cars = self._cars(own)
        if conditions:
            cars = cars.copy()
            change_record(cars, conditions)
        return cars

    def _make_car(self, deviations: tuple[tuple[str, float], ...]) -> NDArray[np.void]:
        cars = self.car.record.copy()
        change_record(cars, dict(deviations))
        derive(cars)
        return cars

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        """Measured minus predicted (n, c) of each manoeuvre, 0 where the weight is 0."""

        return list(self.mapped(lambda m: self.residual(m, self.predict(theta, m)), range(len(self.prepared))))

    def residual(self, m: int, predicted: FloatArray) -> FloatArray:
        """Measured minus this prediction (n, c) of manoeuvre ``m``, 0 where the weight is 0."""
        prepared = self.prepared[m]
        return np.where(prepared.weights > 0.0, prepared.measured - predicted, 0.0)

    def sensor_std(self, signal: str) -> float:
        """Own noise of a signal's sensor in the signal's unit."""
        return own_noise(self.vehicle, signal)

    def physical(self, column: str | int, deviation: float) -> tuple[float, str, float]:
        """Physical value, unit and nominal value of a column at a deviation.

        Raises
        ------
        InputError
            If there is no such column.
        """
        index = self._columns.index(column)
        parameter = self.parameters[index]
        nominal, unit = nominal_value(parameter, self._values)
        value = nominal * (1.0 + deviation) if parameter.relative else nominal + deviation
        return value, unit, nominal

    def deviations_at(self, theta: FloatArray, m: int | None = None) -> dict[str, float]:
        """Deviations that are not 0, by column; ``m`` with those that hold in that manoeuvre only."""
        return self._columns.deviations(theta, m)

    def tables_at(self, deviations: Mapping[str, float]) -> FloatArray:
        """Tables (4 (CELLS + 1), 2) of the tyres by axle, direction, cell; of another form where a deviation asks."""
        loss = deviations.get("tyre_peak_shape.sliding_loss", 0.0)
        shift = deviations.get("tyre_peak_shape.peak_slip", 0.0)
        tables = self.car.tables if loss == 0.0 and shift == 0.0 else self._tables(loss, shift)
        return tables.reshape(-1, tables.shape[-1])

    def _make_tables(self, loss: float, shift: float) -> FloatArray:
        return shaped_tables(self.car.tables, self.car.record[0]["peak_slip_x"][::2], loss, shift)
