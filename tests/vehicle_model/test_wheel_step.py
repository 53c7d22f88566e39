"""Spin and contact of one wheel: exact lock, relaxation, bristles, stability at any step."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from vehicle_model.plant_record import PARAMETER_RECORD, STATE_RECORD, Record
from vehicle_model.road import RoadTables
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres.coefficients import TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PREPARED_SIZE, STIFFNESS_X, STIFFNESS_Y, along, prepare
from vehicle_model.vehicle_file import load_tyres
from vehicle_model.wheel_step import spin_wheel

LOAD, RADIUS, INERTIA = 3000.0, 0.3, 1.0
STEP = 1e-3


class Wheel:
    """A wheel in the air but for its tyre: the hub's velocity is given."""

    def __init__(self, substeps: int = 5, **changes: float) -> None:
        self.p: Record = np.zeros(1, PARAMETER_RECORD)[0]
        self.s: Record = np.zeros(1, STATE_RECORD)[0]
        defaults = {
            "radius": RADIUS,
            "spin_inertia": INERTIA,
            "contact_stiffness_x": 3e5,
            "contact_stiffness_y": 2e5,
            "contact_damping": 8e3,
            "contact_full_below": 0.5,
            "contact_none_above": 1.0,
        }
        self.p["substeps"] = substeps
        for name, value in (defaults | changes).items():
            self.p[name][0] = value
        self.s["load"][0] = LOAD
        self.row: NDArray[np.float64] = np.zeros(TYRE_SIZE)
        row = self.row
        self.tyre: NDArray[np.float64] = np.zeros(PREPARED_SIZE)
        write_tyre(load_tyres("reduced_unit_peak").front, row, right=False)
        prepare(row, RoadTables(RoadFile()).surfaces[0], 1.0, LOAD, 20.0, 0.0, self.tyre)
        self.omega = 0.0

    def turn(self, v_x: float, v_y: float = 0.0, brake: float = 0.0, drive: float = 0.0) -> None:
        self.omega = spin_wheel(self.p, self.s, 0, self.row, self.tyre, self.omega, brake, drive, v_x, v_y, STEP)


def test_the_brake_holds_up_to_its_capacity_and_not_beyond() -> None:
    wheel = Wheel()
    held = 0.5 * 3000.0  # N m of drive torque
    for _ in range(50):
        wheel.turn(0.0, brake=1.001 * held, drive=held)
        assert wheel.omega == 0.0
        assert wheel.s["brake_torque"][0] == pytest.approx(held)
    wheel.turn(0.0, brake=0.99 * held, drive=held)
    assert wheel.omega > 0.0


def test_a_wheel_locks_at_exactly_zero_and_never_turns_back() -> None:
    wheel = Wheel()
    wheel.omega = 20.0 / RADIUS
    speeds = []
    for _ in range(300):
        wheel.turn(20.0, brake=3000.0)
        speeds.append(wheel.omega)
    assert min(speeds) == 0.0
    assert speeds[-1] == 0.0
    assert wheel.s["force_x"][0] == pytest.approx(-LOAD * math.sin(1.316 * math.atan(14.34)))


def test_a_freed_wheel_spins_up_to_rolling() -> None:
    wheel = Wheel()
    for _ in range(500):
        wheel.turn(20.0)
    assert RADIUS * wheel.omega == pytest.approx(20.0, rel=1e-6)


@pytest.mark.parametrize("speed", [0.0, 0.01, 0.4, 0.6, 0.8, 1.2, 3.0, 60.0])
@pytest.mark.parametrize("substeps", [1, 5, 20])
def test_spin_is_stable_at_any_speed(speed: float, substeps: int) -> None:
    wheel = Wheel(substeps)
    wheel.omega = 1.2 * speed / RADIUS + 0.5
    history = []
    for _ in range(2000):
        wheel.turn(speed, brake=100.0)
        history.append(wheel.omega)
    tail = np.array(history[-200:])
    assert np.ptp(tail) < 1e-6
    assert np.isfinite(wheel.s["force_x"][0])


@pytest.mark.parametrize("travel", [1.0, -1.0], ids=["forwards", "backwards"])
@pytest.mark.parametrize("direction", ["x", "y"])
def test_relaxation_delays_the_slip_by_its_length(direction: str, travel: float) -> None:
    """Constant slip from rest: the force follows 1 - exp(-distance / relaxation length) while the curve is linear."""
    length, speed, slip = 0.4, 10.0, 1e-4
    wheel = Wheel(20, spin_inertia=1e12, relaxation_x=length, relaxation_y=length)
    wheel.omega = travel * speed * (1.0 + (slip if direction == "x" else 0.0)) / RADIUS
    v_y = -slip * speed if direction == "y" else 0.0
    # a wheel that turns faster than it travels is pushed the way it travels; the side force opposes v_y both ways
    stiffness = travel * wheel.tyre[STIFFNESS_X] if direction == "x" else wheel.tyre[STIFFNESS_Y]
    for tick in range(100):
        wheel.turn(travel * speed, v_y)
        distance = speed * (tick + 0.5) * STEP  # the force is the mean over the tick
        expected = stiffness * slip * (1.0 - math.exp(-distance / length))
        assert wheel.s[f"force_{direction}"][0] == pytest.approx(expected, rel=5e-2 if tick < 10 else 1e-2)


def test_bristles_agree_with_the_curve_in_slow_rolling() -> None:
    """Below the speed where bristles take over, steady rolling gives the linear curve's force."""
    slip = 0.005
    wheel = Wheel(spin_inertia=1e12, contact_damping=0.0)
    wheel.omega = 0.4 / RADIUS / (1.0 - slip)  # rolling is the faster: slip S5
    for _ in range(3000):
        wheel.turn(0.4)
    assert wheel.s["force_x"][0] == pytest.approx(wheel.tyre[STIFFNESS_X] * slip, rel=2e-2)


def test_a_dragged_locked_wheel_gives_the_sliding_force_almost_down_to_a_stop() -> None:
    """In the last quarter of a metre per second the contact's damper relaxes while its spring winds up."""
    wheel = Wheel()
    sliding = along(wheel.row, wheel.tyre, -1.0, 0.0)[0]
    speed = 1.5
    while speed > 0.005:
        wheel.turn(speed, brake=5000.0)
        tolerance = 1e-4 if speed > 1.0 else (2e-2 if speed > 0.25 else 0.4)
        assert wheel.s["force_x"][0] == pytest.approx(sliding, rel=tolerance)
        speed -= 0.01


def test_the_contact_spring_holds_a_static_force() -> None:
    wheel = Wheel()
    for _ in range(20):
        wheel.turn(0.001, brake=5000.0)
    for _ in range(100):
        wheel.turn(0.0, brake=5000.0)
    stretched = 20 * STEP * 0.001
    assert wheel.s["force_x"][0] == pytest.approx(-3e5 * stretched, rel=1e-6)
    before = wheel.s["force_x"][0]
    for _ in range(5000):
        wheel.turn(0.0, brake=5000.0)
    assert wheel.s["force_x"][0] == pytest.approx(before, rel=1e-9)


def test_a_lifted_wheel_has_no_force() -> None:
    wheel = Wheel()
    wheel.s["load"][0] = 0.0
    row = np.zeros(TYRE_SIZE)
    write_tyre(load_tyres("reduced_unit_peak").front, row, right=False)
    prepare(row, RoadTables(RoadFile()).surfaces[0], 1.0, 0.0, 20.0, 0.0, wheel.tyre)
    for speed in (20.0, 0.3, 0.0):
        wheel.turn(speed, 0.1, brake=100.0)
        assert wheel.s["force_x"][0] == pytest.approx(0.0, abs=1e-9)
        assert wheel.s["force_y"][0] == pytest.approx(0.0, abs=1e-9)
