"""Force EKF whose accelerometer has an offset or feels a slope: rolling wheels tell it, drag would be blamed for it."""

import numpy as np
import pytest

from bench.estimation.made_runs import make_run
from bench.estimation.offline import Request, run_offline
from vehicle_model.vehicle_file import load_vehicle

TABLE_8 = load_vehicle("ekf_car").numbers()
STOP = "friction/e10_abs_grip_jump"


def estimate_of(settings, **changes):
    """Estimate and truth of an ABS stop from 95 km/h on one grip, and the rows from brake to 5 m/s."""
    source = make_run(STOP, {"road.jumps": [], **{key.replace("__", "."): value for key, value in changes.items()}})
    (estimate,) = run_offline(source, TABLE_8, [Request("force_ekf", "force_ekf", settings)])
    true = source.data.array("speed")
    pressed = int(np.argmax(source.data.array("driver_master_pressure") > 0))
    return estimate, true, slice(pressed, pressed + int(np.argmax(true[pressed:] < 5.0)))


def rms(values) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.acceptance("F-17")
@pytest.mark.parametrize("offset", [-0.3, 0.1, 0.3])
def test_an_offset_is_told_by_rolling_wheels(offset, record):
    estimate, true, rows = estimate_of({}, sensors__longitudinal_acceleration__offset=offset)
    error = rms(estimate.output("speed")[rows] - true[rows])
    told = float(estimate.output("acceleration_offset")[rows.start])
    record(f"offset {offset} m/s^2: speed, RMSE in m/s", error, "< 0.2: the document's rows without an offset")
    record(f"offset {offset} m/s^2: told at the brake, m/s^2", told, "within 0.05")
    assert error < 0.2
    # white noise of 0.05 m/s^2 every 5 ms, followed for 0.15 s, leaves 0.01; the rest are drag and rim speeds
    assert told == pytest.approx(offset, abs=0.05)
    assert (estimate.output("speed_confidence")[rows] == 1.0).all()
    assert (estimate.output("resets")[rows] == 0.0).all()


@pytest.mark.acceptance("F-17")
def test_the_documents_rows_alone_take_an_offset_for_drag(record):
    """``rolling_speed: none``: the speed moves towards the 6.75 m/s whose drag explains 0.1 m/s^2, and is believed."""
    estimate, true, rows = estimate_of({"rolling_speed": "none"}, sensors__longitudinal_acceleration__offset=0.1)
    error = rms(estimate.output("speed")[rows] - true[rows])
    record("document's rows, offset 0.1 m/s^2: speed, RMSE in m/s", error, "reported")
    assert 3.0 < error < 6.75
    assert (estimate.output("acceleration_offset") == 0.0).all()


@pytest.mark.acceptance("F-17")
def test_a_slope_is_taken_out_like_an_offset(record):
    """5 % downhill: the accelerometer feels g sin(grade) = 0.49 m/s^2 that no force makes."""
    estimate, true, rows = estimate_of({}, road__grade=-0.05)
    told = float(estimate.output("acceleration_offset")[rows.start])
    error = rms(estimate.output("speed")[rows] - true[rows])
    record("5 % downhill: told at the brake, m/s^2", told, "-0.49 +- 0.05")
    record("5 % downhill: speed, RMSE in m/s", error, "reported")
    assert told == pytest.approx(-9.80665 * np.sin(np.arctan(0.05)), abs=0.05)


def test_an_offset_beyond_its_bound_is_not_believed():
    """A sensor that is off by 2 m/s^2: while wheels roll they hold the speed, in braking it is told as untrusted."""
    estimate, true, rows = estimate_of({}, sensors__longitudinal_acceleration__offset=2.0)
    assert np.abs(estimate.output("acceleration_offset")).max() <= 1.0
    assert abs(estimate.output("speed")[rows.start] - true[rows.start]) < 0.5
    late = slice(rows.start + 400, rows.stop)
    assert (estimate.output("speed_confidence")[late] == 0.0).all()


def test_the_offset_is_forgotten_with_the_filter():
    estimate, _, rows = estimate_of({}, sensors__longitudinal_acceleration__offset=0.3)
    standing = estimate.output("active")[rows.stop :] == 0.0
    assert standing.any()
    assert (estimate.output("acceleration_offset")[rows.stop :][standing] == 0.0).all()
