"""Design of the force document's observer (N-1 to N-10): poles, gains, regressors, Lyapunov matrix and function."""

import inspect
from collections.abc import Callable

import numpy as np
import pytest
from force_scenarios import (
    QUIET,
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
from estimators.neural_force import NeuralForceObserver, regressors
from estimators.neural_force_model import (
    coupling,
    error_dynamics,
    lyapunov_matrices,
    network_centres,
    zero_of_error_dynamics,
)
from estimators.neural_force_settings import NeuralForceSettings
from vehicle_model.reference.steered_track import SteeredTrack
from vehicle_model.reference.steered_track_step import motion
from vehicle_model.vehicle_file import load_vehicle


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
    for name, gain, printed in zip(("L_11", "L_12"), gains()[:2], (510.0, 5000.0), strict=True):
        record(f"{name} from poles -10, -500", gain, f"{printed:g}", id="N-4")
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
def test_regressors(record: Callable[..., None]) -> None:
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
        squared = float(values[name] @ values[name])
        record("sum of the squared regressor", squared, "1 where it is normalised", id="N-7")
        assert squared == pytest.approx(1.0, abs=1e-8)
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
    values, ages = input_columns()
    previous, rises, first = np.inf, 0.0, 0.0
    for k in range(steps):
        angle = 0.5 * np.sin(2.0 * np.pi * 0.2 * k * h)
        put_inputs(values, r, angle, 12.0)
        if k == 0:
            observer.tick(values, ages, out)
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
        observer.tick(values, ages, out)
        r, v = r + h * r_rate, v + h * v_rate
    record("largest rise of V over its start", rises, "<= 1e-9")
    record("V at the end over its start", previous / first, "reported: the weights are not identified")
    assert rises <= 1e-9
    assert abs(r - observer.state[0]) < 1e-4
