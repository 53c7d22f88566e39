"""Acceptance list of the force document (its section 6), on the car that it defines (15c).

Reference numbers are the document's own verification (section 7) and arithmetic on its parameters (section 5).
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from force_scenarios import (
    BUS,
    QUIET,
    WHEELS,
    document_car,
    drive,
    gains,
    input_columns,
    measured,
    numbers,
    observe,
    put_inputs,
    rmse,
)

from estimators import create
from estimators.neural_force import NeuralForceObserver
from estimators.neural_force_settings import NeuralForceSettings
from signals.catalogue import index_of


@pytest.mark.acceptance("N-11", "N-18")
def test_s1_without_noise(record: Callable[..., None]) -> None:
    source = drive("S1")
    found = observe(measured(source), QUIET)
    limits = {"force_front": 25.0, "force_rear": 30.0, "lateral_speed": 0.003}
    for output, limit in limits.items():
        error = rmse(found, source, output)
        record(f"{output} RMSE", error, f"<= {limit:g}", id="N-11")
        assert error <= limit
    # finding F2, both gains zero, and finding F4
    for network, front, rear, lateral in (("none", 222.0, 392.0, 0.039), ("integral", 19.8, 21.5, 0.0018)):
        baseline = observe(measured(source), {**QUIET, "network": network})
        values = [rmse(baseline, source, output) for output in limits]
        record(f"front RMSE, network {network}", values[0], f"{front:g} N within 10 %", id="N-18")
        assert values == pytest.approx((front, rear, lateral), rel=0.1)


@pytest.mark.acceptance("N-12", "N-18")
def test_s1_with_noise(record: Callable[..., None]) -> None:
    source = drive("S1")
    names = "force_front", "force_rear", "lateral_speed"
    runs = [observe(measured(source, seed)) for seed in range(5)]
    errors = np.array([[rmse(found, source, name) for name in names] for found in runs]).mean(axis=0)
    for value, name, centre, band in zip(
        errors, ("F_xf", "F_xr", "v_y"), (43.0, 66.0, 0.0074), (5.0, 7.0, 0.001), strict=True
    ):
        record(f"{name} RMSE, mean of 5 seeds", float(value), f"{centre:g} +- {band:g}", id="N-12")
        assert value == pytest.approx(centre, abs=band)
    walk = observe(measured(source, 0), {}, "random_walk_force_ekf")
    ekf = [rmse(walk, source, name) for name in names]
    record("front RMSE of the random-walk filter (B2)", ekf[0], "17.6 N within 10 %", id="N-18")
    assert ekf[:2] == pytest.approx((17.6, 61.7), rel=0.1)
    assert ekf[2] < 0.0006
    assert ekf[0] < errors[0], "the document reports the filter as the better one here"


@pytest.mark.acceptance("N-13", "N-18")
def test_s2(record: Callable[..., None]) -> None:
    source = drive("S2")
    found = observe(measured(source), QUIET)
    for output, limit in {"force_front": 10.0, "force_rear": 20.0, "lateral_speed": 0.001}.items():
        error = rmse(found, source, output, 2.0)
        record(f"{output} RMSE", error, f"<= {limit:g}", id="N-13")
        assert error <= limit
    for network in ("none", "integral"):
        value = rmse(observe(measured(source), {**QUIET, "network": network}), source, "force_front", 2.0)
        record(f"front RMSE in S2, network {network}", value, "reported", id="N-18")
    walk = observe(measured(source), {}, "random_walk_force_ekf")
    value = rmse(walk, source, "force_front", 2.0)
    record("front RMSE in S2, random-walk filter (B2)", value, "reported", id="N-18")
    assert np.isfinite(value)


@pytest.mark.acceptance("N-14")
@pytest.mark.parametrize(("learning", "settling", "band"), [(1e7, 2.8, 0.1), (1e8, 0.43, 0.1), (3e8, 0.17, 0.1)])
def test_settling_after_a_step(learning: float, settling: float, band: float, record: Callable[..., None]) -> None:
    source = drive("S3")
    found = observe(measured(source), {**QUIET, "learning_front": learning})
    outside = np.flatnonzero(np.abs(found["force_front"][6000:8000] + 400.0) > 20.0)
    if learning == 1e7:
        outside = np.flatnonzero(np.abs(found["force_front"][6000:] + 400.0) > 20.0)
    time = (outside[-1] + 1) * 1e-3
    record(f"settling of F_xf, g_1 = {learning:g}", time, f"{settling:g} s +- {band:g}")
    assert time == pytest.approx(settling, abs=band)
    late = np.flatnonzero(np.abs(found["force_rear"][8000:] - 2000.0) > 0.05 * 1500.0)
    rear = (late[-1] + 1) * 1e-3
    record(f"settling of F_xr, g_1 = {learning:g}", rear, "<= 0.08 s")
    assert rear <= 0.08


@pytest.mark.acceptance("N-15")
def test_without_steering_the_front_force_is_not_observable(record: Callable[..., None]) -> None:
    source = drive("S1", amplitude=0.0)
    observer = create("neural_force_observer", numbers(), QUIET)
    assert isinstance(observer, NeuralForceObserver)
    results = observer.replay(measured(source))
    assert not observer.weights[0].any(), "no excitation, no learning"
    names = [signal.name.partition(".")[2] for signal in observer.outputs]
    assert results[:, names.index("force_front_confidence")].max() == 0.0
    stopped = drive("S4 stopped")
    found = observe(measured(stopped), QUIET)
    total = rmse(found, stopped, "force_total", 11.0)
    record("RMSE of the sum, from 1 s after the steering stops", total, "<= 10 N")
    assert total <= 10.0
    held = rmse(found, stopped, "force_front", 11.0)
    record("RMSE of the held front force", held, "132 N within 10 % (finding F3)")
    assert held == pytest.approx(132.0, rel=0.1)
    assert found["force_front_confidence"][9999] > 0.5 > found["force_front_confidence"][15000]


@pytest.mark.acceptance("N-15")
def test_what_was_learned_stays_to_the_last_bit_while_the_wheels_point_ahead(record: Callable[..., None]) -> None:
    """delta = 0 after 5 s of S1, with a yaw rate that does not fit: an error of it teaches the front force nothing."""
    source = drive("S1")
    signals = measured(source)
    observer = create("neural_force_observer", numbers(), QUIET)
    assert isinstance(observer, NeuralForceObserver)
    (values, ages), out = input_columns(), np.zeros(len(observer.outputs))
    rear_moves = 0.0
    for k in range(7000):
        ahead = k >= 5000
        if k == 5000:
            kept, rear = observer.weights[0].copy(), observer.weights[1].copy()
        yaw_rate = 0.3 if ahead else signals["yaw_rate"][k]
        angle = 0.0 if ahead else signals["road_wheel_angle"][k]
        put_inputs(values, yaw_rate, angle, source.truth["speed"][k])
        observer.tick(values, ages, out)
        if ahead:
            assert np.array_equal(observer.weights[0], kept)
            rear_moves = max(rear_moves, float(np.abs(observer.weights[1] - rear).max()))
    record("largest change of a weight of the front force at delta = 0", float(np.ptp(observer.weights[0] - kept)), "0")
    assert np.count_nonzero(kept) == len(kept)
    assert rear_moves > 1.0, "the rear force goes on learning"


@pytest.mark.acceptance("N-16")
def test_gain_sweep(record: Callable[..., None]) -> None:
    source = drive("S1")
    signals = measured(source)
    # finding F2, front RMSE over g_1 with g_2 = 4e6
    for learning, printed in ((1e6, 136.0), (1e7, 70.0), (1e8, 20.7), (3e8, 11.4), (9e8, 6.2)):
        error = rmse(observe(signals, {"learning_front": learning, "learning_rear": 4e6}), source, "force_front")
        record(f"front RMSE, g_1 = {learning:g}", error, f"{printed:g} N within 5 %")
        assert error == pytest.approx(printed, rel=0.05)
    for learning, printed in ((1e5, 263.0), (1e6, 39.0), (4e6, 24.0), (5e7, 21.0), (9e7, 21.0)):
        error = rmse(observe(signals, {"learning_front": 1e8, "learning_rear": learning}), source, "force_rear")
        record(f"rear RMSE, g_2 = {learning:g}", error, f"{printed:g} N within 5 %")
        assert error == pytest.approx(printed, rel=0.05)
    fastest = rmse(observe(signals, {"learning_front": 1e9, "learning_rear": 4e6}), source, "force_front")
    record("front RMSE, g_1 = 1e+09", fastest, "stable: below that of 9e8 or within 5 % of it")
    assert fastest < 1.05 * 6.2
    # limits of the explicit step (3.6): g_1 max(delta^2) a / I_z h < L_11 and g_2 h < m L_21
    car, (yaw, _, speed, _) = document_car(), gains()
    assert yaw / (0.7**2 * car["to_front"] / car["yaw_inertia"] * 1e-3) == pytest.approx(1.3e9, rel=0.01)
    assert car["mass"] * speed / 1e-3 == pytest.approx(1.05e8, rel=0.01)


@pytest.mark.acceptance("N-17")
def test_wrong_starts(record: Callable[..., None]) -> None:
    source = drive("S1")
    signals = measured(source)
    observer = create("neural_force_observer", numbers(), QUIET)
    assert isinstance(observer, NeuralForceObserver)
    (values, ages), out = input_columns(), np.zeros(len(observer.outputs))
    names = [signal.name.partition(".")[2] for signal in observer.outputs]
    lateral, rear = [], []
    for k in range(2000):
        put_inputs(values, signals["yaw_rate"][k], signals["road_wheel_angle"][k], source.truth["speed"][k])
        observer.tick(values, ages, out)
        if k == 0:
            observer.state[:3] += 0.3, 0.5, 3.0
        lateral.append(out[names.index("lateral_speed")])
        rear.append(out[names.index("force_rear")])
    error = np.abs(np.array(lateral) - source.truth["lateral_speed"][:2000])
    settled = (np.flatnonzero(error > 0.05 * 0.5)[-1] + 1) * 1e-3
    record("lateral speed within 5 % of its start error", settled, "<= 0.2 s")
    record("peak of the rear force after a wrong start", float(np.abs(rear).max()), "reported, 6e4 N in finding F9")
    assert settled <= 0.2
    right = observe(signals, QUIET)
    peak = float(np.abs(right["force_rear"]).max())
    late = float(np.abs(right["force_rear"] - source.truth["force_rear"])[500:1500].max())
    record("peak with the speed started at the measurement", peak, "< 4000 N")
    assert peak < 4000.0
    record("error of the rear force from 0.5 s on", late, "< 100 N")
    assert late < 100.0


@pytest.mark.acceptance("N-17")
@pytest.mark.parametrize("estimator", ["neural_force_observer", "random_walk_force_ekf"])
def test_nothing_begins_before_every_wheel_has_told_its_speed(estimator: str, record: Callable[..., None]) -> None:
    """Sensors need two edges: for some milliseconds one wheel of a rolling car reads its speed and three read zero."""
    observer = create(estimator, numbers(), {})
    (values, ages), out = input_columns(), np.zeros(len(observer.outputs))
    names = [signal.name.partition(".")[2] for signal in observer.outputs]
    forces = []
    for k in range(1000):
        put_inputs(values, 0.0, 0.0, 8.0)
        if k < 5:
            for wheel in WHEELS[1:]:
                values[index_of(f"wheel_speed_{wheel}") - BUS.start] = 0.0
        observer.tick(values, ages, out)
        assert out[names.index("active")] == (k >= 5)
        forces.append(out[names.index("force_front")] + out[names.index("force_rear")])
    peak = float(np.abs(forces).max())
    record(f"largest force of a car that rolls freely, one wheel told first, {estimator}", peak, "0 N")
    assert peak < 1.0


MISMATCH = {
    "nominal": ({}, (21.0, 24.0, 0.0018)),
    "m +10 %": ({"body.mass": 1.1}, (95.0, 117.0, 0.018)),
    "C_f +10 %": ({"steered_track.cornering_stiffness_front": 1.1}, (103.0, 128.0, 0.0018)),
    "C_r +10 %": ({"steered_track.cornering_stiffness_rear": 1.1}, (23.0, 26.0, 0.017)),
    "C_r -10 %": ({"steered_track.cornering_stiffness_rear": 0.9}, (28.0, 31.0, 0.020)),
    "I_z +10 %": ({"body.yaw_inertia": 1.1}, (29.0, 31.0, 0.006)),
    "a +5 %": ({"body.centre_of_gravity_to_front_axle": 1.05}, (28.0, 31.0, 0.005)),
}
"""What the observer believes of the car, as factors, and finding F10: RMSE of F_xf, F_xr [N] and v_y [m/s]."""


def believed_car(factors: Mapping[str, float]) -> dict[str, float]:
    """The document's car with some numbers wrong; a changes alone, not the wheelbase less a."""
    car = {**numbers(), **{path: factor * numbers()[path] for path, factor in factors.items()}}
    distance = "body.centre_of_gravity_to_front_axle"
    return {**car, "body.wheelbase": car["body.wheelbase"] + car[distance] - numbers()[distance]}


@pytest.mark.acceptance("N-19")
@pytest.mark.parametrize("label", MISMATCH)
def test_wrong_car(label: str, record: Callable[..., None]) -> None:
    """The mismatch table, with what the baselines make of the same wrong car beside it."""
    source, (factors, printed) = drive("S1"), MISMATCH[label]
    signals, car = measured(source), believed_car(factors)
    names = "force_front", "force_rear", "lateral_speed"

    def errors(settings: Mapping[str, Any], estimator: str = "neural_force_observer") -> list[float]:
        found = observe(signals, settings, estimator, car)
        return [rmse(found, source, name) for name in names]

    network, integral = errors(QUIET), errors({**QUIET, "network": "integral"})
    nothing, walk = errors({**QUIET, "network": "none"}), errors({}, "random_walk_force_ekf")
    record(f"front RMSE, {label}", network[0], f"{printed[0]:g} N within 25 %")
    record(f"rear RMSE, {label}", network[1], f"{printed[1]:g} N within 25 %")
    for name, values in (("integral", integral), ("no network", nothing), ("random-walk filter", walk)):
        record(f"front RMSE, {label}, {name}", values[0], "reported")
        record(f"rear RMSE, {label}, {name}", values[1], "reported")
    assert network == pytest.approx(printed, rel=0.25)
    # a wrong car does not change who learns: both forces are told better than by not learning
    assert max(network[0], integral[0]) < nothing[0]
    assert max(network[1], integral[1]) < nothing[1]


@pytest.mark.acceptance("N-20")
def test_forgetting(record: Callable[..., None]) -> None:
    """3.4: up to 0.1 1/s costs nothing, 1 doubles the error, 10 multiplies it by 6.5."""
    assert NeuralForceSettings().forgetting_front == 0.0
    source = drive("S1")
    signals = measured(source)
    errors = {}
    for kappa in (0.0, 0.01, 0.1, 1.0, 10.0):
        found = observe(signals, {**QUIET, "forgetting_front": kappa, "forgetting_rear": kappa})
        errors[kappa] = rmse(found, source, "force_front")
        record(f"front RMSE, kappa = {kappa:g}", errors[kappa], "reported")
    assert errors[0.1] <= 1.02 * errors[0.0]
    assert errors[1.0] / errors[0.0] == pytest.approx(2.0, rel=0.25)
    assert errors[10.0] / errors[0.0] == pytest.approx(6.5, rel=0.25)


@pytest.mark.acceptance("N-21")
def test_printed_forms(record: Callable[..., None]) -> None:
    source = drive("S1")
    signals = measured(source)
    # finding F1: unstable for every gain, the observer leaves 1e4 after 0.65 s; here it is reset each time it does
    printed = observe(signals, {**QUIET, "printed_rear_sign": True})
    record("largest lateral speed with the printed rear sign", float(np.abs(printed["lateral_speed"]).max()), "> 1e4")
    assert np.abs(printed["lateral_speed"]).max() > 1e4
    # finding F11: without the square 20.1/22.2 N
    bare = observe(signals, {**QUIET, "printed_exponent": True})
    values = rmse(bare, source, "force_front"), rmse(bare, source, "force_rear")
    record("front RMSE without the square", values[0], "20.1 N within 5 %")
    assert values == pytest.approx((20.1, 22.2), rel=0.05)


@pytest.mark.acceptance("N-8", "N-21")
def test_the_printed_update_needs_what_nothing_measures(record: Callable[..., None]) -> None:
    """(3) learns from the whole state error; its lateral part has to be told, and (3c) does without it."""
    assert NeuralForceSettings().printed_update == 0.0
    source = drive("S1")
    signals = measured(source)
    settings = {**QUIET, "printed_update": 0.1}
    untold = observe({name: values[:2000] for name, values in signals.items()}, settings)
    assert not untold["active"].any(), "on the bus alone the printed law cannot run"
    observer = create("neural_force_observer", numbers(), settings)
    assert isinstance(observer, NeuralForceObserver)
    (values, ages), out = input_columns(), np.zeros(len(observer.outputs))
    place = [signal.name.partition(".")[2] for signal in observer.outputs].index("force_front")
    found = np.zeros(len(source.time))
    for k in range(len(found)):
        put_inputs(values, signals["yaw_rate"][k], signals["road_wheel_angle"][k], source.truth["speed"][k])
        observer.told_lateral_speed[0] = source.truth["lateral_speed"][k]
        observer.tick(values, ages, out)
        found[k] = out[place]
    printed = rmse({"force_front": found}, source, "force_front")
    corrected = rmse(observe(signals, QUIET), source, "force_front")
    record("front RMSE, update from the state error, told the truth", printed, "over 1000 N: unstable", id="N-21")
    record("front RMSE, update from the output error", corrected, "<= 25 N", id="N-8")
    # P B_12 has no second entry: any weight there leaves the proof, and with 0.1 rad/m the observer runs away
    assert printed > 1000.0
    assert corrected <= 25.0


@pytest.mark.acceptance("N-22")
def test_slow_cars(record: Callable[..., None]) -> None:
    """Finding F12: S2 from 1 m/s gives 5.5/13.5 N."""
    source = drive("S2", speed=1.0)
    found = observe(measured(source), QUIET)
    assert all(np.isfinite(column).all() for column in found.values())
    values = rmse(found, source, "force_front", 2.0), rmse(found, source, "force_rear", 2.0)
    record("front RMSE of S2 from 1 m/s", values[0], "5.5 N within 10 %")
    record("rear RMSE of S2 from 1 m/s", values[1], "13.5 N within 10 %")
    assert values == pytest.approx((5.5, 13.5), rel=0.1)
