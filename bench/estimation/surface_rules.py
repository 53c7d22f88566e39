"""The nine rules of a comparison of asphalts, checked on record and runs (friction document 4.5, l. 1608-1658)."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from bench.estimation.surfaces_file import TestRecord

LEAST_RUNS = 5
LARGEST_VARIATION = 0.03
LEAST_START_SPEED_M_S = 60 / 3.6
# what "some years", "calm", "nearly equal" and "flat" mean is assumed
LEAST_YEARS = 1.0
CALM_M_S = 3.0
NEARLY_EQUAL_K = 5.0
FLAT_RAD = 0.005
KEPT, BROKEN, UNKNOWN = "kept", "broken", "unknown"


@dataclass(frozen=True)
class Rule:
    """A rule, whether it was kept, and what that follows from."""

    number: int
    text: str
    verdict: str
    found: str

    def as_json(self) -> dict[str, Any]:
        """The rule as plain data."""
        return asdict(self)


@dataclass(frozen=True)
class SurfaceRuns:
    """What the rules ask of the runs on one surface: start speeds [m/s] and corrected distances [m]."""

    name: str
    start_speeds: Sequence[float]
    distances: Sequence[float]
    variation: float


def check_rules(record: TestRecord, surfaces: Sequence[SurfaceRuns]) -> list[Rule]:
    """The nine rules in their order."""
    return [
        _rule(1, "some years after paving", _at_least(record.years_since_paving, LEAST_YEARS, "years")),
        _rule(
            2, "clean and dry surfaces (or one film of water), calm air or wind corrected",
            _said(record.surfaces_cleaned, "cleaned"), _said(record.surfaces_as_wanted, "as wanted"), _wind(record),
        ),
        _rule(
            3, "surface and air nearly as warm, discs and tyres checked before each run",
            _temperatures(record), _said(record.temperatures_checked, "discs and tyres checked"),
        ),
        _rule(
            4, "stability systems on, start from 60 km/h or more",
            _said(record.stability_systems_on, "systems on"), _start_speeds(surfaces),
        ),
        _rule(
            5, "qualified driver, same car and tyres",
            _said(record.qualified_driver, "qualified driver"), _said(record.same_car_and_tyres, "same car and tyres"),
        ),
        _rule(6, "straight and flat, or corrected for the slope", _said(record.straight, "straight"), _grade(record)),
        _rule(7, "brake pressed as fast and fully as possible", _said(record.pedal_fast_and_full, "fast and full")),
        _rule(
            8, "at least 5 runs on each, all used, coefficient of variation below 3 %",
            _said(record.all_runs_used, "all runs used"), *(_repeated(surface) for surface in surfaces),
        ),
        _rule(9, "distances corrected by (target speed / start speed)²", (KEPT, "each run by itself")),
    ]  # fmt: skip


Finding = tuple[str, str]


def _rule(number: int, text: str, *findings: Finding) -> Rule:
    verdicts = [verdict for verdict, _ in findings]
    worst = BROKEN if BROKEN in verdicts else UNKNOWN if UNKNOWN in verdicts else KEPT
    return Rule(number, text, worst, "; ".join(found for _, found in findings))


def _said(value: bool | None, text: str) -> Finding:
    if value is None:
        return UNKNOWN, f"{text}: not recorded"
    return (KEPT, text) if value else (BROKEN, f"not {text}")


def _at_least(value: float | None, least: float, unit: str) -> Finding:
    if value is None:
        return UNKNOWN, f"{unit}: not recorded"
    return KEPT if value >= least else BROKEN, f"{value:g} {unit}"


def _wind(record: TestRecord) -> Finding:
    if record.wind_speed is None:
        return UNKNOWN, "wind: not recorded"
    if record.wind_speed <= CALM_M_S:
        return KEPT, f"wind {record.wind_speed:g} m/s"
    if record.head_wind is None:
        return BROKEN, f"wind {record.wind_speed:g} m/s, its direction not recorded"
    return KEPT, f"wind corrected, {record.head_wind:g} m/s against the car"


def _temperatures(record: TestRecord) -> Finding:
    if record.air_temperature is None or record.surface_temperature is None:
        return UNKNOWN, "temperatures of air and surface: not recorded"
    apart = abs(record.surface_temperature - record.air_temperature)
    return KEPT if apart <= NEARLY_EQUAL_K else BROKEN, f"{apart:.3g} K apart"


def _grade(record: TestRecord) -> Finding:
    if record.grade is None:
        return UNKNOWN, "slope: not recorded"
    return KEPT, "flat" if abs(record.grade) <= FLAT_RAD else f"corrected for a slope of {100 * record.grade:.2g} %"


def _start_speeds(surfaces: Sequence[SurfaceRuns]) -> Finding:
    slowest = min(min(surface.start_speeds) for surface in surfaces)
    return KEPT if slowest >= LEAST_START_SPEED_M_S else BROKEN, f"slowest start {3.6 * slowest:.1f} km/h"


def _repeated(surface: SurfaceRuns) -> Finding:
    runs, variation = len(surface.distances), surface.variation
    kept = runs >= LEAST_RUNS and variation < LARGEST_VARIATION
    return KEPT if kept else BROKEN, f"{surface.name}: {runs} runs, {100 * variation:.2f} %"
