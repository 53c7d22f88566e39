"""What is left of D's error on the MuJoCo car once the pairs are of one age and the sway is told, by substitution.

See ``test_state_mujoco_fits.py``; the table stands in docs/models/vehicle_state.md. No noise, no seed.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from state_pairs import Pairs
from state_runs import drive, forget_drives
from state_substitutes import axle_load, friction, limit_error_percent, tell_the_lean, weights

Record = Callable[..., None]

SWAY = {"lateral.body_sway": True}
AXLES = {"front": ("fl", "fr"), "rear": ("rl", "rr")}
TOLD_STIFFNESS = 0.82
"""Of ``planar.roll_stiffness``: with it the filter leans as far as the car."""
CASES = {
    "own pairs": (),
    "true lean in the accelerometer": ("lean",),
    "tyres' side force": ("side force",),
    "true yaw acceleration": ("yaw",),
    "true steering angle": ("steering",),
    "roll rate as large as the true one": ("amplitude",),
    "true roll rate in the sway": ("roll rate",),
    "tyre's slip angle": ("tyre",),
    "axle's load": ("load",),
    "tyre's slip angle, axle's load": ("tyre", "load"),
    "the same, true lean and yaw acceleration": ("tyre", "load", "lean", "yaw"),
    "wheel's own force and load as well": ("tyre", "wheel"),
}
PARTS = {"tyre": "slip angle", "load": "axle load", "lean": "lean", "yaw": "yaw acceleration"}


@pytest.fixture(scope="module", autouse=True)
def _runs_are_dropped() -> Iterator[None]:
    yield
    forget_drives()


@pytest.mark.acceptance("V-34")
def test_substitutions_close_the_error_of_the_limit(record: Record) -> None:
    """Part by part; with four of them D is as right as from true pairs.

    Axle loads move by 2 % as the body heaves and pitches, which bends a curve that has hardly a bend yet: the rest in
    front. Behind it is the slip angle, by the course of the roll rate in the sway, not by its size.
    """
    pairs = Pairs(drive("state/slalom_dry_asphalt", plant="mujoco"), SWAY)
    error: dict[tuple[str, str], float] = {}
    for axle, names in AXLES.items():
        varies = 100.0 * float(np.std(axle_load(pairs.run, names[0])[2500:15000]))
        record(f"MuJoCo, sway told, one age: axle load varies by %, {axle}", varies, "reported")
        for case, parts in CASES.items():
            error[case, axle], fits = limit_error_percent(pairs, names, *parts)
            record(f"MuJoCo, sway told, one age: {case}: median error of D %, {axle}", error[case, axle], "reported")
            assert fits == 12, "each half-wave"
    for axle in AXLES:
        assert error["own pairs", axle] > 15.0
        closed = error["the same, true lean and yaw acceleration", axle]
        assert abs(closed - error["wheel's own force and load as well", axle]) < 4.0
    assert abs(error["axle's load", "front"]) < 3.0
    assert abs(error["tyre's slip angle", "rear"]) < 3.0
    assert abs(error["true roll rate in the sway", "rear"]) < 5.0
    assert error["roll rate as large as the true one", "rear"] > 15.0


@pytest.mark.acceptance("V-34")
@pytest.mark.parametrize(("told", "settings"), [("as it is", {}), ("sway told", SWAY)])
def test_the_lean_in_the_accelerometer_is_the_smaller_part(told: str, settings: dict[str, Any], record: Record) -> None:
    """Missing lean makes the measured friction 2 % too large; of the error of D it is a quarter in front at most."""
    pairs = Pairs(drive("state/slalom_dry_asphalt", plant="mujoco"), settings)
    own = pairs.wheel("fl").friction[200:]
    right = friction(pairs, "fl", frozenset({"lean"}))[200:]
    excess = 100.0 * (float(own @ right / (right @ right)) - 1.0)
    record(f"MuJoCo, {told}: friction too large by the missing lean %", excess, "18 % of g sin(roll) over a_y")
    assert 1.0 < excess < 3.0
    for axle, names in AXLES.items():
        share = weights(pairs, names, PARTS)
        for part, weight in share.items():
            record(f"MuJoCo, {told}, one age: weight of {PARTS[part]} in D %, {axle}", weight, "reported")
        largest = "load" if axle == "front" else "tyre"
        assert max(share, key=share.__getitem__) == largest
        assert abs(share["lean"]) < 0.5 * share[largest]


@pytest.mark.acceptance("V-27")
def test_in_the_bend_the_missing_lean_is_the_drift(record: Record) -> None:
    """Nothing but a_y - v_x w holds the lateral speed there: 2 % of a_y move it by a fifth of the slip.

    With the true lean, or the roll stiffness that makes it, slip angles are right and every wheel has its fit, the
    tyres' trail in place.
    """
    run = drive("state/mu_jump_in_bend", plant="mujoco")
    softer = {**run.vehicle, "planar.roll_stiffness": TOLD_STIFFNESS * run.vehicle["planar.roll_stiffness"]}
    cars = {
        "own": Pairs(run, SWAY),
        "true lean": Pairs(run, {**SWAY, "lateral.roll_compensation": False}, change=tell_the_lean),
        "roll stiffness told": Pairs(run, SWAY, vehicle=softer),
    }
    ratio: dict[tuple[str, str], float] = {}
    number: dict[str, int] = {}
    for car, pairs in cars.items():
        time = pairs.rows["time"]
        steady = (time > 5.0) & (time < 6.0)
        for name in ("fl", "rl"):
            wheel = pairs.wheel(name)
            ratio[car, name] = float(np.mean(wheel.slip_angle[steady]) / np.mean(wheel.true_slip_angle[steady]))
            record(f"MuJoCo, bend, sway told, {car}: slip_angle over the true one, {name}", ratio[car, name], "1")
        number[car] = len({event["wheel"] for event in pairs.estimator.events() if event["time"] < 6.0})
        record(f"MuJoCo, bend, sway told, {car}: wheels with a fit of its own", number[car], "4")
    for name in ("fl", "rl"):
        assert ratio["own", name] < 0.9
        assert ratio["true lean", name] == pytest.approx(1.0, abs=0.03)
        assert ratio["roll stiffness told", name] == pytest.approx(1.0, abs=0.05)
    assert number["own"] == 2
    assert number["true lean"] == number["roll stiffness told"] == 4
