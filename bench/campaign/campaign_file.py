"""Campaign files: a scenario, the faults that it is run under, what counts as hazardous, and how runs are chosen.

scenario: stops/dry
faults:
  - name: late_wheel_speeds
    fault: {trigger: {id: 0x120}, disturbance: {delay: {by: 20 ms}}, duration: 0.5 s}
    grid: {disturbance.delay.by: [20 ms, 50 ms, 100 ms]}
times: {from: 0.5 s, to: 3 s, steps: 6}
seeds: {first: 1, count: 2}
hazards:
  - {id: distance, value: stopping_distance, at_most: 1.2, of_fault_free: true}
strategy: exhaustive
"""

from collections.abc import Iterator
from itertools import product
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from bench.campaign.outcome_names import LIMIT_QUANTITIES
from bench.scenario.variants import Variants
from bench.verdict.criteria_file import Criterion
from signals.errors import FieldError
from signals.quantities import FileModel, parameter

ENTRY_KINDS = ("fault", "stimulus", "set")
TIME_PATHS = {"fault": "trigger.from", "stimulus": "when.time"}


class Steps(FileModel):
    """Evenly spaced whole numbers."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True, serialize_by_alias=True)

    start: int = Field(alias="from", description="first value")
    to: int = Field(description="last value, which is one of them if the step meets it")
    step: int = Field(default=1, ge=1, description="distance of two values")

    @model_validator(mode="after")
    def _rising(self) -> "Steps":
        if self.to < self.start:
            raise FieldError("ends before it begins", at=("to",), allowed=f"at least {self.start}")
        return self

    def __len__(self) -> int:
        return (self.to - self.start) // self.step + 1

    def values(self) -> list[int]:
        """All of them."""
        return list(range(self.start, self.to + 1, self.step))


class FaultEntry(FileModel):
    """A kind of fault and the values that it is tried with; exactly one of fault, stimulus, set."""

    name: str = Field(pattern=r"^[A-Za-z]\w*$", description="in keys, tables and charts")
    fault: dict[str, Any] | None = Field(
        default=None, description="entry of `faults:` in a scenario: trigger, disturbance, duration"
    )
    stimulus: dict[str, Any] | None = Field(default=None, description="entry of `stimuli:` in a scenario")
    set: dict[str, Any] | None = Field(
        default=None, description="path: value, as for --set: a wrong parameter, a sensor error; from the start on"
    )
    grid: dict[str, list[Any] | Steps] = Field(
        default={}, description="dotted path in the entry: values, or {from, to, step}; each is combined with each"
    )
    timed: bool = Field(
        default=True, description="begins at each of the campaign's times; false: when its own trigger says"
    )
    e2e: str = Field(default="", description="class of E2E faults, where it is not the disturbance's own")

    @model_validator(mode="after")
    def _one_kind(self) -> "FaultEntry":
        given = [kind for kind in ENTRY_KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise FieldError(
                "a fault is one of three kinds", found=" and ".join(given) or "none", allowed=", ".join(ENTRY_KINDS)
            )
        for path, values in self.grid.items():
            if isinstance(values, list) and not values:
                raise FieldError("no values", at=("grid", path), allowed="a list of values or {from, to, step}")
        return self

    @property
    def kind(self) -> str:
        """fault, stimulus or set."""
        return next(kind for kind in ENTRY_KINDS if getattr(self, kind) is not None)

    @property
    def entry(self) -> dict[str, Any]:
        """What stands behind its kind."""
        entry: dict[str, Any] = getattr(self, self.kind)
        return entry

    @property
    def begins_at_times(self) -> bool:
        """Whether the campaign's times apply: a value that is set has no time."""
        return self.timed and self.kind != "set"

    def combinations(self) -> Iterator[dict[str, Any]]:
        """Path → value of each point of the grid, the last path varying fastest."""
        axes = [values.values() if isinstance(values, Steps) else values for values in self.grid.values()]
        for values in product(*axes):
            yield dict(zip(self.grid, values, strict=True))


class Times(FileModel):
    """Evenly spaced instants."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True, serialize_by_alias=True, validate_default=False)

    start: float = Field(
        alias="from",
        ge=0.0,
        le=36000.0,
        description="first instant, from the start of the run",
        json_schema_extra={"unit": "s"},
    )
    to: float = parameter("s", low=0.0, high=36000.0, description="last instant")
    steps: int = Field(ge=2, le=10_000, description="number of instants")

    def values(self) -> list[float]:
        """All of them, to the microsecond."""
        step = (self.to - self.start) / (self.steps - 1)
        return [round(self.start + step * number, 6) for number in range(self.steps)]


class Instant(FileModel):
    """One instant."""

    at: float = parameter("s", low=0.0, high=36000.0, description="from the start of the run")


def _instants(value: Any) -> Any:
    if not isinstance(value, list):
        return value
    return [entry if isinstance(entry, dict) else {"at": entry} for entry in value]


class Seeds(FileModel):
    """Consecutive seeds."""

    first: int = Field(default=1, ge=0, description="first seed")
    count: int = Field(default=1, ge=1, le=100_000, description="number of seeds")


def _kind_only(value: Any) -> Any:
    return {"kind": value} if isinstance(value, str) else value


class Strategy(FileModel):
    """Which runs of the fault space are made."""

    kind: Literal["exhaustive", "sampled", "adaptive"] = Field(
        default="exhaustive",
        description="exhaustive: every one; sampled: drawn evenly, each once; adaptive: near what hurt so far, and the "
        "smallest sets of faults that still hurt",
    )
    runs: int | None = Field(default=None, ge=1, le=10_000_000, description="number of runs; needed unless exhaustive")
    seed: int = Field(default=1, ge=0, description="of the choice; the runs' own seeds are `seeds`")
    faults_at_once: int = Field(default=1, ge=1, le=10, description="largest number of faults in one run")
    batch: int = Field(
        default=50, ge=1, le=10_000, description="adaptive: runs that are chosen at a time from what is known"
    )
    explore: float = parameter("1", 0.2, low=0.01, high=1.0, description="adaptive: share of runs drawn evenly")

    @model_validator(mode="after")
    def _complete(self) -> "Strategy":
        if self.kind != "exhaustive" and self.runs is None:
            raise FieldError(f"{self.kind} needs the number of runs", at=("runs",), allowed="runs: 1000")
        if self.kind == "exhaustive" and (self.runs is not None or self.faults_at_once > 1):
            raise FieldError("every single fault is run", at=("kind",), allowed="sampled or adaptive beside runs")
        return self


class Hazard(Criterion):
    """A criterion whose violation is a hazard."""

    of_fault_free: bool = Field(
        default=False, description="limits are multiples of the value of the fault-free run with the same seed"
    )
    no_value: Literal["hazardous", "harmless"] = Field(
        default="hazardous", description="what a run without a value is, e.g. a car that does not stop"
    )

    @model_validator(mode="after")
    def _limited(self) -> "Hazard":
        if self.at_most is None and self.at_least is None:
            raise FieldError("a hazard needs a limit", allowed="at_most or at_least")
        return self


class CampaignLimit(FileModel):
    """A limit on the outcome of the whole campaign: breaking it is exit code 1."""

    quantity: Literal[LIMIT_QUANTITIES] = Field(description="what is limited")  # type: ignore[valid-type]
    fault: str | None = Field(default=None, description="only runs with the fault entry of this name")
    variant: str | None = Field(default=None, description="only runs of this variant")
    at_least: float | None = Field(default=None, description="lower limit; times in s")
    at_most: float | None = Field(default=None, description="upper limit; times in s")
    requirement: str = Field(default="", description="what the limit stands for")

    @model_validator(mode="after")
    def _limited(self) -> "CampaignLimit":
        if self.at_most is None and self.at_least is None:
            raise FieldError("no limit", allowed="at_most or at_least")
        return self


class CampaignFile(FileModel):
    """A campaign: the space of faults around a scenario, and how it is searched."""

    format: Literal[1] = Field(default=1, description="version of this format")
    id: str = Field(default="", description="name in reports; by default the path below scenarios/ without .yaml")
    title: str = Field(default="", description="one line for `bench list`")
    description: str = Field(default="", description="what it shows and where its numbers come from")
    standard: str = Field(default="", description="standard, clause or source that it stands for")
    scenario: str = Field(description="id of a scenario, or a path relative to this file")
    set: dict[str, Any] = Field(default={}, description="path: value for every run, as for --set")
    variants: Variants | None = Field(default=None, description="variants of the scenario, each with each fault")
    faults: list[FaultEntry] = Field(min_length=1, description="kinds of faults, alternatives of each other")
    times: (
        Times | Annotated[list[Instant], BeforeValidator(_instants, json_schema_input_type=list[Instant | float | str])]
    ) = Field(default=[], description="instants at which faults begin: a list, or {from, to, steps}")
    seeds: Seeds | list[int] = Field(default_factory=Seeds, description="of the runs: a list, or {first, count}")
    strategy: Annotated[Strategy, BeforeValidator(_kind_only)] = Field(
        default_factory=Strategy, description="exhaustive, or {kind, runs, …}"
    )
    hazards: list[Hazard] = Field(min_length=1, description="criteria whose violation is a hazard")
    same_within: float = parameter(
        "1",
        0.02,
        low=0.0,
        high=1.0,
        description="a run whose hazard values differ from the fault-free ones by less than this share of the limit "
        "counts as unaffected",
    )
    confidence: float = parameter("1", 0.95, low=0.5, high=0.9999, description="of the intervals of shares")
    limits: list[CampaignLimit] = Field(default=[], description="what the campaign as a whole has to keep")

    @model_validator(mode="after")
    def _consistent(self) -> "CampaignFile":
        for field, key in (("faults", "name"), ("hazards", "id")):
            names = [getattr(entry, key) for entry in getattr(self, field)]
            for number, name in enumerate(names):
                if name in names[:number]:
                    raise FieldError("stands here twice", at=(field, number, key), found=repr(name))
        if any(entry.begins_at_times for entry in self.faults) and not self.instants:
            raise FieldError("faults need instants to begin at", at=("times",), allowed="a list, or timed: false")
        for number, limit in enumerate(self.limits):
            known = [entry.name for entry in self.faults]
            if limit.fault is not None and limit.fault not in known:
                raise FieldError("no such fault entry", at=("limits", number, "fault"), allowed=", ".join(known))
        return self

    @property
    def instants(self) -> list[float]:
        """Times at which faults begin, s."""
        return self.times.values() if isinstance(self.times, Times) else [entry.at for entry in self.times]

    @property
    def seed_values(self) -> list[int]:
        """Seeds of the runs."""
        seeds = self.seeds
        return list(range(seeds.first, seeds.first + seeds.count)) if isinstance(seeds, Seeds) else list(seeds)
