"""From points of the fault space to jobs: the resolved scenario of each run as text."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.campaign.campaign_file import CampaignFile, FaultEntry, Hazard
from bench.campaign.fault_space import FaultSpace, Injection, Point
from bench.execution.job import Job, job_of
from bench.scenario.documents import read_document
from bench.scenario.locate import find_scenario
from bench.scenario.resolution import resolve_document
from signals.errors import Fault, FileFaults, InputError
from signals.yaml_files import Document

if TYPE_CHECKING:
    from bench.scenario.schema import ScenarioFile

_CRITERION = re.compile(r"^criteria\[(?P<number>\d+)\]\.?(?P<field>\w*)")
_LISTED = re.compile(r"^(faults|stimuli)\[\d+\]\.?")
_LISTS = {"fault": "faults", "stimulus": "stimuli"}


class ScenarioTexts:
    """Makes the jobs of a campaign.

    Parameters
    ----------
    space : FaultSpace
    folder : Path
        That of the campaign file: its scenario's path starts there.

    Raises
    ------
    InputError
        If the scenario has faults.
    """

    def __init__(self, space: FaultSpace, folder: Path) -> None:
        self._space = space
        self._path = scenario_path(space.campaign, folder)
        self._document: Document = read_document(self._path)
        self._resolved: dict[tuple[int, str], dict[str, Any]] = {}

    def scenario(self, point: Point) -> "ScenarioFile":
        """The resolved scenario of a point, its seed in it."""
        return self.job(point).scenario_file()

    def job(self, point: Point) -> Job:
        """The job of a point, named by its key."""
        injections = self._space.injections_of(point)
        text = dict(self._base(point[0], injections))
        for kind, name in _LISTS.items():
            added = [_named(item) for item in injections if item.kind == kind]
            if added:
                text[name] = [*text.get(name, []), *added]
        return Job(self._space.key(point), json.dumps(text, separators=(",", ":")), self._space.seeds[point[2]])

    def _base(self, variant: int, injections: list[Injection]) -> dict[str, Any]:
        """Scenario of a variant without faults and stimuli of the campaign, but with the values that these set."""
        sets = {path: value for item in injections if item.kind == "set" for path, value in item.entry.items()}
        place = (variant, json.dumps(sets, sort_keys=True))
        if place not in self._resolved:
            job = job_of(self.resolve(variant, sets))
            self._resolved[place] = json.loads(job.scenario)
        return self._resolved[place]

    def resolve(self, variant: int, sets: Mapping[str, Any]) -> "ScenarioFile":
        """The checked scenario of a variant.

        Raises
        ------
        InputError
            With everything that is wrong with it.
        """
        campaign = self._space.campaign
        chosen = self._space.variants[variant]
        return resolve_document(
            self._document,
            self._path,
            {
                "criteria": [criterion_of(hazard) for hazard in campaign.hazards],
                "valid_if": [],
                "ecu.link": None,
                **campaign.set,
                **sets,
            },
            chosen if chosen.name else None,
        )

    def check(self, document: Document) -> None:
        """Check every variant, and every fault of each entry at its first time, as a scenario would be.

        Raises
        ------
        FileFaults
            With places in the campaign file.
        """
        campaign, faults = self._space.campaign, []
        for variant in range(len(self._space.variants)):
            try:
                self.resolve(variant, {})
            except FileFaults as error:
                faults += [_in_campaign(fault, document) for fault in error.faults]
        if faults:
            raise FileFaults(list(dict.fromkeys(faults)), document.file)
        for number, entry in enumerate(campaign.faults):
            where = ("faults", number, entry.kind)
            for sets in self._to_check(entry):
                try:
                    self.resolve(0, sets)
                except FileFaults as error:
                    faults += [_in_entry(fault, document, where) for fault in error.faults]
                except InputError as error:
                    faults.append(document.fault(where, error.message, allowed=error.allowed, nearest=error.nearest))
        if faults:
            raise FileFaults(list(dict.fromkeys(faults)), document.file)

    def _to_check(self, entry: FaultEntry) -> list[dict[str, Any]]:
        """Changes of the scenario that show every fault of an entry: all of them in one list, values one by one."""
        own = [item for item in self._space.injections if item.name == entry.name and item.position[-1] == 0]
        if entry.kind == "set":
            return [dict(own[0].entry), dict(own[-1].entry)]
        name = _LISTS[entry.kind]
        present = self._document.data.get(name) or []
        return [{name: [*(present if isinstance(present, list) else []), *map(_named, own)]}]


def _in_entry(fault: Fault, document: Document, where: Sequence[str | int]) -> Fault:
    """A fault of a scenario that has a campaign's entry in it, at the place of the entry."""
    problem = f"{_LISTED.sub('', fault.field)}: {fault.problem}"
    return document.fault(where, problem, found=fault.found, allowed=fault.allowed, nearest=fault.nearest)


def _in_campaign(fault: Fault, document: Document) -> Fault:
    """A fault of a criterion at its place among the hazards; others have their place in the scenario."""
    match = _CRITERION.match(fault.field)
    if match is None:
        return fault
    place = ("hazards", int(match["number"]), *((match["field"],) if match["field"] else ()))
    return document.fault(place, fault.problem, found=fault.found, allowed=fault.allowed, nearest=fault.nearest)


def scenario_path(campaign: CampaignFile, folder: Path) -> Path:
    """File of the campaign's scenario: beside the campaign file if it is a path, else found by its id."""
    beside = folder / campaign.scenario
    return beside if campaign.scenario.endswith((".yaml", ".yml")) else find_scenario(campaign.scenario)


def criterion_of(hazard: Hazard) -> dict[str, Any]:
    """The criterion by which a run is judged; without limits where these follow from the fault-free run."""
    own = {"of_fault_free", "no_value"} | ({"at_most", "at_least"} if hazard.of_fault_free else set())
    return hazard.model_dump(mode="json", exclude_none=True, exclude=own)


def _named(item: Injection) -> dict[str, Any]:
    """The entry with a name that tells its values and its time."""
    return {"name": re.sub(r"[^a-z0-9]+", "_", item.text.lower().replace("=-", "=minus ")).strip("_"), **item.entry}
