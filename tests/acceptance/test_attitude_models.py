"""Acceptance list of the attitude document (its section 8), items 1 to 13 and 24: models, blocks, Jacobians.

Reference numbers are those of its section 7.2, and vector mechanics that shares nothing with the filters.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from attitude_rides import motorcycle, numbers

from estimators.attitude_bank import AttitudeBank
from estimators.attitude_car import attitude_car
from estimators.attitude_filter import correct_filter, observation_slopes, system_slopes
from estimators.attitude_forms import FORMS, PHI, ROW_ROLL, ROW_SPEED, ROW_Y, ROW_Z, SPEED, THETA
from estimators.attitude_memory import CAR, LOG_VOLUME
from estimators.attitude_settings import AttitudeBankSettings, AttitudeSettings
from estimators.attitude_two_wheeler import (
    L_ELEVATION,
    L_ELEVATION_RATE,
    L_FRONT,
    L_FRONT_Y,
    L_REAR,
    L_REAR_Y,
    L_STROKE_F,
    L_STROKE_R,
    LOADS,
    M_AX,
    M_AY,
    M_AZ,
    M_BALANCE,
    M_FX,
    M_FY,
    M_FZ,
    M_GY,
    M_GZ,
    M_PITCH_RATE,
    M_QX,
    M_QY,
    M_QZ,
    M_ROLL_RATE,
    M_ROLL_RISE,
    M_SPEED_RATE,
    M_WHEEL,
    M_WX,
    M_WY,
    M_WZ,
    MECHANICS,
    follow_springs,
    longitudinal_share,
    mechanics,
    road_slope,
    two_wheeler,
    wheel_loads,
)
from vehicle_model.reference.two_wheeler import random_ride, rotation
from vehicle_model.vehicle_file import load_vehicle

G = 9.80665
RATES = {"p": 0.5, "q": 0.2, "r": -0.3, "dp": 1.0, "dq": 0.4, "dr": -0.6}
PLACES = {"p": 0, "q": 1, "r": 2, "dp": 3, "dq": 4, "dr": 5, "G_x": 6, "zeta": 8, "dzeta": 9}


def bike(form: str = "2A", **settings: object) -> np.void:
    """The document's two-wheeler as the filters read it."""
    return two_wheeler(numbers(), AttitudeSettings(form=form, **settings))[0]  # type: ignore[arg-type]


def at(phi: float = 0.0, theta: float = 0.0, speed: float = 0.0) -> np.ndarray:
    x = np.zeros(10)
    x[PHI], x[THETA], x[SPEED] = phi, theta, speed
    return x


def inputs(**values: float) -> np.ndarray:
    u = np.zeros(11)
    for name, value in values.items():
        u[PLACES[name]] = value
    return u


def solved(x: np.ndarray, u: np.ndarray, form: str = "2A", **settings: object) -> np.ndarray:
    m = np.zeros(MECHANICS)
    mechanics(x, u, bike(form, **settings), m)
    return m


def document(form: str = "2A", **settings: object) -> np.ndarray:
    """The state and inputs of 7.2."""
    zeta = {"zeta": 0.02, "dzeta": 0.1} if form.startswith("2") else {}
    theta = 0.05 if form.startswith("2") else 0.0
    return solved(at(0.4, theta, 18.0), inputs(**RATES, **zeta, G_x=1.2), form, **settings)


@pytest.mark.acceptance("B-1")
def test_frames_at_rest() -> None:
    m = solved(at(0.2), inputs())
    assert m[[M_GY, M_GZ]] == pytest.approx([G * np.sin(0.2), G * np.cos(0.2)], abs=1e-12)
    # at rest the accelerometer x reads what leaves no acceleration
    m = solved(at(theta=0.1), inputs(G_x=-G * np.sin(0.1)))
    assert m[M_SPEED_RATE] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.acceptance("B-2")
def test_euler_rates_against_a_rotation_matrix(record: Callable[..., None]) -> None:
    def angles(t: float) -> tuple[float, float, float]:
        return 0.6 * np.sin(1.3 * t), 0.2 * np.sin(0.9 * t + 0.4), 0.8 * np.sin(0.5 * t)

    def turned(t: float) -> np.ndarray:
        roll, pitch, yaw = angles(t)
        return rotation(np.array([roll]), np.array([pitch]), np.array([yaw]))[0]

    worst, h = 0.0, 1e-4
    for t in np.linspace(0.0, 6.0, 25):
        w = turned(t).T @ (turned(t + h) - turned(t - h)) / (2.0 * h)
        (roll, pitch, _), after, before = angles(t), angles(t + h), angles(t - h)
        m = solved(at(roll, pitch, 15.0), inputs(p=w[2, 1], q=w[0, 2], r=w[1, 0]))
        expected = [(after[k] - before[k]) / (2.0 * h) for k in range(2)]
        worst = max(worst, float(np.abs(m[[M_ROLL_RATE, M_PITCH_RATE]] - expected).max()))
    record("largest error of an Euler rate", worst, "< 1e-6 rad/s")
    assert worst < 1e-6


@pytest.mark.acceptance("B-3")
def test_the_first_embodiment_takes_its_pitch_rate_from_the_yaw_rate() -> None:
    p, r, dp, dr, phi = 0.5, -0.3, 1.0, -0.6, 0.4
    first = solved(at(phi, 0.0, 18.0), inputs(p=p, r=r, dp=dp, dr=dr, G_x=1.2), "1A")
    q, dq = r * np.tan(phi), dr * np.tan(phi) + r * p / np.cos(phi) ** 2
    told = solved(at(phi, 0.0, 18.0), inputs(p=p, q=q, r=r, dp=dp, dq=dq, dr=dr, G_x=1.2), "2A")
    assert first == pytest.approx(told, abs=1e-12)
    assert first[M_PITCH_RATE] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.acceptance("B-4")
def test_wheel_speed_of_a_leaning_wheel(record: Callable[..., None]) -> None:
    car = dict(numbers()) | {"two_wheeler.crown_radius": 0.29 * 0.31}
    m = np.zeros(MECHANICS)
    mechanics(at(np.deg2rad(40.0), speed=1.0), inputs(), two_wheeler(car, AttitudeSettings(form="1A"))[0], m)
    record("wheel speed over V_x at 40 degrees", m[M_WHEEL], "1.0728 +- 0.0005")
    assert m[M_WHEEL] == pytest.approx(1.0728, abs=5e-4)
    tilted = solved(at(speed=1.0), inputs(zeta=0.1))
    assert tilted[M_WHEEL] == pytest.approx(1.0 / np.cos(0.1), rel=1e-12)


@pytest.mark.acceptance("B-5", "B-6")
def test_values_of_the_second_embodiment(record: Callable[..., None]) -> None:
    m = document()
    printed = {
        M_AX: 0.143261662,
        M_AY: -1.038730063,
        M_AZ: -0.55179069,
        M_ROLL_RATE: 0.490069992,
        M_ROLL_RISE: 0.92763672,
        M_PITCH_RATE: 0.301037701,
        M_SPEED_RATE: 1.474856957,
        M_GY: -2.804637298,
        M_GZ: 6.699665071,
        M_WHEEL: 18.425880808,
    }
    worst = max(abs(m[place] - value) for place, value in printed.items())
    record("largest difference to 7.2, second embodiment", worst, "< 1e-6")
    assert worst < 1e-6


@pytest.mark.acceptance("B-5", "B-6")
def test_values_of_the_first_embodiment(record: Callable[..., None]) -> None:
    m = document("1A")
    printed = {
        M_AX: -0.452079886,
        M_AY: -1.066108422,
        M_AZ: 0.006699887,
        M_SPEED_RATE: 1.652079886,
        M_GY: -2.647219035,
        M_GZ: 11.322306065,
        M_WHEEL: 18.422195755,
    }
    worst = max(abs(m[place] - value) for place, value in printed.items())
    record("largest difference to 7.2, first embodiment", worst, "< 1e-6")
    assert worst < 1e-6


@pytest.mark.acceptance("B-7")
def test_characteristic_equation(record: Callable[..., None]) -> None:
    m = document()
    record("Q_x", m[M_BALANCE], "477.971072 +- 1e-4 N m")
    assert m[M_BALANCE] == pytest.approx(477.971072, abs=1e-4)
    assert m[[M_WX, M_WY, M_WZ]] == pytest.approx([-0.0315, 0.081, 0.0015], abs=1e-9)
    assert m[[M_QX, M_QY, M_QZ]] == pytest.approx([21.22, 21.92, -16.82], abs=1e-9)
    assert m[[M_FX, M_FY, M_FZ]] == pytest.approx([268.755, -626.436579, 1541.267966], abs=1e-5)
    # offsets of G_y and G_z stay out of it: it is built from modelled forces
    x = at(0.4, 0.05, 18.0)
    x[8:10] = 1.0, 2.0
    told = solved(x, inputs(**RATES, zeta=0.02, dzeta=0.1, G_x=1.2))
    assert told[M_BALANCE] == m[M_BALANCE]
    scale = 1.0 / (230.0 * (0.75 - 0.10))
    for value in (0.0, 30.0):
        bank = AttitudeBank(numbers(), AttitudeBankSettings(form="2A", characteristic_value=value), 0.002)
        zeros = np.zeros(50)
        columns = dict.fromkeys(bank.inputs, zeros) | {f"wheel_speed_{w}": zeros + 50.0 for w in ("rl", "rr")}
        bank.replay(columns)
        assert bank.memory.measured[ROW_ROLL] == pytest.approx(value * scale, rel=1e-12)


@pytest.mark.acceptance("B-8")
def test_wheel_loads(record: Callable[..., None]) -> None:
    m, loads = document(), np.zeros(LOADS)
    wheel_loads(at(0.4, 0.05, 18.0), m, bike(), loads)
    record("load of the front wheel", loads[L_FRONT], "631.561571 N")
    assert loads[[L_FRONT, L_REAR]] == pytest.approx([631.561571, 909.706395], abs=1e-5)
    assert loads[[L_FRONT_Y, L_REAR_Y]] == pytest.approx([-331.960597, -294.475981], abs=1e-5)
    assert loads[L_FRONT] + loads[L_REAR] == pytest.approx(m[M_FZ], rel=1e-12)
    m = solved(at(), inputs())
    wheel_loads(at(), m, bike(), loads)
    weight = 230.0 * G
    assert loads[[L_FRONT, L_REAR]] == pytest.approx([weight * 0.70 / 1.40, weight * 0.70 / 1.40], rel=1e-12)
    assert loads[L_FRONT] == pytest.approx(1127.76475, abs=1e-5)


@pytest.mark.acceptance("B-9")
def test_split_of_the_longitudinal_force() -> None:
    assert longitudinal_share(500.0, 900.0, 1300.0) == 0.0
    assert longitudinal_share(-500.0, 900.0, 1300.0) == pytest.approx(-500.0 * 900.0 / 2200.0, rel=1e-12)
    assert longitudinal_share(-1e-9, 900.0, 1300.0) == pytest.approx(longitudinal_share(1e-9, 900.0, 1300.0), abs=1e-9)


@pytest.mark.acceptance("B-10")
def test_strokes_after_a_step_of_load(record: Callable[..., None]) -> None:
    b, loads, step = bike(), np.zeros(LOADS), 0.001
    weight = 230.0 * G
    loads[L_FRONT], loads[L_REAR] = 0.5 * weight + 200.0, 0.5 * weight - 100.0
    constant = 1500.0 / 18000.0
    for _ in range(round(constant / step)):
        follow_springs(0.0, b, step, 1.0, loads)
    final = 200.0 * np.cos(np.deg2rad(25.0)) / 18000.0
    record("share of the stroke after C_F/k_F", loads[L_STROKE_F] / final, "1 - 1/e = 0.632")
    # C/k is no whole number of steps
    after = 1.0 - np.exp(-round(constant / step) * step / constant)
    assert loads[L_STROKE_F] == pytest.approx(after * final, rel=1e-9)
    for _ in range(2000):
        follow_springs(0.0, b, step, 1.0, loads)
    assert loads[L_STROKE_F] == pytest.approx(final, rel=1e-6)
    # the lever ratio of the shock absorber acts on its force
    assert loads[L_STROKE_R] == pytest.approx(-2.2 * 100.0 * np.cos(np.deg2rad(8.0)) / 90000.0, rel=1e-6)


@pytest.mark.acceptance("B-11")
def test_elevation_angle() -> None:
    b, loads = bike(), np.zeros(LOADS)
    loads[L_FRONT], loads[L_REAR] = 0.5 * 230.0 * G + 200.0, 0.5 * 230.0 * G
    rates = []
    for _ in range(3000):
        before = loads[L_ELEVATION]
        follow_springs(0.0, b, 0.001, 1.0, loads)
        rates.append(loads[L_ELEVATION_RATE])
        assert loads[L_ELEVATION_RATE] == pytest.approx((loads[L_ELEVATION] - before) / 0.001, abs=1e-12)
    caster, stroke = np.deg2rad(25.0), loads[L_STROKE_F]
    expected = np.arctan(stroke * np.cos(caster) / (1.4 - stroke * np.sin(caster)))
    assert loads[L_ELEVATION] == pytest.approx(expected, rel=1e-9)
    assert loads[L_ELEVATION] > 0.0, "positive where the front is compressed"
    assert max(rates) > 0.0
    tilted = dict(numbers()) | {"two_wheeler.static_elevation": 0.03}
    b = two_wheeler(tilted, AttitudeSettings(form="2A"))[0]
    for _ in range(3000):
        follow_springs(0.0, b, 0.001, 1.0, loads)
    assert loads[L_ELEVATION] == pytest.approx(expected + 0.03, rel=1e-6)


@pytest.mark.acceptance("B-12")
def test_slope(record: Callable[..., None]) -> None:
    slope = float(np.rad2deg(road_slope(0.05, 0.4, 0.02)))
    record("slope", slope, "1.809254596 degrees")
    assert slope == pytest.approx(1.809254596, abs=1e-8)
    assert road_slope(0.05, 0.0, 0.0) == pytest.approx(0.05), "downhill is positive"


@pytest.mark.acceptance("B-13")
def test_aerodynamic_force(record: Callable[..., None]) -> None:
    without, with_drag = document(), document(aerodynamic_force=True)
    drag = 0.5 * 1.2 * 0.4 * 18.0**2
    record("change of F_x", with_drag[M_FX] - without[M_FX], f"{drag:.2f} N")
    assert with_drag[M_FX] - without[M_FX] == pytest.approx(drag, rel=1e-12)
    assert with_drag[M_BALANCE] == without[M_BALANCE], "it acts at the mass centre, along x"


@cache
def _cross(a: tuple[complex, ...], b: tuple[complex, ...]) -> np.ndarray:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return _cross(tuple(a), tuple(b))


def by_vectors(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f and h of the second embodiment by cross products, for complex numbers too."""
    theta, phi, v, b_ro, b_ya, b_pi, b_x, b_y, b_z = (x[k] for k in (0, 1, 2, 4, 5, 6, 7, 8, 9))
    w, dw = u[:3] - np.array([b_ro, b_pi, b_ya]), u[3:6] + 0.0 * x[:3]
    s, c, zeta, dzeta = np.sin(phi), np.cos(phi), u[8], u[9]
    roll = w[0] + (w[1] * s + w[2] * c) * np.tan(theta)
    pitch = w[1] * c - w[2] * s
    rise = dw[0] + (dw[1] * s + dw[2] * c) * np.tan(theta)
    rise = rise + pitch * roll * np.tan(theta) + (w[1] * s + w[2] * c) * pitch / np.cos(theta) ** 2
    arm = np.array([0.65, 0.09 * s, 0.75 - 0.09 * (1.0 - c)])
    moved = roll * np.array([0.0, 0.09 * c, -0.09 * s])
    bent = rise * np.array([0.0, 0.09 * c, -0.09 * s]) + roll**2 * np.array([0.0, -0.09 * s, -0.09 * c])
    up = G * np.array([-np.sin(theta), np.cos(theta) * s, np.cos(theta) * c])
    relative = bent + 2.0 * cross(w, moved) + cross(dw, arm) + cross(w, cross(w, arm))
    contact = v * np.array([1.0, 0.0, np.tan(zeta)])
    carried = cross(w, contact) + np.array([0.0, 0.0, v * dzeta / np.cos(zeta) ** 2])
    dv = u[6] - b_x - (carried + relative + up)[0]
    felt = dv * np.array([1.0, 0.0, np.tan(zeta)]) + carried + relative + up
    inertia = np.array([[22.0, 0.0, 3.0], [0.0, 50.0, 0.0], [3.0, 0.0, 38.0]])
    off = np.array([0.05, 0.0, -0.10])
    road = 230.0 * (felt + cross(dw, off) + cross(w, cross(w, off)))
    spin = inertia @ dw + cross(w, inertia @ w)
    place = np.array([0.0, -0.09 * s, 0.09 * (1.0 - c) - 0.75 + 0.10])
    balance = spin[0] - cross(place, road)[0]
    wheel = v / np.cos(zeta) / (1.0 - 0.09 / 0.31 * (1.0 - c))
    h = np.array([felt[1] + b_y, felt[2] + b_z, wheel, balance / (230.0 * 0.65)])
    return np.array([pitch, roll, dv]), h


@pytest.mark.acceptance("B-24")
@pytest.mark.parametrize("form", [name for name in FORMS if name.startswith("2")])
def test_jacobians_against_complex_steps(form: str, record: Callable[..., None]) -> None:
    bank = AttitudeBank(numbers(), AttitudeBankSettings(form=form), 0.01)  # type: ignore[arg-type]
    a, rows, car, _, _ = bank._bound
    random = np.random.default_rng(5)
    worst = 0.0
    for _ in range(20):
        x = np.array([0.1, 0.6, 1.0, 0.0, 0.03, 0.03, 0.03, 1.0, 1.0, 1.0]) * random.uniform(-1.0, 1.0, 10)
        x[SPEED] += 17.0
        u = np.array([1.0, 0.5, 0.5, 3.0, 2.0, 2.0, 3.0, 0.0, 0.05, 0.2, 0.0]) * random.uniform(-1.0, 1.0, 11)
        system_slopes(x, u, rows[0], car[0], False, a.entries, a.steps, a.rates, a.slopes_f)
        arguments = (a.entries, a.steps, a.mechanics, a.outputs, a.slopes_h)
        observation_slopes(x, u, rows[0], car[0], False, *arguments)
        f, h = by_vectors(x, u)
        assert a.rates[0, :3] == pytest.approx(f, abs=1e-10)
        assert a.outputs[0, [ROW_Y, ROW_Z, ROW_SPEED, ROW_ROLL]] == pytest.approx(h, abs=1e-9)
        for column, entry in enumerate(a.entries):
            moved = x.astype(complex)
            moved[entry] += 1e-30j
            f, h = by_vectors(moved, u)
            slopes = np.imag(np.concatenate([f, h])) / 1e-30
            found = np.concatenate([a.slopes_f[column, :3], a.slopes_h[column, [ROW_Y, ROW_Z, ROW_SPEED, ROW_ROLL]]])
            worst = max(worst, float(np.abs(found - slopes).max()))
    record("largest error of a derivative", worst, "< 1e-5")
    assert worst < 1e-5


@pytest.mark.acceptance("B-24")
@pytest.mark.parametrize("form", ["1A", "2A", "2C", "car_y"])
def test_innovation_covariance_and_gain(form: str) -> None:
    """The rows one after the other give what S = R + H P H' and the gain P H' S^-1 give at once."""
    numbers_of = load_vehicle("ekf_car").numbers() if form == "car_y" else numbers()
    bank = AttitudeBank(numbers_of, AttitudeBankSettings(form=form), 0.01)  # type: ignore[arg-type]
    a, rows, car, _, _ = bank._bound
    random = np.random.default_rng(7)
    k, m = len(a.entries), len(a.rows)
    half = random.normal(0.0, 0.05, (k, k))
    before = half @ half.T + 1e-4 * np.eye(k)
    x = at(0.2, 0.03 if THETA in a.entries else 0.0, 15.0)
    a.inputs[0, :7] = 0.1, 0.05, 0.2, 0.3, 0.1, 0.2, 0.5
    a.measured[:] = 2.0, 9.7, 15.2, 0.1, 0.05, 0.0
    covariance, moved = before.copy(), x.copy()
    squared = correct_filter(moved, covariance, a, rows[0], car[0])
    design = a.slopes_h[:, a.rows].T
    residual = a.measured[a.rows] - a.outputs[0, a.rows]
    s = np.diag(a.noise) + design @ before @ design.T
    gain = before @ design.T @ np.linalg.inv(s)
    assert squared == pytest.approx(residual @ np.linalg.solve(s, residual), rel=1e-9)
    assert a.status[LOG_VOLUME] == pytest.approx(np.linalg.slogdet(s)[1], rel=1e-9)
    assert moved[a.entries] - x[a.entries] == pytest.approx(gain @ residual, rel=1e-7, abs=1e-10)
    left = np.eye(k) - gain @ design
    assert covariance == pytest.approx(left @ before @ left.T + gain @ np.diag(a.noise) @ gain.T, abs=1e-10)
    assert m == len(residual)
    assert a.tuning[CAR] == (form == "car_y")


def test_reference_ride_obeys_its_own_mechanics() -> None:
    """Differentiated places give the specific force of the rigid body; 7.2 found 7e-5 m/s^2 on its ride."""
    flat = random_ride(motorcycle(), 3, seconds=30.0)
    error = np.abs(flat.model_force - flat.specific_force)[100:-100]
    assert error.max() < 1e-4
    sloped = random_ride(motorcycle(), 3, seconds=30.0, sloped=True)
    error = np.abs(sloped.model_force - sloped.specific_force)[100:-100]
    assert np.sqrt(np.mean(error**2)) < 2e-4, "springs and pitch are iterated, not solved together"
    # weight is carried on average
    assert flat.loads.sum(axis=1).mean() == pytest.approx(230.0 * G / np.mean(np.cos(flat.roll_angle)), rel=0.03)


def test_a_car_file_without_two_wheeler_is_refused() -> None:
    from signals.errors import InputError

    with pytest.raises(InputError, match=r"two_wheeler\.sensor_to_rear_axle"):
        AttitudeBank(load_vehicle("ekf_car").numbers(), AttitudeBankSettings(form="2A"))
    assert attitude_car(load_vehicle("ekf_car").numbers(), AttitudeSettings()).shape == (1,)
