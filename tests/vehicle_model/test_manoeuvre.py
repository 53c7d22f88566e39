"""Manoeuvres: their files, the order of their steps, and the manoeuvre of the friction document's section 4.2."""

from pathlib import Path

import pytest
from drive_bench import Drive, manoeuvre_of

from signals.errors import FileFaults, InputError
from signals.vector import SignalVector
from signals.yaml_files import load_yaml
from vehicle_model.manoeuvre import Manoeuvre
from vehicle_model.manoeuvre_file import ManoeuvreFile
from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import load_vehicle, set_parameter

FRICTION_CAR = Path(__file__).parents[2] / "scenarios" / "common" / "friction_car.yaml"

STOP = """
steps:
  - name: roll
    coast: true
    until: {after: 0.2 s}
  - name: brake
    brake: {pedal_force: 300 N, ramp: 1 kN/s}
    until: {signal: speed, below: 1 km/h}
  - name: stand
    brake: {pedal_force: 100 N}
    until: {after: 0.1 s}
"""


def shipped() -> ManoeuvreFile:
    return ManoeuvreFile.model_validate(load_yaml(FRICTION_CAR).data["manoeuvre"])


def test_steps_follow_each_other() -> None:
    drive = Drive(STOP, speed_m_s=20.0)
    assert drive.driver.phase_names == ("roll", "brake", "stand")
    phases = []
    drive.run(20.0, lambda d: phases.append(int(d["manoeuvre_phase"])))
    assert drive.driver.finished
    assert sorted(set(phases)) == [0, 1, 2]
    assert phases == sorted(phases)
    assert drive.begins["brake"] == pytest.approx(0.2)
    assert phases.count(2) == 101  # 0.1 s and the tick in which it is over
    assert drive["driver_pedal_force"] == pytest.approx(100.0)


def test_a_step_lasts_at_least_a_tick_even_if_it_is_over_at_once() -> None:
    drive = Drive(
        """
steps:
  - {name: first, coast: true, until: {time: 0 s}}
  - {name: second, coast: true, until: {time: 0 s}}
  - {name: third, coast: true}
""",
        speed_m_s=10.0,
    )
    drive.run(0.01)
    assert drive.begins == {"first": 0.0, "second": 0.001, "third": 0.002}
    assert not drive.driver.finished


def test_the_last_step_may_go_on_for_ever() -> None:
    drive = Drive("steps: [{name: roll, coast: true}]", speed_m_s=10.0)
    drive.run(1.0)
    assert not drive.driver.finished
    assert drive.time == pytest.approx(1.0)


def test_reset_begins_anew() -> None:
    drive = Drive(STOP, speed_m_s=20.0)
    drive.run(20.0)
    drive.driver.reset()
    drive.powertrain.reset()
    drive.plant.reset(speed_m_s=20.0)
    drive.tick_number = 0
    drive.begins.clear()
    drive.run(20.0)
    assert drive.begins["brake"] == pytest.approx(0.2)
    assert drive.driver.finished


def test_what_a_step_leaves_out_goes_on() -> None:
    drive = Drive(
        """
steps:
  - {name: one, hold_speed: {speed: 20 m/s}, steer: {angle: 10 deg}, until: {after: 1 s}}
  - {name: two, steer: {angle: 20 deg}, until: {after: 1 s}}
  - {name: three, release: true, until: {after: 1 s}}
""",
        speed_m_s=20.0,
    )
    drive.run(1.9)
    assert drive["speed"] == pytest.approx(20.0, abs=0.1)
    assert drive["driver_accelerator"] > 0.05
    drive.run(1.0)
    assert drive["driver_accelerator"] == 0.0
    assert drive["driver_steering_wheel_angle"] == pytest.approx(0.349066, abs=1e-6)


@pytest.mark.parametrize("plant", [None, Plant], ids=["single_track", "mujoco"])
def test_shipped_friction_manoeuvre_has_the_source_s_times(plant: type | None) -> None:
    # document 4.2: gear changes at about 6.5 s and 8.5 s, release at about 14 s and 110 km/h, brake just before 18 s
    slips = []

    def look(drive: Drive) -> None:
        if drive.driver.phase == "accelerate" and drive["driver_gear"] == 1.0:
            slips.append(drive["slip_ratio_rl"])

    drive = Drive(shipped()) if plant is None else Drive(shipped(), plant=plant)
    drive.run(25.0, look)
    changes = {gear: time for time, gear in drive.gears}
    assert changes[2] == pytest.approx(6.5, rel=0.1)
    assert changes[3] == pytest.approx(8.5, rel=0.1)
    assert drive.begins["release"] == pytest.approx(14.0, rel=0.1)
    assert 16.5 < drive.begins["brake"] < 18.0
    assert max(slips) > 0.5  # the rear wheels are clearly faster than the car
    assert sum(slip > 0.15 for slip in slips) > 0.3 * len(slips)
    assert drive.driver.finished


def test_rear_wheels_spin_in_a_higher_gear_on_lower_grip() -> None:
    # document 4.3, E7: rear spins even in a higher gear
    vehicle = load_vehicle("ekf_car")
    set_parameter(vehicle, "tyres.front.longitudinal.peak_friction", 0.70)
    set_parameter(vehicle, "tyres.rear.longitudinal.peak_friction", 0.65)
    second = []

    def look(drive: Drive) -> None:
        if drive["driver_gear"] == 2.0 and drive["driver_clutch"] == 1.0:
            second.append(drive["slip_ratio_rl"])

    drive = Drive(shipped(), vehicle=vehicle)
    drive.run(30.0, look)
    assert max(second) > 0.3
    assert sum(slip > 0.2 for slip in second) > 0.5 * len(second)
    assert drive.driver.finished


def faults(text: str) -> list[str]:
    with pytest.raises(FileFaults) as error:
        manoeuvre_of(text)
    return [str(fault) for fault in error.value.faults]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("steps: []", "at least 1"),
        ("steps: [{name: a, brake: {pedal_force: 500 N}}, {name: a, coast: true}]", "two steps have the same name"),
        ("steps: [{name: a, coast: true}, {name: b, coast: true}]", "the step never ends"),
        ("steps: [{name: a, coast: true, release: true}]", "the feet do one thing"),
        ("steps: [{name: a, steer: {angle: 1}}]", "the first step says what the feet do"),
        ("steps: [{name: 1a, coast: true}]", "not of the right form"),
        ("steps: [{name: a, brake: {pedal_force: 500 bar}}]", "wrong dimension"),
        ("steps: [{name: a, brake: {pedal_force: 5 kN}}]", "out of range"),
        ("steps: [{name: a, brake: {master_pressure: 100 bar, ramp: 1 kN/s}}]", "wrong dimension"),
        ("steps: [{name: a, break: {pedal_force: 500 N}}]", "did you mean brake"),
        ("steps: [{name: a, coast: true, steer: {follow: circle}}]", "a circle needs a radius"),
        ("steps: [{name: a, coast: true, steer: {follow: straight, radius: 50}}]", "only a circle has a radius"),
        ("steps: [{name: a, coast: true, steer: {}}]", "the hands do one thing"),
        ("steps: [{name: a, coast: true, steer: {profile: {}}}]", "a steering profile has one kind"),
        (
            "steps: [{name: a, coast: true, steer: {profile: {table: {time: [0, 0], angle: [0, 1]}}}}]",
            "not rising",
        ),
        ("steps: [{name: a, accelerate: {shift_up_speeds: [20, 10]}}]", "not rising"),
        ("steps: [{name: a, accelerate: {accelerator_by_gear: [1, 2]}}]", "out of range"),
        ("steps: [{name: a, coast: true, until: {signal: sped, below: 1}}]", "did you mean speed"),
    ],
)
def test_bad_files_are_refused_with_the_place(text: str, expected: str) -> None:
    found = faults(text)
    assert any(expected in fault for fault in found), found
    assert all(fault.startswith("manoeuvre.yaml:") for fault in found)


def test_conditions_are_checked_against_the_run() -> None:
    file = manoeuvre_of("steps: [{name: a, coast: true, until: {phase: b}}]")
    units = {signal.name: signal.unit for signal in SignalVector().signals}
    (fault,) = file.faults(units)
    assert fault.at[:3] == ("steps", 0, "until")


def test_a_gear_that_the_car_lacks() -> None:
    file = manoeuvre_of("steps: [{name: a, hold_speed: {speed: 20 m/s, gears: 7}}]")
    with pytest.raises(InputError, match="no such gear"):
        Manoeuvre(file, SignalVector(), load_vehicle("ekf_car"))


def test_schema_needs_no_heavy_library() -> None:
    import subprocess
    import sys

    code = (
        "import sys, vehicle_model.manoeuvre_file; "
        "print([m for m in ('numba','scipy','mujoco','can','cantools','asammdf','matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
