"""Wheel brakes: heat, fade, glazed pads, pistons that stick, drag and uneven discs."""

import numpy as np
import pytest

from hydraulics import HydraulicUnit

BAR = 1e5
STEP_S = 0.001
TORQUE_PER_BAR = 2 * 1.425e-3 * 0.38 * 0.12 * BAR  # eq. 78, front wheel
BRAKES = {
    f"brakes.{axle}.{name}": value
    for axle, area in (("front", 1.425e-3), ("rear", 0.7125e-3))
    for name, value in (("pad_area", area), ("pad_friction", 0.38), ("effective_radius", 0.12))
}
NO_COOLING = {"brakes.front.disc_cooling": 0.0, "brakes.front.disc_cooling_per_speed": 0.0}


class Bench:
    """A unit with open valves, its wheels turning at a constant speed."""

    def __init__(self, parameters: dict[str, float] | None = None) -> None:
        self.unit = HydraulicUnit(BRAKES | (parameters or {}))
        self.out = np.zeros(18)

    def run(self, master_bar: float, speed_rad_s: float, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.unit.tick(master_bar * BAR, np.zeros(4), np.zeros(4), 0.0, self.out, np.full(4, speed_rad_s))

    @property
    def pressure_bar(self) -> float:
        return float(self.out[1] / BAR)

    @property
    def torque(self) -> float:
        return float(self.out[10])

    @property
    def temperature(self) -> float:
        return float(self.out[14])


def test_disc_takes_its_share_of_the_brake_work_as_heat() -> None:
    bench, work = Bench(NO_COOLING), 0.0
    for _ in range(4000):
        bench.run(60.0, 80.0, STEP_S)
        work += bench.torque * 80.0 * STEP_S
    # first law: C ΔT = 0.9 W, capacity 4 kJ/K
    assert bench.temperature - 20.0 == pytest.approx(0.9 * work / 4000.0, rel=1e-9)
    assert bench.temperature > 60.0
    before = bench.temperature
    bench.run(60.0, 0.0, 1.0)  # locked: no heat
    assert bench.temperature == before


def test_disc_cools_with_the_time_constant_of_its_capacity_and_cooling() -> None:
    bench = Bench({"brakes.front.disc_start_temperature": 500.0})
    bench.run(0.0, 60.0, 20.0)
    # C/(h_0 + h_1 ω) = 4000/(8 + 0.5 60) s, towards 20 °C
    assert bench.temperature == pytest.approx(20.0 + 480.0 * np.exp(-20.0 * 38.0 / 4000.0), rel=1e-4)


@pytest.mark.parametrize(
    ("temperature", "share"), [(20.0, 1.0), (300.0, 1.0), (400.0, 0.8), (650.0, 0.3), (900.0, 0.2)]
)
def test_fade_curve_holds_falls_and_ends_at_its_floor(temperature: float, share: float) -> None:
    bench = Bench({"brakes.front.fade": 2e-3, "brakes.front.disc_start_temperature": temperature})
    bench.run(50.0, 0.0, 0.5)
    cooled = bench.temperature  # half a second at rest
    expected = np.clip(1.0 - 2e-3 * max(cooled - 300.0, 0.0), 0.2, 1.0)
    assert bench.torque == pytest.approx(expected * TORQUE_PER_BAR * bench.pressure_bar, rel=1e-5)
    assert expected == pytest.approx(share, abs=2e-3)


def test_torque_fades_within_a_series_of_stops() -> None:
    bench = Bench({"brakes.front.fade": 2e-3})
    torques = []
    for _ in range(8):
        bench.run(80.0, 90.0, 3.0)
        torques.append(bench.torque)
        bench.run(0.0, 90.0, 5.0)
    assert torques[0] > torques[-1]
    assert torques[-1] / torques[0] < 0.9
    assert bench.temperature > 300.0


def test_glazed_pad_loses_its_share_on_its_wheel_only() -> None:
    bench = Bench({"brakes.pad_glazing_fl": 0.4})
    bench.run(50.0, 50.0, 0.5)
    assert bench.torque == pytest.approx(0.6 * TORQUE_PER_BAR * bench.pressure_bar, rel=1e-12)
    assert bench.out[11] == pytest.approx(TORQUE_PER_BAR * bench.out[2] / BAR, rel=1e-12)


def test_sticking_piston_lags_pressure_and_keeps_some_after_release() -> None:
    bench = Bench({"brakes.piston_friction_fl": 4 * BAR})
    bench.run(60.0, 0.0, 1.0)
    assert bench.torque == pytest.approx(TORQUE_PER_BAR * (bench.pressure_bar - 4.0), rel=1e-9)
    bench.run(0.0, 0.0, 1.0)
    assert bench.torque == pytest.approx(TORQUE_PER_BAR * 4.0, rel=1e-6)


def test_piston_that_seizes_while_braking_holds_its_torque_for_good() -> None:
    bench = Bench()
    bench.run(60.0, 0.0, 1.0)
    held = bench.torque
    bench.unit.set("brakes.piston_friction_fl", 500 * BAR)
    bench.run(0.0, 0.0, 1.0)
    assert bench.torque == held
    seized_before = Bench({"brakes.piston_friction_fl": 500 * BAR})
    seized_before.run(100.0, 0.0, 1.0)
    assert seized_before.torque == 0.0


def test_drag_torque_needs_no_pressure() -> None:
    bench = Bench({"brakes.drag_torque_fl": 30.0})
    bench.run(0.0, 50.0, 0.1)
    assert bench.torque == 30.0
    assert bench.temperature > 20.0


def test_uneven_disc_modulates_the_torque_once_per_turn() -> None:
    bench, speed = Bench({"brakes.thickness_variation_fl": 0.1}), 2 * np.pi * 10.0
    bench.run(50.0, speed, 1.0)
    torques = []
    for _ in range(1000):
        bench.run(50.0, speed, STEP_S)
        torques.append(bench.torque)
    spectrum = np.abs(np.fft.rfft(torques)) / 500.0
    assert spectrum[10] == pytest.approx(0.1 * np.mean(torques), rel=1e-3)  # 10 turns in the second
    assert np.argmax(spectrum[1:]) == 9


def test_pad_exponents_and_threshold() -> None:
    # 10 m/s and 30 bar are the points that the exponents turn about
    bench = Bench({"brakes.front.pad_speed_exponent": -0.2, "brakes.front.pad_pressure_exponent": 0.9})
    bench.run(60.0, 5.0 / 0.12, 1.0)
    expected = TORQUE_PER_BAR * 30.0 * (bench.pressure_bar / 30.0) ** 0.9 * 0.5**-0.2
    assert bench.torque == pytest.approx(expected, rel=1e-9)
    lifted = Bench({"brakes.front.threshold_pressure": 2 * BAR})
    lifted.run(50.0, 0.0, 1.0)
    assert lifted.torque == pytest.approx(TORQUE_PER_BAR * (lifted.pressure_bar - 2.0), rel=1e-9)


def test_a_calipers_lag_is_of_first_order() -> None:
    """Release from 60 bar: the pressure of the brake alone against the torque that lags by 50 ms."""
    slow, quick = Bench({"brakes.caliper_time_constant": 0.05}), Bench()
    for bench in (slow, quick):
        bench.run(60.0, 0.0, 2.0)
    assert slow.torque == pytest.approx(quick.torque, rel=1e-6)
    torque = slow.torque
    for _ in range(100):
        for bench in (slow, quick):
            bench.run(0.0, 0.0, STEP_S)
        # implicit Euler of tau dT/dt + T = k p
        torque = (0.05 * torque + STEP_S * quick.torque) / (0.05 + STEP_S)
        assert slow.torque == pytest.approx(torque, rel=1e-9)
