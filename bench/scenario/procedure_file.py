"""Procedure files: several runs and criteria over their results.

runs:
  - {name: abs, scenario: stops/dry, repeat: 10}
  - {name: locked, scenario: stops/dry, set: {ecu.kind: none}}
criteria:
  - id: shorter_with_abs
    value: mean(abs.stopping_distance) / mean(locked.stopping_distance)
    at_most: 1.0
"""

from typing import Any, Literal

from pydantic import Field, model_validator

from signals.errors import FieldError
from signals.quantities import FileModel


class ProcedureRun(FileModel):
    """Runs of one scenario under one name."""

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", description="used in criteria and as folder name")
    scenario: str = Field(description="id of a scenario, or a path relative to this file")
    variant: str | None = Field(default=None, description="variant of the scenario")
    set: dict[str, Any] = Field(default={}, description="path: value, as for --set")
    repeat: int = Field(default=1, ge=1, le=10_000, description="number of runs; their seeds count up")
    seed: int | None = Field(default=None, ge=0, description="of the first run; without it the procedure's")
    must_pass: bool = Field(default=False, description="the runs' own verdicts count too")


class ProcedureCriterion(FileModel):
    """One line of the verdict table, a value over the results of the runs."""

    id: str = Field(pattern=r"^[\w.\-/]+$", description="name in the verdict table")
    requirement: str = Field(default="", description="requirement or clause that the limits stand for")
    description: str = Field(default="", description="one line for people")
    value: str = Field(description="expression, e.g. mean(abs.stopping_distance); NAME.QUANTITY has a value per run")
    unit: str = Field(default="1", description="SI unit of the value")
    at_least: float | str | None = Field(default=None, description="lower limit, in the unit or with one of its own")
    at_most: float | str | None = Field(default=None, description="upper limit")


class ProcedureFile(FileModel):
    """A procedure: runs and criteria over their results."""

    format: Literal[1] = 1
    id: str = Field(default="", description="name in reports; by default the path below scenarios/ without .yaml")
    title: str = Field(default="", description="one line for `bench list`")
    description: str = Field(default="", description="what it shows and where its numbers come from")
    standard: str = Field(default="", description="standard, clause or source that it stands for")
    pacing: Literal["realtime", "lockstep"] = Field(default="lockstep", description="of every run")
    record: bool = Field(default=True, description="false keeps no recordings of the single runs")
    seed: int = Field(default=1, ge=0, description="of the first run of each name")
    runs: list[ProcedureRun] = Field(min_length=1, description="what is run")
    criteria: list[ProcedureCriterion] = Field(default=[], description="what the runs together have to show")

    @model_validator(mode="after")
    def _unique(self) -> "ProcedureFile":
        for field in ("runs", "criteria"):
            names = [getattr(entry, "name" if field == "runs" else "id") for entry in getattr(self, field)]
            for number, name in enumerate(names):
                if name in names[:number]:
                    key = "name" if field == "runs" else "id"
                    raise FieldError("stands here twice", at=(field, number, key), found=repr(name))
        return self
