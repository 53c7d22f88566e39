"""Every fault of the catalogue by name: neutral values change nothing, each example changes the run."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bench
from bench.scenario.fault_catalogue import FAULTS, PhysicalFault
from bench.scenario.resolution import resolve
from bench.scenario.schema import ScenarioFile
from vehicle_model.vehicle_file import load_vehicle, parameter_table

ROOT = Path(__file__).parents[3]
SCENARIOS = sorted(
    str(path.relative_to(ROOT / "scenarios").with_suffix(""))
    for group in ("faults", "regulation")
    for path in (ROOT / "scenarios" / group).glob("*.yaml")
    if not path.name.startswith(("can_", "e5_"))  # those of the bus have tests of their own
)
TABLE = {info.path: info for info in parameter_table(load_vehicle("ekf_car"))}
# parameters with a neutral value that choose a model or describe a healthy part, and are no faults
NO_FAULTS = {
    "hydraulics.active_build_up",
    "hydraulics.rearm_near_target",
    "hydraulics.flow_through",
    "hydraulics.literal_event",
    "hydraulics.circuit_split",
    "sensors.wheel_speed.pitch_error",
    "sensors.wheel_speed.edge_jitter",
    "sensors.wheel_speed.timer_resolution",
    *(f"sensors.inertial.position_{axis}" for axis in "xyz"),
}


def test_catalogue_names_every_fault_parameter_and_nothing_else() -> None:
    named = {path for fault in FAULTS for path in fault.paths()}
    sections = ("hydraulics.", "brakes.", "sensors.")
    with_neutral = {
        path for path, info in TABLE.items() if path.startswith(sections) and info.neutral is not None
    } - NO_FAULTS
    with_neutral = {path for path in with_neutral if not path.endswith((".noise", ".resolution"))}
    assert named == with_neutral
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_example_is_allowed_and_not_neutral(fault: PhysicalFault) -> None:
    info = TABLE[fault.example_path]
    assert fault.example != info.neutral
    assert info.low is None or fault.example >= info.low
    assert info.high is None or fault.example <= info.high
    if fault.scenario:
        assert (ROOT / "scenarios" / f"{fault.scenario}.yaml").exists()


@pytest.fixture(scope="module")
def abs_stop() -> ScenarioFile:
    """A short ABS stop with light braking before it, so that every part of brakes and sensors does something."""
    steps = [
        {
            "name": "press",
            "brake": {"pedal_force": 60, "ramp": 2000},
            "steer": {"follow": "straight"},
            "until": {"time": 0.4},
        },
        {"name": "brake", "brake": {"pedal_force": 500, "ramp": 8000}, "until": {"signal": "speed", "below": 1.0}},
        {"name": "stand", "release": True, "until": {"after": 0.2}},
    ]
    changes = {
        "manoeuvre": {"steps": steps},
        "initial_speed": 10.0,
        "road": {"surface": "dry_asphalt", "friction": 0.5, "left": {"friction": 0.6}},
        "overrides": {"brakes.front.disc_start_temperature": 500.0, "brakes.rear.disc_start_temperature": 500.0},
        "estimators": {},
        "criteria": [],
        "time_limit": 2.4,
    }
    return resolve("stops/dry", changes, ecu="inprocess", pacing="lockstep")


def rows(scenario: ScenarioFile, overrides: dict[str, float]) -> np.ndarray:
    changed = scenario.model_copy(update={"overrides": {**scenario.overrides, **overrides}})
    data = bench.run(changed, record=False).data
    return np.array([data.array(name) for name in data.names])


@pytest.fixture(scope="module")
def healthy(abs_stop: ScenarioFile) -> np.ndarray:
    return rows(abs_stop, {})


def test_neutral_values_of_all_faults_leave_the_run_bit_for_bit(abs_stop: ScenarioFile, healthy: np.ndarray) -> None:
    neutral = {path: TABLE[path].neutral for fault in FAULTS for path in fault.paths()}
    # what the car itself sets to another value (eccentric rings) is a property of this car
    neutral = {path: value for path, value in neutral.items() if TABLE[path].value == value}
    assert len(neutral) > 150
    assert np.array_equal(rows(abs_stop, neutral), healthy, equal_nan=True)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_changes_the_run(fault: PhysicalFault, abs_stop: ScenarioFile, healthy: np.ndarray) -> None:
    if fault.group == "other sensors":  # they show at once, long before the car stands
        abs_stop = abs_stop.model_copy(update={"time_limit": 1.2})
    faulty = rows(abs_stop, {fault.example_path: fault.example})
    common = min(faulty.shape[1], healthy.shape[1])
    assert not np.array_equal(faulty[:, :common], healthy[:, :common], equal_nan=True)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_can_begin_on_line(fault: PhysicalFault, abs_stop: ScenarioFile, healthy: np.ndarray) -> None:
    """Bit for bit the healthy run until the stimulus, another one soon after it."""
    begins_s = 0.43  # while the pedal goes down
    stimulus = {"target": fault.example_path, "when": {"time": begins_s}, "step": fault.example}
    values = abs_stop.model_dump(by_alias=True) | {"stimuli": [stimulus], "time_limit": 1.2}
    data = bench.run(ScenarioFile.model_validate(values), record=False).data
    names = [name for name in data.names if name != "faults_active"]  # counts stimuli
    faulty = np.array([data.array(name) for name in names])
    plain = healthy[[data.names.index(name) for name in names]]
    before, common = round(begins_s * 1000), min(faulty.shape[1], plain.shape[1])
    assert np.array_equal(faulty[:, :before], plain[:, :before], equal_nan=True)
    assert not np.array_equal(faulty[:, before:common], plain[:, before:common], equal_nan=True)


@pytest.mark.parametrize("name", SCENARIOS)
def test_shipped_scenario_of_a_fault_or_a_regulation_passes(name: str) -> None:
    run = bench.run(name, ecu="inprocess", pacing="lockstep", record=False)
    assert run.verdict.verdict == "pass", [(c.id, c.value, c.reason) for c in run.verdict.criteria]


def test_fault_set_on_line_begins_when_told(abs_stop: ScenarioFile, short_stop: Callable[..., ScenarioFile]) -> None:
    stimuli = [{"target": "sensors.yaw_rate.offset", "when": {"time": 0.3}, "step": 0.1}]
    scenario = ScenarioFile.model_validate(abs_stop.model_dump(by_alias=True) | {"stimuli": stimuli})
    run, plain = (bench.run(s, record=False).data.array("yaw_rate") for s in (scenario, abs_stop))
    difference = run[:700] - plain[:700]
    assert np.all(difference[:295] == 0.0)
    assert difference[320:700].mean() == pytest.approx(0.1, abs=0.01)
