"""Acceptance list of the force document (its section 6), on the car that it defines (15c).

Reference numbers are the document's own verification (section 7) and arithmetic on its parameters (section 5).
"""

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from force_scenarios import drive, measured, numbers, observe, rmse

from estimators import create
from estimators.neural_force import NeuralForceObserver, regressors
from estimators.neural_force_model import (
    coupling,
    error_dynamics,
    force_car,
    lyapunov_matrices,
    network_centres,
    observer_gains,
    zero_of_error_dynamics,
)
from estimators.neural_force_settings import NeuralForceSettings
from vehicle_model.reference.steered_track import SteeredTrack
from vehicle_model.reference.steered_track_step import motion
from vehicle_model.vehicle_file import load_vehicle

QUIET = {"learning_front": 1e8, "learning_rear": 4e6}
"""Gains of the noise-free runs (3.4)."""


def document_car(**settings: Any) -> np.void:
    """The document's car as the observers read it."""
    return force_car(numbers(), NeuralForceSettings(**settings))[0]


def gains(**settings: Any) -> tuple[float, float, float, float]:
    """L_11, L_12, L_21, L_22."""
    return observer_gains(NeuralForceSettings(**settings), 0.1)


@pytest.mark.acceptance("N-1")
def test_eigenvalues_of_the_car(record: Callable[..., None]) -> None:
    car = SteeredTrack(load_vehicle("neural_700kg"))
    at, h = np.array([20.0, 0.0, 0.0, 0.0]), 1e-6
    for sign, wanted in ((1.0, -1.494 + 4.070j), (-1.0, 6.09)):
        car._parameters[0]["stiffness"][1] = sign * 19900.0
        jacobian = np.zeros((2, 2))
        for column in (1, 2):
            high, low = np.zeros(4), np.zeros(4)
            step = np.eye(4)[column] * h
            motion(car._parameters[0], at + step, 0.0, 0.0, 0.0, high)
            motion(car._parameters[0], at - step, 0.0, 0.0, 0.0, low)
            jacobian[:, column - 1] = (high - low)[1:3] / (2.0 * h)
        values = np.linalg.eigvals(jacobian)
        if sign > 0.0:
            record("real part, corrected rear sign", float(values[0].real), "-1.494 1/s")
            assert values[0].real == pytest.approx(wanted.real, abs=1e-3)
            assert abs(values[0].imag) == pytest.approx(wanted.imag, abs=1e-3)
        else:
            record("largest real part, printed rear sign", float(values.real.max()), "+6.09 1/s")
            assert values.real.max() == pytest.approx(wanted, abs=0.01)


@pytest.mark.acceptance("N-2")
def test_parameters_are_data() -> None:
    vehicle = load_vehicle("neural_700kg")
    car = document_car()
    printed = {"mass": 700.0, "rear": 19900.0, "front": 1000.0, "to_front": 1.25, "to_rear": 1.5, "yaw_inertia": 1550.0}
    assert {name: float(car[name]) for name in printed} == pytest.approx(printed)
    for path in ("body.mass", "body.yaw_inertia", "steered_track.cornering_stiffness_rear"):
        assert "l. 40" in vehicle.sources[path]


@pytest.mark.acceptance("N-3", "N-6")
def test_frozen_poles_and_zero(record: Callable[..., None]) -> None:
    car, (yaw, lateral, _, _) = document_car(), gains()
    for speed, poles in {5.0: (-470, -46), 10.0: (-491, -22), 20.0: (-500.8, -10.7), 25.0: (-502.6, -8.6)}.items():
        found = np.sort(np.linalg.eigvals(error_dynamics(car, speed, yaw, lateral)).real)
        assert found == pytest.approx(poles, abs=0.5 if speed < 20.0 else 0.1)
        if speed == 20.0:
            record("fast pole at 20 m/s", float(found[0]), "-500.8 +- 0.1", id="N-3")
            record("slow pole at 20 m/s", float(found[1]), "-10.7 +- 0.1", id="N-3")
    printed = np.linalg.eigvals(error_dynamics(document_car(printed_rear_sign=True), 20.0, yaw, lateral)).real.max()
    record("largest pole with the printed rear sign", float(printed), "+11: unstable", id="N-3")
    assert printed == pytest.approx(11.0, abs=0.5)
    zeros = [zero_of_error_dynamics(car, speed) for speed in (5.0, 10.0, 12.0, 20.0, 25.0)]
    record("zero at 20 m/s", zeros[3], "-3.1", id="N-6")
    assert zeros == pytest.approx([-12.5, -6.3, -5.2, -3.1, -2.5], abs=0.05)
    k, d, beta = coupling(car, 20.0)
    assert zeros[3] == pytest.approx(-(d + k * beta), rel=1e-12)
    assert beta == pytest.approx(1.771, abs=1e-3)


@pytest.mark.acceptance("N-4", "N-5")
def test_gains_follow_from_the_poles(record: Callable[..., None]) -> None:
    assert gains() == pytest.approx((510.0, 5000.0, 150.0, 7.0 - 1.0 / 0.1))
    assert gains(poles_yaw=(-20.0, -300.0), pole_speed=-80.0, pole_steering=-30.0) == pytest.approx(
        (320.0, 6000.0, 80.0, 20.0)
    )
    source = drive("S1")
    error = rmse(observe(measured(source), QUIET), source, "road_wheel_angle")
    record("error of the road-wheel angle in S1", error, "< 1e-3 rad", id="N-5")
    assert error < 1e-3


@pytest.mark.acceptance("N-5", "N-21")
def test_the_lag_counted_twice_is_wrong(record: Callable[..., None]) -> None:
    """Finding F7: 0.69 rad at tau = 0.1 s, the ratio of the angles is -0.38."""
    source = drive("S1")
    found = observe(measured(source), {**QUIET, "printed_double_count": True})["road_wheel_angle"][5000:]
    true = source.truth["road_wheel_angle"][5000:]
    error, ratio = float(np.sqrt(np.mean(np.square(found - true)))), float(found @ true / (true @ true))
    record("error with the double count", error, "0.69 rad", id="N-21")
    assert error == pytest.approx(0.69, abs=0.02)
    assert ratio == pytest.approx(-0.38, abs=0.02)


@pytest.mark.acceptance("N-7", "N-21")
def test_regressors() -> None:
    tuning_of = {}
    for name, settings in {"default": {}, "narrow": {"width": 0.3}, "printed": {"printed_exponent": True}}.items():
        observer = create("neural_force_observer", numbers(), settings)
        tuning_of[name] = observer.tick.args[6]
    grid, second = network_centres(NeuralForceSettings())
    assert len(grid) == 25
    assert len(second) == 15
    assert second.min(axis=0).tolist() == [0.0, -1.0]
    assert len(network_centres(NeuralForceSettings(neurons_yaw=3))[0]) == 9
    values = {name: np.zeros(25) for name in tuning_of}
    for name, tuning in tuning_of.items():
        regressors(0.3, -0.4, grid, tuning, values[name])
        # 1e-9 below the root keeps an empty network from dividing by zero (3.4)
        assert values[name] @ values[name] == pytest.approx(1.0, abs=1e-8)
    for name, width, power in (("default", 1.0, 2.0), ("narrow", 0.3, 2.0), ("printed", 1.0, 1.0)):
        distance = np.linalg.norm(grid - [0.3, -0.4], axis=1)
        bare = np.exp(-(distance**power) / (2.0 * width**2))
        assert values[name] == pytest.approx(bare / np.sqrt(bare @ bare + 1e-9), rel=1e-12)


@pytest.mark.acceptance("N-8")
def test_the_observer_sees_decoded_signals_only() -> None:
    observer = create("neural_force_observer", numbers())
    assert isinstance(observer, NeuralForceObserver)
    assert observer.inputs == (
        "yaw_rate",
        "road_wheel_angle",
        "steering_command",
        *(f"wheel_speed_{wheel}" for wheel in ("fl", "fr", "rl", "rr")),
    )
    import estimators.neural_force as module

    source = inspect.getsource(module)
    assert "vehicle_model" not in source
    assert "true_" not in source


@pytest.mark.acceptance("N-9")
def test_one_lyapunov_matrix_for_all_speeds(record: Callable[..., None]) -> None:
    (yaw, lateral, _, _), car = gains(), document_car()

    def holds(ratio: float, slowest: float, fastest: float) -> bool:
        for speed in np.arange(slowest, fastest + 0.01, 0.25):
            p, q, _ = lyapunov_matrices(car, speed, ratio, yaw, lateral)
            if min(np.linalg.eigvalsh(p).min(), np.linalg.eigvalsh(q).min()) <= 0.0:
                return False
        return True

    p, q, weight = lyapunov_matrices(car, 12.0, 2000.0, yaw, lateral)
    assert holds(2000.0, 5.0, 25.0)
    input_row = p @ [1.25 / 1550.0, 1.0 / 700.0]
    record("second entry of P B_12", float(input_row[1]), "0 within 1e-9")
    assert input_row == pytest.approx([weight, 0.0], abs=1e-9)
    assert weight == pytest.approx(1.610, abs=1e-3)
    assert np.allclose(q, q.T)
    # the range of rho in which one P exists, for three ranges of speed
    for slowest, fastest, low, high in ((5.0, 25.0, 1644, 3743), (3.0, 25.0, 1644, 2244), (5.0, 40.0, 2631, 3743)):
        assert holds(low + 10, slowest, fastest)
        assert holds(high - 10, slowest, fastest)
        assert not holds(low - 10, slowest, fastest)
        assert not holds(high + 10, slowest, fastest)
    for slowest, fastest in ((2.0, 25.0), (1.0, 25.0), (1.0, 15.0)):
        assert not any(holds(ratio, slowest, fastest) for ratio in range(100, 8000, 50))
    k, d, beta = coupling(document_car(printed_rear_sign=True), 12.0)
    assert beta * k + d < 0.0, "with the printed rear sign Q_22 is negative: no P exists"


@pytest.mark.acceptance("N-10")
def test_the_lyapunov_function_never_rises(record: Callable[..., None]) -> None:
    """Finding F8: 12 m/s, a front force that the network can represent exactly, rho = 2000, g_1 = 2e7."""
    settings = {"learning_front": 2e7, "learning_rear": 0.0, "width": 1.0}
    observer = create("neural_force_observer", numbers(), settings)
    assert isinstance(observer, NeuralForceObserver)
    car, (yaw_gain, lateral_gain, _, _) = document_car(), gains()
    p, _, weight = lyapunov_matrices(car, 12.0, 2000.0, yaw_gain, lateral_gain)
    grid, _ = network_centres(observer.settings)
    ideal = np.random.default_rng(3).normal(-40.0, 30.0, len(grid))
    activations, tuning = np.zeros(len(grid)), observer.tick.args[6]
    learning = 2e7 / weight  # g = gamma F
    h, steps = 1e-3, 20_000
    # truth at a constant speed, integrated with the observer's own Euler step: the proof is about these equations
    r, v = 0.1, -0.3
    out = np.zeros(len(observer.outputs))
    columns = _columns(observer)
    previous, rises, first = np.inf, 0.0, 0.0
    for k in range(steps):
        angle = 0.5 * np.sin(2.0 * np.pi * 0.2 * k * h)
        _show(columns, r, angle, 12.0)
        if k == 0:
            observer.tick(columns[0], columns[1], out)
            observer.state[:] = 0.0, 0.0, 12.0, 0.0  # an initial error of 0.1 rad/s and 0.3 m/s
            for weights in observer.weights:
                weights[:] = 0.0
        error = np.array([r - observer.state[0], v - observer.state[1]])
        missing = ideal - observer.weights[0]
        value = 0.5 * error @ p @ error + 0.5 * missing @ missing / learning
        if k == 0:
            first = value
        rises = max(rises, (value - previous) / first)
        previous = value
        regressors(observer.state[0] / 0.5, observer.state[1], grid, tuning, activations)
        force = float(ideal @ activations)
        front = car["front"] * (angle - (v + car["to_front"] * r) / 12.0)
        rear = -car["rear"] * (v - car["to_rear"] * r) / 12.0
        r_rate = (car["to_front"] * (force * angle + front) - car["to_rear"] * rear) / car["yaw_inertia"]
        v_rate = -12.0 * r + (force * angle + front + rear) / car["mass"]
        observer.tick(columns[0], columns[1], out)
        r, v = r + h * r_rate, v + h * v_rate
    record("largest rise of V over its start", rises, "<= 1e-9")
    record("V at the end over its start", previous / first, "reported: the weights are not identified")
    assert rises <= 1e-9
    assert abs(r - observer.state[0]) < 1e-4


def _columns(observer: NeuralForceObserver) -> tuple[np.ndarray, np.ndarray]:
    from signals.catalogue import block_slice

    bus, ages = block_slice("bus"), block_slice("bus_age")
    return np.zeros(bus.stop - bus.start), np.zeros(ages.stop - ages.start)


def _show(columns: tuple[np.ndarray, np.ndarray], yaw_rate: float, angle: float, speed: float) -> None:
    from signals.catalogue import block_slice, index_of

    start, radius = block_slice("bus").start, numbers()["wheels.fl.radius"]
    values = columns[0]
    values[index_of("yaw_rate") - start], values[index_of("road_wheel_angle") - start] = yaw_rate, angle
    values[index_of("steering_command") - start] = angle
    for wheel in ("fl", "fr", "rl", "rr"):
        values[index_of(f"wheel_speed_{wheel}") - start] = speed / radius


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
    rear = (late[-1] + 1) * 1e-3 if learning >= 1e8 else 0.0
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
    columns, out = _columns(observer), np.zeros(len(observer.outputs))
    names = [signal.name.partition(".")[2] for signal in observer.outputs]
    lateral, rear = [], []
    for k in range(2000):
        _show(columns, signals["yaw_rate"][k], signals["road_wheel_angle"][k], source.truth["speed"][k])
        observer.tick(columns[0], columns[1], out)
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


@pytest.mark.acceptance("N-19")
@pytest.mark.parametrize(
    ("label", "setting", "printed"),
    [
        ("C_r +10 %", {"cornering_stiffness_rear": 1.1 * 19900.0}, (23.0, 26.0, 0.017)),
        ("C_r -10 %", {"cornering_stiffness_rear": 0.9 * 19900.0}, (28.0, 31.0, 0.020)),
        ("C_f +10 %", {"cornering_stiffness_front": 1100.0}, (103.0, 128.0, 0.0018)),
    ],
)
def test_wrong_stiffness(
    label: str, setting: dict[str, float], printed: tuple[float, ...], record: Callable[..., None]
) -> None:
    source = drive("S1")
    found = observe(measured(source), {**QUIET, **setting})
    values = [rmse(found, source, output) for output in ("force_front", "force_rear", "lateral_speed")]
    record(f"front RMSE, {label}", values[0], f"{printed[0]:g} N within 25 %")
    record(f"rear RMSE, {label}", values[1], f"{printed[1]:g} N within 25 %")
    assert values == pytest.approx(printed, rel=0.25)


@pytest.mark.acceptance("N-19")
@pytest.mark.parametrize(
    ("label", "path", "factor", "printed"),
    [
        ("m +10 %", "body.mass", 1.1, (95.0, 117.0, 0.018)),
        ("I_z +10 %", "body.yaw_inertia", 1.1, (29.0, 31.0, 0.006)),
        ("a +5 %", "body.centre_of_gravity_to_front_axle", 1.05, (28.0, 31.0, 0.005)),
    ],
)
def test_wrong_car(
    label: str, path: str, factor: float, printed: tuple[float, ...], record: Callable[..., None]
) -> None:
    source = drive("S1")
    car = {**numbers(), path: factor * numbers()[path]}
    if path.endswith("front_axle"):  # the document changes a alone, not the wheelbase less a
        car["body.wheelbase"] += car[path] - numbers()[path]
    observer = create("neural_force_observer", car, QUIET)
    results = observer.replay(measured(source))
    found = {signal.name.partition(".")[2]: results[:, k] for k, signal in enumerate(observer.outputs)}
    values = [rmse(found, source, output) for output in ("force_front", "force_rear", "lateral_speed")]
    record(f"front RMSE, {label}", values[0], f"{printed[0]:g} N within 25 %")
    record(f"rear RMSE, {label}", values[1], f"{printed[1]:g} N within 25 %")
    assert values == pytest.approx(printed, rel=0.25)


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


@pytest.mark.acceptance("N-22")
def test_slow_cars() -> None:
    """Finding F12: S2 from 1 m/s gives 5.5/13.5 N."""
    source = drive("S2", speed=1.0)
    found = observe(measured(source), QUIET)
    assert all(np.isfinite(column).all() for column in found.values())
    values = rmse(found, source, "force_front", 2.0), rmse(found, source, "force_rear", 2.0)
    assert values == pytest.approx((5.5, 13.5), rel=0.1)
