"""Parts of the lateral filter's pairs replaced by the truth, one by one: what the fit makes of each tells its weight.

In the document's axes: to the right is positive, roll leans to the left.
"""

import itertools
from collections.abc import Iterable

import numpy as np
from state_pairs import DOCUMENT_WHEELS, STEP, Pairs, age, delayed, low_pass
from state_runs import Columns, Drive

from estimators.vehicle_state_car import GRAVITY

STRAIGHT = 900
"""Tick at which the car of a slalom still goes straight on: loads of then are those at rest."""
AXLE_WHEELS = {"f": ("fl", "fr"), "r": ("rl", "rr")}


def over_step(values: np.ndarray, ends: list[int]) -> np.ndarray:
    """Means over the ticks of the filter's steps."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    last = np.array(ends) + 1
    first = np.maximum(last - STEP, 0)
    return np.asarray((total[last] - total[first]) / (last - first))


def before(values: np.ndarray) -> np.ndarray:
    """Values of the step before."""
    return np.concatenate(([0.0], values[:-1]))


def fine_age(values: np.ndarray, truth: np.ndarray) -> float:
    """``age`` between its delays of 2 ms, by the parabola through the three best [ms]."""
    best = age(values, truth)
    low, most, high = (
        np.corrcoef(values[200:-50], delayed(truth, best + step)[200:-50])[0, 1] for step in (-2.0, 0.0, 2.0)
    )
    return float(best + (low - high) / (low - 2.0 * most + high))


def axle_load(run: Drive, name: str) -> np.ndarray:
    """Load of a wheel's axle over that of the car going straight on."""
    load = np.sum([run[f"vertical_load_{wheel}"] for wheel in AXLE_WHEELS[name[0]]], axis=0)
    return np.asarray(load / load[STRAIGHT])


def side_force(run: Drive) -> np.ndarray:
    """Side force of all tyres over the weight."""
    force = np.sum([run[f"lateral_force_{wheel}"] for wheel in DOCUMENT_WHEELS], axis=0)
    return np.asarray(-force / sum(run[f"vertical_load_{wheel}"][STRAIGHT] for wheel in DOCUMENT_WHEELS))


def friction(pairs: Pairs, name: str, parts: frozenset[str]) -> np.ndarray:
    """Friction of a wheel's pairs with ``parts`` of it replaced.

    ``lean``: true roll in the accelerometer's part of gravity; ``side force``: that of the tyres for the car's mass
    times the body's acceleration (unsprung masses do not sway, the accelerometer has no lag); ``yaw``: true yaw
    acceleration; ``load``: the axle's load in place of that at rest; ``wheel``: the wheel's own force over its load.
    """
    run, rows, ends = pairs.run, pairs.rows, pairs.ends
    if "wheel" in parts:
        return low_pass(pairs.wheel(name).true_friction)
    found = pairs.wheel(name).friction.copy()
    if "lean" in parts:
        found += low_pass(np.sin(before(rows["roll"])) + over_step(np.sin(run["roll_angle"]), ends))
    if "side force" in parts:
        found += low_pass(over_step(side_force(run), ends)) - rows["measured_y"] / GRAVITY
    if "yaw" in parts:
        car = pairs.estimator._car.record
        arm = float(car["arm_1"][0]) if name[0] == "f" else -float(car["arm_2"][0])
        true = low_pass(over_step(-np.gradient(run["true_yaw_rate"], 1e-3), ends))
        found += (true - rows["yaw_acceleration"]) * arm / GRAVITY
    if "load" in parts:
        found /= low_pass(over_step(axle_load(run, name), ends) - 1.0) + 1.0
    return found


def slip_angle(pairs: Pairs, name: str, parts: frozenset[str]) -> tuple[np.ndarray, np.ndarray]:
    """Slip angle of a wheel's pairs and its magnitude of now, with ``parts`` replaced.

    ``roll rate``: the true one in the sway; ``amplitude``: the filter's, as large as the true one; ``steering``: the
    true angle of the wheel; ``tyre``: the tyre's own slip angle.
    """
    run, rows, wheel, now_ticks = pairs.run, pairs.rows, pairs.wheel(name), pairs.ends
    if "tyre" in parts:
        return low_pass(wheel.true_slip_angle), np.abs(wheel.true_slip_angle)
    rate, true_rate = rows["roll_rate"], -run["true_roll_rate"][now_ticks]
    lever = run.vehicle["body.centre_of_gravity_height"] / run[f"wheel_centre_speed_{name}"][now_ticks]
    change = np.zeros(len(rate))
    if "roll rate" in parts:
        change -= lever * (true_rate - rate)
    if "amplitude" in parts:
        change -= lever * rate * (np.std(true_rate[200:-50]) / np.std(rate[200:-50]) - 1.0)
    if "steering" in parts:
        change += -run[f"true_road_wheel_angle_{name}"][now_ticks] - rows["theta"][:, wheel.number]
    # the low-pass takes the slip angles of the step before
    return wheel.slip_angle + low_pass(before(change)), np.abs(rows["alpha"][:, wheel.number] + change)


def limit_error_percent(pairs: Pairs, names: tuple[str, ...], *parts: str) -> tuple[float, float]:
    """Median error of D [%] and fits per wheel, of pairs of one age with ``parts`` of both replaced.

    The median, as the first half-wave is another drive: its fit of pairs that were moved in time is no curve.
    """
    replaced = frozenset(parts)
    errors = []
    for name in names:
        wheel = pairs.wheel(name)
        slip, now = slip_angle(pairs, name, replaced)
        used = friction(pairs, name, replaced)
        late = fine_age(used, wheel.true_friction) - fine_age(slip, wheel.true_slip_angle)
        fits = pairs.fits(wheel, delayed(slip, late), used, delayed(now, late))
        errors += [fit["error"] for fit in fits]
    return 100.0 * float(np.median(errors)), len(errors) / len(names)


def weights(pairs: Pairs, names: tuple[str, ...], parts: Iterable[str]) -> dict[str, float]:
    """What each of ``parts`` adds to the error of D [%], the mean over all orders of replacing them (Shapley's value).

    The order matters: a fit follows a bend that is hardly there. The weights add up to the error that goes.
    """
    parts = tuple(parts)
    errors = {
        frozenset(chosen): limit_error_percent(pairs, names, *chosen)[0]
        for number in range(len(parts) + 1)
        for chosen in itertools.combinations(parts, number)
    }
    orders = list(itertools.permutations(parts))
    found = dict.fromkeys(parts, 0.0)
    for order in orders:
        for place, part in enumerate(order):
            found[part] += (errors[frozenset(order[:place])] - errors[frozenset(order[: place + 1])]) / len(orders)
    return found


def tell_the_lean(columns: Columns, run: Drive) -> None:
    """Take the true part of gravity out of the lateral accelerometer; ``lateral.roll_compensation`` has to be off."""
    columns["lateral_acceleration"] = columns["lateral_acceleration"] - GRAVITY * np.sin(run["roll_angle"])
