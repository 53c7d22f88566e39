"""Acceptance list of the attitude document (its section 8), items 25 to 41, 55 and 56: bank, likelihood, variants."""

from collections.abc import Callable

import numpy as np
import pytest
from attitude_rides import (
    MILLI_G,
    STEP,
    STEPPED,
    TUNED,
    built,
    delayed,
    grid,
    noise,
    observe,
    offsets,
    outputs,
    replayed,
    ridden,
    ride,
    still,
)

from estimators.attitude_bank import AttitudeBank
from estimators.attitude_forms import (
    B_ROLL,
    B_YAW,
    B_Z,
    PHI,
    ROW_SPEED,
    ROW_Y,
    ROW_Z,
    SPEED,
)
from estimators.attitude_settings import SENSORS
from estimators.attitude_two_wheeler import U_ELEVATION
from estimators.attitude_weights import (
    BANK_ROWS,
    LOG,
    OFFSET,
    SMOOTH,
    WEIGHT,
    log_likelihood,
    separation,
    smooth,
    weigh,
)
from signals.errors import InputError
from vehicle_model.reference.two_wheeler import SAMPLE_S, measure


@pytest.mark.acceptance("B-25")
@pytest.mark.parametrize("form", ["1A", "1C", "2A-light", "2C-light"])
def test_dropping_a_filter_leaves_the_others_bit_identical(form: str) -> None:
    columns = ridden(40.0, sloped=form.startswith("2"), y=100.0)
    whole = replayed(columns, {"form": form, "virtual_offsets": grid(-150, -50, 0, 150)})
    for dropped in range(4):
        kept = [k for k in range(4) if k != dropped]
        values = [grid(-150, -50, 0, 150)[k] for k in kept]
        fewer = replayed(columns, {"form": form, "virtual_offsets": values})
        assert np.array_equal(fewer.filter_states, whole.filter_states[kept])
        assert np.array_equal(fewer.filter_covariances, whole.filter_covariances[kept])
    alone = replayed(columns, {"form": form}, "attitude_single")
    assert np.array_equal(alone.filter_states[0], whole.filter_states[2]), "one filter is the bank's middle one"


@pytest.mark.acceptance("B-26")
@pytest.mark.parametrize("values", [(-100, 100), (-150, 0, 150), (-150, -50, 50, 150), tuple(range(-160, 161, 40))])
def test_number_of_filters(values: tuple[int, ...]) -> None:
    bank = built({"form": "1A", "virtual_offsets": grid(*values)})
    found = outputs(bank, ridden(20.0, sloped=False))
    assert bank.filter_states.shape == (len(values), 10)
    assert bank.bank[OFFSET] == pytest.approx(grid(*values))
    assert all(np.isfinite(column).all() for column in found.values())


@pytest.mark.acceptance("B-26")
@pytest.mark.parametrize("values", [[0.5], [0.5, 0.5], [0.0, 0.0, 0.0]])
def test_a_bank_of_equals_is_refused(values: list[float]) -> None:
    with pytest.raises(InputError, match="virtual_offsets"):
        built({"form": "1A", "virtual_offsets": values})


@pytest.mark.acceptance("B-27")
@pytest.mark.parametrize("limit_mg", [100.0, 250.0])
def test_default_offsets_bracket_the_sensor(limit_mg: float) -> None:
    limit = limit_mg * MILLI_G
    offsets_ = built({"form": "2A", "sensor_range": limit}).bank[4]
    assert offsets_.max() > limit
    assert offsets_.min() < -limit
    assert np.any(np.abs(offsets_) < limit)


@pytest.mark.acceptance("B-28")
def test_likelihood_of_the_document(record: Callable[..., None]) -> None:
    bank = np.zeros((BANK_ROWS, 3))
    bank[OFFSET] = grid(150.0, 0.0, -150.0)
    s = np.diag([0.04, 0.04, 0.01])
    for i, e in enumerate(((0.3, -0.1, 0.05), (0.1, 0.0, 0.02), (-0.2, 0.4, 0.0))):
        squared = float(np.array(e) @ np.linalg.solve(s, e))
        bank[LOG, i] = log_likelihood(squared, float(np.linalg.slogdet(s)[1]), 3, 0.0)
    assert np.exp(bank[LOG]) == pytest.approx([63.209899, 216.255573, 20.521250], abs=1e-5)
    smooth(bank, 1.0, False)
    weigh(bank, 0.0)
    value = float(bank[WEIGHT] @ bank[OFFSET]) / MILLI_G
    record("b of (28)", value, "21.345269 mG +- 1e-5")
    assert value == pytest.approx(21.345269, abs=1e-5)


@pytest.mark.acceptance("B-29")
@pytest.mark.parametrize("accumulated", [False, True])
@pytest.mark.parametrize("sigmas", [(1000.0, 1000.0, 1000.0), (0.0, 500.0, 1000.0), (1e-9, 0.0, 40.0)])
def test_weights_of_hopeless_filters(sigmas: tuple[float, ...], accumulated: bool, record: Callable[..., None]) -> None:
    bank = np.zeros((BANK_ROWS, 3))
    for _ in range(2000):
        for i, sigma in enumerate(sigmas):
            bank[LOG, i] = log_likelihood(4.0 * sigma**2, 4.0 * np.log(1e-4), 4, 0.0)
        smooth(bank, 0.01 / 5.01, accumulated)
        weigh(bank, 5.0 if accumulated else 0.0)
        assert np.isfinite(bank[WEIGHT]).all()
        assert bank[WEIGHT].sum() == pytest.approx(1.0, abs=1e-12)
    record("sum of the weights less 1", float(bank[WEIGHT].sum() - 1.0), "< 1e-12")


@pytest.mark.acceptance("B-29")
def test_a_bank_whose_filters_are_all_wrong() -> None:
    """Measurements 1000 sigma off what any filter expects."""
    columns = still(8.0)
    columns["vertical_acceleration"] = np.where(np.arange(4000) > 2000, 30.0, 0.0)
    found = outputs(built({"form": "1A"}), columns)
    assert all(np.isfinite(column).all() for column in found.values())


@pytest.mark.acceptance("B-30")
def test_low_pass_of_the_likelihood() -> None:
    columns = ridden(20.0, sloped=False, y=100.0)
    bank = replayed(columns, {"form": "1A", "likelihood_time_constant": 0.0})
    assert bank.bank[SMOOTH] == pytest.approx(np.exp(bank.bank[LOG]), rel=1e-12)
    slow = replayed(columns, {"form": "1A", "likelihood_time_constant": 5.0})
    assert slow.bank[LOG] == pytest.approx(bank.bank[LOG], rel=1e-12), "the filters do not know of it"
    assert slow.bank[SMOOTH] != pytest.approx(np.exp(slow.bank[LOG]), rel=1e-3)
    # first order: after one time constant 1 - 1/e of a step
    row = np.zeros((BANK_ROWS, 2))
    for _ in range(500):
        smooth(row, 0.01 / 5.01, False)
    assert row[SMOOTH] == pytest.approx(1.0 - (1.0 - 0.01 / 5.01) ** 500, rel=1e-12)


@pytest.mark.acceptance("B-31", "B-32")
@pytest.mark.parametrize("form", ["1A", "1B", "1C", "2A", "2B", "2C"])
def test_weighted_output(form: str) -> None:
    columns = ridden(40.0, sloped=form.startswith("2"), x=300.0, y=300.0, z=300.0)
    bank = built({"form": form})
    found = outputs(bank, columns)
    low, high = bank.bank[OFFSET].min(), bank.bank[OFFSET].max()
    assert found["virtual_offset"].min() >= low - 1e-12
    assert found["virtual_offset"].max() <= high + 1e-12
    combined = bank.bank[WEIGHT] @ bank.filter_states
    assert bank.memory.combined == pytest.approx(combined, rel=1e-12)
    names = ("pitch_angle", "roll_angle", "speed", "lateral_speed", "roll_rate_offset", "yaw_rate_offset")
    names += (
        "pitch_rate_offset",
        *tuple(f"{axis}_acceleration_offset" for axis in ("longitudinal", "lateral", "vertical")),
    )
    assert [found[name][-1] for name in names] == pytest.approx(combined, rel=1e-12)
    assert found["virtual_offset"][-1] == pytest.approx(bank.bank[WEIGHT] @ bank.bank[OFFSET], rel=1e-9)


@pytest.mark.acceptance("B-33")
def test_best_filter() -> None:
    columns = ridden(40.0, y=100.0)
    bank = built({"form": "2C", "output": "best"})
    found = outputs(bank, columns)
    best = int(np.argmax(bank.bank[SMOOTH]))
    assert found["roll_angle"][-1] == bank.filter_states[best, PHI]
    assert found["virtual_offset"][-1] == bank.bank[OFFSET, best]
    seen = np.unique(found["virtual_offset"][found["active"] > 0.5])
    assert np.isin(seen, bank.bank[OFFSET]).all()


@pytest.mark.acceptance("B-34")
def test_other_likelihoods_and_weights() -> None:
    columns = ridden(40.0, y=100.0)
    weights = {}
    for label, settings in {
        "(27)": {},
        "student": {"likelihood": "student"},
        "accumulated": {"weighting": "accumulated"},
        "re-centred": {"recentring": True, "likelihood_time_constant": 2.0},
    }.items():
        bank = replayed(columns, {"form": "2C", **settings})
        weights[label] = bank.bank[WEIGHT].copy()
        assert weights[label].sum() == pytest.approx(1.0)
        assert np.argmax(weights[label]) == np.argmax(weights["(27)"]) or label == "re-centred"
    for label in ("student", "accumulated", "re-centred"):
        assert weights[label] != pytest.approx(weights["(27)"], rel=1e-3), label
    # density of the multivariate Student distribution with S, without its constant
    assert log_likelihood(6.0, 2.0, 3, 4.0) == pytest.approx(-1.0 - 3.5 * np.log(2.5))


@pytest.mark.acceptance("B-35", "B-36")
def test_loop_of_the_wheel_loads() -> None:
    columns = ridden(20.0)
    bank, light = built({"form": "2A"}), built({"form": "2A-light"})
    fed, angle, slope = [], [], []
    length = len(columns["roll_rate"])
    outputs(bank, {name: values[:20] for name, values in columns.items()})
    for start in range(20, length - STEP + 1, STEP):
        found = outputs(bank, {name: values[start : start + STEP] for name, values in columns.items()})
        fed.append(bank.memory.inputs[0, U_ELEVATION])
        angle.append(found["elevation_angle"][-1])
        slope.append(found["road_slope"][-1])
    # what a step gives reaches the filters in the next one
    assert np.array_equal(fed[50:], angle[49:-1])
    assert np.std(angle) > 1e-3
    assert np.std(slope) > 1e-3
    found = outputs(light, columns)
    assert not found["elevation_angle"].any()
    assert not light.memory.inputs[:2, U_ELEVATION : U_ELEVATION + 2].any()
    assert light.tick.func is bank.tick.func, "the same code"
    assert found["road_slope"][-1] == pytest.approx(found["pitch_angle"][-1], abs=1e-12), "zeta = 0"


@pytest.mark.acceptance("B-37")
def test_without_the_characteristic_equation() -> None:
    bank = replayed(ridden(20.0), {"form": "2C", "characteristic_equation": False})
    assert tuple(bank.memory.rows) == (ROW_Y, ROW_Z, ROW_SPEED)
    assert bank.memory.design.shape == (3, 7)


@pytest.mark.acceptance("B-38")
def test_speed_of_the_front_wheel(record: Callable[..., None]) -> None:
    """A ride whose front contact point does not slide sideways, seen by both variants."""
    source = ride(TUNED, True, 110.0, contact="front")
    columns = measure(source, TUNED)
    errors = {}
    for wheel in ("front", "rear"):
        found = observe(source, columns, {"form": "2A", "speed_source": wheel}, "attitude_single")
        errors[wheel] = found.error("roll_angle", 60.0, 109.0)
        record(f"RMSE of roll, {wheel} wheel's equations", errors[wheel], "< 0.3 degrees for the front")
    assert errors["front"] < 0.3
    assert errors["front"] < 0.5 * errors["rear"]
    assert "wheel_speed_fl" in built({"form": "2A", "speed_source": "front"}).inputs


@pytest.mark.acceptance("B-39")
@pytest.mark.parametrize(("form", "limit"), [("1A", 0.3), ("2A", 0.3)])
def test_speed_from_outside(form: str, limit: float, record: Callable[..., None]) -> None:
    source = ride(TUNED, form == "2A", 110.0)
    columns = measure(source, TUNED) | {"ecu_reference_speed": source.speed}
    found = observe(source, columns, {"form": form, "speed_source": "external"}, "attitude_single")
    bank = built({"form": form, "speed_source": "external"})
    assert SPEED not in bank.memory.entries
    assert ROW_SPEED not in bank.memory.rows
    assert not {name for name in bank.inputs if name.startswith("wheel_speed")}
    assert found["speed"][-1] == pytest.approx(source.speed[STEPPED][-1], rel=1e-6)
    record(f"RMSE of roll, form {form}", found.error("roll_angle", 60.0), f"< {limit} degrees")
    assert found.error("roll_angle", 60.0) < limit


@pytest.mark.acceptance("B-40")
def test_sensors_along_other_axes() -> None:
    columns = ridden(30.0)
    mixing = np.array([[1.0, 0.2, 0.0], [-0.1, 0.9, 0.3], [0.1, 0.0, 1.1]])
    skewed = dict(columns)
    for group in (SENSORS[:3], SENSORS[3:]):
        true = np.column_stack([columns[name] for name in group])
        level = np.array([0.0, 0.0, 9.80665]) if group == SENSORS[3:] else np.zeros(3)
        for name, values in zip(group, ((true + level) @ mixing.T - level).T, strict=True):
            skewed[name] = values
    matrix = np.linalg.inv(mixing).tolist()
    straight = outputs(built({"form": "2A"}), columns)
    turned = outputs(built({"form": "2A", "gyro_matrix": matrix, "accelerometer_matrix": matrix}), skewed)
    for name in ("roll_angle", "pitch_angle", "virtual_offset"):
        assert turned[name] == pytest.approx(straight[name], abs=1e-6)
    with pytest.raises(InputError, match="gyro_matrix"):
        built({"form": "2A", "gyro_matrix": [[1, 0, 0], [1, 0, 0], [0, 0, 1]]})


@pytest.mark.acceptance("B-41")
def test_comparison_device() -> None:
    device = built({"form": "comparison"}, "attitude_single")
    assert tuple(device.memory.entries) == (PHI, SPEED, B_ROLL, B_YAW, B_Z)
    assert device.filter_states.shape == (1, 10)
    assert "pitch_rate" not in device.inputs
    with pytest.raises(InputError, match="form"):
        built({"form": "comparison"})


@pytest.mark.acceptance("B-55")
def test_separation_of_neighbouring_filters(record: Callable[..., None]) -> None:
    bank = np.zeros((BANK_ROWS, 3))
    bank[OFFSET] = -1.0, 0.0, 1.0
    for k in (1.0, 1.72, 2.3):
        for true in (0.0, 0.4, 0.9):
            bank[WEIGHT] = np.exp(-0.5 * k**2 * (bank[OFFSET] - true) ** 2)
            assert separation(bank) == pytest.approx(k, rel=1e-12), "whatever the true offset"
    bank[OFFSET] = -1.0, 0.0, 2.0
    bank[WEIGHT] = np.exp(-0.5 * 1.5**2 * bank[OFFSET] ** 2)
    assert separation(bank) == pytest.approx(1.5 * 1.5, rel=1e-12), "of the mean distance"
    assert separation(bank[:, :2].copy()) == 0.0
    source = ride(TUNED, True)
    for form, printed in (("2A", 2.25), ("2C", 2.05), ("2B", 2.8)):
        found = observe(source, measure(source, TUNED), {"form": form})
        rows = found.after(60.0)
        # practical measure of 3.5: w_outer/w_centre = exp(-k^2/2)
        k = float(np.mean(found["separation"][rows]))
        record(f"k of form {form}, no offset", k, f"{printed} within 25 %")
        assert k == pytest.approx(printed, rel=0.25)


@pytest.mark.acceptance("B-56")
def test_headlight_gets_the_roll_angle_with_its_age(record: Callable[..., None]) -> None:
    source = ride(TUNED, True, 110.0)
    bank = built({"form": "2A"})
    columns = measure(source, TUNED) | {"abs_active": np.zeros(len(source.time))}
    found = outputs(bank, columns)
    running = found["active"] > 0.5
    assert running[25:].all()
    age = found["roll_angle_age"][running]
    delay = np.sqrt(2.0) / (2.0 * np.pi * 8.0)
    assert age.min() == pytest.approx(delay, abs=1e-9)
    assert age.max() == pytest.approx(delay + (STEP - 1) * SAMPLE_S, abs=1e-9)
    # the age is what the estimate lags behind
    roll, lags = found["roll_angle"][5004::STEP], np.arange(0, 0.08, SAMPLE_S)
    errors = [np.std(roll - np.interp(source.time[5004::STEP] - lag, source.time, source.roll_angle)) for lag in lags]
    lag = float(lags[int(np.argmin(errors))])
    record("lag of the roll angle", lag, "28 ms +- 6 ms")
    assert lag == pytest.approx(delay, abs=0.006)
    through = np.std(roll - delayed(source.roll_angle)[5004::STEP])
    assert through < 0.5 * errors[0]


def test_weights_are_held_while_the_abs_brakes() -> None:
    columns = ridden(40.0, y=100.0)
    n = len(columns["roll_rate"])
    columns["abs_active"] = np.where((np.arange(n) > 10_000) & (np.arange(n) < 12_000), 1.0, 0.0)
    found = outputs(built({"form": "2C"}), columns)
    held = slice(10_010, 11_990)
    assert found["weights_held"][held].min() == 1.0
    assert np.ptp(found["zero_weight"][held]) == 0.0
    assert np.ptp(found["roll_angle"][held]) > 0.01, "the filters go on"
    assert found["weights_held"][13_000:].max() == 0.0
    free = outputs(built({"form": "2C", "abs_signal": "none"}), columns)
    assert free["weights_held"].max() == 0.0


def test_offsets_outlast_a_stop() -> None:
    source = ride(TUNED, True, 60.0)
    columns = measure(source, TUNED, offsets=offsets(yaw=1.0), onset_s=0.0)
    n = len(source.time)
    parked = {name: np.concatenate([values, np.zeros(1000), values[:2000]]) for name, values in columns.items()}
    parked["abs_active"] = np.zeros(n + 3000)
    found = outputs(built({"form": "2A"}), parked)
    assert found["active"][n + 500] == 0.0
    assert found["active"][-1] == 1.0
    assert found["resets"][-1] == 0.0
    assert found["yaw_rate_offset"][n + 1500] == pytest.approx(found["yaw_rate_offset"][n - 1], abs=2e-3)


def test_noise_settings_reach_the_filters() -> None:
    bank = built({"form": "2A", **noise(0.2, 0.3, 0.4, 0.5)})
    assert bank.memory.noise == pytest.approx(np.square([0.2, 0.3, 0.4, 0.5]))
    assert isinstance(bank, AttitudeBank)
