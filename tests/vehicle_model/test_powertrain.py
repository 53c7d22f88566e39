"""Engine, clutch, gearbox and axles against torque and power balances."""

import numpy as np
import pytest
from numpy.typing import NDArray

from signals.errors import InputError
from vehicle_model.powertrain import Powertrain
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

RATIO_1, RATIO_3, RATIO_5 = 3.6 * 3.2, 1.45 * 3.2, 0.9 * 3.2
EFFICIENCY = 0.93


def car(**changes: float) -> VehicleFile:
    vehicle = load_vehicle("ekf_car")
    for path, value in changes.items():
        set_parameter(vehicle, "driveline." + path.replace("__", "."), value)
    return vehicle


class Bench:
    """A powertrain whose wheels turn as told."""

    def __init__(self, vehicle: VehicleFile) -> None:
        self.powertrain = Powertrain(vehicle)
        self.wheel_speed = np.zeros(4)
        self.out = np.zeros(6)

    def run(self, ticks: int, accelerator: float, clutch: float, gear: float, wheel_speed: float = 0.0) -> None:
        self.wheel_speed[:] = wheel_speed
        for _ in range(ticks):
            self.powertrain.tick(accelerator, clutch, gear, self.wheel_speed, self.out)

    @property
    def engine_speed(self) -> float:
        return float(self.out[0])

    @property
    def engine_torque(self) -> float:
        return float(self.out[1])

    @property
    def drive(self) -> NDArray[np.float64]:
        return self.out[2:]


def test_idles() -> None:
    bench = Bench(car())
    bench.run(5000, 0.0, 0.0, 0.0)
    assert bench.engine_speed == pytest.approx(84.0, rel=0.01)
    assert bench.drive.tolist() == [0.0] * 4


def test_full_load_torque_reaches_the_wheels_through_ratio_and_efficiency() -> None:
    bench = Bench(car())
    bench.run(3000, 1.0, 1.0, 3.0, wheel_speed=60.0)
    speed = RATIO_3 * 60.0
    curve = np.interp(speed, np.array([0, 1000, 2000, 4500, 6000, 6500]) * np.pi / 30, [150, 200, 280, 320, 290, 250])
    assert bench.engine_speed == pytest.approx(speed, rel=1e-9)
    assert bench.engine_torque == pytest.approx(curve, rel=1e-6)
    assert bench.drive == pytest.approx([0.0, 0.0] + 2 * [curve * RATIO_3 * EFFICIENCY / 2], rel=1e-6)
    # power: what the clutch takes from the engine less the losses of the gears
    power = bench.engine_torque * bench.engine_speed
    assert float(bench.drive @ bench.wheel_speed) == pytest.approx(EFFICIENCY * power, rel=1e-6)


def test_engine_drag() -> None:
    bench = Bench(car())
    bench.run(3000, 0.0, 1.0, 5.0, wheel_speed=100.0)
    drag = bench.powertrain.get("driveline.engine.drag_torque")
    assert bench.engine_torque == pytest.approx(-drag)
    # the wheels feed the losses of the gears too
    assert bench.drive.sum() == pytest.approx(-drag * RATIO_5 / EFFICIENCY, rel=1e-6)


def test_part_load_is_between_drag_and_full_load() -> None:
    torques = []
    for accelerator in (0.0, 0.5, 1.0):
        bench = Bench(car())
        bench.run(3000, accelerator, 1.0, 3.0, wheel_speed=60.0)
        torques.append(bench.engine_torque)
    assert torques[1] == pytest.approx(0.5 * (torques[0] + torques[2]), rel=1e-6)


def test_limiter() -> None:
    bench = Bench(car())
    highest = 0.0
    for _ in range(4000):
        bench.run(1, 1.0, 0.0, 0.0)
        highest = max(highest, bench.engine_speed)
    assert 660.0 < bench.engine_speed <= highest < 682.0  # 680 rad/s


def test_slipping_clutch_limits_the_torque() -> None:
    bench = Bench(car())
    bench.run(600, 1.0, 0.0, 1.0)
    assert bench.engine_speed > 300.0
    bench.run(30, 1.0, 0.25, 1.0)
    assert bench.drive.sum() == pytest.approx(0.25 * 600.0 * RATIO_1 * EFFICIENCY)
    # the engine gives less than the clutch takes, so that it slows down
    before = bench.engine_speed
    bench.run(30, 0.0, 0.25, 1.0)
    assert bench.engine_speed < before
    bench.run(1, 1.0, 0.0, 1.0)
    assert bench.drive.tolist() == [0.0] * 4


def test_clutch_locks_and_couples_the_speeds() -> None:
    bench = Bench(car())
    bench.run(100, 0.0, 0.0, 1.0)
    # in first gear engine and shaft swing at 3.4 Hz with a damping ratio of 0.07 until they turn together
    bench.run(8000, 0.2, 1.0, 1.0, wheel_speed=20.0)
    assert bench.engine_speed == pytest.approx(20.0 * RATIO_1, rel=1e-4)


def test_starts_with_the_engine_turning_with_the_wheels() -> None:
    bench = Bench(car())
    bench.run(1, 0.0, 1.0, 3.0, wheel_speed=70.0)
    assert bench.engine_speed == pytest.approx(70.0 * RATIO_3, rel=1e-3)
    assert abs(bench.drive.sum()) < 50.0


@pytest.mark.parametrize(("drive", "share"), [("front", 1.0), ("rear", 0.0), ("all", 0.4)])
def test_driven_axles_share_the_torque(drive: str, share: float) -> None:
    vehicle = car()
    vehicle.driveline.drive = drive  # type: ignore[assignment]
    bench = Bench(vehicle)
    bench.run(3000, 1.0, 1.0, 3.0, wheel_speed=60.0)
    total = bench.drive.sum()
    assert bench.drive == pytest.approx(total * np.array([share, share, 1 - share, 1 - share]) / 2)


def test_open_differential_gives_both_wheels_the_same_torque() -> None:
    bench = Bench(car())
    bench.wheel_speed[:] = [50.0, 50.0, 20.0, 80.0]
    for _ in range(3000):
        bench.powertrain.tick(1.0, 1.0, 3.0, bench.wheel_speed, bench.out)
    assert bench.drive[2] == bench.drive[3] > 100.0
    assert bench.engine_speed == pytest.approx(RATIO_3 * 50.0, rel=1e-6)


def test_light_engine_on_a_stiff_shaft_is_stable() -> None:
    bench = Bench(car(engine__inertia=0.001, shaft_stiffness=1e6, shaft_damping=1e3, engine__time_constant=0.001))
    bench.run(2000, 0.0, 1.0, 5.0, wheel_speed=100.0)
    torque = bench.drive.sum()
    bench.run(1, 0.0, 1.0, 5.0, wheel_speed=100.0)
    assert bench.drive.sum() == pytest.approx(torque, rel=1e-6)
    assert bench.engine_speed == pytest.approx(RATIO_5 * 100.0, rel=1e-3)


def test_a_wheel_on_the_shaft_settles() -> None:
    # both wheels of the axle in the air: one free inertia of 1.6 kg m^2 behind the shaft, integrated tick by tick
    bench = Bench(car())
    omega, speeds = 20.0, []
    for tick in range(3000):
        bench.run(1, 0.05 if tick < 1000 else 0.0, 1.0, 3.0, wheel_speed=omega)
        omega += 1e-3 * bench.drive.sum() / 1.6
        speeds.append(bench.engine_speed / RATIO_3 - omega)
    assert np.abs(speeds[-500:]).max() < 0.05


def test_parameters_by_name() -> None:
    powertrain = Powertrain(car())
    assert {"driveline.engine.inertia", "driveline.gear_ratios.0", "driveline.engine.torque_points.2"} <= set(
        powertrain.names()
    )
    powertrain.set("driveline.engine.drag_torque", 20.0)
    bench = Bench(car())
    bench.powertrain.set("driveline.engine.drag_torque", 20.0)
    bench.run(3000, 0.0, 1.0, 5.0, wheel_speed=100.0)
    assert bench.engine_torque == pytest.approx(-20.0)
    with pytest.raises(InputError, match="clutch_torque"):
        powertrain.set("driveline.clutch_torqe", 100.0)
    with pytest.raises(InputError):
        powertrain.set("driveline.efficiency", 2.0)


def test_too_many_gears() -> None:
    vehicle = car()
    vehicle.driveline.gear_ratios = [5.0 - 0.2 * k for k in range(13)]
    with pytest.raises(InputError, match="gear_ratios"):
        Powertrain(vehicle)
