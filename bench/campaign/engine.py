"""A campaign from its file to its store: fault-free runs first, then batch after batch of the strategy."""

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.campaign.campaign_file import CampaignFile
from bench.campaign.classification import Judgement, classify, severity
from bench.campaign.fault_space import FaultSpace, Point
from bench.campaign.observation import observe
from bench.campaign.outcome_names import BENCH_ERROR, HAZARDOUS, NO_EFFECT
from bench.campaign.rows import run_row, stored_row
from bench.campaign.scenario_texts import ScenarioTexts
from bench.campaign.store import Store
from bench.campaign.strategy import Result, strategy_of
from bench.execution.executors import DaskCluster, Executors, LocalProcesses
from bench.execution.job import DONE, LOST, Job, RunRow, hash_of
from bench.execution.pool import WorkerPool
from signals.errors import InputError
from signals.yaml_files import load_yaml, validate

FAULT_FREE_BATCH = 0


@dataclass
class Progress:
    """How far a campaign is.

    Attributes
    ----------
    made : int
        Runs of this call; ``known`` those that the store had already.
    wall_s : float
        Since the first run of this call began.
    """

    known: int = 0
    made: int = 0
    hazardous: int = 0
    lost: int = 0
    wall_s: float = 0.0
    workers: int = 0
    began: float = field(default_factory=time.perf_counter)

    @property
    def per_hour(self) -> float:
        """Rate of this call's runs."""
        return 3600.0 * self.made / self.wall_s if self.wall_s > 0 else 0.0


def read_campaign(path: Path) -> CampaignFile:
    """A campaign file, checked with its scenario, variants and faults.

    Raises
    ------
    InputError
        With every fault of the file and its place.
    """
    from bench.scenario.locate import id_of

    document = load_yaml(path)
    campaign = validate(document, CampaignFile)
    ScenarioTexts(FaultSpace(campaign), path.parent).check(document)
    return campaign.model_copy(update={"id": campaign.id or id_of(path)})


def executors_of(workers: int | None, scheduler: str | None, example: str) -> Executors:
    """Processes of this machine, or the cluster at an address."""
    if scheduler is None:
        return LocalProcesses(workers, example)
    return DaskCluster(scheduler)


class CampaignRun:
    """One call of a campaign: goes on where the store ends.

    Parameters
    ----------
    campaign : CampaignFile
        As `read_campaign` gives it.
    path : Path
        Its file.
    folder : Path
        Of the store.
    say : callable, optional
        Receives `Progress` after each run.
    """

    def __init__(
        self, campaign: CampaignFile, path: Path, folder: Path, say: Callable[[Progress], None] | None = None
    ) -> None:
        self.campaign = campaign
        self.space = FaultSpace(campaign)
        self.folder = folder
        self.progress = Progress()
        self._texts = ScenarioTexts(self.space, path.parent)
        self._path = path
        self._say = say or (lambda progress: None)
        self._stored: dict[str, Result] = {}
        self._fault_free: dict[tuple[int, int], RunRow] = {}
        self._results: dict[Point, Result] = {}
        self._batch = FAULT_FREE_BATCH

    def run(self, workers: int | None = None, scheduler: str | None = None) -> Progress:
        """Make every run that is missing.

        Raises
        ------
        InputError
            If a fault-free run is hazardous by the campaign's own limits.
        RunError
            If the folder cannot be used, or the workers are gone.
        """
        with Store(self.folder, self._about()) as store:
            self._take_stored(store)
            example = self._texts.job(next(iter(self.space.fault_free()))).scenario
            executors = executors_of(workers, scheduler, example)
            with WorkerPool(executors=executors, observe=observe) as pool:
                self.progress.workers = pool.workers
                self.progress.began = time.perf_counter()
                self._make(store, pool, list(self.space.fault_free()))
                self._check_fault_free()
                strategy = strategy_of(self.space)
                while batch := strategy.next(self._results):
                    self._batch += 1
                    self._make(store, pool, batch)
            store.join()
        return self.progress

    def _about(self) -> dict[str, Any]:
        dumped = self.campaign.model_dump(mode="json", exclude_none=True)
        variants = [hash_of(self._texts.resolve(number, {})) for number in range(len(self.space.variants))]
        identity = hashlib.sha256(json.dumps([dumped, variants], sort_keys=True).encode()).hexdigest()
        return {"identity": identity, "file": str(self._path), "campaign": dumped}

    def _take_stored(self, store: Store) -> None:
        """What earlier calls have made; a run that was lost is made again."""
        lost: set[str] = set()
        for row in store.rows():
            if row["run_outcome"] == LOST:
                lost.add(row["key"])
                continue
            self._stored[row["key"]] = _result(row)
            if row["fault_free"]:
                found = run_row(row)
                places = [n for n, variant in enumerate(self.space.variants) if variant.name == row["variant"]]
                self._fault_free[places[0], self.space.seeds.index(found.seed)] = found
        store.drop(lost)

    def _make(self, store: Store, pool: WorkerPool, points: list[Point]) -> None:
        """Make the runs of a batch that the store does not have."""
        missing = {}
        for point in points:
            key = self.space.key(point)
            if key in self._stored:
                self._note(point, self._stored[key])
                self.progress.known += 1
                self.progress.hazardous += self._stored[key].hazardous
            else:
                missing[key] = point
        jobs: dict[str, Job] = {}
        for row in pool.run(_noting(map(self._texts.job, missing.values()), jobs)):
            point = missing[row.key]
            self._take(store, point, jobs.pop(row.key), row)
        store.flush()

    def _take(self, store: Store, point: Point, job: Job, row: RunRow) -> None:
        place = (point[0], point[2])
        if not point[1]:
            self._fault_free[place] = row
            judgement = Judgement(NO_EFFECT if row.outcome == DONE else BENCH_ERROR, (), 0.0, "", None)
        else:
            judgement = classify(row, self._fault_free[place], self.campaign.hazards, self.campaign.same_within)
        stored = stored_row(self.space, point, job, row, judgement, self._fault_free[place], self._batch)
        store.add(stored)
        self._note(point, _result(stored))
        progress = self.progress
        progress.made += 1
        progress.hazardous += judgement.outcome == HAZARDOUS
        progress.lost += row.outcome == LOST
        progress.wall_s = time.perf_counter() - progress.began
        self._say(progress)

    def _note(self, point: Point, result: Result) -> None:
        """Keep a result for the strategy, which knows of runs with faults only."""
        if point[1]:
            self._results[point] = result

    def _check_fault_free(self) -> None:
        for (variant, seed), row in sorted(self._fault_free.items()):
            name = self.space.variants[variant].name or "the scenario itself"
            where = f"fault-free run of {name}, seed {self.space.seeds[seed]}"
            if row.outcome != DONE:
                raise InputError(f"{where}: {row.reason}", mend=f"try it: bench run {self.campaign.scenario}")
            for hazard in self.campaign.hazards:
                if severity(hazard, row, row) > 1.0:
                    value = row.criteria[hazard.id]["value"]
                    raise InputError(
                        f"{where} breaks the limit of hazard {hazard.id!r}",
                        found="no value" if value is None else f"{value:.4g} {row.criteria[hazard.id]['unit']}",
                        mend="widen the limit, or choose a scenario that keeps it without faults",
                    )


def _noting(jobs: Iterable[Job], noted: dict[str, Job]) -> Iterator[Job]:
    """The jobs, each kept by its key while it is on the way."""
    for job in jobs:
        noted[job.key] = job
        yield job


def _result(row: dict[str, Any]) -> Result:
    return Result(float(row["severity"]), row["outcome"] == HAZARDOUS)
