"""Sensors of the car: from the simulated values to what the bench puts into its frames.

The model is told in docs/models/sensors.md.
"""

import math

import numpy as np
from numpy.typing import NDArray

from signals.catalogue import block_slice, index_of
from signals.quantities import FileModel
from signals.record_memory import numbers_address
from signals.wheels import WHEELS
from vehicle_model import parameters
from vehicle_model import sensors_record as record
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.sensors_step import (
    ADDRESSES,
    AT_CONTACTS,
    AT_EDGES,
    AT_NOISE,
    AT_PARAMETERS,
    AT_SENSED,
    AT_STATE,
    AT_VALUES,
    DRAWN_TICKS,
    RANDOM_NUMBERS,
    sensors_step,
)
from vehicle_model.tone_ring import HISTORY_TICKS, MOST_TEETH, TURN, edge_angles
from vehicle_model.vehicle_file import VehicleFile

_TONE_RINGS, _NOISE, _CONTACTS = 1, 2, 3
_SOURCES = {
    "cluster_can": record.SENSOR,
    "noisy": record.SENSOR,
    "noise_free": record.NOISE_FREE,
    "ideal": record.IDEAL,
}
_OF_THE_EDGES = tuple(f"sensors.wheel_speed.{name}" for name in ("teeth", "pitch_error", "eccentricity"))
_CHANNEL_FIELDS = (
    "scale",
    "offset",
    "noise",
    "resolution",
    "drift",
    "stuck",
    "dropout_rate",
    "dropout_duration",
)
_CHANNEL_SECTIONS = (
    *record.CHANNEL_SIGNALS[: record.BRAKE_PRESSURE],
    *(4 * ("brake_pressure",)),
    "pedal_force",
    "steering_wheel_angle",
)
_OF_THE_CAR = ("driveline.final_drive", "driveline.front_share", "steering.ratio")
"""Parameters of other sections that the sensors' signals follow."""


class Sensors:
    """Every sensor of a car.

    Parameters
    ----------
    vehicle : VehicleFile
        A copy is kept; later changes go through ``set``.
    seed : int
        Seed of the run. The rings' errors and the noise of each channel have a generator each, so that noise on one
        channel leaves the others' as it is.

    Attributes
    ----------
    address : int
        Of the memory that `sensors_step` works on, for compiled callers.
    """

    def __init__(self, vehicle: VehicleFile, seed: int = 0) -> None:
        self._vehicle = vehicle.model_copy(deep=True)
        self._sensors = self._vehicle.sensors
        self._seed = seed
        self._parameters: NDArray[np.void] = np.zeros(1, record.PARAMETER_RECORD)
        self._state: NDArray[np.void] = np.zeros(1, record.STATE_RECORD)
        self._noise = np.zeros((RANDOM_NUMBERS, DRAWN_TICKS))
        self._contacts = np.ones((RANDOM_NUMBERS, DRAWN_TICKS))
        self._values = self._sensed = np.zeros(0)
        self._addresses = np.zeros(ADDRESSES, np.int64)
        self.address = int(self._addresses.ctypes.data)
        for place, array in (
            (AT_PARAMETERS, self._parameters),
            (AT_STATE, self._state),
            (AT_NOISE, self._noise),
            (AT_CONTACTS, self._contacts),
        ):
            self._addresses[place] = array.ctypes.data
        self._fill_places()
        self._fill_car()
        self.reset()

    def reset(self) -> None:
        """Back to the start of the run, with the same random numbers."""
        self._state[:] = np.zeros(1, record.STATE_RECORD)
        self._generators = [np.random.default_rng([self._seed, _NOISE, k]) for k in range(record.CHANNELS + 4)]
        self._contact_generators = [
            np.random.default_rng([self._seed, _CONTACTS, k]) for k in range(record.CHANNELS + 4)
        ]
        rings = np.random.default_rng([self._seed, _TONE_RINGS])
        self._tooth_errors = rings.standard_normal((4, MOST_TEETH))
        self._directions = rings.uniform(0.0, TURN, 4)
        self._state[0]["angle"] = rings.uniform(0.0, TURN, 4)
        # long past: the first edge is not the second of a pair
        self._state[0]["edge_time"] = self._state[0]["time_history"] = -1e3
        self._row = self._contact_row = DRAWN_TICKS
        self._noisy: list[int] = []
        self._loose: list[int] = []
        self._fill()

    def tick(self, values: NDArray[np.float64], time_s: float, sensed: NDArray[np.float64]) -> None:
        """Advance by 1 ms.

        Parameters
        ----------
        values
            The signal vector after the plant's tick.
        time_s
            Start of the tick.
        sensed
            Layout of block "bus"; what comes from the ECU is left alone.
        """
        self.draw()
        if values is not self._values or sensed is not self._sensed:
            self.bind(values, sensed)
        sensors_step(self.address, time_s)

    def draw(self) -> None:
        """The first part of a tick: have random numbers for it."""
        if self._row == DRAWN_TICKS:
            self._draw()
        if self._contact_row == DRAWN_TICKS:
            self._draw_contacts()
        self._row += 1
        self._contact_row += 1

    def bind(self, values: NDArray[np.float64], sensed: NDArray[np.float64]) -> None:
        """Use these arrays from now on: the same come tick by tick, so their addresses are kept."""
        self._addresses[AT_VALUES] = numbers_address(values, values.size)
        self._addresses[AT_SENSED] = numbers_address(sensed, sensed.size)
        self._values, self._sensed = values, sensed

    def _draw(self) -> None:
        """Draw the noise of the coming ticks, only for channels that have some."""
        self._noise[:] = 0.0
        for channel in self._noisy:
            self._generators[channel].standard_normal(out=self._noise[channel])
        self._row = 0
        self._state[0]["row"] = 0

    def _draw_contacts(self) -> None:
        """Draw for the loose contacts; every other contact keeps numbers that never open it."""
        self._contacts[:] = 1.0
        for channel in self._loose:
            self._contact_generators[channel].random(out=self._contacts[channel])
        self._contact_row = 0
        self._state[0]["contact_row"] = 0

    def names(self) -> tuple[str, ...]:
        """Dotted paths of all parameters (``sensors.yaw_rate.offset``) and of those of the car that signals follow."""
        return (*parameters.numbers(self._sensors, "sensors."), *_OF_THE_CAR)

    def get(self, path: str) -> float:
        """Value of one parameter, SI; InputError if there is none of that path."""
        model, prefix = self._owner(path)
        return parameters.get_parameter(model, path, prefix)

    def set(self, path: str, value: float) -> None:
        """Change one parameter from the next tick on; InputError if there is none or the value is out of range."""
        model, prefix = self._owner(path)
        parameters.set_parameter(model, path, value, prefix)
        if path in _OF_THE_CAR:
            self._fill_car()
        else:
            self._fill(path)

    def _owner(self, path: str) -> tuple[FileModel, str]:
        section = path.partition(".")[0] if path in _OF_THE_CAR else "sensors"
        return getattr(self._vehicle, section), f"{section}."

    def _fill_places(self) -> None:
        row, bus = self._parameters[0], block_slice("bus").start
        for name in record.INPUT_SIGNALS:
            row[name] = index_of(name)
        for name in record.OUTPUT_SIGNALS:
            row[f"to_{name}"] = index_of(name) - bus
        row["to_channel"] = [index_of(name) - bus for name in record.CHANNEL_SIGNALS]

    def _fill_car(self) -> None:
        row, line = self._parameters[0], self._vehicle.driveline
        row["final_drive"] = line.final_drive
        row["wheel_share"] = line.wheel_share()
        row["steering_ratio"] = self._vehicle.steering.ratio

    def _fill(self, changed: str = "") -> None:
        """Write the parameters into the record; what ``changed`` cannot touch and takes long to compute is left."""
        row, sensors = self._parameters[0], self._sensors
        row["acceleration_source"] = _SOURCES[sensors.acceleration_source]
        for channel, name in enumerate(_CHANNEL_SECTIONS):
            sensor = getattr(sensors, name)
            for field in _CHANNEL_FIELDS:
                row[field][channel] = getattr(sensor, field)
            row["delay_ticks"][channel] = sensor.delay / TIME_STEP_S
        self._fill_pressure_faults()
        if sensors.acceleration_source == "noisy":
            own = sensors.longitudinal_acceleration.noise
            row["noise"][record.ACCELERATION_X] = math.hypot(own, sensors.noisy_acceleration)
        unit = sensors.inertial
        row["place"] = unit.position_x, unit.position_y, unit.position_z
        if not changed or changed.startswith("sensors.inertial."):
            row["transition"], row["entry"] = low_pass_matrices(unit.cut_off_frequency, unit.damping_ratio)
        row["mounting"] = unit.mounting_roll, unit.mounting_pitch, unit.mounting_yaw
        row["brake_switch_force"] = sensors.brake_switch_force
        self._fill_rings()
        if not changed or changed in _OF_THE_EDGES:
            self._place_edges()
        noisy = [int(channel) for channel in np.flatnonzero(row["noise"])]
        if row["edge_jitter"] > 0.0:
            noisy += range(record.CHANNELS, record.CHANNELS + 4)
        loose = [int(channel) for channel in np.flatnonzero(row["dropout_rate"])]
        if loose != self._loose:
            self._loose, self._contact_row = loose, DRAWN_TICKS
        if noisy != self._noisy:
            self._noisy, self._row = noisy, DRAWN_TICKS

    def _fill_pressure_faults(self) -> None:
        row = self._parameters[0]
        for wheel, name in enumerate(WHEELS):
            fault, channel = getattr(self._sensors.brake_pressure, name), record.BRAKE_PRESSURE + wheel
            row["scale"][channel] *= fault.scale
            for field in ("offset", "drift", "dropout_rate"):
                row[field][channel] += getattr(fault, field)
            row["stuck"][channel] = max(row["stuck"][channel], fault.stuck)

    def _fill_rings(self) -> None:
        row, ring = self._parameters[0], self._sensors.wheel_speed
        row["teeth"], row["pitch"] = ring.teeth, TURN / ring.teeth
        row["timer_resolution"], row["edge_jitter"] = ring.timer_resolution, ring.edge_jitter
        row["window_ticks"] = min(max(round(ring.window / TIME_STEP_S), 1), HISTORY_TICKS - 1)
        row["standstill_timeout"] = ring.standstill_timeout
        row["ring_radius"], row["threshold_speed"] = ring.ring_radius, ring.threshold_speed
        for wheel, name in enumerate(WHEELS):
            row["missing_teeth"][wheel] = getattr(ring, f"missing_teeth_{name}")
            row["air_gap"][wheel] = getattr(ring, f"air_gap_{name}")
            row["connected"][wheel] = round(getattr(ring, f"connected_{name}"))
            row["ring_scale"][wheel] = getattr(ring, f"scale_{name}")
            for field in ("stuck", "dropout_rate"):
                row[field][record.CHANNELS + wheel] = getattr(ring, f"{field}_{name}")
            row["dropout_duration"][record.CHANNELS + wheel] = ring.dropout_duration

    def _place_edges(self) -> None:
        ring = self._sensors.wheel_speed
        self._edges = np.array(
            [
                edge_angles(ring.teeth, ring.pitch_error, ring.eccentricity, errors, direction)
                for errors, direction in zip(self._tooth_errors, self._directions, strict=True)
            ]
        )
        self._addresses[AT_EDGES] = self._edges.ctypes.data
        state = self._state[0]
        for wheel in range(4):
            state["next_edge"][wheel] = np.searchsorted(self._edges[wheel], state["angle"][wheel], "right") % ring.teeth


def low_pass_matrices(
    cut_off_frequency_hz: float, damping_ratio: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Exact transition of x'' + 2 d w x' + w^2 x = w^2 u over a tick with constant u.

    Parameters
    ----------
    cut_off_frequency_hz
        Frequency at which the magnitude is 1/sqrt(2), whatever the damping.
    damping_ratio
        d of the second-order low-pass.

    Returns
    -------
    transition : shape (2, 2)
        Of (x, x').
    entry : shape (2,)
        Of the input.
    """
    from scipy.linalg import expm

    square = damping_ratio**2
    # w_3dB/w of a second-order low-pass
    ratio = math.sqrt(1.0 - 2.0 * square + math.sqrt(4.0 * square * square - 4.0 * square + 2.0))
    natural = TURN * cut_off_frequency_hz / ratio
    system = np.array([[0.0, 1.0, 0.0], [-(natural**2), -2.0 * damping_ratio * natural, natural**2], [0.0, 0.0, 0.0]])
    step = expm(system * TIME_STEP_S)
    return step[:2, :2], step[:2, 2]
