"""Faults of valves, pump, circuits, fluid and accumulators against their closed forms."""

import numpy as np
import pytest

from hydraulics import PARAMETERS, HydraulicUnit
from hydraulics.fluid import ATMOSPHERE_PA, POLYTROPIC_EXPONENT, kinematic_viscosity, stiffness_share, viscosity_ratio
from hydraulics.record import PARAMETER_RECORD, fill_record
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import load_vehicle, parameter_table

BAR = 1e5
STEP_S = 0.001
STIFFNESS_FRONT, STIFFNESS_REAR = 7e12, 1.6e13
TAU_S = 0.05  # friction document 2.6.4 [DEF]
LEAK = 1e-13  # 1 cm^3/s at 100 bar
BRAKES = {
    f"brakes.{axle}.{name}": value
    for axle, area in (("front", 1.425e-3), ("rear", 0.7125e-3))
    for name, value in (("pad_area", area), ("pad_friction", 0.38), ("effective_radius", 0.12))
}
OPEN, HELD, RELEASED = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)


def run(
    unit: HydraulicUnit, master_bar: float, valves: tuple[float, float], seconds: float, pump: float = 1.0
) -> np.ndarray:
    """Output after a time, pressures in bar."""
    out = np.zeros(18)
    for _ in range(round(seconds / STEP_S)):
        unit.tick(master_bar * BAR, np.full(4, valves[0]), np.full(4, valves[1]), pump, out)
    out[1:5] /= BAR
    return out


def with_fault(**faults: float) -> HydraulicUnit:
    return HydraulicUnit(BRAKES | {f"hydraulics.{name}": value for name, value in faults.items()})


def test_vehicle_file_and_unit_declare_the_same_parameters() -> None:
    table = {info.path: info for info in parameter_table(load_vehicle("ekf_car"))}
    for parameter in PARAMETERS:
        info = table[parameter.path]
        assert (info.unit, info.low, info.high) == (parameter.unit, parameter.low, parameter.high), parameter.path
        if parameter.default is not None and info.default is not None:
            assert info.default == parameter.default, parameter.path


def test_neutral_values_leave_every_pressure_and_torque_bit_for_bit() -> None:
    table = {info.path: info.neutral for info in parameter_table(load_vehicle("ekf_car")) if info.neutral is not None}
    neutral = {p.path: table[p.path] for p in PARAMETERS if p.path in table}
    assert len(neutral) > 60
    generator = np.random.default_rng(3)
    plain, explicit = HydraulicUnit(BRAKES), HydraulicUnit(BRAKES)
    for path, value in neutral.items():
        explicit.set(path, value)
    first, second = np.zeros(18), np.zeros(18)
    for n in range(3000):
        valves = generator.integers(0, 2, (2, 4)).astype(float)
        speed = generator.uniform(0.0, 90.0, 4)
        for unit, out in ((plain, first), (explicit, second)):
            unit.tick(120 * BAR * min(n / 300, 1.0), valves[0], valves[1], float(n % 700 > 300), out, speed)
        assert np.array_equal(first, second)
    # eq. 78: 2 A µ R p, exactly
    assert first[10] == plain._parameters[0]["torque_per_pressure"][0] * first[1]


def test_inlet_leak_builds_pressure_behind_a_closed_valve() -> None:
    out = run(with_fault(inlet_leak_fl=LEAK, inlet_leak_rl=LEAK), 100.0, HELD, 0.5)
    # dp/dt = k G (p_line - p)
    assert out[1] == pytest.approx(100.0 * (1.0 - np.exp(-STIFFNESS_FRONT * LEAK * 0.5)), rel=1e-3)
    assert out[3] == pytest.approx(100.0 * (1.0 - np.exp(-STIFFNESS_REAR * LEAK * 0.5)), rel=1e-3)
    assert out[2] == out[4] == 0.0


def test_outlet_leak_lets_held_pressure_sink_into_the_accumulator() -> None:
    unit = with_fault(outlet_leak_fr=LEAK)
    before = run(unit, 80.0, OPEN, 1.0, pump=0.0)
    out = run(unit, 80.0, HELD, 1.0, pump=0.0)
    assert out[2] < before[2] - 20.0
    assert out[1] == pytest.approx(before[1], abs=0.1)
    # while the outlet is closed and the supply constant, what left the caliper is in the second circuit's accumulator;
    # some more leaked during the build-up, which the open inlet valve replaced
    held = (before[2] - out[2]) * BAR / STIFFNESS_FRONT
    assert unit.accumulator_volume_m3[1] == pytest.approx(held + LEAK * 80 * BAR * 1.0, rel=0.1)
    assert unit.accumulator_volume_m3[0] == 0.0


def test_leaking_wheel_brake_ends_where_inflow_meets_the_leak() -> None:
    out = run(with_fault(brake_leak_fl=10 * LEAK), 100.0, OPEN, 2.0)
    # (p_line - p)/τ = k G p
    assert out[1] == pytest.approx(100.0 / (1.0 + STIFFNESS_FRONT * 10 * LEAK * TAU_S), rel=1e-2)
    assert out[2] == pytest.approx(100.0, abs=0.01)


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_valve_conductance_divides_the_time_constants(share: float) -> None:
    unit = with_fault(inlet_conductance_fl=share, outlet_conductance_rl=share)
    out = run(unit, 100.0, OPEN, 0.05)
    assert out[1] == pytest.approx(100.0 * (1.0 - np.exp(-0.05 * share / TAU_S)), rel=1e-9)
    assert out[2] == pytest.approx(100.0 * (1.0 - np.exp(-0.05 / TAU_S)), rel=1e-9)
    run(unit, 100.0, OPEN, 2.0)
    out = run(unit, 100.0, RELEASED, 0.02)
    assert out[3] == pytest.approx(100.0 * np.exp(-0.02 * share / 0.03), rel=1e-6)  # τ_DECREASE 30 ms
    assert out[4] == pytest.approx(100.0 * np.exp(-0.02 / 0.03), rel=1e-6)


def test_conductance_changed_while_pressure_builds_makes_no_jump() -> None:
    unit = with_fault()
    before = run(unit, 100.0, OPEN, 0.03)[1]
    unit.set("hydraulics.inlet_conductance_fl", 0.1)
    after = run(unit, 100.0, OPEN, 0.001)[1]
    assert 0.0 < after - before == pytest.approx((100.0 - before) * (1.0 - np.exp(-0.001 * 0.1 / TAU_S)), rel=1e-6)


@pytest.mark.acceptance("F-8")
@pytest.mark.parametrize(("rate", "flow"), [(1.0, 6e-6), (0.4, 2.4e-6), (0.0, 0.0)])
def test_weak_pump_takes_less_out_of_the_accumulators(rate: float, flow: float) -> None:
    unit = with_fault(pump_rate=rate)
    run(unit, 60.0, OPEN, 0.5, pump=0.0)
    run(unit, 60.0, RELEASED, 0.5, pump=0.0)
    run(unit, 60.0, HELD, 0.1)
    assert unit.pumped_volume_m3 == pytest.approx([flow * 0.1] * 2, rel=1e-9)  # 6 cm^3/s per circuit


@pytest.mark.parametrize(
    ("split", "failed", "without"),
    [
        (0.0, "first", ("fl", "rr")),
        (0.0, "second", ("fr", "rl")),
        (1.0, "first", ("fl", "fr")),
        (1.0, "second", ("rl", "rr")),
    ],
)
def test_failed_circuit_has_no_pressure(split: float, failed: str, without: tuple[str, str]) -> None:
    unit = with_fault(circuit_split=split)
    run(unit, 100.0, OPEN, 1.0)
    unit.set(f"hydraulics.{failed}_circuit_failure", 1.0)
    out = run(unit, 100.0, OPEN, 0.5)
    for wheel, pressure in zip(WHEELS, out[1:5], strict=True):
        assert pressure == pytest.approx(0.0 if wheel in without else 100.0, abs=0.01)


def test_air_takes_up_the_volume_of_a_compressed_gas() -> None:
    air = 2e-6
    unit, plain = with_fault(air_volume_fl=air), with_fault()
    volume, pressure = 0.0, 0.0
    for _ in range(400):
        volume += (80 * BAR - pressure) * (1.0 - np.exp(-STEP_S / TAU_S)) / STIFFNESS_FRONT  # what the valve lets in
        pressure = run(unit, 80.0, OPEN, STEP_S)[1] * BAR
    gas = air * (1.0 - (ATMOSPHERE_PA / (ATMOSPHERE_PA + pressure)) ** (1.0 / POLYTROPIC_EXPONENT))
    assert volume == pytest.approx(pressure / STIFFNESS_FRONT + gas, rel=0.02)
    # slow start of the build-up: the gas is soft below 10 bar
    assert run(with_fault(air_volume_fl=air), 80.0, OPEN, 0.02)[1] < 0.3 * run(plain, 80.0, OPEN, 0.02)[1]


def test_air_below_the_atmosphere_is_as_soft_as_at_it() -> None:
    """A pressure sensor's offset of more than an atmosphere left no number: dp/dV = 1/(1/k + V_a/(n p_0)) at most."""
    softest = 1.0 / (1.0 + STIFFNESS_FRONT * 2e-6 / (POLYTROPIC_EXPONENT * ATMOSPHERE_PA))
    numbers = np.zeros(1, PARAMETER_RECORD)
    given = {one.path: one.default for one in PARAMETERS if one.default is not None}
    fill_record(given | BRAKES | {"hydraulics.air_volume_fl": 2e-6}, numbers)
    for pressure in (0.0, -0.5 * ATMOSPHERE_PA, -1.2 * ATMOSPHERE_PA):
        assert stiffness_share(numbers[0], 0, pressure) == pytest.approx(softest)


def test_viscosity_follows_walther_between_the_limits_of_fmvss_116() -> None:
    assert kinematic_viscosity(-40.0) == pytest.approx(1300.0, rel=1e-9)
    assert kinematic_viscosity(100.0) == pytest.approx(2.1, rel=1e-9)
    assert viscosity_ratio(20.0) == 1.0
    assert 10.0 < kinematic_viscosity(20.0) < 25.0  # data sheets of DOT 4 fluids: about 15 mm^2/s
    assert all(np.diff([kinematic_viscosity(t) for t in range(-40, 150, 5)]) < 0.0)


def test_cold_fluid_slows_build_up_and_release() -> None:
    factor = 1.0 + 0.1 * (viscosity_ratio(-20.0) - 1.0)
    assert factor > 1.5
    out = run(with_fault(fluid_temperature=-20.0), 100.0, OPEN, 0.05)
    assert out[1] == pytest.approx(100.0 * (1.0 - np.exp(-0.05 / (TAU_S * factor))), rel=1e-9)


def test_blocked_accumulator_takes_no_fluid_so_that_nothing_is_released() -> None:
    unit = with_fault(second_accumulator_blocked=1.0)
    run(unit, 100.0, OPEN, 1.0)
    out = run(unit, 100.0, RELEASED, 0.3)
    assert out[2] == out[3] == pytest.approx(100.0, abs=0.01)
    assert max(out[1], out[4]) < 1.0


def test_first_order_brake_has_the_same_faults() -> None:
    unit = HydraulicUnit(
        BRAKES | {"hydraulics.first_circuit_failure": 1.0, "hydraulics.inlet_conductance_fr": 0.5}, brake="first_order"
    )
    out = run(unit, 100.0, OPEN, 0.025)
    assert out[1] == out[4] == 0.0
    # eq. 79, τ_b 20 ms and t_D 5 ms: the step arrives within the sixth millisecond
    assert out[2] == pytest.approx(100.0 * (1.0 - np.exp(-0.0195 * 0.5 / 0.02)), rel=0.02)
    assert out[3] == pytest.approx(100.0 * (1.0 - np.exp(-0.0195 / 0.02)), rel=0.02)
