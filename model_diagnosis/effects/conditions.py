"""Conditions of a drive that may hold in one manoeuvre only: its road and the wind are not those of the others."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from model_diagnosis.effects.effect import EffectParameter

CONDITIONS = (
    "road_grade.grade",
    "road_bank.bank",
    "head_wind.speed",
    "side_wind.speed",
    "mu_step.level",
    "mu_step.place",
)
"""Columns of the catalogue that a manoeuvre may have for itself."""

MOST_MANOEUVRES = 12
"""Manoeuvres up to which each has conditions of its own: of long logs they would be most of all columns."""

SHARE_OF_SCATTER = 1.0
"""Scatter from manoeuvre to manoeuvre of one drive over that from drive to drive: gusts and waves of the road."""

_IN = "_in_manoeuvre_"


@dataclass(frozen=True)
class Condition:
    """A condition of one manoeuvre.

    Attributes
    ----------
    column : the column of the catalogue that it adds to
    manoeuvre : number, from 0 on
    """

    column: str
    manoeuvre: int

    @property
    def name(self) -> str:
        """Its own column; manoeuvres count from 1 in names."""
        return f"{self.column}{_IN}{self.manoeuvre + 1}"


def conditions_of(columns: Sequence[str], manoeuvres: int) -> tuple[Condition, ...]:
    """Conditions that each of so many manoeuvres may have for itself."""
    if not 1 < manoeuvres <= MOST_MANOEUVRES:
        return ()
    return tuple(Condition(column, m) for column in CONDITIONS if column in columns for m in range(manoeuvres))


def own_parameter(parameter: EffectParameter, condition: Condition) -> EffectParameter:
    """The catalogue's parameter as it may differ in one manoeuvre."""
    return replace(
        parameter,
        name=condition.name.partition(".")[2],
        nuisance_std=SHARE_OF_SCATTER * parameter.nuisance_std,
    )


def everywhere(name: str) -> str:
    """Name of the catalogue's parameter or column behind one that may hold in one manoeuvre only."""
    return name.partition(_IN)[0]


def only_in(name: str) -> int | None:
    """Number of the manoeuvre that a column or parameter is for, from 0 on; None where it holds in all."""
    number = name.partition(_IN)[2]
    return int(number) - 1 if number else None
