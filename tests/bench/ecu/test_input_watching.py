"""What the ECU does about missing, corrupt or implausible inputs, and how it recovers (friction document 1.7)."""

from typing import Any

import numpy as np
import pytest

from bench.ecu.faults import (
    FAULTS,
    IMPLAUSIBLE_BRAKE,
    IMPLAUSIBLE_INERTIAL,
    IMPLAUSIBLE_WHEEL,
    MISSING_WHEEL,
    PROTECTION,
    TIMEOUT,
)
from bench.ecu.records import SOURCES

BULB_CHECK_S = 1.8


def healthy(can_car: Any, speed: float = 20.0) -> Any:
    """A car that has passed the bulb check and drives."""
    car = can_car()
    car.drive(BULB_CHECK_S + 0.7, speed)
    assert car["abs_lamp"] == 0
    assert car["ecu_fault_code"] == 0
    return car


def brake_with_a_locking_wheel(car: Any, **options: Any) -> None:
    car.drive(0.2, 20.0, master_bar=100, **options)
    car.drive(0.1, (4.0, 20.0, 20.0, 20.0), master_bar=100, **options)


def test_bulb_check_after_key_on(can_car: Any) -> None:
    car = can_car()
    car.drive(0.1, 0.0)
    assert car["abs_lamp"] == 1
    car.drive(BULB_CHECK_S - 0.15, 0.0)
    assert car["abs_lamp"] == 1
    car.drive(0.15, 0.0)
    assert car["abs_lamp"] == 0


def test_abs_works_during_the_bulb_check(can_car: Any) -> None:
    car = can_car()
    car.drive(0.3, 20.0)
    brake_with_a_locking_wheel(car)
    assert car["abs_active"] == 1
    assert car["valve_outlet_fl"] == 1


@pytest.mark.parametrize(
    ("message", "source", "period_s"),
    [
        ("WHEEL_SPEED_FRONT", "wheel_speed_front", 0.005),
        ("WHEEL_SPEED_REAR", "wheel_speed_rear", 0.005),
        ("WHEEL_EDGES_FL", "wheel_edges_fl", 0.005),
        ("WHEEL_EDGES_RR", "wheel_edges_rr", 0.005),
        ("BRAKE", "brake", 0.010),
        ("VEHICLE_STATUS", "vehicle_status", 0.020),
    ],
)
def test_message_missing_for_more_than_five_periods_switches_abs_off(
    can_car: Any, message: str, source: str, period_s: float
) -> None:
    car = healthy(can_car)
    car.drive(4 * period_s, 20.0, drop=(message,))
    assert car["abs_lamp"] == 0
    # five periods, the phase of the message, the task, the status frame
    car.drive(2 * period_s + 0.035, 20.0, drop=(message,))
    assert car["abs_lamp"] == 1
    assert car["ecu_fault_code"] == TIMEOUT + SOURCES.index(source)
    brake_with_a_locking_wheel(car, drop=(message,))
    assert car["abs_active"] == 0
    assert [car[f"valve_inlet_{w}"] for w in ("fl", "fr")] == [0, 0]
    assert [car[f"valve_outlet_{w}"] for w in ("fl", "fr")] == [0, 0]


@pytest.mark.parametrize("message", ["WHEEL_EDGES_FL", "BRAKE", "VEHICLE_STATUS"])
def test_refused_frames_have_codes_of_their_own(can_car: Any, message: str) -> None:
    car = healthy(can_car)
    car.drive(0.3, 20.0, corrupt=(message,))
    assert car["abs_lamp"] == 1
    assert car["ecu_fault_code"] == PROTECTION + SOURCES.index(message.lower())


def test_single_corrupt_frame_is_no_fault(can_car: Any) -> None:
    car = healthy(can_car)
    for _ in range(20):
        car.drive(0.005, 20.0, corrupt=("WHEEL_EDGES_FL", "BRAKE"))
        car.drive(0.050, 20.0)
    assert car["abs_lamp"] == 0
    assert car["ecu_fault_code"] == 0


def test_fault_during_control_opens_the_valves_and_keeps_plain_braking(can_car: Any) -> None:
    car = healthy(can_car)
    brake_with_a_locking_wheel(car)
    assert car["abs_active"] == 1
    assert car["valve_inlet_fl"] == 1
    car.drive(0.1, (4.0, 20.0, 20.0, 20.0), master_bar=100, drop=("WHEEL_SPEED_FRONT",))
    assert car["abs_active"] == 0
    assert car["valve_inlet_fl"] == 0
    assert car["valve_outlet_fl"] == 0


def test_distribution_remains_without_a_front_sensor(can_car: Any) -> None:
    car = healthy(can_car)
    options: dict[str, Any] = {"drop": ("WHEEL_EDGES_FL",)}
    car.drive(0.2, 20.0, **options)
    car.drive(0.2, (18.0, 18.0, 17.0, 17.0), master_bar=60, **options)
    assert car["abs_active"] == 0
    assert car["ebd_active"] == 1
    assert [car[f"valve_inlet_{w}"] for w in ("fl", "fr", "rl", "rr")] == [0, 0, 1, 1]


def test_distribution_needs_the_brake_message(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(0.2, 20.0, drop=("BRAKE",))
    car.drive(0.2, (18.0, 18.0, 16.0, 16.0), master_bar=60, drop=("BRAKE",))
    assert car["ebd_active"] == 0
    assert [car[f"valve_inlet_{w}"] for w in ("rl", "rr")] == [0, 0]


def test_wheel_without_pulses_while_the_car_drives(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(1.5, 20.0, dead_wheels=(2,))
    assert car["ecu_fault_code"] == MISSING_WHEEL + 2
    assert car["abs_lamp"] == 1


def test_wheel_that_dies_during_control_is_not_released_for_ever(can_car: Any) -> None:
    car = healthy(can_car)
    brake_with_a_locking_wheel(car)
    car.drive(0.8, 18.0, master_bar=100, dead_wheels=(0,))
    assert car["ecu_fault_code"] == MISSING_WHEEL
    assert car["valve_inlet_fl"] == 0


def test_locked_braked_wheel_is_no_sensor_fault(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(0.2, 20.0, master_bar=100)
    car.drive(0.15, (0.0, 20.0, 20.0, 20.0), master_bar=100)
    assert car["ecu_fault_code"] == 0


def test_pulses_that_contradict_the_speed_frame(can_car: Any) -> None:
    car = healthy(can_car)

    def falsify(values: np.ndarray) -> None:
        values[1] *= 1.5

    car.drive(0.3, 20.0, change=falsify)
    assert car["ecu_fault_code"] == IMPLAUSIBLE_WHEEL + 1
    assert car["abs_lamp"] == 1


def test_pressure_without_brake_switch(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(1.3, 20.0, master_bar=30, brake_switch=0.0)
    assert car["ecu_fault_code"] == IMPLAUSIBLE_BRAKE
    assert car["abs_lamp"] == 1


def test_lost_accelerometer_only_costs_its_help(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(0.3, 20.0, drop=("INERTIAL",))
    assert car["ecu_fault_code"] == TIMEOUT + SOURCES.index("inertial")
    assert car["abs_lamp"] == 0
    brake_with_a_locking_wheel(car, drop=("INERTIAL",))
    assert car["abs_active"] == 1


def test_accelerometer_against_the_wheels(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(0.6, 20.0, acceleration=7.0)
    assert car["ecu_fault_code"] == IMPLAUSIBLE_INERTIAL
    assert car["abs_lamp"] == 0


def test_message_fault_heals_after_a_healthy_drive(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(0.3, 20.0, drop=("BRAKE",))
    car.drive(0.8, 20.0)
    assert car["abs_lamp"] == 1
    car.drive(0.4, 20.0)
    assert car["abs_lamp"] == 0
    assert car["ecu_fault_code"] == 0


def test_message_fault_does_not_heal_below_ten_kilometres_per_hour_or_while_braking(can_car: Any) -> None:
    car = healthy(can_car, speed=2.0)
    car.drive(0.3, 2.0, drop=("BRAKE",))
    car.drive(3.0, 2.0)
    assert car["abs_lamp"] == 1
    car.drive(2.0, 20.0, master_bar=20)
    assert car["abs_lamp"] == 1
    car.drive(1.5, 20.0)
    assert car["abs_lamp"] == 0


def test_sensor_fault_heals_after_key_on_and_a_healthy_drive(can_car: Any) -> None:
    car = healthy(can_car)
    car.drive(1.5, 20.0, dead_wheels=(3,))
    car.drive(3.0, 20.0)
    assert car["abs_lamp"] == 1  # the sensor is back, but was not proven since key-on
    car.drive(0.5, 0.0, ignition=0.0)
    assert car["abs_lamp"] == 0  # nothing shines without ignition
    car.drive(BULB_CHECK_S + 0.5, 0.0)
    assert car["abs_lamp"] == 1
    car.drive(3.5, 20.0)
    assert car["abs_lamp"] == 0
    assert car["ecu_fault_code"] == 0


def test_inputs_that_never_come_are_a_fault_after_the_start_time(can_car: Any) -> None:
    car = can_car()
    car.drive(0.4, 20.0, drop=("WHEEL_EDGES_RL",))
    assert car["ecu_fault_code"] == 0
    car.drive(0.3, 20.0, drop=("WHEEL_EDGES_RL",))
    assert car["ecu_fault_code"] == TIMEOUT + SOURCES.index("wheel_edges_rl")


def test_bus_that_sleeps_and_wakes_is_no_fault(can_car: Any) -> None:
    car = healthy(can_car, speed=0.0)
    everything = tuple(car._identifiers)
    car.drive(6.0, 0.0, drop=everything)
    assert car["abs_lamp"] == 0
    car.drive(BULB_CHECK_S + 0.5, 0.0)
    assert car["ecu_fault_code"] == 0
    assert car["abs_lamp"] == 0


def test_fault_codes_fit_the_diagnostics_channel() -> None:
    assert all(0 < code < 256 for code in FAULTS)
    assert len({fault.name for fault in FAULTS.values()}) == len(FAULTS)
