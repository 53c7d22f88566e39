"""The one catalogue of signal names, units and descriptions.

A run keeps one float64 vector with a value per signal; every part of the bench owns a block of consecutive entries
and writes only there. Plain names (``wheel_speed_fl``) are what an observer on the ECU side of the bus decoded; the
value of the simulated car is ``true_wheel_speed_fl``. Signals that no bus message carries (``speed``,
``slip_ratio_fl``) are the simulated car's and have no prefix. Values are SI, axes ISO 8855 (x forward, y left, z up).
"""

from dataclasses import dataclass
from functools import cache

from signals.wheels import WHEELS


@dataclass(frozen=True)
class Signal:
    """One entry of the catalogue.

    Attributes
    ----------
    name, unit, description
        Name used in files and recordings, SI unit ("1" where there is none), one line of explanation.
    block
        The part of the bench that writes it.
    display_unit, display_factor
        Unit shown to people and the factor from the SI value to it.
    """

    name: str
    unit: str
    description: str
    block: str
    display_unit: str
    display_factor: float


_DISPLAY = {
    "Pa": ("bar", 1e-5),
    "rad": ("deg", 57.29577951308232),
    "rad/s": ("rad/s", 1.0),
}


def _signal(block: str, name: str, unit: str, description: str, display: tuple[str, float] | None = None) -> Signal:
    display_unit, factor = display or _DISPLAY.get(unit, (unit, 1.0))
    return Signal(name, unit, description, block, display_unit, factor)


def _wheels(block: str, name: str, unit: str, description: str) -> list[Signal]:
    return [_signal(block, f"{name}_{w}", unit, f"{description}, {w}") for w in WHEELS]


_KMH = ("km/h", 3.6)
_DEG_S = ("deg/s", 57.29577951308232)


def _clock() -> list[Signal]:
    return [
        _signal("clock", "time", "s", "time since the start of the run"),
        _signal("clock", "manoeuvre_phase", "1", "index of the manoeuvre step that is active"),
    ]


def _driver() -> list[Signal]:
    return [
        _signal("driver", "driver_pedal_force", "N", "brake pedal force of the driver"),
        _signal("driver", "driver_master_pressure", "Pa", "unmodulated brake pressure that the driver makes"),
        _signal("driver", "driver_accelerator", "1", "accelerator pedal, 0 to 1"),
        _signal("driver", "driver_clutch", "1", "clutch engagement, 0 open to 1 closed"),
        _signal("driver", "driver_gear", "1", "selected gear, 0 is neutral"),
        _signal("driver", "driver_steering_wheel_angle", "rad", "steering-wheel angle, positive to the left"),
    ]


def _hydraulics() -> list[Signal]:
    block = "hydraulics"
    return [
        _signal(block, "true_master_pressure", "Pa", "master-cylinder pressure"),
        *_wheels(block, "true_brake_pressure", "Pa", "wheel brake pressure"),
        *_wheels(
            block, "hydraulic_state", "1", "selection logic: 0 increase, 1 hold, 2 decrease, 3 invalid valves, held"
        ),
        _signal(block, "accumulator_pressure", "Pa", "low-pressure accumulator, worst circuit"),
        *_wheels(block, "brake_torque_capacity", "N m", "torque that the brake can transmit"),
        *_wheels(block, "brake_disc_temperature", "degC", "temperature of the brake disc"),
    ]


def _plant() -> list[Signal]:
    block = "plant"
    return [
        _signal(block, "speed", "m/s", "longitudinal speed of the centre of gravity in body axes", _KMH),
        _signal(block, "lateral_speed", "m/s", "lateral speed of the centre of gravity in body axes"),
        _signal(block, "position_x", "m", "position of the centre of gravity, road axes"),
        _signal(block, "position_y", "m", "position of the centre of gravity, road axes"),
        _signal(block, "distance", "m", "path length driven"),
        _signal(block, "yaw_angle", "rad", "yaw angle, positive to the left"),
        _signal(block, "roll_angle", "rad", "roll angle of the body"),
        _signal(block, "pitch_angle", "rad", "pitch angle of the body, positive nose down"),
        _signal(block, "true_yaw_rate", "rad/s", "yaw rate", _DEG_S),
        _signal(block, "true_roll_rate", "rad/s", "roll rate", _DEG_S),
        _signal(block, "true_pitch_rate", "rad/s", "pitch rate", _DEG_S),
        _signal(block, "true_longitudinal_acceleration", "m/s^2", "acceleration of the centre of gravity, body x"),
        _signal(block, "true_lateral_acceleration", "m/s^2", "acceleration of the centre of gravity, body y"),
        _signal(block, "true_vertical_acceleration", "m/s^2", "acceleration of the centre of gravity, body z"),
        _signal(block, "side_slip_angle", "rad", "side-slip angle of the centre of gravity"),
        *_wheels(block, "true_wheel_speed", "rad/s", "rotational speed of the wheel"),
        *_wheels(block, "wheel_centre_speed", "m/s", "speed of the wheel centre along the wheel plane"),
        *_wheels(block, "slip_ratio", "1", "longitudinal slip (R w - v)/max(R w, v), locked is -1"),
        *_wheels(block, "slip_angle", "rad", "slip angle of the tyre"),
        *_wheels(block, "vertical_load", "N", "vertical tyre load"),
        *_wheels(block, "longitudinal_force", "N", "longitudinal tyre force, driving positive"),
        *_wheels(block, "lateral_force", "N", "lateral tyre force, positive to the left"),
        *_wheels(block, "friction_used", "1", "longitudinal tyre force over vertical load"),
        *_wheels(block, "friction_limit", "1", "largest longitudinal friction coefficient at the wheel's position"),
        *_wheels(block, "true_road_wheel_angle", "rad", "steering angle of the road wheel"),
        *_wheels(block, "suspension_travel", "m", "suspension travel, compression positive"),
        *_wheels(block, "true_brake_torque", "N m", "brake torque that acts on the wheel"),
        *_wheels(block, "true_drive_torque", "N m", "drive torque that acts on the wheel"),
        _signal(block, "mechanical_energy", "J", "kinetic and potential energy of the car"),
        _signal(
            block, "dissipated_energy", "J", "energy lost in brakes, tyres, drag, rolling, dampers since the start"
        ),
        _signal(block, "drive_energy", "J", "work done by the drive torques since the start"),
        _signal(block, "road_grade", "1", "rise over run of the road at the car, uphill positive", ("%", 100.0)),
        _signal(block, "road_bank", "1", "rise over run across the road, left side higher is positive", ("%", 100.0)),
    ]


def _powertrain() -> list[Signal]:
    return [
        _signal("powertrain", "true_engine_speed", "rad/s", "engine speed"),
        _signal("powertrain", "true_engine_torque", "N m", "engine torque"),
        *_wheels("powertrain", "drive_torque_demand", "N m", "drive torque at the wheel"),
    ]


def _bus() -> list[Signal]:
    block = "bus"
    return [
        *_wheels(block, "wheel_speed", "rad/s", "wheel speed as decoded from the bus"),
        *_wheels(block, "wheel_edge_count", "1", "tone-ring edge counter, modulo 65536"),
        *_wheels(block, "wheel_edge_time", "s", "time of the last tone-ring edge, wrapping"),
        _signal(block, "longitudinal_acceleration", "m/s^2", "accelerometer x"),
        _signal(block, "lateral_acceleration", "m/s^2", "accelerometer y"),
        _signal(block, "vertical_acceleration", "m/s^2", "accelerometer z, gravity removed"),
        _signal(block, "yaw_rate", "rad/s", "gyroscope z", _DEG_S),
        _signal(block, "roll_rate", "rad/s", "gyroscope x", _DEG_S),
        _signal(block, "pitch_rate", "rad/s", "gyroscope y", _DEG_S),
        _signal(block, "pedal_force", "N", "brake pedal force"),
        _signal(block, "brake_switch", "1", "brake light switch"),
        _signal(block, "master_pressure", "Pa", "master-cylinder pressure"),
        *_wheels(block, "brake_pressure", "Pa", "reported wheel brake pressure"),
        _signal(block, "engine_torque", "N m", "engine torque"),
        _signal(block, "engine_speed", "rad/s", "engine speed"),
        _signal(block, "gearbox_speed", "rad/s", "gearbox output speed"),
        _signal(block, "gear", "1", "selected gear"),
        _signal(block, "drive_torque_f", "N m", "drive torque of the front axle"),
        _signal(block, "drive_torque_r", "N m", "drive torque of the rear axle"),
        _signal(block, "steering_wheel_angle", "rad", "steering-wheel angle, positive to the left"),
        _signal(block, "steering_command", "rad", "commanded road-wheel angle"),
        _signal(block, "road_wheel_angle", "rad", "mean road-wheel angle of the front wheels, positive to the left"),
        _signal(block, "ignition", "1", "1 while the ignition is on"),
        *_wheels(block, "valve_inlet", "1", "inlet valve energised (closed)"),
        *_wheels(block, "valve_outlet", "1", "outlet valve energised (open)"),
        _signal(block, "pump", "1", "return pump on"),
        _signal(block, "abs_active", "1", "ABS control active"),
        _signal(block, "abs_lamp", "1", "ABS warning lamp"),
        _signal(block, "ebd_active", "1", "electronic brake-force distribution active"),
        _signal(block, "ecu_fault_code", "1", "first active fault of the ECU, 0 is none"),
        _signal(block, "ecu_reference_speed", "m/s", "reference speed of the ECU", _KMH),
        *_wheels(block, "ecu_phase", "1", "phase of the ECU: 0 off, 1 build-up, 2 hold, 3 release, 4 stepped rebuild"),
    ]


def _bus_ages() -> list[Signal]:
    groups = ("wheel_speed", "wheel_edges", "inertial", "brake", "wheel_pressure", "powertrain", "vehicle_status")
    ages = [_signal("bus_age", f"age_{g}", "s", f"age of the last accepted {g} frame") for g in groups]
    ages.append(_signal("bus_age", "age_valve_pump", "s", "age of the last accepted valve and pump frame"))
    ages.append(_signal("bus_age", "age_abs_status", "s", "age of the last accepted ABS status frame"))
    return ages


def _timing() -> list[Signal]:
    block = "timing"
    return [
        _signal(block, "bus_load", "1", "share of bus time in use, last 100 ms", ("%", 100.0)),
        _signal(block, "lateness", "s", "start of the tick after its deadline", ("us", 1e6)),
        _signal(block, "tick_cpu_time", "s", "processor time of the tick", ("us", 1e6)),
        _signal(block, "overruns", "1", "ticks that ended after the next deadline, so far"),
        _signal(block, "faults_active", "1", "stimuli and faults that are active"),
    ]


@cache
def catalogue() -> tuple[Signal, ...]:
    """Every signal of a run, in the order of the signal vector."""
    return tuple(_clock() + _driver() + _hydraulics() + _powertrain() + _plant() + _bus() + _bus_ages() + _timing())


@cache
def names() -> tuple[str, ...]:
    """Names in the order of the signal vector."""
    return tuple(signal.name for signal in catalogue())


@cache
def index_of(name: str) -> int:
    """Position of a signal in the vector.

    Raises
    ------
    KeyError
        If the catalogue has no such signal.
    """
    try:
        return names().index(name)
    except ValueError:
        raise KeyError(name) from None


@cache
def block_slice(block: str) -> slice:
    """Consecutive entries of the vector that one part of the bench writes."""
    positions = [i for i, signal in enumerate(catalogue()) if signal.block == block]
    if not positions:
        raise KeyError(block)
    return slice(positions[0], positions[-1] + 1)
