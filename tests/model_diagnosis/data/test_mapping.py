"""Suggested channel maps: by name and unit, by sign, by correlation where the name says nothing."""

import os
from pathlib import Path

import can
import cantools
import kinematic_car as car
import numpy as np
import pytest
from asammdf import MDF, Signal

from model_diagnosis.data import suggest_channels
from model_diagnosis.data.channel_names import signals_by_name
from signals.errors import InputError
from signals.measured.channel_map import load_channel_map
from signals.measured.measured_log import read_log
from vehicle_model.vehicle_file import load_vehicle

ROOT = Path(__file__).parents[3]
SHARED = Path(os.environ.get("BENCH_SHARED_DATA", ROOT.parent / "shared" / "data"))
SHIPPED = ROOT / "scenarios" / "diagnosis"

NAMES = {
    "wheel_speed_fl": "WheelSpeedFL [rad/s]",
    "wheel_speed_fr": "WheelSpeedFR [rad/s]",
    "wheel_speed_rl": "WheelSpeedRL [rad/s]",
    "wheel_speed_rr": "WheelSpeedRR [rad/s]",
    "speed": "vx(m/s)",
    "yaw_rate": "YawRate",
    "longitudinal_acceleration": "ax(m/s^2)",
    "lateral_acceleration": "channel_17",
    "steering_wheel_angle": "SteeringWheelAngle",
}


def _driven(kind="turn_brake", seed=5):
    random = np.random.default_rng(seed)
    driven = car.drive(kind, random, 14.0)
    return car.logged(driven, car.sensed(driven, random), random)


def test_names_units_signs_and_a_column_without_a_name(tmp_path, vehicle):
    renamed = {NAMES[n]: (t, -57.29578 * y if n == "yaw_rate" else y) for n, (t, y) in _driven().items() if n in NAMES}
    path = car.write_csv(tmp_path / "foreign.csv", renamed)
    found = {s.name: s for s in suggest_channels([path], vehicle).channels}
    assert {name: s.source for name, s in found.items()} == NAMES
    assert found["speed"].unit == "m/s"
    assert found["yaw_rate"].sign == -1
    assert found["yaw_rate"].unit == "deg/s"
    assert "correlation" in found["lateral_acceleration"].reason
    assert found["lateral_acceleration"].unit == "m/s^2"


ODD_UNITS = {
    "yaw_rate": ("deg/s", 57.29577951308232),
    "longitudinal_acceleration": ("g", 1.0 / 9.81),
    "steering_wheel_angle": ("deg", 57.29577951308232),
    "speed": ("km/h", 3.6),
    **{f"wheel_speed_{wheel}": ("km/h", 3.6 * car.RADIUS_M) for wheel in ("fl", "fr", "rl", "rr")},
    **{f"brake_pressure_{wheel}": ("bar", 1e-5) for wheel in ("fl", "fr", "rl", "rr")},
}


@pytest.mark.parametrize("told", [False, True])
def test_the_suggested_map_reads_what_was_driven(tmp_path, vehicle, told):
    """Units that no column tells, two of them wrong at once, are found by the motion; of told ones all may be odd.

    Tables are written with seven digits.
    """
    odd = ODD_UNITS if told else {name: ODD_UNITS[name] for name in ("yaw_rate", "longitudinal_acceleration")}
    log = _driven()
    scaled = {}
    for name, (time, values) in log.items():
        unit, factor = odd.get(name, ("", 1.0))
        scaled[f"{name} ({unit})" if told and unit else name] = (time, values * factor)
    path = car.write_csv(tmp_path / "foreign.csv", scaled)
    suggested = suggest_channels([path], vehicle)
    assert {one.name for one in suggested.channels} == set(log)
    read = read_log(path, suggested.channel_map(), wheel_radius_m=car.RADIUS_M)
    for name, (_, values) in log.items():
        known = values[np.isfinite(values)]
        assert read.channels[name].values[: len(known)] == pytest.approx(known, rel=1e-6), name


UNTOLD = ODD_UNITS | {f"wheel_speed_{wheel}": ("rpm", 9.549296585513721) for wheel in ("fl", "fr", "rl", "rr")}
"""A speed along the road in km/h is by chance 1.0008 times the rotation in rad/s: nobody could tell them apart."""


def test_a_column_without_a_name_is_found_beside_drives_that_do_not_move_it(tmp_path, vehicle):
    """Two straight drives, of which its noise is all, and a turn; the yaw rate in degrees makes all of them move."""
    paths = []
    for seed, kind in enumerate(("stop", "turn_brake", "accelerate")):
        log = {n: (t, y * UNTOLD[n][1] if n == "yaw_rate" else y) for n, (t, y) in _driven(kind, seed).items()}
        log = {NAMES[n]: column for n, column in log.items() if n in NAMES}
        paths.append(car.write_csv(tmp_path / f"{kind}.csv", log))
    found = {one.name: one for one in suggest_channels(paths, vehicle).channels}
    assert (found["lateral_acceleration"].source, found["lateral_acceleration"].by_name) == ("channel_17", False)


def test_units_that_no_column_tells_are_found_where_all_are_odd_and_one_sign_is(tmp_path, vehicle):
    """Four groups and a sign are wrong at once, one more than a comparison explains."""
    paths = []
    for seed, kind in enumerate(("turn_brake", "slalom", "accelerate", "stop")):
        scaled = {name: (t, y * UNTOLD.get(name, ("", 1.0))[1]) for name, (t, y) in _driven(kind, seed).items()}
        scaled["lateral_acceleration"] = (scaled["speed"][0], -scaled["lateral_acceleration"][1])
        paths.append(car.write_csv(tmp_path / f"{kind}.csv", scaled))
    found = {one.name: one for one in suggest_channels(paths, vehicle).channels}
    assert {name: found[name].unit for name in UNTOLD} == {name: unit for name, (unit, _) in UNTOLD.items()}
    assert [one.name for one in found.values() if one.sign < 0] == ["lateral_acceleration"]
    assert not [one.name for one in found.values() if not one.motion]


def test_a_pressure_that_moves_nothing_stands_in_a_likely_unit(tmp_path, vehicle):
    time = np.arange(400) * 0.01
    table = np.column_stack([time, np.full(400, 20.0), 30.0 * np.clip(time - 2.0, 0.0, 1.0)])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t,speed,Bremsdruck_VL", comments="")
    pressure = {one.name: one for one in suggest_channels([tmp_path / "a.csv"], vehicle).channels}["brake_pressure_fl"]
    assert (pressure.unit, pressure.is_likely, pressure.motion) == ("bar", True, "")


def test_units_of_mf4_channels_and_of_a_database_are_taken(tmp_path, vehicle):
    time = np.arange(400) * 0.01
    speed = 90.0 - 5.0 * time
    with MDF() as mdf:
        mdf.append([Signal(speed, time, name="VehSpd", unit="kmph"), Signal(0.1 * speed, time, name="p", unit="Nm")])
        mdf.save(tmp_path / "a.mf4")
    suggested = suggest_channels([tmp_path / "a.mf4"], vehicle)
    assert [(s.name, s.source, s.unit) for s in suggested.channels] == [("speed", "VehSpd", "km/h")]
    dbc = (
        'VERSION ""\nNS_ :\nBS_:\nBU_: A\nBO_ 256 MOTION: 8 A\n SG_ YawRate : 0|16@1- (0.01,0) [-300|300] "°/s" A\n'
        ' SG_ YawRate_Valid : 16|1@1+ (1,0) [0|1] "" A\n SG_ LongAccel : 24|16@1- (0.001,0) [-3|3] "g" A\n'
        'BO_ 512 NEVER_SENT: 8 A\n SG_ LatAccel : 0|16@1- (0.001,0) [-3|3] "g" A\n'
    )
    (tmp_path / "car.dbc").write_text(dbc, encoding="cp1252")
    message = cantools.database.load_string(dbc).get_message_by_name("MOTION")
    for log_file in (tmp_path / "frames.blf", tmp_path / "frames.mf4"):
        with can.Logger(log_file) as log:
            for t in time:
                data = message.encode({"YawRate": 3.0 * np.sin(t), "YawRate_Valid": 1, "LongAccel": 0.1 * np.cos(t)})
                log(can.Message(timestamp=1.79e9 + t, arbitration_id=256, data=data, is_extended_id=False))
        suggested = suggest_channels([log_file], vehicle, str(tmp_path / "car.dbc"))
        assert {(s.name, s.source, s.unit) for s in suggested.channels} == {
            ("yaw_rate", "MOTION.YawRate", "deg/s"),
            ("longitudinal_acceleration", "MOTION.LongAccel", "g"),
        }
        with pytest.raises(InputError, match="needs a database"):
            suggest_channels([log_file], vehicle)


@pytest.mark.parametrize(("column", "factor", "unit"), [("Timestamp", 1e3, "ms"), ("t", 1e6, "us"), ("zeit", 1.0, "s")])
def test_the_time_of_a_table_is_found_with_its_unit(tmp_path, vehicle, column, factor, unit):
    time = np.arange(400) * 0.01
    rows = np.column_stack([90.0 - 5.0 * time, factor * time])
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=f"speed,{column}", comments="")
    clock = suggest_channels([tmp_path / "a.csv"], vehicle).clock
    assert (clock.column, clock.unit) == (column, unit)


# names as public databases and tools have them
PUBLIC_NAMES = {
    "WHEEL_SPEEDS.WHEEL_SPEED_RR": "wheel_speed_rr",
    "ESP_03.ESP_HL_Radgeschw": "wheel_speed_rl",
    "WhlSpdFrontLeft": "wheel_speed_fl",
    "Raddrehzahl_VR": "wheel_speed_fr",
    "Vhcl.RL.rotv": "wheel_speed_rl",
    "KINEMATICS.YAW_RATE": "yaw_rate",
    "ESP_02.ESP_Gierrate": "yaw_rate",
    "KINEMATICS.ACCEL_X": "longitudinal_acceleration",
    "ESP_Laengsbeschl": "longitudinal_acceleration",
    "Querbeschleunigung": "lateral_acceleration",
    "STEERING.STEER_ANGLE": "steering_wheel_angle",
    "LWI_Lenkradwinkel": "steering_wheel_angle",
    "Car.SteerAngleFL": "road_wheel_angle",
    "Brake.pWB_FR": "brake_pressure_fr",
    "ESP.P_RR": "brake_pressure_rr",
    "BRAKE.BRAKE_PRESSURE": "master_pressure",
    "MasterCylinderPressure": "master_pressure",
    "EngineRPM": "engine_speed",
    "MotorTorque": "engine_torque",
    "FrontAxleDriveTorque": "drive_torque_f",
    "Car.CRL.Tire.FrcC.y": "lateral_force_rl",
    "GPS.Speed": "speed",
    "VehicleSpeed": "speed",
    "heading": "yaw_angle",
    "VALVES.ValveInletFl": "valve_inlet_fl",
    "Auslassventil_HR": "valve_outlet_rr",
    "ReturnPump": "pump",
    "yawAngAcc": None,
    "YawRate_Valid": None,
    "STEERING.STEER_RATE": None,
    "TirePressureFL": None,
    "AcceleratorPedal": None,
    "WindSpeed": None,
    "EngineTemp": None,
    "FuelPump": None,
}


@pytest.mark.parametrize("name", PUBLIC_NAMES)
def test_names_of_public_databases_are_known(name):
    assert list(signals_by_name([name], {})) == [signal for signal in (PUBLIC_NAMES[name],) if signal]


def test_what_is_measured_goes_before_what_is_computed_or_commanded():
    columns = signals_by_name(["yawRateFilt", "yawRate", "yaw_rate_ref"], {})["yaw_rate"]
    assert [column.source for column in columns] == ["yawRate", "yawRateFilt", "yaw_rate_ref"]


NOT_BY_NAME = {"iac-av21": {"road_bank"}}
"""What is known from the data's description only: the roll angle on a banked oval is the road's."""
NOT_TOLD = {"speed", "slip_ratio_fl", "vertical_load_fl", "longitudinal_force_fl", "lateral_force_fl"}
"""Channels of the rig, whose columns tell no unit; no other channel does either."""


@pytest.mark.parametrize(
    ("log", "scenario"),
    [
        ("iac-av21/LVMS_23_01_04_B.csv.gz", "iac-av21"),
        ("revs-250lm-2014/250lm_20140222_01_t150-425.csv.gz", "revs-250lm-2014"),
        ("carmaker-bosch/slalom1_14_5ms.CSV.gz", "carmaker-bosch"),
        ("tyre-rig-ttc-deid/drivebrake.csv.gz", "tyre-rig-ttc-deid"),
    ],
)
def test_maps_of_public_logs_are_those_made_by_hand_from_their_descriptions(log, scenario):
    if not (SHARED / log).is_file():
        pytest.skip(f"shared data not here: {SHARED / log}")
    by_hand = load_channel_map(SHIPPED / scenario / "channels.yaml")
    suggested = suggest_channels([SHARED / log], load_vehicle(SHIPPED / scenario / "vehicle.yaml"))
    assert suggested.clock == by_hand.clock
    found = {one.name: one for one in suggested.channels}
    for name, channel in by_hand.channels.items():
        if name in NOT_BY_NAME.get(scenario, ()):
            continue
        assert found[name].source == channel.source, name
        if scenario == "tyre-rig-ttc-deid" and name in NOT_TOLD:
            assert found[name].unit is None, name
        else:
            assert (found[name].unit, found[name].sign) == (channel.unit, channel.sign), name
