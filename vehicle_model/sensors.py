"""Sensors of the car: from the simulated values to what the bench puts into its frames.

The model is told in docs/models/sensors.md.
"""

import math

import numpy as np
from numpy.typing import NDArray

from signals.catalogue import block_slice, index_of
from vehicle_model import parameters
from vehicle_model import sensors_record as record
from vehicle_model.interface import TIME_STEP_S
from vehicle_model.sensors_step import sensors_step
from vehicle_model.tone_ring import HISTORY_TICKS, MOST_TEETH, TURN, edge_angles
from vehicle_model.vehicle_file import VehicleFile

# ticks that noise is drawn for in advance: few, so that no tick has to draw for long
_NOISE_ROWS = 64
_TONE_RINGS, _NOISE = 1, 2
_SOURCES = {"sensor": record.SENSOR, "noise_free": record.NOISE_FREE, "ideal": record.IDEAL}
_CHANNEL_SECTIONS = (
    *record.CHANNEL_SIGNALS[: record.BRAKE_PRESSURE],
    *(4 * ("brake_pressure",)),
    "pedal_force",
    "steering_wheel_angle",
)


class Sensors:
    """Every sensor of a car.

    Parameters
    ----------
    vehicle : VehicleFile
        Its section ``sensors`` is copied; later changes go through ``set``.
    seed : int
        Seed of the run. The rings' errors and the noise of each channel have a generator each, so that noise on one
        channel leaves the others' as it is.
    """

    def __init__(self, vehicle: VehicleFile, seed: int = 0) -> None:
        self._sensors = vehicle.sensors.model_copy(deep=True)
        self._seed = seed
        self._parameters: NDArray[np.void] = np.zeros(1, record.PARAMETER_RECORD)
        self._state: NDArray[np.void] = np.zeros(1, record.STATE_RECORD)
        self._noise = np.zeros((_NOISE_ROWS, record.CHANNELS + 4))
        self._fill_places()
        self._fill_car(vehicle)
        self.reset()

    def reset(self) -> None:
        """Back to the start of the run, with the same random numbers."""
        self._state[:] = np.zeros(1, record.STATE_RECORD)
        self._generators = [np.random.default_rng([self._seed, _NOISE, k]) for k in range(record.CHANNELS + 4)]
        rings = np.random.default_rng([self._seed, _TONE_RINGS])
        self._tooth_errors = rings.standard_normal((4, MOST_TEETH))
        self._directions = rings.uniform(0.0, TURN, 4)
        self._state[0]["angle"] = rings.uniform(0.0, TURN, 4)
        # long past: the first edge is not the second of a pair
        self._state[0]["edge_time"] = self._state[0]["time_history"] = -1e3
        self._row = _NOISE_ROWS
        self._noisy: list[int] = []
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
        if self._row == _NOISE_ROWS:
            self._draw()
        self._row += 1
        sensors_step(self._parameters, self._state, self._edges, self._noise, values, sensed, time_s)

    def _draw(self) -> None:
        """Draw the noise of the coming ticks, only for channels that have some."""
        self._noise[:] = 0.0
        for channel in self._noisy:
            self._noise[:, channel] = self._generators[channel].standard_normal(_NOISE_ROWS)
        self._row = 0
        self._state[0]["row"] = 0

    def names(self) -> tuple[str, ...]:
        """Dotted paths of all parameters (``sensors.yaw_rate.offset``)."""
        return tuple(parameters.numbers(self._sensors, "sensors."))

    def get(self, path: str) -> float:
        """Value of one parameter, SI; InputError if there is none of that path."""
        return parameters.get_parameter(self._sensors, path, "sensors.")

    def set(self, path: str, value: float) -> None:
        """Change one parameter from the next tick on; InputError if there is none or the value is out of range."""
        parameters.set_parameter(self._sensors, path, value, "sensors.")
        self._fill(rings=path.startswith("sensors.wheel_speed."))

    def _fill_places(self) -> None:
        row, bus = self._parameters[0], block_slice("bus").start
        for name in record.INPUT_SIGNALS:
            row[name] = index_of(name)
        for name in record.OUTPUT_SIGNALS:
            row[f"to_{name}"] = index_of(name) - bus
        row["to_channel"] = [index_of(name) - bus for name in record.CHANNEL_SIGNALS]

    def _fill_car(self, vehicle: VehicleFile) -> None:
        row, line = self._parameters[0], vehicle.driveline
        row["final_drive"] = line.final_drive
        front = {"front": 1.0, "rear": 0.0, "all": line.front_share}[line.drive]
        row["wheel_share"] = (front / 2.0, front / 2.0, (1.0 - front) / 2.0, (1.0 - front) / 2.0)
        row["steering_ratio"] = vehicle.steering.ratio

    def _fill(self, *, rings: bool = True) -> None:
        row, sensors = self._parameters[0], self._sensors
        row["acceleration_source"] = _SOURCES[sensors.acceleration_source]
        for channel, name in enumerate(_CHANNEL_SECTIONS):
            sensor = getattr(sensors, name)
            for field in ("scale", "offset", "noise", "resolution"):
                row[field][channel] = getattr(sensor, field)
            row["delay_ticks"][channel] = sensor.delay / TIME_STEP_S
        unit = sensors.inertial
        row["place"] = unit.position_x, unit.position_y, unit.position_z
        row["transition"], row["entry"] = low_pass_matrices(unit.cut_off_frequency, unit.damping_ratio)
        row["brake_switch_force"] = sensors.brake_switch_force
        if rings:
            self._fill_rings()
        noisy = [int(channel) for channel in np.flatnonzero(row["noise"])]
        if row["edge_jitter"] > 0.0:
            noisy += range(record.CHANNELS, record.CHANNELS + 4)
        if noisy != self._noisy:
            self._noisy, self._row = noisy, _NOISE_ROWS

    def _fill_rings(self) -> None:
        row, ring = self._parameters[0], self._sensors.wheel_speed
        row["teeth"], row["pitch"] = ring.teeth, TURN / ring.teeth
        row["timer_resolution"], row["edge_jitter"] = ring.timer_resolution, ring.edge_jitter
        row["window_ticks"] = min(max(round(ring.window / TIME_STEP_S), 1), HISTORY_TICKS - 1)
        row["standstill_timeout"] = ring.standstill_timeout
        self._edges = np.array(
            [
                edge_angles(ring.teeth, ring.pitch_error, ring.eccentricity, errors, direction)
                for errors, direction in zip(self._tooth_errors, self._directions, strict=True)
            ]
        )
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
