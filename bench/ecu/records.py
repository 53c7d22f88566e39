"""Records that the compiled controller works on: calibration, memory, and the places of signals on the bus."""

import numpy as np
from numpy.typing import NDArray

from bench.ecu.calibration import AxleSlip, CalibrationFile
from signals.catalogue import block_slice, names

TASK_S = 0.005
TASK_TICKS = 5
TASK_OFFSET_TICKS = 4
"""The task runs after all messages of its cycle have arrived and before the valve frame is due."""

# phases of a wheel, as reported on the diagnostics channel
OFF, BUILD_UP, WAIT, RELEASE, REBUILD = range(5)

WINDOW = 8
"""Edge readings kept per wheel."""

SOURCES = (
    "wheel_speed_front",
    "wheel_speed_rear",
    "wheel_edges_fl",
    "wheel_edges_fr",
    "wheel_edges_rl",
    "wheel_edges_rr",
    "brake",
    "vehicle_status",
    "inertial",
)
"""Messages that the ECU watches, in the order of every array about them."""
SPEED_FRONT, SPEED_REAR, EDGES_FL, EDGES_FR, EDGES_RL, EDGES_RR, BRAKE, STATUS, INERTIAL = range(len(SOURCES))

# columns of the health of a source
AGE_TICKS, REJECTED, PERIOD_TICKS, PRESENT = range(4)

_BUS = names()[block_slice("bus")]


def bus_position(name: str) -> int:
    """Position of a signal in an array with the layout of block "bus"."""
    return _BUS.index(name)


BUS_SIGNALS = len(_BUS)

_FLOAT_STATE = (
    # wheels, from pulses
    *((name, 4) for name in ("edge_count", "edge_time", "elapsed", "wheel_speed", "path_speed", "acceleration")),
    ("previous_speed", 4),
    ("raw_acceleration", 4),
    ("slowest_wheel", 1),
    ("yaw_rate", 1),
    # reference
    *((name, 1) for name in ("reference", "previous_reference", "predicted_acceleration", "learned_acceleration")),
    *((name, 1) for name in ("bias", "anchor_speed", "anchor_age")),
    ("late_deficit", 4),
    # pressures as the controller imagines them
    ("master_pressure", 1),
    ("pressure", 4),
    ("road_pressure", 4),
    ("release_start", 4),
    ("goal", 4),
    # slip control
    *((name, 4) for name in ("predicted_slip_speed", "release_level", "end_level", "build_level", "entry_level")),
    ("split_difference", 1),
)
_INTEGER_STATE = (
    ("have_edges", 4),
    ("silent_tasks", 4),
    ("window_fill", 4),
    ("window_position", 4),
    ("rolling_tasks", 4),
    ("free_tasks", 4),
    ("phase", 4),
    ("timer", 4),
    ("pulses", 4),
    ("calm_tasks", 4),
    ("was_rising", 4),
    ("returning_tasks", 4),
    ("since_pulse", 4),
    ("bleeding", 4),
    ("recovering", 4),
    ("inlet", 4),
    ("outlet", 4),
    ("braking", 1),
    ("abs_active", 1),
    ("ebd_active", 1),
    ("pump_tasks", 1),
    ("underbraked_wheel", 1),
    ("underbraking_tasks", 1),
    ("next_underbraked", 1),
    ("inertial_ok", 1),
    ("started", 1),
    # input watching
    ("age_tasks", 1),
    ("ignition", 1),
    ("healthy_tasks", 1),
    ("abs_available", 1),
    ("ebd_available", 1),
    ("lamp", 1),
    ("first_fault", 1),
    ("wheel_valid", 4),
    ("stopped_tasks", 4),
    ("contradiction_tasks", 4),
    ("jump_tasks", 4),
    ("pedal_tasks", 1),
    ("inertial_tasks", 1),
    ("fresh", 4),
    ("rejected_before", len(SOURCES)),
    ("rejected_run", len(SOURCES)),
    ("seen", len(SOURCES)),
)
FAULT_CODES = 64
"""Size of the fault memory; codes are below it."""


def _field(name: str, kind: str, size: int) -> tuple[str, str] | tuple[str, str, tuple[int, ...]]:
    return (name, kind) if size == 1 else (name, kind, (size,))


STATE_RECORD = np.dtype(
    [
        *(_field(name, "f8", size) for name, size in _FLOAT_STATE),
        ("window_angle", "f8", (4, WINDOW)),
        ("window_time", "f8", (4, WINDOW)),
        *(_field(name, "i8", size) for name, size in _INTEGER_STATE),
        ("fault_present", "i8", (FAULT_CODES,)),
        ("fault_stored", "i8", (FAULT_CODES,)),
    ]
)

_SECTIONS = (
    "car",
    "wheel_speed",
    "reference",
    "pressure",
    "split",
    "distribution",
    "limits",
    "monitoring",
)


def _calibration_fields() -> list[tuple[str, str] | tuple[str, str, tuple[int, ...]]]:
    fields = []
    for section in _SECTIONS:
        model = CalibrationFile.model_fields[section].annotation
        fields += [_field(f"{section}_{name}", "f8", 1) for name in getattr(model, "model_fields", {})]
    fields += [_field(f"slip_{name}", "f8", 2) for name in AxleSlip.model_fields]
    return [*fields, ("slip_rear_select_low", "f8"), ("slip_turn_reduction", "f8"), ("wheel_radius", "f8", (4,))]


CALIBRATION_RECORD = np.dtype(_calibration_fields())


def calibration_record(calibration: CalibrationFile) -> NDArray[np.void]:
    """Calibration as the compiled controller reads it: ``<section>_<field>``, slip thresholds by axle."""
    record: NDArray[np.void] = np.zeros(1, CALIBRATION_RECORD)
    for section in _SECTIONS:
        for name, value in getattr(calibration, section):
            record[f"{section}_{name}"] = float(value)
    for name in AxleSlip.model_fields:
        record[f"slip_{name}"] = (getattr(calibration.slip.front, name), getattr(calibration.slip.rear, name))
    record["slip_rear_select_low"] = float(calibration.slip.rear_select_low)
    record["slip_turn_reduction"] = calibration.slip.turn_reduction
    car = calibration.car
    record["wheel_radius"] = (car.front_wheel_radius,) * 2 + (car.rear_wheel_radius,) * 2
    return record
