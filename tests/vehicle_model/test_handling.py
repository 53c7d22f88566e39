"""Cornering of the MuJoCo car against the closed forms of the linear single track, in the limit where those hold."""

import math

import numpy as np
import pytest
from plant_cases import GRAVITY, without_losses
from scipy.linalg import expm

from signals.wheels import WHEELS
from vehicle_model.plant import Plant

MASS, WHEELBASE, TO_FRONT, HEIGHT, TRACK = 1296.0, 2.57, 1.25, 0.535, 1.46  # Table 8
TO_REAR = WHEELBASE - TO_FRONT
RATIO = 16.0
FRONT, REAR = "tyres.front.lateral.stiffness", "tyres.rear.lateral.stiffness"


def limit_car(changes: dict[str, float] | None = None) -> Plant:
    """Light wheels, hard springs and tyres, hard steering, no trail: the single track's assumptions."""
    limit = {
        f"wheels.{wheel}.{name}": value
        for wheel in WHEELS
        for name, value in (("vertical_stiffness", 3e6), ("inertia", 0.1), ("unsprung_mass", 10.0))
    }
    for axle in ("front", "rear"):
        limit |= {
            f"suspension.{axle}.spring_rate": 4e5,
            f"suspension.{axle}.anti_roll_rate": 4e5,
            f"suspension.{axle}.compression_damping": 6e3,
            f"suspension.{axle}.rebound_damping": 6e3,
            f"tyres.{axle}.pneumatic_trail": 0.0,
        }
    limit |= {"steering.stiffness": 2e5, "steering.damping": 20.0}
    return Plant(without_losses(limit | (changes or {})), steps_per_tick=2)


def axle_stiffness(car: Plant) -> tuple[float, float]:
    """Cornering stiffness of the axles [N/rad]: slope B C D of the curve times the axle's load."""
    result = []
    for axle, arm in (("front", TO_REAR), ("rear", TO_FRONT)):
        curve = [car.get(f"tyres.{axle}.lateral.{name}") for name in ("stiffness", "shape", "peak_friction")]
        result.append(math.prod(curve) * MASS * GRAVITY * arm / WHEELBASE)
    return result[0], result[1]


def understeer_gradient(car: Plant) -> float:
    """m / L (b / C_f - a / C_r) [rad s^2/m] (Mitschke, Wallentowitz, Dynamik der Kraftfahrzeuge; friction doc. 2.7)."""
    front, rear = axle_stiffness(car)
    return MASS / WHEELBASE * (TO_REAR / front - TO_FRONT / rear)


@pytest.mark.parametrize("softer", [FRONT, REAR, ""], ids=["understeering", "oversteering", "neutral"])
def test_understeer_gradient_and_steady_state_cornering(softer: str) -> None:
    """Yaw gain v / (L + K v^2) at three speeds, and the side-slip angle b / R - m a v^2 / (L C_r R)."""
    car = limit_car()
    if softer:
        car.set(softer, 0.7 * car.get(softer))
    gradient, (_, rear) = understeer_gradient(car), axle_stiffness(car)
    if softer:
        assert (gradient > 0.0) == (softer == FRONT)
    needed = []
    for speed in (10.0, 15.0, 20.0):
        car.reset(speed_m_s=speed)
        angle = 0.3 / speed**2 * WHEELBASE  # about 0.3 m/s^2
        car.step(4000, steer=RATIO * angle)
        state = car.state()
        v, yaw_rate = state["speed"], state["true_yaw_rate"]
        assert yaw_rate / angle == pytest.approx(v / (WHEELBASE + gradient * v * v), rel=1e-2)
        side_slip = (TO_REAR - MASS * TO_FRONT * v * v / (WHEELBASE * rear)) * yaw_rate / v
        assert state["side_slip_angle"] == pytest.approx(side_slip, abs=1e-2 * abs(TO_REAR * yaw_rate / v))
        needed.append((angle * v / yaw_rate - WHEELBASE) / v**2)
    # the gradient itself, from the angle that each bend needs beyond L / R
    scale = max(abs(gradient), 2e-4 * WHEELBASE)
    np.testing.assert_allclose(np.array(needed), gradient, rtol=0.0, atol=1e-2 * scale)


def test_soft_steering_adds_its_compliance_to_the_understeer_gradient() -> None:
    """The side force acts t behind the wheel's centre and turns the wheel back by F_y t / c."""
    trail, stiffness = 0.03, 8e3
    car = limit_car({"tyres.front.pneumatic_trail": trail, "tyres.rear.pneumatic_trail": 0.0})
    car.set("steering.stiffness", stiffness)
    speed = 20.0
    car.reset(speed_m_s=speed)
    angle = 0.3 / speed**2 * WHEELBASE
    car.step(4000, steer=RATIO * angle)
    state = car.state()
    v = state["speed"]
    (front, rear), base = axle_stiffness(car), WHEELBASE - trail
    slip_front = TO_REAR / base * (1.0 / front + trail / (2.0 * stiffness))
    gradient = MASS * (slip_front - (TO_FRONT - trail) / base / rear)
    assert state["true_yaw_rate"] / angle == pytest.approx(v / (WHEELBASE + gradient * v * v), rel=1e-2)


@pytest.mark.parametrize("ratio", [12.0, 20.0])
def test_steering_ratio(ratio: float) -> None:
    car = limit_car()
    car.set("steering.ratio", ratio)
    car.reset(speed_m_s=15.0)
    car.step(1500, steer=0.06)
    assert car.state()["true_road_wheel_angle_fl"] == pytest.approx(0.06 / ratio, rel=1e-3)


def test_step_steer_follows_the_linear_single_track() -> None:
    """Yaw rate and lateral speed over 1.5 s within 1 % of their largest values of the exact solution."""
    # a low centre of gravity: the body's point does not sway with its roll
    car = limit_car({"body.yaw_inertia": 2200.0, "body.centre_of_gravity_height": 0.3})
    front, rear = axle_stiffness(car)
    speed, angle, rise = 20.0, 0.002, 0.05
    car.reset(speed_m_s=speed)
    couple = TO_FRONT * front - TO_REAR * rear
    turn = TO_FRONT**2 * front + TO_REAR**2 * rear
    generator = np.zeros((3, 3))
    generator[:2, :2] = [
        [-(front + rear) / (MASS * speed), -couple / (MASS * speed) - speed],
        [-couple / (2200.0 * speed), -turn / (2200.0 * speed)],
    ]
    generator[:2, 2] = front / MASS * angle, TO_FRONT * front / 2200.0 * angle
    step, x = expm(generator * 1e-3), np.zeros(3)
    own, exact = [], []
    for tick in range(1500):
        share = min((tick + 0.5) * 1e-3 / rise, 1.0)
        car.step(1, steer=RATIO * angle * share)
        x = step @ (x[0], x[1], share)
        own.append([car.state()["lateral_speed"], car.state()["true_yaw_rate"]])
        exact.append(x[:2])
    scale = np.abs(np.array(exact)).max(axis=0)
    error = np.abs(np.array(own) - np.array(exact)).max(axis=0) / scale
    assert np.all(error < 1e-2), error


def test_load_transfer_of_braking_in_the_limit() -> None:
    """m a h / L, light wheels and hard springs: 1 %."""
    car = limit_car()
    car.reset(speed_m_s=25.0)
    before = car.state()
    car.step(1500, brake_torque=[600.0, 600.0, 300.0, 300.0])
    state = car.state()
    expected = -MASS * state["true_longitudinal_acceleration"] * HEIGHT / WHEELBASE
    assert expected > 1000.0
    for first, side in (("f", 1.0), ("r", -1.0)):
        moved = sum(state[f"vertical_load_{first}{k}"] - before[f"vertical_load_{first}{k}"] for k in "lr")
        assert side * moved == pytest.approx(expected, rel=1e-2)


def test_lateral_load_transfer_splits_as_the_roll_stiffness_and_the_roll_centres() -> None:
    """Per axle (M_i + G_i) / track: springs share by their stiffness what the guides leave (Reimpell, 5.4).

    The tyres carry both parts, the springs their own: roll = M_i / K_spring,i + (M_i + G_i) / K_tyre on both axles.
    """
    heights = {"front": 0.05, "rear": 0.15}
    car = limit_car({f"suspension.{axle}.roll_centre_height": height for axle, height in heights.items()})
    car.set("suspension.rear.anti_roll_rate", 1e5)
    car.reset(speed_m_s=20.0)
    car.step(3000, steer=0.1)
    state = car.state()
    tyre, in_series, guided = 0.5 * TRACK**2 * 3e6, {}, {}
    sprung, acceleration = MASS - 4.0 * 10.0, state["true_lateral_acceleration"]
    for axle, arm in (("front", TO_REAR), ("rear", TO_FRONT)):
        rate = car.get(f"suspension.{axle}.spring_rate") + 2.0 * car.get(f"suspension.{axle}.anti_roll_rate")
        in_series[axle] = 1.0 / (1.0 / (0.5 * TRACK**2 * rate) + 1.0 / tyre)
        guided[axle] = sprung * arm / WHEELBASE * acceleration * heights[axle]
    moment = MASS * acceleration * HEIGHT - sum(guided.values())
    roll = (moment + sum(in_series[axle] * guided[axle] / tyre for axle in heights)) / sum(in_series.values())
    for axle, left, right in (("front", "fl", "fr"), ("rear", "rl", "rr")):
        moved = (state[f"vertical_load_{right}"] - state[f"vertical_load_{left}"]) / 2.0
        expected = (in_series[axle] * (roll - guided[axle] / tyre) + guided[axle]) / TRACK
        assert moved == pytest.approx(expected, rel=1e-2)
