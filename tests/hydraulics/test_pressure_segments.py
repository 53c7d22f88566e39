"""Properties of friction document 2.6.4, each with its number, and the event forms of 2.6.3."""

from typing import Any

import numpy as np
import pytest

from hydraulics import HydraulicUnit

BAR = 1e5
STEP_S = 0.001
BRAKES = {
    f"brakes.{axle}.{name}": value
    for axle, area in (("front", 1.425e-3), ("rear", 0.7125e-3))
    for name, value in (("pad_area", area), ("pad_friction", 0.38), ("effective_radius", 0.12))
}
OPEN, CLOSED = 0.0, 1.0
INCREASE, HOLD, DECREASE = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)


class Rig:
    """Unit under test with the outputs of all four wheels driven alike."""

    def __init__(self, **options: Any) -> None:
        parameters = options.pop("parameters", {})
        self.unit = HydraulicUnit({**BRAKES, **parameters}, **options)
        self.out = np.zeros(18)

    def step(self, master_bar: float, valves: tuple[float, float], pump: float = 1.0, steps: int = 1) -> float:
        inlet, outlet = np.full(4, valves[0]), np.full(4, valves[1])
        for _ in range(steps):
            self.unit.tick(master_bar * BAR, inlet, outlet, pump, self.out)
        return self.pressure_bar

    @property
    def pressure_bar(self) -> float:
        return float(self.out[1]) / BAR


@pytest.mark.acceptance("F-8", "F-A20")
def test_increase_is_the_exponential_of_eq_106() -> None:
    rig = Rig()
    for n in range(1, 200):
        pressure = rig.step(100.0, INCREASE)
        assert pressure == pytest.approx(100.0 - 100.0 * np.exp(-n * STEP_S / 0.05), abs=1e-9)


def test_decrease_with_running_pump_approaches_zero_with_its_own_time_constant() -> None:
    rig = Rig(parameters={"hydraulics.accumulator_volume": 1e-4})
    start = rig.step(100.0, INCREASE, steps=400)
    for n in range(1, 100):
        assert rig.step(100.0, DECREASE) == pytest.approx(start * np.exp(-n * STEP_S / 0.03), rel=1e-9)


@pytest.mark.acceptance("F-8", "F-A20")
def test_hold_stays_within_one_step_of_the_preceding_segment() -> None:
    rig = Rig()
    entry = rig.step(100.0, INCREASE, steps=30)
    one_step = (100.0 - entry) * (1.0 - np.exp(-STEP_S / 0.05))
    for _ in range(500):
        assert 0.0 <= rig.step(100.0, HOLD) - entry <= one_step + 1e-9


@pytest.mark.acceptance("F-8", "F-A20")
@pytest.mark.parametrize("following", [INCREASE, HOLD, DECREASE])
@pytest.mark.parametrize("preceding", [INCREASE, DECREASE])
def test_pressure_at_an_event_moves_by_one_step_of_the_new_exponential(
    preceding: tuple[float, float], following: tuple[float, float]
) -> None:
    rig = Rig()
    rig.step(120.0, INCREASE, steps=40)
    before = rig.step(120.0, preceding, steps=10)
    after = rig.step(120.0, following)
    if following == HOLD:
        largest = max(120.0 - before, before) * (1.0 - np.exp(-STEP_S / 0.03))
        assert abs(after - before) <= largest
    else:
        target, time_constant = (120.0, 0.05) if following == INCREASE else (0.0, 0.03)
        if following != preceding:
            assert after == pytest.approx(target - (target - before) * np.exp(-STEP_S / time_constant), abs=1e-9)


@pytest.mark.acceptance("F-9", "F-A20")
def test_driver_ramp_of_400_bar_per_second_lags_by_threshold_and_time_constant() -> None:
    rig = Rig()
    rate_bar_s, largest = 400.0, 0.0
    for n in range(400):
        master = rate_bar_s * n * STEP_S
        largest = max(largest, master - rig.step(master, INCREASE))
    assert largest <= 1.0 + rate_bar_s * 0.05
    assert largest > 0.9 * rate_bar_s * 0.05  # and it is no shortcut: a first-order lag of a ramp is r tau


def test_slow_ramp_below_the_threshold_per_step_is_followed_too() -> None:
    rig = Rig()
    largest = 0.0
    for n in range(3000):
        master = 10.0 * n * STEP_S
        largest = max(largest, master - rig.step(master, INCREASE))
    assert largest <= 1.0 + 10.0 * 0.05


def test_rearming_near_the_target_narrows_the_lag_of_a_slow_ramp() -> None:
    def worst(rearm: float) -> float:
        rig = Rig(parameters={"hydraulics.rearm_near_target": rearm})
        return max(5.0 * n * STEP_S - rig.step(5.0 * n * STEP_S, INCREASE) for n in range(3000))

    assert worst(0.0) > 1.0
    assert worst(1.0) < 0.3  # r tau = 0.25 bar


@pytest.mark.acceptance("F-9")
def test_literal_and_form_of_the_event_cannot_hold() -> None:
    rig = Rig(parameters={"hydraulics.literal_event": 1.0})
    entry = rig.step(100.0, INCREASE, steps=30)
    assert 40.0 < entry < 50.0
    assert rig.step(100.0, HOLD, steps=200) > 95.0  # the running segment goes on to the master pressure

    correct = Rig()
    correct.step(100.0, INCREASE, steps=30)
    assert correct.step(100.0, HOLD, steps=200) < 50.0


@pytest.mark.acceptance("F-9")
def test_literal_and_form_does_not_follow_a_ramp() -> None:
    rig = Rig(parameters={"hydraulics.literal_event": 1.0})
    for n in range(300):
        rig.step(0.4 * n, INCREASE)
    assert rig.pressure_bar < 1.0


@pytest.mark.parametrize("valves", [INCREASE, HOLD, DECREASE])
def test_pressure_never_exceeds_the_drivers(valves: tuple[float, float]) -> None:
    rig = Rig()
    rig.step(100.0, INCREASE, steps=300)
    assert rig.step(20.0, valves) <= 20.0
    assert rig.step(0.0, valves) == 0.0


def test_pressure_that_flowed_back_does_not_return_through_a_closed_inlet_valve() -> None:
    rig = Rig()
    rig.step(100.0, INCREASE, steps=300)
    rig.step(20.0, HOLD, steps=5)
    assert rig.step(100.0, HOLD, steps=100) == pytest.approx(20.0)


def test_changing_a_time_constant_on_line_makes_no_jump() -> None:
    rig = Rig()
    before = rig.step(100.0, INCREASE, steps=30)
    rig.unit.set("hydraulics.increase_time_constant", 0.5)
    after = rig.step(100.0, INCREASE)
    assert after == pytest.approx(100.0 - (100.0 - before) * np.exp(-STEP_S / 0.5), abs=1e-9)


@pytest.mark.acceptance("F-A20", "F-40")
def test_same_inputs_give_the_same_bits() -> None:
    def trace() -> bytes:
        generator = np.random.default_rng(5)
        rig, rows = Rig(), []
        for _ in range(3000):
            inlet = (generator.random(4) > 0.5).astype(float)
            outlet = inlet * (generator.random(4) > 0.5)
            rig.unit.tick(150e5 * generator.random(), inlet, outlet, float(generator.random() > 0.5), rig.out)
            rows.append(rig.out.copy())
        return np.array(rows).tobytes()

    assert trace() == trace()


@pytest.mark.acceptance("F-8", "F-A20")
def test_wheels_are_independent() -> None:
    unit, out = HydraulicUnit(BRAKES), np.zeros(18)
    inlet, outlet = np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 0.0])
    for _ in range(40):
        unit.tick(100 * BAR, np.zeros(4), np.zeros(4), 1.0, out)
    before = out[1:5].copy()
    for _ in range(20):
        unit.tick(100 * BAR, inlet, outlet, 1.0, out)
    assert out[1] == out[4] > before[0]
    assert out[2] == pytest.approx(before[1], rel=0.02)
    assert out[3] < 0.6 * before[2]
    assert list(out[5:9]) == [0.0, 1.0, 2.0, 0.0]
