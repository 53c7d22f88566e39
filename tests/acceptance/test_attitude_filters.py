"""Acceptance list of the attitude document (its section 8), items 14 to 23: sensors, forms of the filters."""

from collections.abc import Callable

import numpy as np
import pytest
from attitude_rides import (
    TUNED,
    built,
    observe,
    offsets,
    replayed,
    ridden,
    ride,
    still,
)
from scipy.signal import butter, lfilter

from estimators.attitude_bank import AttitudeFilter
from estimators.attitude_filter import observation_slopes, system_slopes
from estimators.attitude_forms import (
    B_PITCH,
    B_ROLL,
    B_X,
    B_Y,
    B_YAW,
    B_Z,
    PHI,
    ROW_ROLL,
    ROW_SPEED,
    ROW_Y,
    ROW_Z,
    SPEED,
    THETA,
)
from estimators.attitude_settings import SENSORS
from estimators.attitude_two_wheeler import U_PITCH_RISE, U_ROLL_RISE, U_YAW_RISE
from estimators.attitude_weights import (
    OFFSET,
)
from signals.errors import InputError
from vehicle_model.reference.two_wheeler import SAMPLE_S, Noise, measure


@pytest.mark.acceptance("B-14")
@pytest.mark.parametrize("form", ["1A", "2A", "car_y"])
def test_inputs_and_their_low_passes(form: str, record: Callable[..., None]) -> None:
    bank = built({"form": "2A"})
    wanted = {*SENSORS, "wheel_speed_rl", "wheel_speed_rr", "abs_active"}
    assert set(bank.inputs) == wanted
    assert set(built({"form": "1A"}).inputs) == wanted - {"pitch_rate"}
    if form == "car_y":
        return
    n = 500
    for channel, name in enumerate(SENSORS):
        if form == "1A" and name == "pitch_rate":
            continue
        bank = built({"form": form})
        step = np.where(np.arange(n) >= 200, 0.1, 0.0)
        bank.replay(still(1.0) | {name: step})
        b, a = butter(2, 8.0, fs=1.0 / SAMPLE_S)
        others = [k for k in range(6) if k != channel]
        assert bank.memory.filtered[channel, 2] == pytest.approx(lfilter(b, a, step)[-1], abs=1e-12)
        assert bank.memory.filtered[others, 2] == pytest.approx(0.0)
    speed = np.where(np.arange(n) >= n - 1, 16.0, 15.0) / 0.31
    bank = replayed(still(1.0) | {"wheel_speed_rl": speed, "wheel_speed_rr": speed}, {"form": form})
    assert bank.memory.filtered[6, 2] == pytest.approx(16.0), "the speed has none"
    record("cut-off", 8.0, "8 Hz, second order")


@pytest.mark.acceptance("B-15")
def test_differentiators() -> None:
    for form, rises in (("1A", (U_ROLL_RISE, U_YAW_RISE)), ("2A", (U_ROLL_RISE, U_PITCH_RISE, U_YAW_RISE))):
        for name, rise in zip(
            ("roll_rate", "pitch_rate", "yaw_rate"), (U_ROLL_RISE, U_PITCH_RISE, U_YAW_RISE), strict=True
        ):
            if rise not in rises:
                continue
            n = round(4.0 / SAMPLE_S)
            offset = np.where(np.arange(n) >= 500, 0.02, 0.0)
            bank = replayed(still() | {name: offset}, {"form": form})
            assert bank.memory.inputs[0, rise] == pytest.approx(0.0, abs=1e-9), "after the transient"
            ramp = 0.1 * SAMPLE_S * np.arange(n)
            bank = replayed(still() | {name: ramp}, {"form": form})
            assert bank.memory.inputs[0, rise] == pytest.approx(0.1, abs=1e-6)


@pytest.mark.acceptance("B-16", "B-17")
def test_injected_offsets_and_noise(record: Callable[..., None]) -> None:
    source = ride(TUNED, True, 40.0)
    quiet = Noise(0.0, 0.0, 0.0)
    right = measure(source, 1, noise=quiet)
    for name, value in offsets(roll=1.0, pitch=-0.5, yaw=2.0, x=100.0, y=-250.0, z=50.0).items():
        wrong = measure(source, 1, offsets={name: value}, onset_s=12.5, noise=quiet)
        late = source.time >= 12.5
        assert wrong[name][late] - right[name][late] == pytest.approx(value)
        assert np.array_equal(wrong[name][~late], right[name][~late])
        assert all(np.array_equal(wrong[other], right[other]) for other in right if other != name)
    noisy = measure(source, 1)
    for name in SENSORS:
        expected = np.deg2rad(0.1) if name.endswith("rate") else 0.25
        found = float(np.std(noisy[name] - right[name]))
        record(f"noise of {name}", found, f"{expected:.4g} within 3 %", id="B-17")
        assert found == pytest.approx(expected, rel=0.03)
    assert np.std(noisy["wheel_speed_rl"] - right["wheel_speed_rl"]) * 0.31 == pytest.approx(0.03, rel=0.03)
    with pytest.raises(InputError, match="no such sensor"):
        measure(source, 1, offsets={"roll_angle": 1.0})


@pytest.mark.acceptance("B-18", "B-19")
@pytest.mark.parametrize(
    ("form", "states", "virtual"),
    [
        ("1A", (PHI, SPEED, B_ROLL, B_YAW, B_Z), B_Y),
        ("1B", (PHI, SPEED, B_ROLL, B_YAW, B_Y), B_Z),
        ("1C", (PHI, SPEED, B_ROLL, B_YAW, B_Z), B_X),
        ("1D", (PHI, SPEED, B_ROLL, B_YAW, B_Y), B_X),
    ],
)
def test_forms_of_the_first_embodiment(form: str, states: tuple[int, ...], virtual: int) -> None:
    bank = replayed(ridden(20.0, sloped=False), {"form": form})
    assert tuple(bank.memory.entries) == states
    assert bank.form.virtual == virtual
    assert tuple(bank.memory.rows) == (ROW_Y, ROW_Z, ROW_SPEED)
    assert bank.memory.design.shape == (3, 5), "three measurements, a gain of five rows"
    assert bank.filter_covariances.shape == (3, 5, 5)
    assert bank.filter_states[:, virtual] == pytest.approx(bank.bank[OFFSET])
    f, h = _slopes(bank, virtual)
    acts_in_f = virtual == B_X
    assert bool(np.any(f)) == acts_in_f
    assert bool(np.any(h)) != acts_in_f


@pytest.mark.acceptance("B-20", "B-21")
@pytest.mark.parametrize(("form", "state", "virtual"), [("2A", B_Z, B_X), ("2B", B_X, B_Z), ("2C", B_X, B_Y)])
def test_forms_of_the_second_embodiment(form: str, state: int, virtual: int) -> None:
    for name in (form, f"{form}-light"):
        bank = replayed(ridden(20.0), {"form": name})
        assert tuple(bank.memory.entries) == (THETA, PHI, SPEED, B_ROLL, B_YAW, B_PITCH, state)
        assert tuple(bank.memory.rows) == (ROW_Y, ROW_Z, ROW_SPEED, ROW_ROLL)
        assert bank.form.virtual == virtual
        assert bank.filter_states[:, virtual] == pytest.approx(bank.bank[OFFSET])
        f, h = _slopes(bank, virtual)
        if virtual == B_X:
            assert f[SPEED] == pytest.approx(-1.0), "in f"
            assert h[ROW_Z] == pytest.approx(-np.tan(0.02)), "in the row of G_z"
            assert h[ROW_ROLL] != 0.0, "and in that of Q_x"
            assert h[[ROW_Y, ROW_SPEED]] == pytest.approx([0.0, 0.0], abs=1e-12)
        else:
            assert not f.any()


def _slopes(bank: AttitudeFilter, entry: int) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of f and h by an entry of the full vector, at some lean."""
    a, rows, car, _, _ = bank._bound
    x = bank.filter_states[1].copy()
    x[PHI], u = 0.4, np.array([0.5, 0.2, -0.3, 1.0, 0.4, -0.6, 1.2, 0.0, 0.02, 0.1, 0.0])
    entries = np.array([entry])
    f, h = np.zeros((1, 4)), np.zeros((1, 6))
    system_slopes(x, u, rows[0], car[0], False, entries, a.steps, a.rates, f)
    observation_slopes(x, u, rows[0], car[0], False, entries, a.steps, a.mechanics, a.outputs, h)
    return f[0], h[0]


@pytest.mark.acceptance("B-22")
def test_gyro_offsets_are_subtracted_in_f_and_h(record: Callable[..., None]) -> None:
    source = ride(TUNED, False, 110.0)
    found = observe(source, measure(source, TUNED, offsets=offsets(yaw=1.0)), {"form": "1A"}, "attitude_single")
    value = found.mean("yaw_rate_offset")
    record("b_ya of one filter for 1 degree/s", value, "1.0 +- 0.1 degree/s; 2.96 with the printed form")
    assert value == pytest.approx(1.0, abs=0.1)
    bank = replayed(ridden(20.0), {"form": "2A"})
    for entry in (B_ROLL, B_YAW, B_PITCH):
        f, h = _slopes(bank, entry)
        assert f.any()
        assert h.any()


@pytest.mark.acceptance("B-23")
def test_offsets_are_constant_but_for_process_noise() -> None:
    bank = replayed(ridden(20.0), {"form": "2A"})
    a = bank.memory
    for place, entry in enumerate(a.entries):
        unit = np.eye(len(a.entries))[place]
        if entry >= B_ROLL:
            assert np.array_equal(a.transition[place], unit)
            deviation = 4e-3 if entry >= B_X else 6e-5
            assert a.process[place, place] == pytest.approx(deviation**2 * 0.01)
