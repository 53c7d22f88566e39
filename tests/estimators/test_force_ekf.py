"""Force EKF against the document's equations and its acceptance figure A14."""

import friction_twin as twin
import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from friction_figures import run

import estimators
from estimators import force_model as model
from estimators.force_ekf import model_parameters
from estimators.force_settings import ForceEkfSettings
from estimators.vehicle_numbers import longitudinal_car

T = 0.001
CAR = longitudinal_car(twin.TABLE_8)
DRAGS = ["quadratic", "cosine"]
V0 = 40.0


def parameters(drag: str) -> np.ndarray:
    return model_parameters(CAR, ForceEkfSettings(drag=drag, cosine_speed=V0))


def document_step(x, torques, drag):
    """Eq. 84 with the wheel rows of 3.5, eta = (M - F_x R)/Theta; complex-valued for exact derivatives."""
    v0 = V0
    square = x[0] ** 2
    if drag == "cosine":
        square = np.pi * v0**2 / (3 * np.pi - 6) * (1 - np.cos(np.pi * x[0] / (2 * v0)))
    resistance = -twin.DRAG * square - twin.MASS * twin.GRAVITY * twin.ROLLING
    a = (resistance + x[3] + x[5] + x[7]) / twin.MASS
    eta = [(m - f * twin.RADIUS) / twin.AXLE_INERTIA for m, f in zip(torques, (x[3], x[5]), strict=True)]
    return x + T * np.array([a, *eta, x[4], 0.0, x[6], 0.0, x[8], 0.0]), a


def random_state(random):
    return np.array([random.uniform(5, 40), *random.uniform(20, 140, 2), *random.uniform(-9000, 3000, 6)])


@pytest.mark.acceptance("F-17")
@pytest.mark.parametrize("drag", DRAGS)
def test_step_and_jacobians_equal_the_document(drag, record):
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(20):
        x, torques = random_state(random), random.uniform(-3000, 2000, 2)
        predicted, transition = np.zeros(9), np.zeros((9, 9))
        four = np.array([*torques, 0.0, 0.0])
        model.predict(x, four, T, parameters(drag), predicted, transition)
        assert predicted == pytest.approx(document_step(x, torques, drag)[0], rel=1e-12)
        expected, design = np.zeros(3), np.zeros((3, 9))
        model.measure(x, parameters(drag), expected, design)
        assert expected == pytest.approx([document_step(x, torques, drag)[1], x[1], x[2]], rel=1e-12)
        for j in range(9):
            moved = x.astype(complex)
            moved[j] += 1e-30j
            step, acceleration = document_step(moved, torques, drag)
            column = step.imag / 1e-30
            worst = max(worst, (np.abs(transition[:, j] - column) / np.maximum(np.abs(column), 1e-3)).max())
            assert design[0, j] == pytest.approx(acceleration.imag / 1e-30, rel=1e-12, abs=1e-15)
    record(f"{drag}: F against complex steps, relative", worst, "1e-6")
    assert worst < 1e-9


@pytest.mark.acceptance("F-17")
@pytest.mark.parametrize("drag", DRAGS)
def test_jacobian_equals_finite_differences(drag, record):
    random = np.random.default_rng(2)
    worst = 0.0
    for _ in range(10):
        x = random_state(random)
        four = np.array([*random.uniform(-3000, 2000, 2), 0.0, 0.0])
        transition = np.zeros((9, 9))
        model.predict(x, four, T, parameters(drag), np.zeros(9), transition)
        for j in range(9):
            # the forces enter linearly and are of 1e4 N: a large step keeps rounding small
            step = 1e-5 * max(abs(x[j]), 1.0) if j == 0 else max(abs(x[j]), 1.0)
            up, down, ends = x.copy(), x.copy(), [np.zeros(9), np.zeros(9)]
            up[j] += step
            down[j] -= step
            for end, state in zip(ends, (up, down), strict=True):
                model.predict(state, four, T, parameters(drag), end, np.zeros((9, 9)))
            column = (ends[0] - ends[1]) / (up[j] - down[j])
            worst = max(worst, np.abs(column - transition[:, j]).max())
    record(f"{drag}: F against finite differences", worst, "1e-6")
    assert worst < 1e-6


def test_cosine_substitute():
    """3.5 [CHK]: same integral over [0, v0] as v^2, 0.917 v0^2 at v0, largest error 0.083 v0^2."""
    values = parameters("cosine")
    rolling = values[model.ROLLING_FORCE]
    speeds = np.linspace(0.0, V0, 4001)
    square = np.array([-(model.resistance(v, values)[0] + rolling) / twin.DRAG for v in speeds])
    assert np.trapezoid(square, speeds) == pytest.approx(V0**3 / 3, rel=1e-6)
    assert square[-1] == pytest.approx(0.917 * V0**2, rel=1e-3)
    assert np.abs(square - speeds**2).max() == pytest.approx(0.083 * V0**2, rel=0.01)


def test_unmodelled_force_is_off_by_default():
    columns = {name: values[:4000] for name, values in twin.measured(run("E6")).items()}
    for switched_on in (False, True):
        estimator = estimators.create("force_ekf", twin.TABLE_8, {"unmodelled_force": switched_on})
        index = [signal.name for signal in estimator.outputs].index("force_ekf.unmodelled_force")
        assert estimator.replay(columns)[:, index].any() == switched_on


def errors(truth: twin.Run, path: str, **settings: object) -> tuple[float, float]:
    """RMSE of the axle forces outside 50 ms windows around jumps of the friction in use, while the filter runs."""
    columns = twin.measured(truth, actual_torque=settings.get("brake_torque") == "actual")
    ages = None
    if path == "bus":
        columns, ages = twin.held(columns)
    estimator = estimators.create("force_ekf", twin.TABLE_8, settings)
    results = estimator.replay(columns, ages)
    at = {signal.name.split(".")[1]: i for i, signal in enumerate(estimator.outputs)}
    kept = results[:, at["active"]] > 0
    result = []
    for axle in ("front", "rear"):
        used = getattr(truth, f"used_{axle}")
        # a jump changes the friction in use by 0.3 within 10 ms
        jumps = np.flatnonzero(np.abs(used[10:] - used[:-10]) > 0.3)
        outside = kept.copy()
        for jump in jumps:
            outside[max(0, jump - 25) : jump + 35] = False
        error = results[:, at[f"force_{axle}"]] - used * getattr(truth, f"load_{axle}")
        result.append(float(np.sqrt(np.mean(error[outside] ** 2))))
    return result[0], result[1]


@pytest.mark.acceptance("F-A14")
@pytest.mark.parametrize("drag", DRAGS)
@pytest.mark.parametrize(("path", "brake_torque"), [("ideal", "actual"), ("ideal", "capacity"), ("bus", "capacity")])
def test_axle_forces_in_a_hard_launch_and_a_stop_with_locked_wheels(path, brake_torque, drag, record):
    """E3: strong acceleration, emergency stop without ABS, largest friction about 1."""
    truth = twin.simulate((1.0, 1.0), start_speed=1.0, top_speed=110 / 3.6)
    front, rear = errors(truth, path, brake_torque=brake_torque, drag=drag)
    share = 2.0 / (twin.MASS * twin.GRAVITY)
    record("force RMSE front over m g/2", front * share, "0.10")
    record("force RMSE rear over m g/2", rear * share, "0.10")
    assert front * share <= 0.10
    assert rear * share <= 0.10


def test_step_equals_filterpy():
    """The document's rows; those of rolling axles are two more of the same kind."""
    columns = twin.measured(run("E8"), actual_torque=True)
    columns = {name: values[5000:5600] for name, values in columns.items()}
    estimator = estimators.create("force_ekf", twin.TABLE_8, {"brake_torque": "actual", "rolling_speed": "none"})
    settings, values = estimator.settings, parameters("quadratic")
    estimator.replay({name: c[:1] for name, c in columns.items()})
    reference = ExtendedKalmanFilter(dim_x=9, dim_z=3)
    reference.x, reference.P = estimator.state.copy(), estimator.covariance.copy()
    wheel, force, rate = settings.process_wheel_speed, settings.process_force, settings.process_force_rate
    reference.Q = np.diag(np.square([settings.process_speed, wheel, wheel, force, rate, force, rate, 0.0, 0.0]))
    sensor = settings.measurement_wheel_speed
    reference.R = np.diag(np.square([settings.measurement_acceleration, sensor, sensor]))
    predicted, transition, expected, design = np.zeros(9), np.zeros((9, 9)), np.zeros(3), np.zeros((3, 9))

    def h(x):
        model.measure(x, values, expected, design)
        return expected.copy()

    def jacobian(x):
        h(x)
        return design.copy()

    for k in range(1, 600):
        estimator.replay({name: c[k : k + 1] for name, c in columns.items()})
        torques = np.array([columns["drive_torque_f"][k], columns["drive_torque_r"][k], 0.0, 0.0])
        model.predict(reference.x, torques, T, values, predicted, transition)
        reference.x = predicted.copy()
        reference.P = transition @ reference.P @ transition.T + reference.Q
        front = 0.5 * (columns["wheel_speed_fl"][k] + columns["wheel_speed_fr"][k])
        rear = 0.5 * (columns["wheel_speed_rl"][k] + columns["wheel_speed_rr"][k])
        reference.update(np.array([columns["longitudinal_acceleration"][k], front, rear]), jacobian, h)
        assert (np.abs(estimator.state - reference.x) / np.maximum(np.abs(reference.x), 1.0)).max() < 1e-9
