"""Start, stop, guards, inputs that are late or wrong, post-filter and arithmetic of the friction EKF."""

import friction_twin as twin
import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from friction_figures import LOW, Estimate, run, stop
from hypothesis import given, settings
from hypothesis import strategies as st

import estimators
from estimators.friction_ekf import FrictionEkf
from estimators.friction_jacobians import MEASUREMENTS, measure, predict
from estimators.friction_settings import initial_deviations, measurement_deviations, process_deviations
from estimators.friction_setup import model_parameters
from estimators.vehicle_numbers import longitudinal_car
from signals.catalogue import block_slice, index_of
from signals.errors import InputError

BUS = block_slice("bus")
WHEELS = ("fl", "fr", "rl", "rr")


def names_of(estimator) -> dict[str, int]:
    return {signal.name.split(".")[1]: i for i, signal in enumerate(estimator.outputs)}


def idle(seconds: float) -> twin.Run:
    length = round(seconds * 1000)
    zeros = np.zeros(length)
    ones = {"limit_front": np.ones(length), "limit_rear": np.ones(length), "load_front": np.full(length, 6500.0)}
    return twin.Run(**{name: ones.get(name, zeros) for name in twin.Run.__dataclass_fields__})


@pytest.mark.acceptance("F-22")
@pytest.mark.parametrize("path", ["ideal", "bus"])
def test_two_stops_a_locked_phase_and_a_spinning_launch(path, record):
    """Exactly two resets, none while the wheels are locked above the minimum speed, start speed within 0.5 m/s."""
    launch = {"start_speed": 0.0, "top_speed": 110 / 3.6, "spin_torque": 1700.0}
    first = twin.simulate(LOW, **launch)
    second = twin.simulate(LOW, abs_on=True, **launch)
    truth = twin.join(first, idle(0.5), second, idle(0.5))
    columns = twin.measured(truth)
    ages = None
    if path == "bus":
        columns, ages = twin.held(columns)
    estimator = estimators.create("friction_ekf", twin.TABLE_8)
    results = estimator.replay(columns, ages)
    at = names_of(estimator)
    active, resets, speed = results[:, at["active"]], results[:, at["resets"]], results[:, at["speed"]]
    record("resets", int(resets[-1]), "2")
    assert resets[-1] == 2
    locked = (truth.wheel_front == 0.0) & (truth.wheel_rear == 0.0) & (truth.speed > 1.5)
    assert locked.sum() > 500
    assert active[locked].all()
    starts = np.flatnonzero(np.diff(active) > 0) + 1
    assert len(starts) == 2
    for start in starts:
        assert truth.slip_rear[start] > 0.2  # the driven wheels spin
        record("start speed error m/s", float(abs(speed[start] - truth.speed[start])), "0.5")
        assert abs(speed[start] - truth.speed[start]) <= 0.5
    assert np.isfinite(results).all()


@pytest.mark.acceptance("F-22")
@pytest.mark.parametrize(("acceleration", "expected"), [(1.0, 10.0), (-1.0, 20.0)])
def test_start_speed_comes_from_the_wheels_that_do_not_slip(acceleration, expected):
    """3.6.7: R min(w) while accelerating, R max(w) while braking."""
    columns = {f"wheel_speed_{w}": np.full(3, (10.0 if w[0] == "f" else 20.0) / twin.RADIUS) for w in WHEELS}
    columns["longitudinal_acceleration"] = np.full(3, acceleration)
    estimator = estimators.create("friction_ekf", twin.TABLE_8, {"torque_mode": "z2"})
    results = estimator.replay(columns)
    assert results[0, names_of(estimator)["speed"]] == pytest.approx(expected)
    assert results[0, names_of(estimator)["friction_limit_front"]] == 1.0
    assert results[0, names_of(estimator)["friction_limit_rate_front"]] == 0.0


@pytest.mark.acceptance("F-22")
@pytest.mark.parametrize("name", ["friction_ekf", "friction_ukf", "force_ekf"])
def test_it_waits_for_every_wheel_s_first_speed(name):
    """Right wheels report 5 ms later than left ones: an axle's mean is half the car's speed until then."""
    columns = {f"wheel_speed_{w}": np.full(20, 20.0 / twin.RADIUS) for w in WHEELS}
    for w in ("fr", "rr"):
        columns[f"wheel_speed_{w}"][:5] = 0.0
    columns |= {key: np.zeros(20) for key in estimators.create(name, twin.TABLE_8).inputs if key not in columns}
    columns["longitudinal_acceleration"] = np.full(20, 0.1)
    estimator = estimators.create(name, twin.TABLE_8)
    results = estimator.replay(columns)
    at = names_of(estimator)
    assert list(results[:6, at["active"]]) == [0, 0, 0, 0, 0, 1]
    assert results[5, at["speed"]] == pytest.approx(20.0)


@pytest.mark.acceptance("F-22")
def test_standstill_gives_the_initial_state_and_no_division_by_zero():
    estimator = estimators.create("friction_ekf", twin.TABLE_8)
    columns = {name: np.zeros(50) for name in estimator.inputs}
    results = estimator.replay(columns)
    assert np.isfinite(results).all()
    at = names_of(estimator)
    assert (results[:, at["active"]] == 0).all()
    assert (results[:, at["friction_limit_front"]] == 1.0).all()
    assert (results[:, at["speed"]] == 0.0).all()


@pytest.mark.acceptance("F-16", "F-18")
@pytest.mark.parametrize("mode", ["known", "z2"])
def test_step_equals_the_pseudocode_in_filterpy(mode, record):
    """3.6.10 with dense matrices and one joint update in an independent library, 1500 steps into a stop."""
    truth = stop("E8")
    columns = twin.measured(truth, actual_torque=True)
    estimator = estimators.create("friction_ekf", twin.TABLE_8, {"torque_mode": mode, "brake_torque": "actual"})
    assert isinstance(estimator, FrictionEkf)
    parameters = model_parameters(longitudinal_car(twin.TABLE_8), estimator.settings)
    reference = ExtendedKalmanFilter(dim_x=9, dim_z=MEASUREMENTS)
    reference.Q = np.diag(np.square(process_deviations(estimator.settings)))
    reference.R = np.diag(np.square(measurement_deviations(estimator.settings)))
    reference.P = np.diag(np.square(initial_deviations(estimator.settings)))
    forces, predicted, transition = np.zeros((4, 6)), np.zeros(9), np.zeros((9, 9))
    expected, design = np.zeros(MEASUREMENTS), np.zeros((MEASUREMENTS, 9))

    def h(x):
        measure(x, parameters, forces, expected, design)
        return expected.copy()

    def jacobian(x):
        measure(x, parameters, forces, expected, design)
        return design.copy()

    worst = 0.0
    results = estimator.replay({name: values[:1] for name, values in columns.items()})
    reference.x = estimator.state.copy()
    for k in range(1, 1500):
        row = {name: values[k : k + 1] for name, values in columns.items()}
        results = estimator.replay(row)
        before = reference.x[0]
        torques = np.array([columns["drive_torque_f"][k], columns["drive_torque_r"][k], 0.0, 0.0])
        predict(reference.x, torques, 0.001, parameters, mode == "z2", forces, predicted, transition)
        reference.x = predicted.copy()
        reference.P = transition @ reference.P @ transition.T + reference.Q
        wheels = [0.5 * sum(columns[f"wheel_speed_{w}"][k] for w in axle) for axle in (WHEELS[:2], WHEELS[2:])]
        a = columns["longitudinal_acceleration"][k]
        reference.update(np.array([a, *wheels, 0.0, 0.0, 1.0, 1.0, before + 0.001 * a]), jacobian, h)
        scale = np.maximum(np.abs(reference.x), 1.0)
        worst = max(worst, (np.abs(estimator.state - reference.x) / scale).max())
        worst = max(worst, np.abs(estimator.covariance - reference.P).max())
        assert np.array_equal(estimator.covariance, estimator.covariance.T)
        assert np.linalg.eigvalsh(estimator.covariance).min() > 0.0
    record("largest difference to filterpy", worst, "1e-9", id="F-16")
    assert worst < 1e-9
    assert results[0, 0] == 1.0


@pytest.mark.acceptance("F-27")
@pytest.mark.parametrize(("kind", "delay"), [("low_pass", 0.2), ("median", 0.025)])
def test_post_filter_reduces_the_spread_and_tells_its_delay(kind, delay, record):
    estimate = Estimate(run("E8"), path="bus", post_filter=kind)
    raw = estimate["friction_limit_front"][estimate.phase]
    filtered = estimate["friction_limit_front_filtered"][estimate.phase]
    record(f"{kind}: spread filtered / raw", float(filtered.std() / raw.std()), "< 1")
    record(f"{kind}: delay s", estimate.estimator.post_filter_delay_s, f"{delay}")
    assert filtered.std() < 0.9 * raw.std()
    assert filtered.mean() == pytest.approx(raw.mean(), rel=0.01)
    assert estimate.estimator.post_filter_delay_s == pytest.approx(delay)
    plain = Estimate(stop("E8"))
    assert np.array_equal(plain["friction_limit_front"], plain["friction_limit_front_filtered"])
    assert plain.estimator.post_filter_delay_s == 0.0


def test_substeps_change_little_and_help_at_low_speed():
    """3.6.4: explicit Euler of the slip row needs v > 4.7 m/s at 1 ms with set T and high grip."""
    truth = stop("E8")
    plain, fine = Estimate(truth), Estimate(truth, prediction_substeps=5)
    assert fine.mean("friction_limit_front") == pytest.approx(plain.mean("friction_limit_front"), rel=0.005)
    slow = (truth.speed < 4.0) & (truth.speed > 1.7) & (truth.braking > 0)
    for estimate in (plain, fine):
        assert np.abs(estimate["speed"][slow] - truth.speed[slow]).max() < 0.3


def test_a_pitching_car_is_corrected_for():
    """Nose down by c a, the accelerometer reads a (1 + g c); 3 degrees at 1 g is usual for a soft car."""
    truth = stop("E8")
    gradient = np.radians(3.0) / 9.81
    pitching = twin.Run(**{**vars(truth), "acceleration": truth.acceleration * (1 + 9.81 * gradient)})
    errors = {}
    for assumed in (0.0, gradient):
        columns = twin.measured(pitching)
        estimator = estimators.create("friction_ekf", twin.TABLE_8, {"pitch_gradient": assumed})
        speed = estimator.replay(columns)[:, names_of(estimator)["speed"]]
        phase = truth.braking_phase()
        errors[assumed] = float(np.sqrt(np.mean((speed[phase] - truth.speed[phase]) ** 2)))
    assert errors[gradient] < 0.05
    assert errors[0.0] > 3 * errors[gradient]


@pytest.mark.acceptance("F-40")
def test_same_inputs_give_the_same_bits():
    first, second = Estimate(run("E9"), path="bus"), Estimate(run("E9"), path="bus")
    assert np.array_equal(first.results, second.results)
    again = first.estimator
    again.reset()
    columns, ages = twin.held(twin.measured(run("E9")))
    assert np.array_equal(again.replay(columns, ages), second.results)


@pytest.mark.acceptance("F-37")
def test_lost_frames_are_held_then_the_filter_resets_and_comes_back():
    """50 ms without wheel speeds are bridged; 400 ms reset the filter, which starts again when they are back."""
    truth = stop("E8")
    columns, ages = twin.held(twin.measured(truth))
    at_onset = truth.brake_onset()
    for gap, resets in ((50, 0), (400, 1)):
        lost = slice(at_onset + 600, at_onset + 600 + gap)
        broken, late = {k: v.copy() for k, v in columns.items()}, {k: v.copy() for k, v in ages.items()}
        late["age_wheel_speed"][lost] = late["age_wheel_speed"][lost.start - 1] + 0.001 * np.arange(1, gap + 1)
        for w in WHEELS:
            broken[f"wheel_speed_{w}"][lost] = broken[f"wheel_speed_{w}"][lost.start - 1]
        estimator = estimators.create("friction_ekf", twin.TABLE_8)
        results = estimator.replay(broken, late)
        at = names_of(estimator)
        end = lost.stop + 400
        assert results[end, at["resets"]] == resets
        assert results[end, at["active"]] == 1.0
        assert results[lost.stop - 2, at["input_state"]] == (2.0 if resets else 0.0)
        assert results[lost.stop - 2, at["active"]] == (0.0 if resets else 1.0)
        assert np.abs(results[:end, at["speed"]][results[:end, at["active"]] > 0]).max() < 30.0
        assert results[end, at["friction_limit_front"]] == pytest.approx(1.12, rel=0.1)


@pytest.mark.acceptance("F-37")
def test_wheels_on_their_way_into_lock_do_not_restart_the_filter(record):
    """Inputs are lost just before a stop without ABS and come back while the wheels lock: no confident wrong speed."""
    truth = stop("E6")
    columns, ages = twin.held(twin.measured(truth))
    locked = np.flatnonzero((truth.wheel_front == 0.0) & (truth.speed > 5.0))[0]
    worst = 0.0
    for back in (locked - 60, locked - 30, locked - 10):
        lost = slice(back - 250, back)
        broken, late = {k: v.copy() for k, v in columns.items()}, {k: v.copy() for k, v in ages.items()}
        late["age_wheel_speed"][lost] = late["age_wheel_speed"][lost.start - 1] + 0.001 * np.arange(1, 251)
        for w in WHEELS:
            broken[f"wheel_speed_{w}"][lost] = broken[f"wheel_speed_{w}"][lost.start - 1]
        estimator = estimators.create("friction_ekf", twin.TABLE_8)
        results = estimator.replay(broken, late)
        at = names_of(estimator)
        after = slice(lost.stop, len(truth))
        error = np.abs(results[after, at["speed"]] - truth.speed[after])
        worst = max(worst, float((error * (results[after, at["active"]] > 0)).max()))
    record("speed error while active m/s", worst, "3")
    assert worst < 3.0


@pytest.mark.acceptance("F-37")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e9, -1e9])
def test_a_wrong_sample_is_held_and_flagged(bad):
    truth = stop("E8")
    columns = twin.measured(truth)
    clean = estimators.create("friction_ekf", twin.TABLE_8).replay(columns)
    for name in ("longitudinal_acceleration", "wheel_speed_fl", "brake_pressure_rr", "drive_torque_r"):
        broken = {key: value.copy() for key, value in columns.items()}
        broken[name][1000:1020] = bad
        estimator = estimators.create("friction_ekf", twin.TABLE_8)
        results = estimator.replay(broken)
        at = names_of(estimator)
        assert np.isfinite(results).all()
        assert (results[1000:1020, at["input_state"]] == 1.0).all()
        assert results[1020, at["input_state"]] == 0.0
        assert np.abs(results[:3000, at["speed"]] - clean[:3000, at["speed"]]).max() < 0.1


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_no_input_makes_it_write_what_is_not_finite(data):
    truth = stop("E8")
    columns = {name: values[300:1200].copy() for name, values in twin.measured(truth).items()}
    ages = {name: np.zeros(900) for name in ("age_wheel_speed", "age_inertial", "age_wheel_pressure", "age_powertrain")}
    wild = st.one_of(st.floats(), st.sampled_from([np.nan, np.inf, -np.inf, 1e308, 0.0]))
    for _ in range(data.draw(st.integers(1, 8))):
        table = data.draw(st.sampled_from([columns, ages]))
        name = data.draw(st.sampled_from(sorted(table)))
        start = data.draw(st.integers(0, 899))
        table[name][start : start + data.draw(st.integers(1, 300))] = data.draw(wild)
    mode = data.draw(st.sampled_from(["known", "z1", "z2"]))
    estimator = estimators.create("friction_ekf", twin.TABLE_8, {"torque_mode": mode})
    assert np.isfinite(estimator.replay(columns, ages)).all()


def test_ticks_on_views_of_the_signal_vector_without_allocation():
    """The loop hands over views of blocks "bus" and "bus_age"; a tick writes into the view of its outputs."""
    from signals.vector import SignalVector

    estimator = estimators.create("friction_ekf", twin.TABLE_8)
    vector = SignalVector(estimator.outputs)
    for wheel in WHEELS:
        vector.values[index_of(f"wheel_speed_{wheel}")] = 70.0
    first = vector.index("friction_ekf.active")
    out = vector.values[first : first + len(estimator.outputs)]
    estimator.tick(vector.block("bus"), vector.block("bus_age"), out)
    assert vector["friction_ekf.active"] == 1.0
    assert vector["friction_ekf.speed"] == pytest.approx(70.0 * twin.RADIUS)


def test_vehicle_without_a_number_is_refused():
    vehicle = {path: value for path, value in twin.TABLE_8.items() if path != "brakes.rear.pad_area"}
    with pytest.raises(InputError, match=r"brakes\.rear\.pad_area"):
        estimators.create("friction_ekf", vehicle)
    assert estimators.create("friction_ekf", vehicle, {"torque_mode": "z2"}).inputs == (
        "longitudinal_acceleration",
        *(f"wheel_speed_{wheel}" for wheel in WHEELS),
    )


def test_a_bound_tick_is_a_tick():
    """The same numbers to the last bit, by arrays and by the address of their table."""
    columns, ages = twin.held(twin.measured(twin.simulate(LOW, abs_on=True)))
    results = estimators.create("friction_ekf", twin.TABLE_8).replay(columns, ages)
    estimator = estimators.create("friction_ekf", twin.TABLE_8)
    age_block = block_slice("bus_age")
    inputs, input_ages = np.zeros(BUS.stop - BUS.start), np.zeros(age_block.stop - age_block.start)
    out = np.zeros(len(estimator.outputs))
    tick = estimator.bind(inputs, input_ages, out)
    for k in range(len(results)):
        for name in estimator.inputs:
            inputs[index_of(name) - BUS.start] = columns[name][k]
        for name, values in ages.items():
            input_ages[index_of(name) - age_block.start] = values[k]
        tick()
        assert np.array_equal(out, results[k])
