"""What the sensor effects do to signals, and their columns of the sensitivity matrix without any simulation.

``measured_signals`` turns true signals into what the sensors report, ``sensor_columns`` is its derivative, and
``true_inputs`` turns reported inputs into those that drive the replay. Deviations are given by column,
``<effect>.<parameter>``; a missing one is neutral, and neutral deviations leave every array bit-identical.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

_AXES = {"longitudinal": "longitudinal_acceleration", "lateral": "lateral_acceleration"}

ACCELERATION_COLUMNS = ("accelerometer_offset.longitudinal", "accelerometer_scale.longitudinal")
PRESSURE_LAG = "pressure_sensor_lag.time_constant"
PRESSURE_COLUMNS = ("pressure_sensor_scale.wheels", "pressure_sensor_offset.wheels", PRESSURE_LAG)
"""Columns that change what drives a replay; the acceleration drives it only where a force was not measured."""


def measured_signals(
    deviations: Mapping[str, float], signals: Sequence[str], true: FloatArray, ring_carriers: FloatArray | None = None
) -> FloatArray:
    """What the sensors report of true signals.

    Parameters
    ----------
    deviations : column -> deviation
    signals : names of the c columns of ``true``
    true : (n, c), or (n, c, k) of k cars, in the catalogue's units
    ring_carriers : (n, 4) of ``ring_carriers``; needed only for tone_ring_error

    Returns
    -------
    array as ``true``; ``true`` itself where every deviation is neutral
    """
    active = {column: value for column, value in deviations.items() if value != 0.0}
    if not active:
        return true
    place = {name: k for k, name in enumerate(signals)}
    reported = true.copy()
    _misalign(active.get("accelerometer_misalignment.angle", 0.0), place, reported)
    for axis, name in _AXES.items():
        _scale_and_offset(
            reported, place.get(name), active, f"accelerometer_scale.{axis}", f"accelerometer_offset.{axis}"
        )
    _scale_and_offset(reported, place.get("yaw_rate"), active, "gyro_scale.yaw_rate", "gyro_offset.yaw_rate")
    for k, wheel in enumerate(WHEELS):
        amplitude = active.get(f"tone_ring_error.{wheel}", 0.0)
        column = place.get(f"wheel_speed_{wheel}")
        if amplitude != 0.0 and column is not None and ring_carriers is not None:
            reported[:, column] *= (1.0 + amplitude * ring_carriers[:, k]).reshape(-1, *[1] * (true.ndim - 2))
    return reported


def _misalign(angle: float, place: Mapping[str, int], reported: FloatArray) -> None:
    x, y = place.get("longitudinal_acceleration"), place.get("lateral_acceleration")
    if angle == 0.0 or x is None or y is None:
        return
    forward, left = reported[:, x].copy(), reported[:, y].copy()
    reported[:, x] = forward * np.cos(angle) + left * np.sin(angle)
    reported[:, y] = left * np.cos(angle) - forward * np.sin(angle)


def _scale_and_offset(
    reported: FloatArray, column: int | None, active: Mapping[str, float], scale: str, offset: str
) -> None:
    if column is not None:
        reported[:, column] = reported[:, column] * (1.0 + active.get(scale, 0.0)) + active.get(offset, 0.0)


def sensor_columns(
    deviations: Mapping[str, float], signals: Sequence[str], true: FloatArray, ring_carriers: FloatArray | None = None
) -> dict[str, FloatArray]:
    """Derivatives of ``measured_signals`` by every deviation of an ``Application.SENSOR`` effect.

    Arguments as in ``measured_signals``; ``true`` are the signals before the sensors.

    Returns
    -------
    column -> (n, c); effects whose signal is not among ``signals`` have zeros
    """
    place = {name: k for k, name in enumerate(signals)}
    angle = deviations.get("accelerometer_misalignment.angle", 0.0)
    turned = true.copy()
    _misalign(angle, place, turned)
    columns: dict[str, FloatArray] = {}
    for axis, name in _AXES.items():
        columns[f"accelerometer_offset.{axis}"] = _single(true, place.get(name), 1.0)
        columns[f"accelerometer_scale.{axis}"] = _single(true, place.get(name), _column(turned, place.get(name)))
    columns["accelerometer_misalignment.angle"] = _misalignment_column(deviations, angle, place, true)
    columns["gyro_offset.yaw_rate"] = _single(true, place.get("yaw_rate"), 1.0)
    columns["gyro_scale.yaw_rate"] = _single(true, place.get("yaw_rate"), _column(true, place.get("yaw_rate")))
    for k, wheel in enumerate(WHEELS):
        column = place.get(f"wheel_speed_{wheel}")
        carrier = 0.0 if ring_carriers is None else ring_carriers[:, k]
        columns[f"tone_ring_error.{wheel}"] = _single(true, column, _column(true, column) * carrier)
    return columns


def _column(values: FloatArray, column: int | None) -> FloatArray | float:
    return 0.0 if column is None else values[:, column]


def _single(like: FloatArray, column: int | None, values: FloatArray | float) -> FloatArray:
    derivative = np.zeros_like(like)
    if column is not None:
        derivative[:, column] = values
    return derivative


def _misalignment_column(
    deviations: Mapping[str, float], angle: float, place: Mapping[str, int], true: FloatArray
) -> FloatArray:
    x, y = place.get("longitudinal_acceleration"), place.get("lateral_acceleration")
    derivative = np.zeros_like(true)
    if x is None or y is None:
        return derivative
    forward, left = true[:, x], true[:, y]
    scale_x = 1.0 + deviations.get("accelerometer_scale.longitudinal", 0.0)
    scale_y = 1.0 + deviations.get("accelerometer_scale.lateral", 0.0)
    derivative[:, x] = scale_x * (left * np.cos(angle) - forward * np.sin(angle))
    derivative[:, y] = -scale_y * (forward * np.cos(angle) + left * np.sin(angle))
    return derivative


def ring_carriers(time: FloatArray, wheel_speeds: FloatArray) -> FloatArray:
    """Once-per-turn carriers cos(phi − phi_0) of the four wheels, their phase read from the measured speeds.

    phi is the integral of the measured speed; phi_0 is where the speed's fast part (what a moving mean over one turn
    leaves) correlates with it. A speed of zero throughout gives zeros.

    Parameters
    ----------
    time : (n,) [s], equal steps
    wheel_speeds : (n, 4) measured [rad/s]
    """
    step = float(time[1] - time[0])
    angle = np.cumsum(wheel_speeds, axis=0) * step
    carriers = np.zeros_like(wheel_speeds)
    for k in range(wheel_speeds.shape[1]):
        speed = wheel_speeds[:, k]
        mean_speed = float(np.mean(np.abs(speed)))
        if mean_speed == 0.0:
            continue
        window = max(3, round(2.0 * np.pi / mean_speed / step) | 1)
        fast = speed - np.convolve(np.pad(speed, window // 2, mode="edge"), np.full(window, 1.0 / window), "valid")
        cosine, sine = np.cos(angle[:, k]), np.sin(angle[:, k])
        phase = float(np.arctan2(np.sum(fast * sine), np.sum(fast * cosine)))
        carriers[:, k] = np.cos(angle[:, k] - phase)
    return carriers


def without_lag(deviations: Mapping[str, float]) -> dict[str, float]:
    """The deviations of what is measured, not of how late a pressure is read."""
    return {column: value for column, value in deviations.items() if column != PRESSURE_LAG}


def true_inputs(
    deviations: Mapping[str, float],
    time: FloatArray,
    channels: Mapping[str, FloatArray],
    leads: Mapping[str, FloatArray] | None = None,
) -> dict[str, FloatArray]:
    """What drives the replay as it was, from what was reported.

    Wheel pressures are p = (p' + tau dp'/dt − b)/s, never below zero. The longitudinal acceleration, which stands in
    for forces that no channel tells, is a = (a' − b_x)/s_x.

    Parameters
    ----------
    deviations : column -> deviation of ``PRESSURE_COLUMNS`` and ``ACCELERATION_COLUMNS``
    time : (n,) [s], equal steps
    channels : name -> (n,); others than these two are handed through
    leads : dp'/dt (n,) of wheel pressures [Pa/s], where something else than their samples tells it
    """
    inputs = dict(channels)
    _true_pressures(inputs, deviations, float(time[1] - time[0]), leads or {})
    offset, scale = (deviations.get(column, 0.0) for column in ACCELERATION_COLUMNS)
    felt = channels.get("longitudinal_acceleration")
    if felt is not None and (offset != 0.0 or scale != 0.0):
        inputs["longitudinal_acceleration"] = (felt - offset) / (1.0 + scale)
    return inputs


def _true_pressures(
    inputs: dict[str, FloatArray], deviations: Mapping[str, float], step: float, leads: Mapping[str, FloatArray]
) -> None:
    scale = 1.0 + deviations.get("pressure_sensor_scale.wheels", 0.0)
    offset = deviations.get("pressure_sensor_offset.wheels", 0.0)
    lag = deviations.get(PRESSURE_LAG, 0.0)
    if scale == 1.0 and offset == 0.0 and lag == 0.0:
        return
    names = [name for wheel in WHEELS if (name := f"brake_pressure_{wheel}") in inputs]
    for name in names:
        leading = inputs[name]
        if lag != 0.0:
            leading = leading + lag * (leads[name] if name in leads else np.gradient(leading, step))
        inputs[name] = np.maximum((leading - offset) / scale, 0.0)
