"""The lateral filter, the fit and the wheels' observer of the vehicle-state document, part by part (AC-16 to AC-42)."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import estimators
from estimators.kalman.filters import GaussianFilter
from estimators.kalman.sigma_points import unscented_weights
from estimators.magic_formula_fit_solver import fit_curve, slsqp_fit
from estimators.magic_formula_fit_step import observe_pair
from estimators.vehicle_state_lateral import (
    NODES,
    NOISE_TABLE,
    PREDICTED,
    PROCESS_TABLE,
    lateral_step,
    predict_state,
    side_force,
    table_value,
)
from estimators.vehicle_state_record import BUFFER, CURVED, LINEAR, LOG_COLUMNS, LOG_ROWS
from estimators.wheel_sliding_mode_step import adapt_slope, surface
from vehicle_model.vehicle_file import load_vehicle

NUMBERS = load_vehicle("lada_vesta_assumed_steering").numbers()


def build(name: str = "vehicle_state_ukf", **settings: Any) -> Any:
    return estimators.create(name, NUMBERS, {key.replace("__", "."): value for key, value in settings.items()})


@pytest.mark.acceptance("V-16")
@pytest.mark.parametrize("alpha", [1e-3, 1e-2, 0.1, 1.0])
def test_weights_add_up_to_one(alpha: float, record: Callable[..., None]) -> None:
    mean, _, _ = unscented_weights(10, alpha, 2.0, -7.0)
    error = abs(mean.sum() - 1.0) / np.abs(mean).max()
    record("(sum of W_m - 1) / largest", error, "<= 1e-9")
    assert error <= 1e-9
    # eq. 1.3 as its glyph reads, lambda in the numerator, does not add up (3.2 [X])
    scaling = 3.0 * alpha**2 - 10.0
    printed = scaling / (10.0 + scaling) + 20 * scaling / (2.0 * (10.0 + scaling))
    assert abs(printed - 1.0) > 1.0


@pytest.mark.acceptance("V-17")
@pytest.mark.parametrize(("redraw", "process"), [(True, 0.3), (False, 0.0), (False, 0.3)])
def test_equals_the_linear_filter(redraw: bool, process: float, record: Callable[..., None]) -> None:
    """Exact for redraw with any Q and without redraw for Q = 0; not without redraw and with Q (3.2 [E])."""
    random = np.random.default_rng(0)
    transition = np.array([[1.0, 0.1, 0.0], [0.0, 0.95, 0.2], [0.05, 0.0, 0.9]])
    design = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]])
    noise, measured_noise = process * np.eye(3), 0.2 * np.eye(2)
    linear = GaussianFilter(np.zeros(3), np.eye(3))
    unscented = GaussianFilter(np.zeros(3), np.eye(3), unscented_weights(3, 1.0, 2.0, 0.0))
    worst = 0.0
    for _ in range(50):
        z = random.standard_normal(2)
        linear.predict(transition, noise)
        unscented.predict_through(lambda x: transition @ x, noise)
        linear.correct(z, design, measured_noise)
        unscented.correct_through(z, lambda x: design @ x, measured_noise, redraw=redraw)
        worst = max(worst, float(np.max(np.abs(linear.state - unscented.state))))
    if redraw or process == 0.0:
        record(f"redraw {redraw}, Q {process}", worst, "<= 1e-8")
        assert worst <= 1e-8
    else:
        assert worst > 1e-3


@pytest.mark.acceptance("V-18", "V-19")
def test_state_of_ten_and_predictor_of_seventeen() -> None:
    filter_ = build()
    assert filter_.state.shape == (10,)
    assert PREDICTED == 17
    full = np.zeros(PREDICTED)
    x = np.array([0.1, 0.2, 8.0, 9.0, 10.0, 11.0, 0.5, 0.6, 0.7, 0.8])
    s, t = filter_._rows[0], filter_._tuning[0]
    s["v_x"] = 15.0
    s["theta"] = 0.02, 0.02, 0.0, 0.0
    predict_state(x, s, filter_._curves, filter_._car.record[0], t, 0.01, full)
    # slopes and limits walk at random; then a_y, four slip angles, roll rate, roll
    assert full[2:10] == pytest.approx(x[2:10])
    a_y, alphas = full[10], full[11:15]
    assert alphas[0] == pytest.approx(0.02 - math.atan((0.1 + 0.2 * 1.14) / (15.0 - 0.2 * 0.755)))
    assert full[0] == pytest.approx(0.1 + 0.01 * (a_y - 15.0 * full[1]))  # semi-implicit: the new yaw rate
    assert full[16] == pytest.approx(0.01 * full[15])
    # h(x) = x[1:10]: nine measurements, the lateral speed is none of them
    assert filter_._memory.z.shape == (9,)
    step = filter_._memory
    lateral_step(step, s, filter_._curves, filter_._car.record[0], t, 0.2, 1.0)
    assert step.outputs == pytest.approx(step.points[:, 1:10])


@pytest.mark.acceptance("V-20")
def test_printed_tables_at_their_nodes() -> None:
    for node, process, noise in zip(NODES, PROCESS_TABLE, NOISE_TABLE, strict=True):
        assert table_value(node, PROCESS_TABLE) == pytest.approx(process, rel=1e-12)
        assert table_value(node, NOISE_TABLE) == pytest.approx(noise, rel=1e-12)
    assert table_value(4.25, PROCESS_TABLE) == pytest.approx(0.5 * (5e-3 + 0.05))


def curve_memory(**settings: Any) -> tuple[Any, ...]:
    built = build("magic_formula_fit", **settings)
    return built._curves, np.zeros((2, BUFFER)), np.zeros((2, BUFFER)), np.zeros((LOG_ROWS, len(LOG_COLUMNS))), \
        np.zeros(1), built._tuning[0]  # fmt: skip


def feed(memory: tuple[Any, ...], angles: np.ndarray, friction: np.ndarray, number: int = 0) -> Any:
    curves, pair, scratch, log, logged, t = memory
    for k, (x, mu) in enumerate(zip(angles, friction, strict=True)):
        now, time = float(abs(x)), 0.01 * k
        observe_pair(curves[number], pair[0], pair[1], scratch, log, logged, number, float(x), float(mu), now, time, t)
    return curves[number]


def law(x: np.ndarray, d: float, b: float) -> np.ndarray:
    return d * np.sin(1.5 * np.arctan(b * x))


EARLIER = 8
SURFACES = {"asphalt": (0.95, 8.0), "basalt": (0.55, 8.0), "ice": (0.28, 14.0)}


def solve(x: np.ndarray, mu: np.ndarray) -> tuple[float, float, float]:
    scratch = np.zeros((2, len(x)))
    return fit_curve(x, mu, len(x), 1.5, 0.05, 1.3, 3.0, 40.0, scratch)


@pytest.mark.acceptance("V-28")
@pytest.mark.parametrize("surface", SURFACES)
def test_fit_is_no_worse_than_slsqp(surface: str, record: Callable[..., None]) -> None:
    """Two parameters, absolute deviations, C = 1.5, E = 0; SLSQP is scipy's, from several starts."""
    d, b = SURFACES[surface]
    random = np.random.default_rng(3)
    worst = -math.inf
    for _ in range(5):
        x = np.linspace(1e-3, math.tan(math.asin(0.65) / 1.5) / b, 60)
        mu = law(x, d, b) + 0.005 * random.standard_normal(60)
        ours = solve(x, mu)[2]
        theirs = min(
            slsqp_fit(x, mu, 1.5, (1.2 * mu.max(), start), ((0.05, 1.3), (3.0, 40.0)))[2] for start in (5.0, 10.0, 20.0)
        )
        worst = max(worst, ours / theirs - 1.0)
    record(f"{surface}: J over the best of SLSQP - 1", worst, "<= 1e-3")
    assert worst <= 1e-3


@pytest.mark.acceptance("V-29")
@pytest.mark.parametrize("surface", SURFACES)
def test_fit_without_noise(surface: str, record: Callable[..., None]) -> None:
    d, b = SURFACES[surface]
    x = np.linspace(1e-3, math.tan(math.asin(0.45) / 1.5) / b, 60)
    found = solve(x, law(x, d, b))[0]
    record(f"{surface}: D error %", 100.0 * abs(found / d - 1.0), "<= 1")
    assert found == pytest.approx(d, rel=0.01)


def up_to_65_percent(surface: str) -> np.ndarray:
    """Sixty slip angles up to 65 % of the peak of a surface's curve (AC-30)."""
    return np.linspace(1e-3, math.tan(math.asin(0.65) / 1.5) / SURFACES[surface][1], 60)


@pytest.mark.acceptance("V-30")
@pytest.mark.parametrize("surface", SURFACES)
def test_fit_with_noise(surface: str, record: Callable[..., None]) -> None:
    """Median over 400 draws, beside the one that theory gives for least absolute deviations (asymptotic normality).

    On ice theory gives 5.2 %, more than the 5 % that the document proposes: no search of its objective does better
    without a word of the stiffness. The document's ice row has that word (C.3, "start close to the answer in B") and is
    judged under it below; the figure of a wheel that knows nothing is reported here.
    """
    d, b = SURFACES[surface]
    x = up_to_65_percent(surface)
    errors = []
    for seed in range(5000, 5400):
        random = np.random.default_rng(seed)
        errors.append(abs(solve(x, law(x, d, b) + 0.005 * random.standard_normal(60))[0] / d - 1.0))
    median = 100.0 * float(np.median(errors))
    inner = 1.5 * np.arctan(b * x)
    jacobian = np.column_stack((np.sin(inner), d * np.cos(inner) * 1.5 * x / (1.0 + (b * x) ** 2)))
    # absolute deviations under normal noise: variance pi/2 times that of least squares
    variance = 0.5 * math.pi * 0.005**2 * np.linalg.inv(jacobian.T @ jacobian)[0, 0]
    theory = 100.0 * 0.6745 * math.sqrt(variance) / d
    judged = surface != "ice"
    limit = "<= 5" if judged else "reported: nothing known of B; 5 by the document with B nearly known"
    record(f"{surface}: median D error %", median, limit)
    record(f"{surface}: by theory %", theory, "reported")
    assert median == pytest.approx(theory, rel=0.2)  # three standard errors of a median of 400 draws
    assert median <= 5.0 or not judged


@pytest.mark.acceptance("V-30")
def test_fit_with_noise_behind_earlier_fits_of_the_same_ice(record: Callable[..., None]) -> None:
    """C.3's condition for ice, B nearly known, as a wheel in service has it: from its own EARLIER fits, noisy as well.

    Through the engine, which takes that stiffness only where it explains the data of the curve at hand. A curve that
    gives no fit counts as infinitely wrong.
    """
    d, b = SURFACES["ice"]
    x = up_to_65_percent("ice")
    errors, takes_known_b = np.full((400, EARLIER + 1), math.inf), np.zeros((400, EARLIER + 1), bool)
    for draw in range(400):
        random = np.random.default_rng(7000 + draw)
        memory = curve_memory(fit__threshold="fixed", fit__threshold_lateral=float(x[-2:].mean()))
        fits = 0
        for number in range(EARLIER + 1):
            known_b = float(memory[0][0]["known_b"])
            angles = (-1.0) ** number * x
            feed(memory, angles, law(angles, d, b) + 0.005 * random.standard_normal(60))
            if memory[4][0] > fits:
                event = dict(zip(LOG_COLUMNS, memory[3][fits], strict=True))
                errors[draw, number] = abs(event["limit"] / d - 1.0)
                takes_known_b[draw, number] = event["stiffness"] == known_b
                fits += 1
    medians = 100.0 * np.median(errors, axis=0)
    record(f"ice, behind {EARLIER} fits of it: median D error %", medians[EARLIER], "<= 5")
    record("ice, behind 2 fits of it: median D error %", medians[2], "reported")
    record("ice, engine's first fit: median D error %", medians[0], "reported: nothing known of B")
    record(f"ice, behind {EARLIER} fits of it: part that takes their B", takes_known_b[:, -1].mean(), "reported")
    assert medians[EARLIER] <= 5.0
    assert np.isfinite(errors).all()  # none of the medians is one of chosen curves


@pytest.mark.acceptance("V-31", "V-38")
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_buffer_and_threshold(sign: float) -> None:
    """Fit at the threshold's crossing; a change of sign clears the buffer and starts no fit."""
    memory = curve_memory(fit__threshold="fixed", fit__threshold_lateral=0.0611)
    below = sign * np.linspace(0.002, 0.058, 30)
    curve = feed(memory, below, law(below, 0.95, 8.0))
    assert (curve["fits"], curve["count"], curve["mode"]) == (0, 30, LINEAR)
    back = -sign * np.linspace(0.002, 0.01, 5)
    assert feed(memory, back, law(back, 0.95, 8.0))["count"] == 5
    assert curve["fits"] == 0
    over = sign * np.linspace(0.002, 0.07, 40)
    curve = feed(memory, over, law(over, 0.95, 8.0))
    assert curve["fits"] == 1
    assert curve["mode"] == CURVED
    assert curve["d"] == pytest.approx(0.95, rel=0.02)
    event = memory[3][0]
    assert event[LOG_COLUMNS.index("sign")] == sign
    assert event[LOG_COLUMNS.index("r_squared")] > 0.99


def limits_of_half_waves(agreement: float, surfaces: tuple[str, ...], noise: float, seed: int) -> np.ndarray:
    """D over its truth of the fits of a wheel that steers to and fro, a half-wave on each of the surfaces."""
    random = np.random.default_rng(seed)
    memory = curve_memory(fit__agreement=agreement)
    for number, road in enumerate(surfaces):
        d, b = SURFACES[road]
        angles = (-1.0) ** number * np.linspace(1e-3, 1.0 / b, 80)
        feed(memory, angles, law(angles, d, b) + noise * random.standard_normal(len(angles)))
    assert memory[4][0] == len(surfaces)
    truth = np.array([SURFACES[road][0] for road in surfaces])
    return np.array(memory[3][: len(surfaces), LOG_COLUMNS.index("limit")] / truth)


@pytest.mark.parametrize("surface", SURFACES)
def test_earlier_curves_steady_the_limit(surface: str) -> None:
    """Twelve half-waves on one road, of which the last eight are judged: the median error of D falls by a fifth."""
    error = {}
    for agreement in (0.0, 0.2):
        ratios = [limits_of_half_waves(agreement, (surface,) * 12, 0.005, seed)[4:] for seed in range(6000, 6020)]
        error[agreement] = float(np.median(np.abs(np.concatenate(ratios) - 1.0)))
    assert error[0.2] < 0.8 * error[0.0]


@pytest.mark.parametrize("agreement", [0.0, 0.2])
def test_earlier_curves_do_not_hold_back_a_change_of_the_road(agreement: float) -> None:
    """The first fit on ice behind six on asphalt, whose curves are half as stiff, does not move towards them."""
    roads = (*("asphalt",) * 6, "ice")
    errors = [limits_of_half_waves(agreement, roads, 0.005, seed)[-1] - 1.0 for seed in range(6000, 6040)]
    assert abs(np.median(errors)) < 0.02


@pytest.mark.acceptance("V-32")
def test_no_chatter_at_the_threshold() -> None:
    memory = curve_memory(fit__threshold="fixed", fit__threshold_lateral=0.05)
    rise = np.linspace(0.002, 0.049, 40)
    hover = 0.05 * (1.0 + 0.02 * np.sin(np.arange(400)))
    angles = np.concatenate((rise, hover))
    modes = []
    for k in range(len(angles)):
        modes.append(int(feed(memory, angles[k : k + 1], law(angles[k : k + 1], 0.95, 8.0))["mode"]))
    assert np.count_nonzero(np.diff(modes)) == 1
    assert memory[0][0]["fits"] == 1


@pytest.mark.acceptance("V-33")
@pytest.mark.parametrize(("degrees", "d", "b"), [(3.5, 0.95, 7.2), (2.5, 0.55, 7.5), (1.5, 0.28, 16.7)])
def test_thresholds_by_surface_and_by_rule(degrees: float, d: float, b: float) -> None:
    fixed = curve_memory(fit__threshold="fixed", fit__threshold_lateral=math.radians(degrees))
    angles = np.radians(np.arange(0.1, 5.0, 0.1))
    feed(fixed, angles, law(angles, d, b))
    event = fixed[3][0]
    assert event[0] == pytest.approx(0.01 * (round(10 * degrees)), abs=0.0101)  # the first pair above it
    automatic = curve_memory()
    curve = feed(automatic, angles, law(angles, d, b))
    assert curve["fits"] == 1
    assert curve["threshold"] == pytest.approx(min(max(0.42 / b, math.radians(1.5)), math.radians(3.5)), rel=0.02)


@pytest.mark.acceptance("V-37")
def test_hand_over_by_the_event() -> None:
    filter_ = build()
    s, curves = filter_._rows[0], filter_._curves
    s["v_x"] = 15.0
    filter_.covariance[:] = np.diag(np.full(10, 0.01))
    curves[2]["handed_over"], curves[2]["d"], curves[2]["mode"] = 1, 0.43, CURVED
    lateral_step(filter_._memory, s, curves, filter_._car.record[0], filter_._tuning[0], 0.0, 0.0)
    assert filter_.state[8] == pytest.approx(0.43, abs=1e-6)
    assert filter_.covariance[8, 8] == pytest.approx(0.05, rel=1e-3)
    assert curves[2]["handed_over"] == 0


@pytest.mark.acceptance("V-39")
def test_sliding_surface() -> None:
    tuning = build("wheel_sliding_mode")._tuning[0]
    assert surface(0.2, -3.0, tuning) == pytest.approx(300.0 * 0.2 - 12.0 * 3.0)


@pytest.mark.acceptance("V-40", "V-47")
def test_two_integrators_and_their_ends() -> None:
    """Rate within k_max / 0.05 s, slope within [0, k_max], no winding up beyond an end."""
    tuning = build("wheel_sliding_mode", longitudinal__integrators=2, longitudinal__largest_slope=12.0)._tuning[0]
    slope, rate = 5.0, 0.0
    for _ in range(200):
        slope, rate = adapt_slope(slope, rate, 1.0, 1.0, 0.001, tuning)
        assert abs(rate) <= 240.0
        assert 0.0 <= slope <= 12.0
    assert slope == 12.0
    steps = 0
    while slope == 12.0:
        slope, rate = adapt_slope(slope, rate, -1.0, -1.0, 0.001, tuning)
        steps += 1
    assert steps <= 2  # it leaves its end at once
    for _ in range(400):
        slope, rate = adapt_slope(slope, rate, -1.0, -1.0, 0.001, tuning)
    assert slope == 0.0
    assert estimators.describe("wheel_sliding_mode").settings().longitudinal.largest_slope >= 25.0


@pytest.mark.acceptance("V-61")
def test_front_forces_are_projected_once() -> None:
    """The listing multiplies the curve's front forces by cos(theta) before the sums do (Annex B, l. 5375)."""
    state = np.zeros(10)
    state[6] = 0.9
    forces = []
    for printed in (False, True):
        tuning = build(lateral__double_projection=printed)._tuning[0]
        forces.append(side_force(state, 0.1, 4000.0, 0, True, 8.0, 1.5, 0.3, tuning))
    assert forces[1] == pytest.approx(forces[0] * math.cos(0.3))
    assert forces[1] < 0.96 * forces[0]


@pytest.mark.acceptance("V-60")
@pytest.mark.parametrize(
    "name", ["vehicle_state_ukf", "wheel_sliding_mode", "magic_formula_fit", "road_grade", "observer_cascade"]
)
def test_production_sensors_only(name: str) -> None:
    inputs = estimators.describe(name).inputs(estimators.describe(name).settings())
    assert not [signal for signal in inputs if "pressure" in signal or "reference" in signal or signal == "speed"]
