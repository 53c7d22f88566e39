"""The vocabulary as a table: every kind of disturbance with its group, class of E2E faults and level."""

from collections.abc import Iterator
from dataclasses import dataclass

from can_fault_injector.faults.fault_file import Disturbance
from can_fault_injector.faults.levels import E2EClass, Group, Level
from signals.validation import alternatives


@dataclass(frozen=True)
class Kind:
    """One kind of disturbance: its name in files, what it does, and what it says of itself."""

    name: str
    description: str
    group: Group
    e2e: E2EClass
    realised_as: Level
    fields: tuple[str, ...]


def kinds() -> Iterator[Kind]:
    """Every kind, in the order of the files' schema."""
    for name, field in Disturbance.model_fields.items():
        model = alternatives(field.annotation)[0]
        description = " ".join((model.__doc__ or "").split())
        yield Kind(name, description, model.group, model.e2e, model.realised_as, tuple(model.model_fields))


def kind_named(name: str) -> Kind:
    """The kind of a name; KeyError if there is none."""
    return {kind.name: kind for kind in kinds()}[name]
