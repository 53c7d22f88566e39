"""Speed of the plant: 20 s of driving with a hard stop, one call per tick from Python, best of five.

    python -m benchmarks.plant_speed [--vehicle ekf_car] [--ticks 20000] [--tyres tmeasy lugre …]

First the plant alone with the vehicle's own tyres, then the car with everything on: Magic Formula 6.1 with relaxation
lengths, damper curves, adaptive dampers, stops, guided wheels, lift, side force, hydraulic unit with moving valves, and
all sensors. Prints microseconds per tick and the real-time factor on one core, by the clock and by the processor time
of the thread, which a busy machine disturbs less, and the load of the machine. With ``--tyres`` the plant alone on each
of these tyres instead.

The goals come from a machine on which MuJoCo's own step of such a car, without any tyre, took 3.6 us. That step is
timed here too, right before and after: what the goals are on this machine at this hour follows from it.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import mujoco
import numpy as np

from bench.loop.quiet_tick import Car
from hydraulics import HydraulicUnit
from signals.catalogue import block_slice
from signals.vector import SignalVector
from vehicle_model.mjcf import build_model
from vehicle_model.plant import Plant
from vehicle_model.rigid_bodies import rigid_bodies
from vehicle_model.sensors import Sensors
from vehicle_model.vehicle_file import VehicleFile, load_tyres, load_vehicle

GOAL = 140.0
FULL_GOAL = 120.0  # with everything on
STEP_OF_THE_GOALS_US = 3.6  # MuJoCo's own step of a car of 16 degrees of freedom where the goals were set
REPEATS = 5

TYRE = """[UNITS]
LENGTH = 'meter'
FORCE = 'newton'
ANGLE = 'radian'
MASS = 'kg'
TIME = 'second'
[MODEL]
FITTYP = 61
TYRESIDE = 'LEFT'
LONGVL = 16.7
[DIMENSION]
UNLOADED_RADIUS = 0.3
[OPERATING_CONDITIONS]
INFLPRES = 2.3e5
NOMPRES = 2.2e5
[VERTICAL]
FNOMIN = 3500
[COEFFICIENTS]
"""
# no tyre's, of usual size: every term is at work
COEFFICIENTS = (
    "PCX1=1.58 PDX1=1.1 PDX2=-0.1 PDX3=0.1 PEX1=0.1 PEX2=0.1 PEX3=-0.05 PEX4=0.01 PKX1=22 PKX2=-0.5 PKX3=0.2 "
    "PHX1=2e-4 PHX2=-2e-4 PVX1=1e-5 PVX2=1e-5 PPX1=-0.3 PPX2=0.1 PPX3=0.05 PPX4=0.05 RBX1=13 RBX2=10 RBX3=2 RCX1=1.05 "
    "REX1=0.2 REX2=-0.1 RHX1=1e-3 PCY1=1.33 PDY1=1 PDY2=-0.1 PDY3=0.5 PEY1=-0.8 PEY2=-0.6 PEY3=0.1 PEY4=-2 PEY5=1 "
    "PKY1=-16 PKY2=1.7 PKY3=0.4 PKY4=2 PKY5=1 PKY6=-0.9 PKY7=-0.2 PHY1=1e-3 PHY2=1e-4 PVY1=1e-3 PVY2=-1e-3 PVY3=-0.1 "
    "PVY4=-0.1 PPY1=-0.6 PPY2=-0.1 PPY3=-0.1 PPY4=0.1 PPY5=0.1 RBY1=10 RBY2=8 RBY3=0.01 RBY4=1 RCY1=1.05 REY1=0.2 "
    "REY2=0.1 RHY1=1e-3 RHY2=1e-3 RVY1=0.02 RVY2=-0.01 RVY3=-0.2 RVY4=10 RVY5=1.9 RVY6=-10 QBZ1=10 QBZ2=-2 QBZ3=-0.5 "
    "QBZ4=0.1 QBZ5=-0.3 QBZ9=15 QBZ10=0.1 QCZ1=1.1 QDZ1=0.1 QDZ2=-0.01 QDZ3=-0.1 QDZ4=0.5 QDZ6=1e-3 QDZ7=1e-3 "
    "QDZ8=-0.1 QDZ9=0.05 QDZ10=0.1 QDZ11=-0.1 QEZ1=-2 QEZ2=1 QEZ3=-0.5 QEZ4=0.2 QEZ5=-1 QHZ1=1e-3 QHZ2=1e-3 QHZ3=0.1 "
    "QHZ4=0.1 PPZ1=-0.5 PPZ2=0.1 SSZ1=0.01 SSZ2=0.01 SSZ3=0.1 SSZ4=-0.1 PTX1=1.9 PTX2=1e-3 PTX3=0.3 PTY1=2 PTY2=2 "
    "QSX1=1e-3 QSX2=0.5 QSX3=0.03 QSY1=0.01 QSY2=0"
)


SUSPENSION = (
    "{damper_speeds: [-1, -0.3, -0.05, 0, 0.05, 0.3, 1], damper_forces: [-1700, -900, -350, 0, 200, 550, 1100], "
    "damping_scale: 0.9, bump_stop_clearance: 0.03, bump_stop_rate: 60000, bump_stop_progression: 1e6, "
    "rebound_stop_clearance: 0.05, rebound_stop_rate: 60000, roll_centre_height: 0.06, brake_support_angle: 0.12, "
    "drive_support_angle: 0.05, camber: -0.01, camber_gain: -0.5}"
)
Run = Callable[[int], None]


def with_everything_on(vehicle: str, folder: Path) -> VehicleFile:
    """The car on tyres of the Magic Formula 6.1 with every part of suspension and air forces at work."""
    (folder / "tyre.tir").write_text(TYRE + COEFFICIENTS.replace(" ", "\n").replace("=", " = ") + "\n")
    tyre = "{tir: tyre.tir, relaxation_length_longitudinal: 0.15, relaxation_length_lateral: 0.4}"
    (folder / "car.yaml").write_text(
        f"format: 1\nname: full\nextends: {vehicle}\ntyres: {{front: {tyre}, rear: {tyre}}}\n"
        f"suspension: {{front: {SUSPENSION}, rear: {SUSPENSION}, adaptive: {{mode: 1}}}}\n"
        "steering: {ackermann: 0.5}\n"
        "aerodynamics: {lift_coefficient_front: 0.05, lift_coefficient_rear: 0.1, side_force_coefficient: 2}\n"
    )
    return load_vehicle(folder / "car.yaml")


def plant_run(vehicle: VehicleFile) -> Run:
    """A run of the plant alone: cruise, brake to standstill, stand."""
    car, brake, drive = Plant(vehicle), np.zeros(4), np.zeros(4)

    def run(ticks: int) -> None:
        brake[:] = 0.0
        car.reset(speed_m_s=40.0)
        for tick in range(ticks):
            if tick == ticks // 4:
                brake[:] = 650.0
            car.tick(brake, drive, 0.02, tick * 1e-3)

    return run


def on_tyres(vehicle: str, tyres: str) -> VehicleFile:
    """The car on other tyres."""
    car = load_vehicle(vehicle)
    object.__setattr__(car, "tyres", load_tyres(tyres))
    return car


def full_run(vehicle: VehicleFile) -> Run:
    """The same with hydraulic unit, whose valves move as under an ABS, and all sensors."""
    vector, bus = SignalVector(), block_slice("bus")
    plant, unit, sensors = Plant(vehicle), HydraulicUnit(vehicle.numbers()), Sensors(vehicle, 1)
    plant.bind(vector.block("plant"))
    car = Car(vector, np.zeros(bus.stop - bus.start), unit, plant, sensors)
    values, index = vector.values, vector.index
    inlet, outlet = (values[index(name) : index(name) + 4] for name in ("valve_inlet_fl", "valve_outlet_fl"))
    values[index("driver_steering_wheel_angle")], values[index("pump")] = 0.02, 1.0
    master_pressure, time_place = index("driver_master_pressure"), index("time")

    def run(ticks: int) -> None:
        plant.reset(speed_m_s=40.0)
        unit.reset()
        sensors.reset()
        for tick in range(ticks):
            values[time_place] = tick * 1e-3
            if tick % 50 == 0:  # build up, hold, release
                inlet[:] = tick % 150 != 0
                outlet[:] = tick % 150 == 100
                values[master_pressure] = 6e6 if tick > ticks // 4 else 0.0
            car.tick(tick * 1e-3)

    return run


def best_times(run: Run, ticks: int) -> tuple[float, float]:
    """Best of ``REPEATS`` runs by the clock and by the thread's processor time [s]; compiling does not count."""
    run(100)
    elapsed, used = [], []
    for _ in range(REPEATS):
        began, began_used = time.perf_counter(), time.thread_time()
        run(ticks)
        elapsed.append(time.perf_counter() - began)
        used.append(time.thread_time() - began_used)
    return min(elapsed), min(used)


def mujoco_step_us(vehicle: VehicleFile, ticks: int) -> float:
    """Best time of MuJoCo's own step of the car's bodies, falling free: no tyre, no force of the bench [us]."""
    numbers = vehicle.numbers()
    model = build_model(rigid_bodies(numbers, numbers), 1e-3)
    data, elapsed = mujoco.MjData(model), []
    for _ in range(REPEATS):
        mujoco.mj_resetData(model, data)
        began = time.perf_counter()
        mujoco.mj_step(model, data, ticks)
        elapsed.append(time.perf_counter() - began)
    return min(elapsed) / ticks * 1e6


def best_time(vehicle: str, ticks: int) -> float:
    """Best time of the plant alone by the clock [s]."""
    return best_times(plant_run(load_vehicle(vehicle)), ticks)[0]


def main() -> None:
    """Run the benchmark and print its figures."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    arguments.add_argument("--vehicle", default="ekf_car")
    arguments.add_argument("--ticks", type=int, default=20000)
    arguments.add_argument("--tyres", nargs="+", default=[], metavar="NAME", help="tyre files or shipped tyres")
    options = arguments.parse_args()
    vehicle = load_vehicle(options.vehicle)
    if options.tyres:
        cases = tuple((name, plant_run(on_tyres(options.vehicle, name)), GOAL) for name in options.tyres)
        report(cases, options.ticks)
        return
    steps = [mujoco_step_us(vehicle, options.ticks)]
    with tempfile.TemporaryDirectory() as folder:
        full = with_everything_on(options.vehicle, Path(folder))
        cases = (
            ("plant alone", plant_run(vehicle), GOAL),
            ("with Magic Formula 6.1 and all of the suspension", plant_run(full), FULL_GOAL),
            ("with hydraulics and sensors too", full_run(full), FULL_GOAL),
        )
    report(cases, options.ticks)
    steps.append(mujoco_step_us(vehicle, options.ticks))
    share = STEP_OF_THE_GOALS_US / min(steps)
    print(
        f"MuJoCo's own step of the car: {steps[0]:.2f} us before, {steps[1]:.2f} us after; {STEP_OF_THE_GOALS_US} us "
        f"where the goals were set: here they are {GOAL * share:.0f} x alone, {FULL_GOAL * share:.0f} x with all"
    )


def report(cases: Sequence[tuple[str, Run, float]], ticks: int) -> None:
    """Run and print each case: name, run, goal."""
    for name, run, goal in cases:
        elapsed, used = best_times(run, ticks)
        simulated = ticks * 1e-3
        print(
            f"{name}: {elapsed / ticks * 1e6:.2f} us per tick, {simulated / elapsed:.0f} x real time "
            f"(by processor time {simulated / used:.0f} x; goal {goal:.0f})"
        )
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")


if __name__ == "__main__":
    main()
