"""What an effect is to the generator."""

from collections.abc import Callable
from dataclasses import dataclass

from hidden_effects.car import Numbers

SMALLEST_UNITS = 4.0
"""Size in scatters below which an effect may be a healthy car's deviation."""

Change = Callable[[Numbers, Numbers, float, int], None]

BOTH, UP, DOWN = (-1, 1), (1,), (-1,)
"""Directions in which an effect makes sense."""


@dataclass(frozen=True)
class HiddenEffect:
    """One effect.

    Attributes
    ----------
    unit : of the physical value; "1" for a factor on the nominal value
    relative : True where the value is a factor on the nominal one (its deviation is value − 1)
    scatter : ordinary deviation, the unit of size
    largest : largest size in units of scatter
    signs : directions that make sense
    places : number of wheels or axles among which one is drawn; 0 for none
    change : changes car and chain by a deviation at a place
    field : number that tells the true physical value afterwards ("" : the drawn deviation itself)
    needs : channels that must be in the log for it to be seen
    smallest : size in scatters from which the shipped manoeuvres show it (``isolability.detection_limit``), at least 4
    also : further numbers whose scatter would add to the deviation: two that act as one, one that divides the other
    """

    name: str
    group: str
    unit: str
    relative: bool
    scatter: float
    largest: float
    signs: tuple[int, ...]
    change: Change
    places: int = 0
    field: str = ""
    needs: tuple[str, ...] = ()
    smallest: float = SMALLEST_UNITS
    also: tuple[str, ...] = ()

    def numbers_at(self, place: int) -> list[tuple[str, int | None]]:
        """Numbers of car or chain (``chain:<name>``) that a deviation takes the place of, and which entry of each.

        The size of an effect counts from the data sheet: what the number scatters by from car to car is in it.
        """
        fields = [name for name in self.field.split(",") if name]
        if len(fields) > 1:
            fields = fields[place : place + 1]
        entry = place if self.places else None
        return [*((name, entry) for name in fields), *((name, None) for name in self.also)]
