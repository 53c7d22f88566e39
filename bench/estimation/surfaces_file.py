"""Files of ``bench compare-surfaces``: two asphalts, stops on each, and what is known of the tests.

.. code-block:: yaml

    title: site 1, dry
    target_speed: 100 km/h
    vehicle: asphalt_car
    record: {years_since_paving: 4, surfaces_cleaned: true, ...}
    reference:
      name: conventional
      runs: [runs/conventional-1, runs/conventional-2, ...]
    compared:
      name: rubber-bitumen
      runs: [runs/rubber-1, ...]
"""

from typing import Any, Literal

from pydantic import Field

from signals.quantities import FileModel, parameter

_RULES = "friction document 4.5"


class TestRecord(FileModel):
    """What is known of the tests; what is left out is unknown, and the rule that asks for it not shown to be kept."""

    years_since_paving: float | None = parameter(
        "1", None, low=0.0, high=100.0, description="rule 1: years since both surfaces were built", source=_RULES
    )
    surfaces_cleaned: bool | None = Field(default=None, description="rule 2: no soil, dust or gravel")
    surfaces_as_wanted: bool | None = Field(
        default=None, description="rule 2: both dried, or for a wet test both under the same film of water"
    )
    wind_speed: float | None = parameter("m/s", None, low=0.0, high=60.0, description="rule 2", source=_RULES)
    head_wind: float | None = parameter(
        "m/s", None, low=-60.0, high=60.0, description="rule 2: where it is not calm, its part against the car"
    )
    air_temperature: float | None = Field(default=None, ge=-60.0, le=60.0, description="rule 3, in degrees Celsius")
    surface_temperature: float | None = Field(default=None, ge=-60.0, le=90.0, description="rule 3, in degrees Celsius")
    temperatures_checked: bool | None = Field(
        default=None, description="rule 3: discs and tyres before each run, after conditioning stops"
    )
    stability_systems_on: bool | None = Field(default=None, description="rule 4: they hold the slip near its best")
    qualified_driver: bool | None = Field(default=None, description="rule 5")
    same_car_and_tyres: bool | None = Field(default=None, description="rule 5: on both surfaces, wear watched")
    straight: bool | None = Field(default=None, description="rule 6")
    grade: float | None = parameter(
        "rad", None, low=-0.3, high=0.3, description="rule 6: slope of the road, uphill positive", source=_RULES
    )
    pedal_fast_and_full: bool | None = Field(default=None, description="rule 7: as fast and fully as possible")
    all_runs_used: bool | None = Field(default=None, description="rule 8: no run was left out")


class ScenarioRuns(FileModel):
    """Runs that are made of a scenario, in place of recordings."""

    scenario: str = Field(description="id of a scenario, or a path")
    variant: str | None = Field(default=None, description="variant of the scenario")
    set: dict[str, Any] = Field(default={}, description="path: value, as for --set")
    repeat: int = Field(default=5, ge=1, le=1000, description="number of runs; their seeds count up")
    seed: int = Field(default=1, ge=0, description="of the first run")


class Surface(FileModel):
    """A surface and the stops on it."""

    name: str = Field(min_length=1, description="in the result")
    runs: list[str | ScenarioRuns] = Field(
        min_length=1, description="run folders or logs (a path, or one relative to this file), or runs of a scenario"
    )


class SurfaceComparisonFile(FileModel):
    """A comparison of two surfaces."""

    format: Literal[1] = 1
    title: str = Field(default="", description="of the result")
    target_speed: float = parameter(
        "m/s", low=60 / 3.6, high=70.0, description="speed that distances are corrected to", source="rules 4 and 9"
    )
    vehicle: str = Field(description="car: name of a shipped one or path of a file")
    channels: str | None = Field(default=None, description="channel map of measured logs, path relative to this file")
    record: TestRecord = Field(default_factory=TestRecord, description="what is known of the tests")
    reference: Surface = Field(description="surface to compare with")
    compared: Surface = Field(description="surface that is compared")
    smallest_difference: float = parameter(
        "1", 0.02, low=0.0, high=0.5, description="a smaller difference is not reported as one", source="assumed"
    )
    estimator: dict[str, Any] = Field(
        default={"torque_mode": "z2"}, description="settings of the friction EKF (docs/estimators.md)"
    )
