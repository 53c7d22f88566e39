"""Why the lateral fits of the vehicle-state observers come out too high on the MuJoCo car, by substitution.

The document defines no such car; V-34 is reported there (``test_state_mujoco.py``). Without noise, one part of a pair
after the other is replaced by the truth: what a fit then finds tells which part is wrong.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
from state_pairs import Pairs, age, delayed, flat_slip_angle, low_pass, tyre_slip_angle
from state_runs import ALL_NOISE, SEEDS, WHEELS, Replay, drive, errors_of, fits_of, forget_drives
from test_state_document import SLALOMS

Record = Callable[..., None]

STIFF_BODY = {"suspension__front__anti_roll_rate": 9e5, "suspension__rear__anti_roll_rate": 9e5}
STIFF_STEERING = {"steering__stiffness": 2e5}
NO_TRAIL = {"tyres__front__pneumatic_trail": 0.0, "tyres__rear__pneumatic_trail": 0.0}
NO_LEAN = {"lateral.roll_compensation": False}
SWAY = {"lateral.body_sway": True}
CARS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "as it is": ({}, {}),
    "sway told": (SWAY, {}),
    "sway told, stiff steering": (SWAY, STIFF_STEERING),
    "stiff body and steering": (NO_LEAN, {**STIFF_BODY, **STIFF_STEERING}),
}
AXLES = {"front": ("fl", "fr"), "rear": ("rl", "rr")}


@pytest.fixture(scope="module", autouse=True)
def _runs_are_dropped() -> Iterator[None]:
    yield
    pairs_of.cache_clear()
    forget_drives()


@cache
def pairs_of(scenario: str, car: str) -> Pairs:
    settings, changes = CARS[car]
    return Pairs(drive(f"state/{scenario}", plant="mujoco", **changes), settings)


def error_percent(fits: list[dict[str, Any]]) -> float:
    return 100.0 * float(np.mean([event["error"] for event in fits]))


def ages(pairs: Pairs, name: str) -> tuple[float, float]:
    """How old slip angle and friction of a wheel's pairs are [ms], the low-pass of both included."""
    wheel = pairs.wheel(name)
    return age(wheel.slip_angle, wheel.true_slip_angle), age(wheel.friction, wheel.true_friction)


def substituted(pairs: Pairs, names: tuple[str, ...], part: str) -> list[dict[str, Any]]:
    """Fits of an axle with the pairs' ``part`` replaced by the truth."""
    found = []
    for name in names:
        wheel = pairs.wheel(name)
        slip, friction, now = wheel.slip_angle, wheel.friction, wheel.now
        if part in ("slip angle", "both"):
            slip, now = low_pass(wheel.true_slip_angle), np.abs(wheel.true_slip_angle)
        if part in ("friction", "both"):
            friction = low_pass(wheel.true_friction)
        if part == "same age":
            late = np.subtract(*reversed(ages(pairs, name)))
            slip, now = delayed(slip, late), delayed(now, late)
        found += pairs.fits(wheel, slip, friction, now)
    return found


def test_own_pairs_make_the_filters_own_fits() -> None:
    """The experiment's engine is the filter's: fed with its pairs it finds its fits."""
    pairs = pairs_of("slalom_dry_asphalt", "as it is")
    for name in WHEELS:
        wheel = pairs.wheel(name)
        found = pairs.fits(wheel, wheel.slip_angle, wheel.friction, wheel.now)
        assert [event["limit"] for event in found] == [event["limit"] for event in pairs.events(name)]
    assert len(pairs.estimator.events()) >= 20


@pytest.mark.acceptance("V-34")
@pytest.mark.parametrize("axle", AXLES)
def test_the_curve_of_the_tyre_is_found_from_true_pairs(axle: str, record: Record) -> None:
    """With the tyre's own slip angle and friction D is right: neither load, combined slip nor the shape is the reason.

    The low-pass of 30 ms is on both; the car is as it is. Judged by the document's own measure of a fit, AC-30.
    """
    fits = substituted(pairs_of("slalom_dry_asphalt", "as it is"), AXLES[axle], "both")
    record(f"MuJoCo, dry slalom, true pairs: fits of an axle, {axle}", len(fits), "24: each half-wave, both wheels")
    median = 100.0 * float(np.median([abs(event["error"]) for event in fits]))
    record(f"MuJoCo, dry slalom, true pairs: mean error of D %, {axle}", error_percent(fits), "reported")
    record(f"MuJoCo, dry slalom, true pairs: median error of D %, {axle}", median, "<= 5 (AC-30)")
    assert len(fits) == 24
    assert median <= 5.0


@pytest.mark.acceptance("V-34")
@pytest.mark.parametrize("axle", AXLES)
def test_the_centre_of_gravity_sways_over_the_wheels(axle: str, record: Record) -> None:
    """Tyre's slip angle less that of a flat car: h times the roll rate over the speed, which puts the latter ahead."""
    run = pairs_of("slalom_dry_asphalt", "as it is").run
    height = run.vehicle["body.centre_of_gravity_height"]
    for name in AXLES[axle]:
        rolling = (run["true_roll_rate"] / run[f"wheel_centre_speed_{name}"])[2000:]
        gap = (tyre_slip_angle(run, name) - flat_slip_angle(run, name))[2000:]
        lever = float(gap @ rolling / (rolling @ rolling))
        rest = float(np.degrees(np.std(gap - lever * rolling)))
        ahead = -age(flat_slip_angle(run, name)[::10], tyre_slip_angle(run, name)[::10])
        record(f"MuJoCo: sway, m per rad of roll, {axle}", lever, f"{height} m, the centre's height")
        record(f"MuJoCo: sway, rest deg, {axle}", rest, "reported")
        record(f"MuJoCo: slip angle of a flat car is ahead by ms, {axle}", ahead, "reported")
        assert lever == pytest.approx(height, rel=0.1)
        assert rest < 0.3 * float(np.degrees(np.std(gap)))
        assert 20.0 < ahead < 70.0


@pytest.mark.acceptance("V-34")
def test_friction_that_is_older_than_its_slip_angle_is_the_reason(record: Record) -> None:
    """Ages of both parts of a pair, and D from pairs of one age: the table of the results page.

    Friction that is older than its slip angle makes a softer, straighter curve, which ends higher.
    """
    found: dict[tuple[str, str], float] = {}
    for car in CARS:
        pairs = pairs_of("slalom_dry_asphalt", car)
        for axle, names in AXLES.items():
            both = np.mean([ages(pairs, name) for name in names], axis=0)
            for what, value in zip(("slip angle", "friction"), both, strict=True):
                record(f"MuJoCo, {car}: age of the {what} ms, {axle}", float(value), "40, the low-pass and a step")
            for part in ("own", "slip angle", "friction", "same age"):
                fits = substituted(pairs, names, part)
                record(f"MuJoCo, {car}: {part}: fits per wheel, {axle}", 0.5 * len(fits), "12 half-waves")
                found[car, f"{part} {axle}"] = error_percent(fits) if len(fits) >= 12 else np.nan
                if len(fits) >= 12:
                    record(f"MuJoCo, {car}: {part}: mean error of D %, {axle}", error_percent(fits), "reported")
            found[car, f"older {axle}"] = float(both[1] - both[0])
    for axle in AXLES:
        assert found["as it is", f"older {axle}"] > 20.0
        # told of the sway the slip angle is as old as it should be, within what is left of the lean
        assert found["sway told", f"older {axle}"] < 0.6 * found["as it is", f"older {axle}"]
        aligned, own = (found["stiff body and steering", f"{part} {axle}"] for part in ("same age", "own"))
        assert own > 12.0
        assert abs(aligned) < 7.0
    assert np.isnan(found["as it is", "own front"]), "no fit where the friction is 50 ms older"


@pytest.mark.acceptance("V-34")
def test_ten_milliseconds_move_the_limit_by_a_fifth(record: Record) -> None:
    """How much the fit asks of the ages: D of a wheel whose slip angle is moved against its friction."""
    pairs = pairs_of("slalom_dry_asphalt", "stiff body and steering")
    for name in ("fl", "rl"):
        wheel = pairs.wheel(name)
        errors = [
            error_percent(pairs.fits(wheel, delayed(wheel.slip_angle, late), wheel.friction, delayed(wheel.now, late)))
            for late in (0.0, 10.0, 20.0)
        ]
        for late, error in zip((0, 10, 20), errors, strict=True):
            record(f"MuJoCo, slip angle {late} ms later: mean error of D %, {name}", error, "reported")
        assert errors[0] - errors[1] > 10.0
        assert errors[1] - errors[2] > 10.0


@pytest.mark.acceptance("V-25", "V-34")
def test_told_of_the_sway_the_filter_meets_the_limits(record: Record) -> None:
    """``lateral.body_sway`` on the car as it is, over the seeds that judge."""
    run = drive("state/slalom_dry_asphalt", plant="mujoco")
    found = [Replay(run, "vehicle_state_ukf", SWAY, seed=seed, noise=ALL_NOISE) for seed in SEEDS]
    errors = [errors_of(run, one) for one in found]
    for quantity, limit in SLALOMS["dry_asphalt"].items():
        mean = float(np.mean([run_errors[quantity][0] for run_errors in errors]))
        record(f"MuJoCo, sway told: {quantity} %", mean, f"planar car: <= {limit}", id="V-25")
        assert mean <= limit
    fits = [event for one in found for event in fits_of(run, one)]
    record("MuJoCo, sway told: largest share of the true peak", max(e["true_share"] for e in fits), "<= 0.765")
    record("MuJoCo, sway told: fits per run", len(fits) / len(SEEDS), "reported", id="V-34")
    record("MuJoCo, sway told: mean error of D %, 20 seeds", error_percent(fits), "reported", id="V-34")


def before_the_jump(pairs: Pairs, part: str) -> int:
    """Wheels with a fit before the friction jumps, from pairs with ``part`` replaced by the truth."""
    found = {
        event["wheel"] for names in AXLES.values() for event in substituted(pairs, names, part) if event["time"] < 6.0
    }
    return len(found)


@pytest.mark.acceptance("V-27")
def test_in_the_bend_the_slip_angle_hides_the_curve(record: Record) -> None:
    """No wheel has a fit; with the tyres' own slip angles and the filter's friction all have one.

    The sway while the car turns in hides it, and the missing lean, by which the slip angle drifts to less
    (``test_state_mujoco_rests.py``). Without the tyres' pneumatic trail, which moves side force from the rear axle to
    the front one, all have a fit as well, but the slip angle drifts as before: the trail is not the reason for that.
    """
    bend = {
        "as it is": pairs_of("mu_jump_in_bend", "as it is"),
        "sway told": pairs_of("mu_jump_in_bend", "sway told"),
        "sway told, no trail": Pairs(drive("state/mu_jump_in_bend", plant="mujoco", **NO_TRAIL), SWAY),
    }
    wheels = {(car, part): before_the_jump(bend[car], part) for car, part in (
        ("as it is", "own"), ("as it is", "slip angle"), ("as it is", "friction"), ("sway told", "own"),
        ("sway told, no trail", "own"),
    )}  # fmt: skip
    for (car, part), number in wheels.items():
        record(f"MuJoCo, bend, {car}: {part}: wheels with a fit", number, "4")
    for car, pairs in bend.items():
        for name in ("fl", "rl"):
            wheel = pairs.wheel(name)
            steady = (wheel.time > 5.0) & (wheel.time < 6.0)
            for what in ("slip_angle", "friction"):
                ratio = np.mean(getattr(wheel, what)[steady]) / np.mean(getattr(wheel, f"true_{what}")[steady])
                record(f"MuJoCo, bend, {car}: {what} over the true one, {name}", float(ratio), "1")
    assert wheels["as it is", "own"] == 0
    assert wheels["as it is", "slip angle"] == 4
    assert wheels["as it is", "friction"] == 0
    assert wheels["sway told", "own"] == 2
    assert wheels["sway told, no trail", "own"] == 4
