"""The vehicle-state document's criteria on the MuJoCo car, over the seeds that judge: reported beside the planar car.

The document defines no such car, so that its limits do not bind here. Each miss has its physical reason measured: the
property of the car that the observers do not know is taken away, and the criterion is then met.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
from state_runs import ALL_NOISE, SEEDS, TUNING_SEEDS, WHEELS, Replay, drive, errors_of, fits_of, forget_drives
from state_runs import rmse_percent as percent
from test_state_document import LAUNCHES, SLALOMS
from test_state_document_grade import HILLS, section

Record = Callable[..., None]

STIFF_BODY = {"suspension__front__anti_roll_rate": 9e5, "suspension__rear__anti_roll_rate": 9e5}
"""A body that hardly leans; the filter's own lean is then switched off as well."""
NO_LEAN = {"lateral.roll_compensation": False}
STIFF_STEERING = {"steering__stiffness": 2e5}


@pytest.fixture(scope="module", autouse=True)
def _runs_are_dropped() -> Iterator[None]:
    yield
    slaloms.cache_clear()
    forget_drives()


def replays(scenario: str, name: str, settings: dict[str, Any], seeds: Any = SEEDS, **changes: Any) -> Iterator[Replay]:
    run = drive(scenario, plant="mujoco", **changes)
    for seed in seeds:
        yield Replay(run, name, settings, seed=seed, noise=ALL_NOISE)


@cache
def slaloms(surface: str) -> tuple[Any, Any]:
    """Errors and fits of all seeds."""
    run = drive(f"state/slalom_{surface}", plant="mujoco")
    found = list(replays(f"state/slalom_{surface}", "vehicle_state_ukf", {}))
    return [errors_of(run, one) for one in found], [event for one in found for event in fits_of(run, one)]


def note_fits(record: Record, surface: str, fits: list[dict[str, Any]], direction: str, identifier: str) -> None:
    """Where fits came, and what they told: share of the peak, R^2, D and B against the car's own curve."""

    def told(name: str, value: float, limit: str = "reported") -> None:
        record(f"MuJoCo, {surface}: {name}", value, limit, id=identifier)

    chosen = [event for event in fits if event["direction"] == direction]
    told("fits per run", len(chosen) / len(SEEDS))
    for wheel in WHEELS:
        told(f"fits of {wheel} per run", sum(event["wheel"] == wheel for event in chosen) / len(SEEDS))
    if not chosen:
        return
    shares, errors = (np.array([event[key] for event in chosen]) for key in ("true_share", "error"))
    told("share of the true peak, median", float(np.median(shares)), "0.45 ... 0.65, longitudinal 0.71 ... 0.80")
    told("share of the true peak, smallest", float(shares.min()))
    told("share of the true peak, largest", float(shares.max()), "<= 0.765, longitudinal 0.80")
    told("part of the fits within", float(np.mean((shares >= 0.71) & (shares <= 0.80))))
    told("R^2, smallest", min(event["r_squared"] for event in chosen), ">= 0.90")
    told("median error of D %", 100.0 * float(np.median(np.abs(errors))))
    told("mean error of D %", 100.0 * float(np.mean(errors)))
    told("median B", float(np.median([event["stiffness"] for event in chosen])))
    for sign, name in ((1.0, "right"), (-1.0, "left")):
        told(f"part of the fits to the {name}", float(np.mean([event["sign"] == sign for event in chosen])))


@pytest.mark.acceptance("V-25", "V-34", "V-54", "V-55")
@pytest.mark.parametrize("surface", SLALOMS)
def test_slalom(surface: str, record: Record) -> None:
    errors, fits = slaloms(surface)
    for quantity in errors[0]:
        limit = f"planar car: <= {SLALOMS[surface][quantity]}" if quantity in SLALOMS[surface] else "reported"
        means = [float(np.mean([run[quantity][base] for run in errors])) for base in (0, 1)]
        record(f"MuJoCo, {surface}: {quantity} %", means[0], limit, id="V-25")
        record(f"MuJoCo, {surface}: {quantity} % of mean x", means[1], "reported", id="V-54")
        assert np.isfinite(means).all()
    note_fits(record, surface, fits, "lateral", "V-34")
    assert len(errors) >= 20


@pytest.mark.acceptance("V-25", "V-34")
def test_a_body_that_leans_and_a_steering_that_yields_are_the_reason(record: Record) -> None:
    """Slip angles and fits of the dry slalom with a body that does not lean, then with a stiff steering as well.

    The centre of gravity rides 0.6 m above the wheels' tracks on a body that leans by up to 5 degrees: its lateral
    speed contains the lean's rate, by which the wheels' slip angles lag or lead; the filter's flat car has neither. A
    steering that yields turns the front wheels by some per cent less than its map says.
    """
    found = {}
    for name, settings, changes in (
        ("as it is", {}, {}),
        ("stiff body", NO_LEAN, STIFF_BODY),
        ("stiff body and steering", NO_LEAN, {**STIFF_BODY, **STIFF_STEERING}),
    ):
        run = drive("state/slalom_dry_asphalt", plant="mujoco", **changes)
        runs = list(
            replays("state/slalom_dry_asphalt", "vehicle_state_ukf", settings, seeds=TUNING_SEEDS[:5], **changes)
        )
        errors = [errors_of(run, one) for one in runs]
        fits = [event for one in runs for event in fits_of(run, one)]
        found[name] = {axle: float(np.mean([error[axle][0] for error in errors])) for axle in ("a_y", "front", "rear")}
        found[name]["wheels"] = len({event["wheel"] for event in fits})
        found[name]["share"] = max(event["true_share"] for event in fits)
        true = run["slip_angle_rl"]
        ratio = float(np.mean([one["slip_angle_rl"] @ true / (true @ true) for one in runs]))
        record(f"MuJoCo, {name}: rear slip angle over the true one", ratio, "1", id="V-25")
        leans, turns = run["roll_angle"], run["steering_wheel_angle"] / 16.0
        ratio = float(np.mean([one["roll_angle"] @ leans / (leans @ leans) for one in runs]))
        record(f"MuJoCo, {name}: lean that the filter knows over the true one", ratio, "1", id="V-25")
        ratio = float(run["true_road_wheel_angle_fl"] @ turns / (turns @ turns))
        record(f"MuJoCo, {name}: angle of the front wheel over that of the map", ratio, "1", id="V-25")
        error = 100.0 * float(np.mean([event["error"] for event in fits]))
        record(f"MuJoCo, {name}: mean error of D %", error, "reported", id="V-34")
        lean = float(np.degrees(np.abs(run["roll_angle"]).max()))
        record(f"MuJoCo, {name}: largest lean deg", lean, "reported", id="V-25")
        for axle in ("front", "rear"):
            record(f"MuJoCo, {name}: {axle} slip angle %", found[name][axle], "reported", id="V-25")
        record(f"MuJoCo, {name}: wheels with fits", found[name]["wheels"], "4", id="V-34")
    limits = SLALOMS["dry_asphalt"]
    assert found["as it is"]["rear"] > limits["rear"]
    assert found["as it is"]["wheels"] < 4
    assert found["stiff body"]["rear"] < 0.25 * found["as it is"]["rear"]
    assert found["stiff body"]["wheels"] == 4
    assert found["stiff body and steering"]["front"] < 0.5 * found["stiff body"]["front"]
    assert all(found["stiff body"][quantity] <= limits[quantity] for quantity in ("a_y", "front", "rear"))
    assert found["stiff body"]["share"] <= 0.765


@pytest.mark.acceptance("V-35", "V-36", "V-43", "V-44", "V-45", "V-54", "V-55")
@pytest.mark.parametrize("surface", LAUNCHES)
def test_launch(surface: str, record: Record) -> None:
    identifier = {"ice": "V-43", "icy_snow": "V-44", "dry_asphalt": "V-45"}[surface]
    run = drive(f"state/launch_{surface}", plant="mujoco")
    part = run["time"] > 1.0
    pairs = {"v_x": ("speed", "speed"), "a_x": ("true_longitudinal_acceleration", "longitudinal_acceleration")}
    pairs |= {f"friction {wheel}": (f"friction_used_{wheel}", f"friction_used_{wheel}") for wheel in ("fl", "fr")}
    errors: dict[str, list[tuple[float, float]]] = {name: [] for name in pairs}
    for found in replays(f"state/launch_{surface}", "wheel_sliding_mode", {}):
        for name, (true, told) in pairs.items():
            errors[name].append(percent(run[true][part], found[told][part]))
    fits = [e for found in replays(f"state/launch_{surface}", "magic_formula_fit", {}) for e in fits_of(run, found)]
    limits = dict(zip(("v_x", "a_x"), LAUNCHES[surface], strict=True))
    for name, values in errors.items():
        means = np.mean(values, axis=0)
        limit = f"planar car: <= {limits[name]}" if name in limits else "reported"
        record(f"MuJoCo, {surface}: {name} %", float(means[0]), limit, id=identifier)
        record(f"MuJoCo, {surface}: {name} % of mean x", float(means[1]), "reported", id="V-54")
    longitudinal = [event for event in fits if event["direction"] == "longitudinal"]
    note_fits(record, surface, longitudinal, "longitudinal", "V-35")
    if surface == "dry_asphalt":
        record("MuJoCo, longitudinal fits on a dry launch", len(longitudinal), "0", id="V-36")


@pytest.mark.acceptance("V-27")
def test_jump_of_friction_in_a_bend(record: Record) -> None:
    run = drive("state/mu_jump_in_bend", plant="mujoco")
    clock = run["time"]
    for found in replays("state/mu_jump_in_bend", "vehicle_state_ukf", {}):
        limit = np.mean([found[f"friction_limit_lateral_{w}"] for w in WHEELS], axis=0)
        before, low, after = (limit[(clock > a) & (clock < b)].mean() for a, b in ((5, 6), (9, 10), (12, 14)))
        record("MuJoCo, estimate before the jump", before, "reported")
        record("MuJoCo, estimate in the jump", low, "reported: planar car < 0.8 of before")
        record("MuJoCo, estimate after the jump", after, "reported: planar car > 1.15 of that in the jump")
        record("MuJoCo, lateral fits in the bend", len(found.estimator.events()), "reported")
    told = {}
    for name, settings, changes in (("", {}, {}), ("stiff body", NO_LEAN, STIFF_BODY)):
        told[name] = [
            len(found.estimator.events())
            for found in replays(
                "state/mu_jump_in_bend", "vehicle_state_ukf", settings, seeds=TUNING_SEEDS[:5], **changes
            )
        ]
    record("MuJoCo, lateral fits in the bend with a stiff body", float(np.mean(told["stiff body"])), "reported")


@pytest.mark.acceptance("V-46")
def test_split_friction(record: Record) -> None:
    run = drive("state/launch_split", plant="mujoco")
    part = (run["time"] > 3.0) & (run["time"] < 5.0)
    for found in replays("state/launch_split", "wheel_sliding_mode", {}):
        left, right = (np.mean(found[f"slip_{w}"][part]) for w in ("fl", "fr"))
        record("MuJoCo, slip right over left", float(right / left), "> 1.2 on the planar car")
        assert np.isfinite(right / left)


@pytest.mark.acceptance("V-50", "V-51", "V-55")
@pytest.mark.parametrize(("grade", "length", "way"), HILLS)
def test_hills(grade: int, length: int, way: str, record: Record) -> None:
    forget_drives()  # all signals of one take a third of a gigabyte
    run = drive(f"state/hill_{grade}_{way}", plant="mujoco")
    true = grade / 100.0 if way == "up" else -grade / 100.0
    results = [section(run, found) for found in replays(f"state/hill_{grade}_{way}", "road_grade", {})]
    error = 100.0 * abs(np.mean([mean for mean, _ in results]) / true - 1.0)
    worst = max(abs(found - length) for _, found in results)
    record(f"MuJoCo, {grade} % {way}: error of the mean %", float(error), "planar car: <= 6.2", id="V-50")
    record(f"MuJoCo, {grade} % {way}: error of the length m", float(worst), "planar car: <= 10", id="V-51")
    assert np.isfinite([error, worst]).all()
