"""Metrics against closed forms: every definition of the bench's figures is checked once, here."""

import numpy as np
import pytest
from synthetic_run import BRAKE_AT, DECELERATION, FRONT_SLIP, REAR_SLIP, SPEED, STOP_AFTER, stop

from bench.recording.arrays import RunArrays
from bench.verdict.assessment import Assessment, NoValueError
from bench.verdict.vocabulary import METRICS

WHEELS = ("fl", "fr", "rl", "rr")


@pytest.fixture(scope="module")
def run() -> Assessment:
    return Assessment(stop())


def test_brake_start(run: Assessment) -> None:
    assert run.metric("brake_start_time") == pytest.approx(BRAKE_AT)
    assert run.metric("brake_start_speed") == SPEED


def test_stopping_distance_is_v2_over_2a(run: Assessment) -> None:
    # standstill is a speed below 0.1 m/s, which leaves 0.1²/2a = 0.6 mm
    assert run.metric("stopping_distance") == pytest.approx(SPEED**2 / (2 * DECELERATION), abs=1e-3)
    assert run.metric("stopping_time") == pytest.approx(STOP_AFTER, abs=0.1 / DECELERATION + 1e-3)


def test_correction_to_a_target_speed_is_quadratic(run: Assessment) -> None:
    distance = run.metric("stopping_distance")
    assert run.metric("stopping_distance_corrected", {"target_speed": 2 * SPEED}) == pytest.approx(4 * distance)


def test_mean_deceleration_and_mfdd(run: Assessment) -> None:
    assert run.metric("mean_deceleration") == pytest.approx(DECELERATION, rel=1e-9)
    assert run.metric("mfdd") == pytest.approx(DECELERATION, rel=1e-6)
    assert run.metric("max_deceleration") == pytest.approx(DECELERATION, rel=1e-6)


def test_mfdd_in_kmh_is_the_clause(run: Assessment) -> None:
    # 71/320/EEC annex II 1.1.2: (v_b² − v_e²) / (25.92 (s_e − s_b)), km/h and m
    v_b, v_e = 0.8 * SPEED * 3.6, 0.1 * SPEED * 3.6
    s = [(SPEED**2 - (v / 3.6) ** 2) / (2 * DECELERATION) for v in (v_b, v_e)]
    assert run.metric("mfdd") == pytest.approx((v_b**2 - v_e**2) / (25.92 * (s[1] - s[0])), rel=1e-6)


def test_braking_phase_is_that_of_the_friction_document(run: Assessment) -> None:
    window = run.window("braking")
    assert run.time[window.start] == pytest.approx(BRAKE_AT + 0.4)
    speed = run.signal("speed")
    assert speed[window.stop - 1] >= 5.0 > speed[window.stop]


def test_braking_distance_begins_where_the_deceleration_passes_a_tenth_of_its_mean() -> None:
    # deceleration rises linearly to 8 m/s² within 0.2 s: a tenth of the mean is passed 0.02 s after the brake start
    time = np.arange(6000) * 1e-3
    ramp = np.clip((time - 1.0) / 0.2, 0, 1) * 8.0
    lost = np.concatenate(([0.0], np.cumsum(0.5 * (ramp[1:] + ramp[:-1]) * 1e-3)))
    speed = np.maximum(25.0 - lost, 0.0)
    data = RunArrays(
        time,
        {"time": time, "speed": speed, "driver_pedal_force": (time >= 1.0) * 100.0},
        {"time": "s", "speed": "m/s", "driver_pedal_force": "N"},
    )
    run = Assessment(data)
    difference = run.metric("stopping_distance") - run.metric("braking_distance")
    assert difference == pytest.approx(25.0 * 0.02, abs=25.0 * 3e-3)
    corrected = run.metric("braking_distance", {"target_speed": 50.0})
    assert corrected == pytest.approx(4 * run.metric("braking_distance"), rel=1e-3)


def test_wheel_lock_counts_the_longest_time_above_its_speed() -> None:
    # locked for 0.2 s at once, then 0.05 s; and always below 15 km/h, which does not count
    def slip(time: np.ndarray) -> np.ndarray:
        locked = ((time >= 1.5) & (time < 1.7)) | ((time >= 2.0) & (time < 2.05)) | (time >= 3.7)
        return np.where(locked, -0.995, -0.1)

    run = Assessment(stop(slip_ratio_rl=slip))
    assert run.metric("wheel_lock") == pytest.approx([0, 0, 0.2, 0], abs=1e-9)
    fast_time = (SPEED - 15 / 3.6) / DECELERATION
    assert run.metric("lock_share")[2] == pytest.approx(0.25 / fast_time, rel=1e-3)
    assert run.metric("wheel_lock", {"above_speed": 0.0})[2] > 0.4
    assert run.metric("wheel_lock", {"locked_below": 0.001})[2] == 0.0


def test_lock_speed_ratio_needs_both_axles() -> None:
    def from_time(start: float):
        return lambda time: np.where(time >= start, -1.0, -0.1)

    assert Assessment(stop(slip_ratio_fr=from_time(1.5))).metric("lock_speed_ratio") == 0.0
    both = Assessment(stop(slip_ratio_fr=from_time(1.5), slip_ratio_rl=from_time(2.0)))
    assert both.metric("lock_speed_ratio") == pytest.approx((SPEED - DECELERATION) / SPEED, rel=1e-6)


def test_slip_statistics(run: Assessment) -> None:
    assert run.metric("slip_mean") == pytest.approx((FRONT_SLIP + REAR_SLIP) / 2)
    assert run.metric("slip_mean_wheel") == pytest.approx([FRONT_SLIP, FRONT_SLIP, REAR_SLIP, REAR_SLIP])
    assert run.metric("slip_band", {"low": 0.1, "high": 0.2}) == pytest.approx(0.5)
    assert run.metric("slip_high_share", {"above_slip": 0.1}) == pytest.approx(0.5)
    assert run.metric("slip_high_share_wheel", {"above_slip": 0.1}) == pytest.approx([1, 1, 0, 0])


def test_yaw_and_lateral_figures(run: Assessment) -> None:
    assert run.metric("max_abs_yaw_rate") == pytest.approx(0.1, rel=1e-5)
    assert run.metric("yaw") == pytest.approx(0.02 * STOP_AFTER, abs=3e-4)
    assert run.metric("lateral_offset") == 0.0


def test_lateral_offset_is_from_the_line_driven() -> None:
    heading = 0.3
    along = Assessment(
        stop(
            yaw_angle=lambda t: np.full_like(t, heading),
            position_x=lambda t: 20 * t * np.cos(heading) - 2 * (t > 2) * np.sin(heading),
            position_y=lambda t: 20 * t * np.sin(heading) + 2 * (t > 2) * np.cos(heading),
        )
    )
    assert along.metric("lateral_offset") == pytest.approx(2.0)


def test_abs_cycles_are_release_phases() -> None:
    def phases(time: np.ndarray) -> np.ndarray:
        return np.where((time > 1) & (np.mod(time, 0.2) < 0.05) & (time < 2), 3.0, 1.0)

    run = Assessment(stop(ecu_phase_fl=phases))
    assert run.metric("abs_cycles") == pytest.approx([5, 0, 0, 0])


def test_estimator_error_and_settling() -> None:
    # road friction falls from 1.0 to 0.6 at 2 s; the estimate follows with a time constant of 0.05 s and an offset
    def limit(time: np.ndarray) -> np.ndarray:
        return np.where(time < 2.0, 1.0, 0.6)

    def estimate(time: np.ndarray) -> np.ndarray:
        return np.where(time < 2.0, 1.0, 0.6 + 0.4 * np.exp(-(time - 2.0) / 0.05))

    run = Assessment(
        stop(
            friction_limit_fl=limit,
            friction_limit_fr=limit,
            **{"friction_ekf.friction_limit_front": estimate, "friction_ekf.speed": lambda t: np.zeros_like(t) + 3.0},
        )
    )
    assert run.metric("friction_jump_time") == pytest.approx(2.0)
    from bench.verdict.expression import evaluate

    settling = evaluate("settling_time(friction_ekf.friction_limit_front)", run, "brake")
    assert settling == pytest.approx(0.05 * np.log(0.4 / 0.06), abs=1.5e-3)
    speed = run.signal("speed")[run.window("braking")]
    expected = np.sqrt(np.mean((speed - 3.0) ** 2))
    assert evaluate("estimator_error(friction_ekf.speed)", run, "braking") == pytest.approx(expected)
    assert evaluate("rmse(friction_ekf.speed, truth(friction_ekf.speed))", run, "braking") == pytest.approx(expected)


def test_an_estimate_that_never_settles_is_infinite() -> None:
    def limit(time: np.ndarray) -> np.ndarray:
        return np.where(time < 2.0, 1.0, 0.6)

    never = stop(
        friction_limit_fl=limit,
        friction_limit_fr=limit,
        **{"friction_ekf.friction_limit_front": lambda t: np.ones_like(t)},
    )
    from bench.verdict.expression import evaluate

    assert evaluate("settling_time(friction_ekf.friction_limit_front)", never, "brake") == np.inf


def test_timing_metrics_come_from_the_timing_block() -> None:
    data = stop()
    data.timing = {"overruns": 3, "late_ticks": 7}
    run = Assessment(data)
    assert (run.metric("real_time_overruns"), run.metric("late_ticks")) == (3.0, 7.0)
    late = Assessment(stop(lateness=lambda t: np.where(t < 0.5, 2e-3, 1e-5)))
    assert late.metric("late_ticks") == 500
    data.timing = {"mode": "lockstep"}
    assert Assessment(data).metric("skipped_ticks") == 0.0


def test_brake_start_is_the_application_that_takes_the_most_speed() -> None:
    def pedal(time: np.ndarray) -> np.ndarray:
        return np.where(((time > 0.2) & (time < 0.3)) | (time >= 1.0), 100.0, 0.0)

    zero = {"driver_master_pressure": lambda t: np.zeros_like(t)}
    assert Assessment(stop(driver_pedal_force=pedal, **zero)).metric("brake_start_time") == pytest.approx(1.0)


def test_without_a_pedal_signal_the_deceleration_tells() -> None:
    full = stop()
    bare = RunArrays(full.time, {"time": full.time, "speed": full.array("speed")}, {"time": "s", "speed": "m/s"})
    run = Assessment(bare)
    assert run.metric("brake_start_time") == pytest.approx(BRAKE_AT, abs=0.01)
    assert run.notes == [
        "brake start taken from the deceleration: the recording has no pedal force, pressure or switch"
    ]


def test_slip_from_wheel_speed_and_radius() -> None:
    full = stop()
    columns = {"time": full.time, "speed": full.array("speed"), "pedal_force": full.array("driver_pedal_force")}
    for wheel in WHEELS:
        columns[f"wheel_speed_{wheel}"] = full.array("speed") * 0.9 / 0.3
    units = dict.fromkeys(columns, "1")
    run = Assessment(RunArrays(full.time, columns, units), wheel_radius_m=0.3)
    assert run.metric("slip_mean") == pytest.approx(0.1)
    with pytest.raises(NoValueError, match="wheel radius"):
        Assessment(RunArrays(full.time, columns, units)).metric("slip_mean")


@pytest.mark.parametrize(
    ("columns", "metric", "reason"),
    [
        ({"speed": lambda t: np.full_like(t, 25.0)}, "stopping_distance", "does not come to a stop"),
        (
            {"driver_pedal_force": np.zeros_like, "driver_master_pressure": np.zeros_like},
            "mean_deceleration",
            "not actuated",
        ),
        ({}, "friction_jump_time", "does not jump"),
        ({}, "real_time_overruns", "timing block"),
        ({}, "steering_wheel_peak", "has no signal driver_steering_wheel_angle or steering_wheel_angle"),
    ],
)
def test_says_why_a_run_has_no_value(columns: dict, metric: str, reason: str) -> None:
    with pytest.raises(NoValueError, match=reason):
        Assessment(stop(**columns)).metric(metric)


def test_every_metric_has_a_value_or_a_reason(run: Assessment) -> None:
    for name, metric in METRICS.items():
        try:
            value = run.metric(name)
        except NoValueError:
            continue
        assert np.shape(value) == ((4,) if metric.per_wheel else ()), name


def test_truth_of_an_axle_is_weighted_by_the_wheels_loads() -> None:
    data = stop(
        friction_limit_fl=lambda t: np.full_like(t, 0.8),
        friction_limit_fr=lambda t: np.full_like(t, 0.2),
        vertical_load_fl=lambda t: np.full_like(t, 3000.0),
        vertical_load_fr=lambda t: np.full_like(t, 1000.0),
        **{"friction_ekf.friction_limit_front": lambda t: np.full_like(t, 0.5)},
    )
    from bench.verdict.metrics import truth

    assert truth(Assessment(data), "friction_ekf.friction_limit_front") == pytest.approx(0.65)


def test_truth_of_side_friction_is_the_axles_force_over_its_load() -> None:
    """Both wheels' 1800 N over 6000 N; a slip angle of -2 deg in ISO 8855 is +2 deg for the estimator."""
    from bench.verdict.metrics import truth

    data = stop(
        lateral_force_fl=lambda t: np.full_like(t, 1500.0),
        lateral_force_fr=lambda t: np.full_like(t, 300.0),
        vertical_load_fl=lambda t: np.full_like(t, 4000.0),
        vertical_load_fr=lambda t: np.full_like(t, 2000.0),
        slip_angle_fl=lambda t: np.full_like(t, -0.04),
        slip_angle_fr=lambda t: np.full_like(t, -0.02),
    )
    run = Assessment(data)
    assert truth(run, "cornering_stiffness_rls.friction_used_front") == pytest.approx(0.3)
    assert truth(run, "cornering_stiffness_rls.slip_angle_front") == pytest.approx(0.03)
