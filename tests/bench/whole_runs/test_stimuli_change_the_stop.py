"""Stimuli end to end: what they change in a stop is what mechanics says, and neutral ones change nothing at all."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bench
from bench.loop.session import Parts, build_parts, road_of
from bench.scenario.schema import ScenarioFile
from signals.catalogue import block_slice, names
from vehicle_model.road_file import road_parameter_table
from vehicle_model.vehicle_file import load_vehicle, parameter_table

SHORT_STOP = Path(__file__).parent / "short_stop.yaml"
CAR = {info.path: info.value for info in parameter_table(load_vehicle("ekf_car"))}
WHEELS = ("fl", "fr", "rl", "rr")
CHANGE_S = 1.2
"""When a stimulus changes something: the brake is on since 0.3 s."""

NO_ECU: dict[str, Any] = {"kind": "none", "link": None}
NO_DRAG = {"aerodynamics.drag_coefficient": 0.0, **{f"wheels.{wheel}.rolling_resistance": 0.0 for wheel in WHEELS}}


def braking(pressure_bar: float) -> dict[str, Any]:
    """Free running, then a constant pressure; the clutch is open."""
    brake = {"master_pressure": f"{pressure_bar} bar", "ramp": "1000 bar/s"}
    steps = [
        {"name": "roll", "release": True, "until": {"time": 0.3}},
        {"name": "brake", "brake": brake, "until": {"signal": "speed", "below": 0.1, "lasting": 0.1}},
    ]
    return {
        "manoeuvre": {"steps": steps},
        "initial_speed": "100 km/h",
        "time_limit": 2.2,
        "ecu": NO_ECU,
        "criteria": [],
    }


def at_change(target: str, **shape: Any) -> dict[str, Any]:
    return {"target": target, "when": {"time": CHANGE_S}, **shape}


def mean(run: bench.Run, name: str, begin_s: float, end_s: float) -> float:
    return float(run.data.array(name)[int(begin_s * 1000) : int(end_s * 1000)].mean())


HELD_BACK = CAR["hydraulics.pressure_change_threshold"]
"""What a wheel's pressure stays behind the master cylinder's after a rising ramp (friction document 2.6.2, step 1)."""


def brake_force(pressure_pa: float, front_pad: float = CAR["brakes.front.pad_friction"]) -> float:
    """Force of four brakes at the road: 2 p A mu R each (friction document 2.4.2) over the rolling radius."""
    torque = 0.0
    for axle, pad in (("front", front_pad), ("rear", CAR["brakes.rear.pad_friction"])):
        area, radius = CAR[f"brakes.{axle}.pad_area"], CAR[f"brakes.{axle}.effective_radius"]
        torque += 2 * 2 * pressure_pa * area * pad * radius
    return torque / CAR["wheels.fl.radius"]


MASS = CAR["body.mass"] + 4 * CAR["wheels.fl.inertia"] / CAR["wheels.fl.radius"] ** 2
"""With the turning wheels; their slip is small at these pressures."""


def test_fading_front_pads(short_stop: Callable[..., ScenarioFile]) -> None:
    """Half the pad friction at the front: deceleration falls from F/m to what the smaller force gives."""
    fade = [at_change("brakes.front.pad_friction", step=0.5 * CAR["brakes.front.pad_friction"])]
    run = bench.run(short_stop(overrides=NO_DRAG, stimuli=fade, **braking(40)), record=False)
    before, after = (mean(run, "true_longitudinal_acceleration", *span) for span in ((0.9, 1.2), (1.7, 2.2)))
    pressure, pad = 40e5 - HELD_BACK, CAR["brakes.front.pad_friction"]
    assert -before == pytest.approx(brake_force(pressure, pad) / MASS, rel=0.01)
    assert -after == pytest.approx(brake_force(pressure, 0.5 * pad) / MASS, rel=0.01)
    capacity = run.data.array("brake_torque_capacity_fl")
    assert capacity[1190] / capacity[1300] == pytest.approx(2.0, rel=1e-6)
    for name in ("brake_torque_capacity_rl", "true_brake_pressure_fl", "true_brake_pressure_rl"):
        assert run.data.array(name)[1190] == pytest.approx(run.data.array(name)[1300], rel=1e-6)


def test_master_pressure_overridden(short_stop: Callable[..., ScenarioFile]) -> None:
    """A driver signal: the brakes follow the override, 20 bar in place of 40, and return when it ends."""
    hold = [at_change("driver_master_pressure", step="20 bar", duration=0.5)]
    run = bench.run(short_stop(overrides=NO_DRAG, stimuli=hold, **braking(40)), record=False)
    inside, later = (mean(run, "true_longitudinal_acceleration", *span) for span in ((1.5, 1.7), (2.0, 2.2)))
    assert -inside == pytest.approx(brake_force(20e5) / MASS, rel=0.01)
    assert -later == pytest.approx(brake_force(40e5) / MASS, rel=0.01)  # a step leaves nothing held back
    assert run.data.array("faults_active")[[1190, 1300, 1800]].tolist() == [0, 1, 0]


def test_road_friction_changes_under_locked_wheels(short_stop: Callable[..., ScenarioFile]) -> None:
    """Locked wheels give mu m g with one load-independent mu: half the road friction, half the deceleration."""
    ice = [at_change("road.friction", step=0.4)]
    run = bench.run(short_stop(overrides=NO_DRAG, stimuli=ice, **braking(150)), record=False)
    assert max(run.data.array(f"true_wheel_speed_{wheel}")[1190] for wheel in WHEELS) == 0.0
    before, after = (mean(run, "true_longitudinal_acceleration", *span) for span in ((0.9, 1.2), (1.7, 2.2)))
    # the front's share of the load moves with the deceleration, and front and rear tyres differ by 14 %
    front, rear = (CAR[f"tyres.{axle}.longitudinal.peak_friction"] for axle in ("front", "rear"))
    shift = 1 - CAR["body.centre_of_gravity_height"] / CAR["body.wheelbase"] * (front - rear) * 0.8
    assert after / before == pytest.approx(0.5, rel=abs(1 - shift))
    assert -9.81 * 0.8 * front < before < -9.81 * 0.8 * rear * 0.85


def test_sensed_wheel_speed_is_overridden_on_the_bus_only(short_stop: Callable[..., ScenarioFile]) -> None:
    """The frames carry the changed value from the next one on; the wheel itself turns as before."""
    lie = [at_change("wheel_speed_fl", step="20 rad/s", duration=0.3)]
    settings = {**braking(30), "overrides": NO_DRAG}
    told, quiet = (bench.run(short_stop(stimuli=stimuli, **settings), record=False) for stimuli in (lie, []))
    assert told.data.array("wheel_speed_fl")[1210:1500] == pytest.approx(20.0, abs=0.01)  # resolution of the frame
    assert told.data.array("wheel_speed_fl")[1510] == quiet.data.array("wheel_speed_fl")[1510]
    for name in ("true_wheel_speed_fl", "wheel_speed_fr", "speed"):
        assert np.array_equal(told.data.array(name), quiet.data.array(name)), name


def test_overridden_valve_frame_keeps_a_wheel_from_building_pressure(short_stop: Callable[..., ScenarioFile]) -> None:
    """Inlet closed from before the brake starts: that wheel gets no pressure, the others do."""
    shut = [{"target": "valve_inlet_fl", "step": 1, "when": {"time": 0.1}}]
    run = bench.run(short_stop(stimuli=shut, **braking(40)), record=False)
    pressures = [run.data.array(f"true_brake_pressure_{wheel}")[1200] for wheel in WHEELS]
    assert pressures[0] < 0.5e5
    assert pressures[1:] == pytest.approx([40e5 - HELD_BACK] * 3, rel=1e-3)


@pytest.fixture(scope="module")
def untouched(short_stop: Callable[..., ScenarioFile]) -> bench.Run:
    return bench.run(short_stop(), record=False)


def assert_equal(run: bench.Run, other: bench.Run) -> None:
    different = [
        name
        for name in other.data.names
        if name != "faults_active" and not np.array_equal(run.data.array(name), other.data.array(name), equal_nan=True)
    ]
    assert different == []


def test_every_parameter_overridden_with_its_own_value(untouched: bench.Run) -> None:
    table = [*parameter_table(load_vehicle("ekf_car")), *road_parameter_table(road_of(untouched.scenario))]
    values = {info.path: info.value for info in table}
    assert len(values) > 200
    assert_equal(bench.run(SHORT_STOP, pacing="lockstep", ecu="inprocess", sets=values, record=False), untouched)


def test_every_parameter_set_on_line_to_its_own_value(
    untouched: bench.Run, short_stop: Callable[..., ScenarioFile]
) -> None:
    """Once before the brake and once in the middle of the stop; at its end each gets back the value that it had."""
    parts = build_parts(short_stop())
    paths = sorted({path for owner in owners(parts) for path in owner.names()})
    assert {"brakes.front.pad_friction", "road.friction", "body.mass"} <= set(paths)
    stimuli = [
        {"name": f"{path} {time}", "target": path, "when": {"time": time}, "step": value, "duration": 0.01}
        for path in paths
        for time in (0.1, 1.0)
        for value in [next(owner.get(path) for owner in owners(parts) if path in owner.names())]
    ]
    assert_equal(bench.run(short_stop(stimuli=stimuli), record=False), untouched)


def owners(parts: Parts) -> list[Any]:
    return [parts.plant, parts.hydraulic_unit, parts.powertrain, parts.manoeuvre, parts.sensors]


def test_every_signal_overridden_by_nothing(untouched: bench.Run, short_stop: Callable[..., ScenarioFile]) -> None:
    """Zero is added to each signal that can be overridden, from the driver's to those on the bus."""
    blocks = ("driver", "hydraulics", "powertrain", "bus")
    targets = [name for block in blocks for name in names()[block_slice(block)] if name != "manoeuvre_phase"]
    stimuli = [{"target": name, "name": f"s {name}", "step": 0.0, "relative": True} for name in targets]
    run = bench.run(short_stop(stimuli=stimuli), record=False)
    assert run.data.array("faults_active").max() == len(targets)
    assert_equal(run, untouched)
