"""Columns of a replay: what each deviation of theta is, and what it does in which manoeuvre."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.conditions import Condition, conditions_of, own_parameter
from model_diagnosis.effects.effect import Effect, EffectParameter
from model_diagnosis.replay.parameters import Values, adjusted_parameter
from model_diagnosis.replay.terms import TermCourse
from signals.errors import unknown_name
from vehicle_model.vehicle_file import Scatter

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Columns:
    """The catalogue's columns, behind them those of single manoeuvres, and behind these those of terms.

    Attributes
    ----------
    effects : that the columns belong to
    names, parameters : (p) of the columns, bounds and scatter as for this vehicle
    owner : (p,) index into ``effects``
    catalogue : number of the catalogue's columns
    conditions : of single manoeuvres
    terms : that are no effects of the catalogue
    """

    effects: tuple[Effect, ...]
    names: tuple[str, ...]
    parameters: tuple[EffectParameter, ...]
    owner: NDArray[np.int64]
    catalogue: int
    conditions: tuple[Condition, ...] = ()
    terms: tuple[TermCourse, ...] = ()

    @classmethod
    def of(
        cls, effects: Sequence[Effect], values: Values, scatter: Mapping[str, Scatter], manoeuvres: int = 0
    ) -> "Columns":
        """Columns of effects for a vehicle; with conditions of each of so many manoeuvres."""
        names = [column for effect in effects for column in effect.columns]
        owner = [index for index, effect in enumerate(effects) for _ in effect.parameters]
        parameters = [adjusted_parameter(one, values, scatter) for effect in effects for one in effect.parameters]
        conditions = conditions_of(names, manoeuvres)
        places = [names.index(one.column) for one in conditions]
        return cls(
            effects=tuple(effects),
            names=(*names, *(one.name for one in conditions)),
            parameters=(
                *parameters,
                *(own_parameter(parameters[place], one) for place, one in zip(places, conditions, strict=True)),
            ),
            owner=np.array([*owner, *(owner[place] for place in places)], dtype=np.int64),
            catalogue=len(names),
            conditions=conditions,
        )

    def with_terms(self, terms: Sequence[TermCourse]) -> "Columns":
        """The same with those of terms behind all others."""
        added = [term.effect for term in terms]
        owner = [len(self.effects) + k for k, effect in enumerate(added) for _ in effect.parameters]
        return replace(
            self,
            effects=(*self.effects, *added),
            names=(*self.names, *(column for effect in added for column in effect.columns)),
            parameters=(*self.parameters, *(one for effect in added for one in effect.parameters)),
            owner=np.array([*self.owner, *owner], dtype=np.int64),
            terms=(*self.terms, *terms),
        )

    @cached_property
    def _place(self) -> dict[str, int]:
        return {name: index for index, name in enumerate(self.names)}

    def index(self, column: str | int) -> int:
        """Place of a column.

        Raises
        ------
        InputError
            If there is no such column.
        """
        if isinstance(column, str):
            if column not in self._place:
                raise unknown_name("column of the replay", column, self.names)
            return self._place[column]
        return int(column)

    def deviations(self, theta: FloatArray, m: int | None = None) -> dict[str, float]:
        """Deviations that are not 0, by column of the catalogue or of a term; ``m`` with those of that manoeuvre only.

        What another replay's theta has behind the catalogue's columns is passed over.
        """
        held = np.array(theta[: self.catalogue], dtype=np.float64)
        if len(theta) != len(self.names):
            return {self.names[int(k)]: float(held[k]) for k in np.flatnonzero(held)}
        behind = self.catalogue + len(self.conditions)
        if m is not None:
            for one, deviation in zip(self.conditions, theta[self.catalogue : behind], strict=True):
                if one.manoeuvre == m:
                    held[self._place[one.column]] += deviation
        by_column = {self.names[int(k)]: float(held[k]) for k in np.flatnonzero(held)}
        return by_column | {self.names[k]: float(theta[k]) for k in range(behind, len(theta)) if theta[k] != 0.0}

    def acts_as(self, column: int, m: int) -> str | None:
        """Column of the catalogue or a term that a column acts as in a manoeuvre; None where it does not act there."""
        if not self.catalogue <= column < self.catalogue + len(self.conditions):
            return self.names[column]
        one = self.conditions[column - self.catalogue]
        return one.column if one.manoeuvre == m else None
