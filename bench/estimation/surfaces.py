"""Comparison of two asphalts from stops on each: distance, and friction by the EKF and by the simple model.

Friction document 4.5 to 4.7: distances are corrected run by run, friction is the mean over the braking phase (0.4 s
after the brake start until 5 m/s). A difference is reported where it is larger than the smallest that counts and the
interval of 95 % leaves zero out.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.estimation.made_runs import make_run
from bench.estimation.offline import Request, run_offline
from bench.estimation.source import Source, open_source
from bench.estimation.surface_rules import KEPT, Rule, SurfaceRuns, check_rules
from bench.estimation.surfaces_file import ScenarioRuns, Surface, SurfaceComparisonFile
from bench.recording.arrays import FloatArray
from bench.verdict.assessment import Assessment, NoValueError
from signals.errors import InputError

CONFIDENCE = 0.95
INCONCLUSIVE_EXIT_CODE = 3
EKF, SIMPLE = "friction_ekf", "simple_braking"


@dataclass(frozen=True)
class Stop:
    """One run: start speed, distance from the onset of the deceleration, the same from the target speed, friction."""

    name: str
    start_speed_m_s: float
    distance_m: float
    corrected_distance_m: float
    friction: Mapping[str, float]
    friction_deviation: Mapping[str, float]


@dataclass(frozen=True)
class Difference:
    """Relative difference of two means with its interval of 95 %."""

    value: float
    low: float
    high: float
    reported: bool

    def as_json(self) -> dict[str, Any]:
        """The difference as plain data."""
        return {"value": self.value, "low": self.low, "high": self.high, "reported": self.reported}


@dataclass(frozen=True)
class SurfaceComparison:
    """What a comparison has shown."""

    title: str
    target_speed_m_s: float
    names: tuple[str, str]
    stops: tuple[Sequence[Stop], Sequence[Stop]]
    rules: Sequence[Rule]
    shortening: Difference
    friction: Mapping[str, Difference]

    @property
    def conclusive(self) -> bool:
        """True where all rules were kept."""
        return all(rule.verdict == KEPT for rule in self.rules)

    @property
    def verdict(self) -> str:
        """``inconclusive``, ``no difference``, or which surface has more grip by the EKF."""
        if not self.conclusive:
            return "inconclusive"
        found = self.friction[EKF]
        if not found.reported:
            return "no difference"
        return f"{self.names[1] if found.value > 0 else self.names[0]} has more grip"

    @property
    def exit_code(self) -> int:
        """Exit code of the command."""
        return 0 if self.conclusive else INCONCLUSIVE_EXIT_CODE


def compare_surfaces(file: SurfaceComparisonFile, folder: Path) -> SurfaceComparison:
    """Compare the surfaces of a file; ``folder`` is where its relative paths start.

    Raises
    ------
    InputError
        If a run cannot be read, has no stop, or lacks a signal.
    """
    from vehicle_model.vehicle_file import load_vehicle

    car = _beside(file.vehicle, folder)
    numbers = load_vehicle(car).numbers()
    channels = None if file.channels is None else folder / file.channels
    stops = [
        [measure_stop(source, numbers, file) for source in _sources(surface, folder, channels, car)]
        for surface in (file.reference, file.compared)
    ]
    return judge_stops(file, stops[0], stops[1])


def _beside(name: str, folder: Path) -> str:
    path = folder / name
    return str(path) if path.exists() else name


def _sources(surface: Surface, folder: Path, channels: Path | None, car: str) -> list[Source]:
    sources: list[Source] = []
    for entry in surface.runs:
        if isinstance(entry, ScenarioRuns):
            sources += run_scenario(entry, folder)
        else:
            sources.append(open_source(_beside(entry, folder), channels, car))
    return sources


def run_scenario(entry: ScenarioRuns, folder: Path) -> list[Source]:
    """Make the runs of a scenario in memory."""
    scenario = _beside(entry.scenario, folder)
    seeds = range(entry.seed, entry.seed + entry.repeat)
    return [make_run(scenario, entry.set, seed=seed, variant=entry.variant) for seed in seeds]


def measure_stop(source: Source, vehicle: Mapping[str, float], file: SurfaceComparisonFile) -> Stop:
    """Distance and friction of one stop.

    Raises
    ------
    InputError
        If the run has no stop, or lacks a signal.
    """
    record = file.record
    simple = {"grade": record.grade or 0.0, "head_wind": record.head_wind or 0.0}
    requests = [Request(EKF, EKF, file.estimator), Request(SIMPLE, SIMPLE, simple)]
    ekf, plain = run_offline(source, vehicle, requests)
    assessment = Assessment(source.data)
    try:
        start = assessment.metric("brake_start_speed")
        distance = assessment.metric("braking_distance")
        corrected = assessment.metric("braking_distance", {"target_speed": file.target_speed})
        phase = assessment.window("braking")
    except NoValueError as error:
        raise InputError(f"{source.path}: not a stop that can be compared: {error}") from None
    used = {
        EKF: np.abs(ekf.output("friction_used_mean")[phase]),
        SIMPLE: np.abs(plain.output("friction_used")[phase]),
    }
    return Stop(
        str(source.path),
        float(start),
        float(distance),
        float(corrected),
        {name: float(np.mean(values)) for name, values in used.items()},
        {name: float(np.std(values)) for name, values in used.items()},
    )


def judge_stops(file: SurfaceComparisonFile, reference: Sequence[Stop], compared: Sequence[Stop]) -> SurfaceComparison:
    """Rules and differences of the stops on two surfaces."""
    surfaces = [
        SurfaceRuns(
            surface.name,
            [stop.start_speed_m_s for stop in stops],
            distances := [stop.corrected_distance_m for stop in stops],
            _variation(distances),
        )
        for surface, stops in ((file.reference, reference), (file.compared, compared))
    ]
    least = file.smallest_difference
    longer = difference(surfaces[0].distances, surfaces[1].distances, least)
    friction = {
        name: difference([stop.friction[name] for stop in reference], [stop.friction[name] for stop in compared], least)
        for name in (EKF, SIMPLE)
    }
    return SurfaceComparison(
        file.title,
        file.target_speed,
        (file.reference.name, file.compared.name),
        (reference, compared),
        check_rules(file.record, surfaces),
        Difference(-longer.value, -longer.high, -longer.low, longer.reported),
        friction,
    )


def _variation(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1) / np.mean(values)) if len(values) > 1 else math.inf


def difference(reference: Sequence[float], compared: Sequence[float], least: float) -> Difference:
    """Relative difference of the means (compared over reference, less one), by Welch's interval.

    Parameters
    ----------
    least : float
        Magnitude below which no difference is reported.
    """
    from scipy.stats import t

    a: FloatArray = np.asarray(reference, np.float64)
    b: FloatArray = np.asarray(compared, np.float64)
    value = float(b.mean() / a.mean() - 1.0)
    if len(a) < 2 or len(b) < 2:
        return Difference(value, -math.inf, math.inf, False)
    share_a, share_b = float(a.var(ddof=1)) / len(a), float(b.var(ddof=1)) / len(b)
    spread = math.sqrt(share_a + share_b)
    half = 0.0
    if spread > 0.0:
        freedom = (share_a + share_b) ** 2 / (share_a**2 / (len(a) - 1) + share_b**2 / (len(b) - 1))
        half = float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * spread / float(a.mean())
    low, high = value - half, value + half
    return Difference(value, low, high, abs(value) >= least and low * high > 0.0)
