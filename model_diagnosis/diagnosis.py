"""The whole diagnosis: logs or manoeuvres in, the answer and everything behind it out.

from model_diagnosis.diagnosis import diagnose
findings = diagnose(["drive.csv"], "car.yaml", "channels.yaml")
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from model_diagnosis.data import check_data, read_manoeuvres
from model_diagnosis.data.holding_out import check_held_out, held_out_by_time
from model_diagnosis.data.liveliest import liveliest
from model_diagnosis.discovery.unknown import MARGIN, FoundUnknown, weigh_unknown
from model_diagnosis.effects.catalogue import effect as find_effect
from model_diagnosis.effects.form import FORM_NAMES
from model_diagnosis.evidence.answer import CauseDetail
from model_diagnosis.evidence.base import Base, fit_base
from model_diagnosis.evidence.car_numbers import CarNumbers, numbers_within_scatter
from model_diagnosis.evidence.excitation import Excitation, excitation, excited_columns
from model_diagnosis.evidence.hypotheses import by_effect, hypotheses_of
from model_diagnosis.evidence.naming import named
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Accepted, Selection, Selector
from model_diagnosis.evidence.stage import linear_evidence, ratios
from model_diagnosis.evidence.structure import are_forced_together
from model_diagnosis.evidence.threshold import bootstrap_maxima, threshold
from model_diagnosis.evidence.wrong_vehicle import WrongVehicle, are_of_the_car, compare
from model_diagnosis.extension.car_numbers import numbers_of
from model_diagnosis.findings import Findings
from model_diagnosis.gain import is_proven
from model_diagnosis.held_out import gain_of, gain_of_numbers, noise_std
from model_diagnosis.localisation import Localisation, localise, place_remarks
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.next_manoeuvre import next_manoeuvre
from model_diagnosis.pictures import manoeuvre_findings
from model_diagnosis.remarks import remarks_of
from model_diagnosis.replay import Replay, ReplayBase, RigReplay
from model_diagnosis.replay.choosing import replay_class
from model_diagnosis.result import DataFault, Diagnosis, Gain
from model_diagnosis.verdict import verdict_of
from signals.errors import InputError
from signals.measured import ChannelMap, load_channel_map
from vehicle_model import load_vehicle
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]
Progress = Callable[[str, float], None]
Source = Sequence[Manoeuvre] | Sequence[str | Path]

REFIT_MARGIN = 3.0
"""Log evidence below the threshold from which an effect is still refitted."""

STEPS = {
    "data": 0.0,
    "base": 0.1,
    "threshold": 0.4,
    "search": 0.42,
    "unknown": 0.75,
    "answer": 0.85,
    "plan": 0.9,
    "gain": 0.95,
}
"""Share of the whole at which each step begins, for the progress bar."""


@dataclass
class _Clock:
    """Times of the steps and the caller's progress bar."""

    progress: Progress | None
    seconds: dict[str, float] = field(default_factory=dict)
    step: str = ""
    since: float = 0.0

    def begin(self, step: str) -> None:
        now = time.perf_counter()
        if self.step:
            self.seconds[self.step] = now - self.since
        self.step, self.since = step, now
        if step in STEPS:
            self.tell(step, 0.0)

    def tell(self, text: str, share: float) -> None:
        if self.progress is None:
            return
        begins = sorted(STEPS.values())
        begin = STEPS.get(self.step, 1.0)
        end = next((one for one in begins if one > begin), 1.0)
        self.progress(text, begin + share * (end - begin))


def diagnose(
    source: Source,
    vehicle: VehicleFile | str | Path,
    channel_map: ChannelMap | str | Path | None = None,
    *,
    hold_out: Source | None = None,
    hold_out_share: float = 0.0,
    at_most_s: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Findings:
    """What the simulation of ``vehicle`` gets wrong on measured data, and why.

    Parameters
    ----------
    source : manoeuvres, or paths of logs (MF4, BLF, ASC, candump, CSV, Parquet)
    vehicle : vehicle file, its path or the name of a shipped one
    channel_map : needed for logs that are not our own recordings
    hold_out : manoeuvres or logs that take no part in the search and measure the gain; without them it is measured by
        leaving out each manoeuvre in turn
    hold_out_share : of each drive's time, from its end, that takes no part in the search either; its data is checked
        and repaired together with the rest of the drive
    at_most_s : search only the liveliest manoeuvres, of so much time together [s]; the data is checked as a whole
    seed : of the bootstraps
    progress : called with what is being done and the share done, 0 to 1

    Raises
    ------
    InputError
        If a file cannot be read or holds nothing that a diagnosis could use.
    """
    clock = _Clock(progress)
    clock.begin("data")
    car = vehicle if isinstance(vehicle, VehicleFile) else load_vehicle(vehicle)
    manoeuvres, logs = _manoeuvres(source, car, channel_map)
    held_out, _ = _manoeuvres(hold_out, car, channel_map) if hold_out else ([], [])
    model = replay_class(manoeuvres)
    if held_out and replay_class(held_out) is not model:
        raise InputError(
            "logs of a car and of a wheel on a rig in one diagnosis", mend="diagnose and hold out each kind for itself"
        )
    # replays share the processors already, and threads of the linear algebra that wait for more work take them away
    with threadpool_limits(1, user_api="blas"):
        faults, manoeuvres = check_data(manoeuvres, car, model)
        if held_out:
            held_out = check_held_out(held_out, faults, car, model)
        if hold_out_share:
            manoeuvres, last = held_out_by_time(manoeuvres, hold_out_share)
            held_out = [*held_out, *last]
        if at_most_s is not None:
            manoeuvres = liveliest(manoeuvres, at_most_s)
        try:
            replay = RigReplay(car, manoeuvres) if model is RigReplay else Replay(car, manoeuvres, conditions=True)
        except InputError as error:
            raise _with_faults(error, faults) from None
        if not any(len(replay.signals(number)) for number in range(len(manoeuvres))):
            raise InputError("no signal of these logs can be compared with a replay", mend="check the channel map")
        other = model(car, held_out) if held_out else None
        if isinstance(other, RigReplay) and other.columns != replay.columns:
            raise InputError(
                "the held-out wheel is of another axle", mend="diagnose and hold out wheels of the same axle"
            )
        return _Pipeline(car, replay, other, faults, logs, seed, clock).run()


def _with_faults(error: InputError, faults: Sequence[DataFault]) -> InputError:
    """An error of data that cannot be replayed, with the faults that took the channels away."""
    told = [fault.message for fault in faults[:6]]
    return InputError(
        error.message, found=error.found, allowed=error.allowed, mend="\n".join([*told, *([error.mend] * (not told))])
    )


def _manoeuvres(
    source: Source, vehicle: VehicleFile, channel_map: ChannelMap | str | Path | None
) -> tuple[list[Manoeuvre], list[str]]:
    if all(isinstance(one, Manoeuvre) for one in source):
        return list(cast(Sequence[Manoeuvre], source)), sorted(
            {one.source for one in cast(Sequence[Manoeuvre], source)}
        )
    paths = [Path(cast(str, one)) for one in source]
    if channel_map is None:
        channels = ChannelMap()
    else:
        channels = channel_map if isinstance(channel_map, ChannelMap) else load_channel_map(channel_map)
    return read_manoeuvres(paths, channels, vehicle), [str(path) for path in paths]


@dataclass
class _Pipeline:
    """The steps after the data is read; each method is one step."""

    vehicle: VehicleFile
    replay: ReplayBase
    held_out: ReplayBase | None
    faults: list[DataFault]
    logs: list[str]
    seed: int
    clock: _Clock

    def run(self) -> Findings:
        self.clock.begin("base")
        base = fit_base(self.replay, self._priors(), self.clock.tell)
        search, needed = self._search(base)
        self.clock.begin("search")
        selector = Selector(search, needed, self.clock.tell)
        selection = selector.run(base.nothing, base.at_nothing, base.at_saturated)
        self.clock.begin("unknown")
        guilty = self._localised(base, selection)
        unknown = self._unknown(base, selector, selection, needed)
        self.clock.begin("answer")
        chords, starts = (base.at_nothing, base.at_saturated), (selection.fit.theta, base.saturated.theta)
        found = unknown.evidence if unknown else sum(one.evidence for one in selection.accepted)
        accepted = [self.replay.effects[one.hypothesis.effect] for one in selection.accepted]
        is_incomplete = selection.left > 0.0 and not unknown and are_of_the_car(accepted)
        wrong = compare(base.problem, selection.nothing, chords, starts, 0.0 if is_incomplete else found)
        is_wrong = wrong.beats(found, selection.fit.cost, is_incomplete)
        details: list[CauseDetail] = []
        if not is_wrong and not unknown:
            selection, details = named(search, selector, selection, self._forced, self.replay.physical)
        shown = excitation(base.problem, base.at_nothing.information, needed)
        self.clock.begin("plan")
        following = None
        if isinstance(self.replay, Replay):
            following = next_manoeuvre(self.vehicle, self.replay, search, selection, details)
        self.clock.begin("gain")
        unknown = None if is_wrong else unknown
        answer, numbers = self._diagnosis(
            search, selection, details, wrong if is_wrong else None, shown, guilty, needed, unknown
        )
        answer.next_manoeuvre = following
        findings = self._findings(answer, base, selection, search, unknown, numbers)
        self.clock.begin("")
        answer.timing_s.update(self.clock.seconds)
        return findings

    def _unknown(self, base: Base, selector: Selector, selection: Selection, needed: float) -> FoundUnknown | None:
        """The term that says more than all causes of the catalogue together, or than nothing where there are none.

        One that says on this data what the only cause does is that cause, whose law nobody knows to the last digit.
        """
        if not isinstance(self.replay, Replay):
            return None
        chosen = [one.hypothesis for one in selection.accepted]
        named = selector.evidence_of(chosen, selection.fit, selection.linearisation) - selector.evidence_of(
            [], selection.nothing, selection.linearisation
        )
        least = max(needed, named + MARGIN) if chosen else needed
        found = weigh_unknown(base.problem, self.replay, selection.nothing, base.at_nothing, least, self.seed)
        if found is not None and len(chosen) == 1 and selector.name(chosen[0]).partition(".")[0] in found.same_as:
            selection.decisions.append(f"refused {found.term.formula}: {selector.name(chosen[0])} in other words")
            return None
        return found

    def _localised(self, base: Base, selection: Selection) -> Localisation:
        if not isinstance(self.replay, Replay):
            return Localisation({}, {})
        return localise(self.replay, base, selection.nothing.theta, self.seed)

    def _priors(self) -> Priors:
        return Priors.of(self.replay.parameters)

    def _search(self, base: Base) -> tuple[Search, float]:
        """Hypotheses that the data can show, and the evidence that one of them needs."""
        self.clock.begin("threshold")
        excited = excited_columns(base.problem, base.at_nothing.informations)
        hypotheses = hypotheses_of(self.replay, list(excited))
        maxima = bootstrap_maxima(
            base.at_nothing.information,
            ratios(base.problem, ()),
            [one.columns for one in hypotheses],
            np.random.default_rng(self.seed),
        )
        needed = threshold(maxima, int(excited.sum()), len(self.replay.manoeuvres))
        return Search(base.problem, hypotheses, needed - REFIT_MARGIN), needed

    @property
    def _nameable(self) -> int:
        """Effects of the replay that may be causes."""
        return sum(effect.name not in FORM_NAMES for effect in self.replay.effects)

    def _forced(self, accepted: Accepted) -> list[int]:
        """Effects that these channels of a car cannot tell from an accepted one on any data."""
        if not isinstance(self.replay, Replay):
            return []
        channels = {name for manoeuvre in self.replay.manoeuvres for name in manoeuvre.channels}
        effects = self.replay.effects
        own = effects[accepted.hypothesis.effect].name
        return [
            k
            for k, effect in enumerate(effects)
            if effect.name != own and are_forced_together(channels, own, effect.name)
        ]

    def _diagnosis(
        self,
        search: Search,
        selection: Selection,
        details: Sequence[CauseDetail],
        wrong: WrongVehicle | None,
        shown: Excitation,
        guilty: Localisation,
        needed: float,
        unknown: FoundUnknown | None,
    ) -> tuple[Diagnosis, CarNumbers | None]:
        """The answer, and the car's own numbers where they are what it comes to."""
        found = [detail.cause for detail in details]
        terms = [unknown.answer] if unknown else []
        gain = gain_of(search.problem, selection, self.held_out, self.seed) if found else None
        if unknown:
            held_out = unknown.on(self.held_out) if isinstance(self.held_out, Replay) else None
            gain = gain_of(unknown.problem, unknown.selection, held_out, self.seed, unknown.theta_on)
        verdict = verdict_of(found, terms, self.faults, wrong, shown.insufficient, self._nameable)
        numbers = None
        if not found and not terms:
            numbers, gain = self._numbers(search, selection, wrong if verdict == "wrong_vehicle" else None)
        answer = Diagnosis(
            verdict=verdict,
            subject="wheel_on_rig" if isinstance(self.replay, RigReplay) else "car",
            data_faults=self.faults,
            causes=found,
            discovered_terms=terms,
            gain=gain,
            remarks=[
                *remarks_of(self.replay, selection, wrong, unknown),
                *place_remarks([find_effect(cause.effect) for cause in found], guilty.by_innovations),
            ],
            insufficient=list(shown.insufficient),
            detection_limits=dict(shown.by_column),
            guilty_equations=dict(guilty.by_equation_error),
            guilty_by_innovations=dict(guilty.by_innovations),
            probability_of_nothing=min((detail.alike.nothing for detail in details), default=None),
            threshold=needed,
        )
        return answer, numbers

    def _numbers(
        self, search: Search, selection: Selection, wrong: WrongVehicle | None
    ) -> tuple[CarNumbers | None, Gain | None]:
        """Another car's numbers with their gain; of this car those within its scatter, where held-out data proves them.

        A scatter says how far a file may be off: what is inside is no cause, and still better known now.
        """
        if self.held_out is None:
            return (None if wrong is None else wrong.numbers), None
        inside = numbers_within_scatter(search.problem, selection.linearisation, selection.nothing.theta)
        if wrong is not None and wrong.numbers is not None:
            return wrong.numbers, gain_of_numbers(inside.theta, wrong.numbers.theta, self.held_out, self.seed)
        gain = gain_of_numbers(None, inside.theta, self.held_out, self.seed)
        return (inside, gain) if gain is not None and is_proven(gain) else (None, None)

    def _findings(
        self,
        answer: Diagnosis,
        base: Base,
        selection: Selection,
        search: Search,
        unknown: FoundUnknown | None,
        numbers: CarNumbers | None,
    ) -> Findings:
        replay, held_out = self.replay, self.held_out
        theta = beyond = selection.fit.theta if answer.causes else np.zeros(len(replay.columns))
        if numbers is not None:
            theta = beyond = numbers.theta
        if unknown:
            replay, theta = unknown.replay, unknown.selection.fit.theta
            if isinstance(held_out, Replay):
                held_out, beyond = unknown.on(held_out), unknown.theta_on(held_out, theta)
        manoeuvres = manoeuvre_findings(replay, theta, held_out=False)
        if held_out is not None:
            manoeuvres += manoeuvre_findings(held_out, beyond, held_out=True)
        quadratic = base.problem.quadratic(base.at_nothing, base.problem.rows(base.nothing.theta), base.nothing.theta)
        linear = by_effect(
            search.hypotheses, linear_evidence(base.problem, quadratic, search.hypotheses), len(self.replay.effects)
        )
        return Findings(
            diagnosis=answer,
            vehicle=self.vehicle.name,
            manoeuvres=manoeuvres,
            sensor_std=noise_std(self.replay),
            evidence={
                effect.name: float(value)
                for effect, value in zip(self.replay.effects, linear, strict=True)
                if np.isfinite(value)
            },
            logs=self.logs,
            terms=[unknown.for_the_car] if unknown else [],
            numbers=numbers_of(self.replay, numbers, answer.gain),
        )
