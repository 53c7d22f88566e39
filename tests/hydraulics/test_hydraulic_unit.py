"""Selection logic, accumulators, brake torque, eq. 79, faults and parameters of the hydraulic unit."""

from typing import Literal

import numpy as np
import pytest

from hydraulics import PARAMETERS, HydraulicUnit, SelectionLogic, abs_logic
from signals.catalogue import block_slice, names
from signals.errors import InputError

BAR = 1e5
STEP_S = 0.001
BRAKES = {
    f"brakes.{axle}.{name}": value
    for axle, area in (("front", 1.425e-3), ("rear", 0.7125e-3))
    for name, value in (("pad_area", area), ("pad_friction", 0.38), ("effective_radius", 0.12))
}
ZERO, ONE = np.zeros(4), np.ones(4)


def run(unit: HydraulicUnit, master_bar: float, valves: tuple[float, float], pump: float, steps: int) -> np.ndarray:
    out = np.zeros(18)
    for _ in range(steps):
        unit.tick(master_bar * BAR, np.full(4, valves[0]), np.full(4, valves[1]), pump, out)
    return out


def test_output_is_the_block_of_the_catalogue() -> None:
    block = names()[block_slice("hydraulics")]
    assert len(block) == 18
    assert block[14] == "brake_disc_temperature_fl"
    assert block[0] == "true_master_pressure"
    assert block[1] == "true_brake_pressure_fl"
    assert block[5] == "hydraulic_state_fl"
    assert block[9] == "accumulator_pressure"
    assert block[10] == "brake_torque_capacity_fl"


@pytest.mark.acceptance("F-7")
def test_torque_is_eq_78_and_13_newton_metres_per_bar_in_front() -> None:
    out = run(HydraulicUnit(BRAKES), 100.0, (0.0, 0.0), 0.0, 2000)
    assert out[10] == pytest.approx(2 * 1.425e-3 * 0.38 * 0.12 * out[1])
    assert out[10] == pytest.approx(1300.0, rel=1e-3)  # friction document 2.4.2: 26 N m/bar per front axle
    assert out[12] == pytest.approx(650.0, rel=1e-3)


@pytest.mark.acceptance("F-8")
def test_esp_logic_builds_up_to_the_pump_pressure_with_the_pedal_released() -> None:
    unit = HydraulicUnit({**BRAKES, "hydraulics.pump_pressure": 80 * BAR}, selection_logic="esp")
    assert run(unit, 0.0, (0.0, 0.0), 1.0, 500)[1] == 0.0
    unit.set("hydraulics.active_build_up", 1.0)
    out = np.zeros(18)
    for n in range(1, 300):
        unit.tick(0.0, ZERO, ZERO, 1.0, out)
        assert out[1] / BAR == pytest.approx(80.0 * (1.0 - np.exp(-n * STEP_S / 0.05)), abs=1e-9)
    assert run(unit, 0.0, (1.0, 0.0), 1.0, 300)[1] / BAR == pytest.approx(80.0, abs=0.5)  # held
    assert run(unit, 120.0, (0.0, 0.0), 1.0, 500)[1] / BAR == pytest.approx(120.0, abs=0.1)  # the driver wants more
    unit.set("hydraulics.active_build_up", 0.0)
    assert run(unit, 0.0, (0.0, 0.0), 1.0, 1)[1] == 0.0


def test_abs_logic_has_no_active_build_up() -> None:
    unit = HydraulicUnit({**BRAKES, "hydraulics.active_build_up": 1.0})
    assert run(unit, 0.0, (0.0, 0.0), 1.0, 200)[1] == 0.0


@pytest.mark.acceptance("F-8")
def test_own_logic_can_be_given_as_a_table() -> None:
    table = abs_logic().table.copy()
    table[0, 1] = (2, 2)  # a unit that releases with the outlet alone
    unit = HydraulicUnit(BRAKES, selection_logic=SelectionLogic("own", table))
    run(unit, 100.0, (0.0, 0.0), 1.0, 300)
    assert run(unit, 100.0, (0.0, 1.0), 1.0, 100)[1] < 10 * BAR
    with pytest.raises(ValueError, match="shape"):
        SelectionLogic("bad", np.zeros((2, 2), np.int64))


def test_invalid_combination_is_reported_and_held() -> None:
    unit = HydraulicUnit(BRAKES)
    before = run(unit, 100.0, (0.0, 0.0), 1.0, 30)[1]
    out = run(unit, 100.0, (0.0, 1.0), 1.0, 50)
    assert list(out[5:9]) == [3.0] * 4
    assert list(unit.invalid_steps) == [50] * 4
    assert before <= out[1] <= before + 1.2 * BAR


@pytest.mark.parametrize("brake", ["hcu", "first_order"])
def test_fluid_flows_through_two_open_valves_where_it_may(brake: Literal["hcu", "first_order"]) -> None:
    """dp/dt = (100 bar - p) / tau_in - p / tau_out, solved in closed form; steps of 1 ms are 1 % off."""
    filling, emptying = (0.05, 0.03) if brake == "hcu" else (0.02, 0.02)
    numbers = {"flow_through": 1.0, "accumulator_volume": 1e-4, "pump_flow": 1e-3}
    unit = HydraulicUnit(BRAKES | {f"hydraulics.{name}": value for name, value in numbers.items()}, brake=brake)
    rate, rest = 1.0 / filling + 1.0 / emptying, 100.0 / filling / (1.0 / filling + 1.0 / emptying)
    out = np.zeros(18)
    run(unit, 100.0, (0.0, 0.0), 1.0, 1000)
    for tick in range(1, 100):
        unit.tick(100.0 * BAR, ZERO, ONE, 1.0, out)
        assert out[1] / BAR == pytest.approx(rest + (100.0 - rest) * np.exp(-tick * STEP_S * rate), abs=1.5)
    assert list(unit.invalid_steps) == [99] * 4
    # what comes next goes on from there, and a full accumulator takes no more
    assert run(unit, 100.0, (1.0, 0.0), 1.0, 50)[1] / BAR == pytest.approx(rest, abs=1.5)
    unit.set("hydraulics.pump_failure", 1.0)
    assert run(unit, 100.0, (0.0, 1.0), 1.0, 8000)[1] / BAR == pytest.approx(100.0, abs=0.1)


def test_drop_without_pump_ends_at_the_accumulator_pressure() -> None:
    unit = HydraulicUnit(BRAKES)
    run(unit, 60.0, (0.0, 0.0), 0.0, 1000)
    out = run(unit, 60.0, (1.0, 1.0), 0.0, 1000)
    assert out[1] == pytest.approx(out[9], abs=1 * BAR)  # within the threshold that re-arms a segment
    assert 1 * BAR < out[9] < 5 * BAR


def test_full_accumulator_without_pump_limits_the_drop() -> None:
    unit = HydraulicUnit({**BRAKES, "hydraulics.accumulator_volume": 1e-6})
    run(unit, 100.0, (0.0, 0.0), 0.0, 1000)
    out = run(unit, 100.0, (1.0, 1.0), 0.0, 1000)
    assert unit.accumulator_volume_m3 == pytest.approx([1e-6, 1e-6], rel=1e-12)
    assert out[9] == pytest.approx(5 * BAR)
    # what left the calipers of a circuit is in its accumulator: front 7e12 Pa/m^3, rear 1.6e13 Pa/m^3
    lost = (100 * BAR - out[1]) / 7e12 + (100 * BAR - out[4]) / 1.6e13
    assert lost == pytest.approx(1e-6, rel=1e-6)
    pumped = run(unit, 100.0, (1.0, 1.0), 1.0, 500)
    assert pumped[1] < 0.5 * out[1]


def test_accumulator_volume_is_conserved() -> None:
    generator = np.random.default_rng(11)
    unit, out = HydraulicUnit(BRAKES), np.zeros(18)
    stiffness = np.array([7e12, 7e12, 1.6e13, 1.6e13])
    released = np.zeros(2)
    mode = np.zeros(4)
    for n in range(4000):
        if n % 17 == 0:
            mode = generator.integers(0, 3, 4).astype(float)
        before = unit.wheel_pressure_pa
        pump = float(n % 1000 > 500)
        unit.tick(120 * BAR, (mode > 0).astype(float), (mode > 1).astype(float), pump, out)
        # the master pressure is constant, so a falling pressure can only leave through the outlet valve
        drop = np.where(mode > 1, np.maximum(before - unit.wheel_pressure_pa, 0.0) / stiffness, 0.0)
        released += (drop[0] + drop[3], drop[1] + drop[2])
    assert released.min() > 1e-5
    assert unit.pumped_volume_m3.min() > 1e-6
    assert unit.accumulator_volume_m3 + unit.pumped_volume_m3 == pytest.approx(released, rel=1e-9)


def test_pump_empties_the_accumulator_with_its_flow() -> None:
    unit = HydraulicUnit(BRAKES)
    run(unit, 60.0, (0.0, 0.0), 0.0, 500)
    run(unit, 60.0, (1.0, 1.0), 0.0, 500)
    before = unit.accumulator_volume_m3
    run(unit, 60.0, (1.0, 0.0), 1.0, 100)
    assert before - unit.accumulator_volume_m3 == pytest.approx([6e-7, 6e-7], rel=1e-9)  # 6 cm^3/s for 0.1 s


def analytic_ramp(time_s: float, rate: float, delay_s: float, time_constant_s: float) -> float:
    since = time_s - delay_s
    return rate * (since - time_constant_s * (1.0 - np.exp(-since / time_constant_s))) if since > 0 else 0.0


@pytest.mark.acceptance("F-7")
@pytest.mark.parametrize("delay_s", [0.0, 0.005, 0.0123])
def test_first_order_brake_follows_the_closed_form_of_eq_79(delay_s: float) -> None:
    unit = HydraulicUnit({**BRAKES, "brakes.hydraulic_delay": delay_s}, brake="first_order")
    out = np.zeros(18)
    for n in range(500):
        unit.tick(400 * BAR * n * STEP_S, ZERO, ZERO, 0.0, out)
        expected = analytic_ramp(n * STEP_S, 400 * BAR, delay_s, 0.02)
        # linear interpolation rounds the kink of the ramp's start off within one step
        assert out[1] == pytest.approx(expected, abs=0.01 * BAR if delay_s % STEP_S else 1e-3)


def test_first_order_brake_is_modulated_by_the_valves() -> None:
    unit = HydraulicUnit(BRAKES, brake="first_order")
    top = run(unit, 100.0, (0.0, 0.0), 1.0, 300)[1]
    assert run(unit, 100.0, (1.0, 0.0), 1.0, 100)[1] == top
    released = run(unit, 100.0, (1.0, 1.0), 1.0, 20)[1]
    assert released == pytest.approx(top * np.exp(-0.02 / 0.02), rel=1e-9)
    assert run(unit, 0.0, (1.0, 0.0), 1.0, 300)[1] < 1e-3 * BAR


@pytest.mark.acceptance("F-8")
@pytest.mark.parametrize(
    ("fault", "value", "valves", "state"),
    [
        ("inlet_stuck_fl", 1.0, (1.0, 0.0), 0.0),
        ("inlet_stuck_fl", 2.0, (0.0, 0.0), 1.0),
        ("outlet_stuck_fl", 1.0, (1.0, 0.0), 2.0),
        ("outlet_stuck_fl", 2.0, (1.0, 1.0), 1.0),
    ],
)
def test_stuck_valve_overrules_the_command_of_its_wheel_only(
    fault: str, value: float, valves: tuple[float, float], state: float
) -> None:
    unit = HydraulicUnit(BRAKES)
    healthy = run(unit, 100.0, valves, 1.0, 5)[6]
    unit.set(f"hydraulics.{fault}", value)
    out = run(unit, 100.0, valves, 1.0, 5)
    assert out[5] == state
    assert out[6] == healthy != state


@pytest.mark.acceptance("F-8")
def test_failed_pump_leaves_the_accumulators_full() -> None:
    unit = HydraulicUnit({**BRAKES, "hydraulics.pump_failure": 1.0, "hydraulics.accumulator_volume": 1.5e-6})
    run(unit, 100.0, (0.0, 0.0), 1.0, 500)
    assert run(unit, 100.0, (1.0, 1.0), 1.0, 1000)[9] == pytest.approx(5 * BAR)
    assert unit.pumped_volume_m3 == pytest.approx([0.0, 0.0])


@pytest.mark.acceptance("F-8")
def test_slow_valve_acts_after_its_dead_time() -> None:
    unit, out = HydraulicUnit({**BRAKES, "hydraulics.inlet_delay_fr": 0.02}), np.zeros(18)
    run(unit, 100.0, (0.0, 0.0), 1.0, 50)
    states = []
    for _ in range(30):
        unit.tick(100 * BAR, ONE, ZERO, 1.0, out)
        states.append(out[5:7].copy())
    assert [s[0] for s in states] == [1.0] * 30
    assert [s[1] for s in states] == [0.0] * 20 + [1.0] * 10


def test_parameters_by_dotted_path() -> None:
    unit = HydraulicUnit(BRAKES)
    assert unit.names() == tuple(p.path for p in PARAMETERS)
    assert unit.get("hydraulics.increase_time_constant") == 0.05
    run(unit, 100.0, (0.0, 0.0), 0.0, 500)
    unit.set("brakes.front.pad_friction", 0.19)
    out = run(unit, 100.0, (0.0, 0.0), 0.0, 500)
    assert out[10] == pytest.approx(650.0, rel=1e-3)
    assert out[12] == pytest.approx(650.0, rel=1e-3)


def test_bad_parameters_end_in_one_clear_message() -> None:
    unit = HydraulicUnit(BRAKES)
    with pytest.raises(InputError, match=r"did you mean hydraulics\.increase_time_constant\?"):
        unit.set("hydraulics.increase_time", 1.0)
    with pytest.raises(InputError, match=r"found -1; allowed: 0\.0001 to 2 s"):
        unit.set("hydraulics.hold_time_constant", -1.0)
    with pytest.raises(InputError, match=r"brakes\.front\.pad_area is missing"):
        HydraulicUnit({})
    with pytest.raises(InputError, match="allowed: abs, esp"):
        HydraulicUnit(BRAKES, selection_logic="asr")
    with pytest.raises(InputError, match="allowed: hcu, first_order"):
        HydraulicUnit(BRAKES, brake="none")
