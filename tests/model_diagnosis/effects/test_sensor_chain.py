"""Sensor effects: neutral is bit-identical, analytic columns are the derivatives, inputs are turned back exactly."""

import numpy as np
import pytest

from model_diagnosis.effects.effect import Application
from model_diagnosis.effects.sensor_chain import measured_signals, ring_carriers, sensor_columns, true_inputs
from model_diagnosis.effects.sensors import SENSOR_EFFECTS

TIME = 0.01 * np.arange(600)
SIGNALS = ("wheel_speed_fl", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "wheel_speed_rr")


def _true():
    wheels = 90.0 - 3.0 * TIME
    return np.stack(
        [wheels, -2.0 + np.sin(TIME), 3.0 * np.cos(2.0 * TIME), 0.2 * np.cos(2.0 * TIME), wheels + 1.0], axis=1
    )


def _carriers():
    return ring_carriers(TIME, np.repeat(_true()[:, :1], 4, axis=1) * (1.0 + 0.01 * np.cos(90.0 * TIME))[:, None])


def test_neutral_deviations_leave_the_very_array():
    true = _true()
    assert measured_signals({"gyro_scale.yaw_rate": 0.0}, SIGNALS, true) is true


@pytest.mark.parametrize(
    "column", [c for e in SENSOR_EFFECTS if e.application is Application.SENSOR for c in e.columns]
)
def test_columns_are_the_derivatives(column):
    """Central differences around a car that already has every other error."""
    base = {c: 0.01 for e in SENSOR_EFFECTS if e.application is Application.SENSOR for c in e.columns}
    true, carriers, step = _true(), _carriers(), 1e-5
    up = measured_signals(base | {column: base[column] + step}, SIGNALS, true, carriers)
    down = measured_signals(base | {column: base[column] - step}, SIGNALS, true, carriers)
    analytic = sensor_columns(base, SIGNALS, true, carriers)[column]
    np.testing.assert_allclose(analytic, (up - down) / (2.0 * step), atol=1e-6)


def test_pressures_are_turned_back():
    """Reported = (true behind a lag) · scale + offset; without lag exact, with it to second order."""
    true = 2e6 + 1e6 * np.sin(3.0 * TIME)
    reported = {"brake_pressure_fl": true * 1.1 + 5e4}
    deviations = {"pressure_sensor_scale.wheels": 0.1, "pressure_sensor_offset.wheels": 5e4}
    np.testing.assert_allclose(true_inputs(deviations, TIME, reported)["brake_pressure_fl"], true, rtol=1e-12)
    lagged = true - 0.02 * 3e6 * np.cos(3.0 * TIME)  # dp/dt is of the lagged pressure: second order (0.06)² is left
    back = true_inputs({"pressure_sensor_lag.time_constant": 0.02}, TIME, {"brake_pressure_fl": lagged})
    np.testing.assert_allclose(back["brake_pressure_fl"][10:-10], true[10:-10], rtol=5e-3)


def test_carrier_finds_the_rings_phase():
    """A ring error put on with a known phase is what its own carrier takes off again."""
    turn = np.cumsum(np.full(600, 50.0)) * 0.01
    speeds = np.repeat((50.0 * (1.0 + 0.02 * np.cos(turn - 0.7)))[:, None], 4, axis=1)
    carrier = ring_carriers(TIME, speeds)[:, 0]
    amplitude = 2.0 * np.mean((speeds[:, 0] / 50.0 - 1.0) * carrier)
    assert amplitude == pytest.approx(0.02, rel=0.05)
