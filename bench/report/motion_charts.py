"""Charts of the car's motion: speeds, deceleration, slip, yaw, steering, place on the road."""

import numpy as np
from numpy.typing import NDArray

from bench.report.charts import Area, Chart, ChartBook, LineChart, Series
from bench.report.run_data import FloatArray, RunData
from signals.wheels import WHEELS

KMH = 3.6
DEGREES = 180.0 / np.pi
STANDING_M_S = 0.3
FAST_M_S = 15 / 3.6  # below it a wheel may lock: what happens there must not set the scale


def rolling_radius(run: RunData, wheel: str) -> float | None:
    """Radius R of the wheel's rim speed R ω, from the slip while the car is fast; None where the run never is.

    Slip is (R ω - v)/max(R ω, v), so R ω = v (1 + slip) while braking and v/(1 - slip) while driving.
    """
    names = (f"wheel_centre_speed_{wheel}", f"slip_ratio_{wheel}", f"true_wheel_speed_{wheel}")
    if not run.has(*names):
        return None
    centre, slip, speed = (run.array(name) for name in names)
    fast = (centre > FAST_M_S) & (speed > 1.0) & (np.abs(slip) < 0.5)
    if not fast.any():
        return None
    centre, slip, speed = centre[fast], slip[fast], speed[fast]
    return float(np.median(np.where(slip <= 0.0, centre * (1.0 + slip), centre / (1.0 - slip)) / speed))


def wheel_rim_speeds(run: RunData) -> dict[str, FloatArray]:
    """Speed of each wheel's circumference in m/s; a wheel whose radius the run does not tell is left out."""
    speeds = {}
    for wheel in WHEELS:
        radius = rolling_radius(run, wheel)
        if radius is not None:
            speeds[wheel] = run.array(f"true_wheel_speed_{wheel}") * radius
    return speeds


def speed_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Speed of the car and of the wheels' circumference, reference speed of the ECU."""
    if not run.has("speed"):
        return None
    series = []
    for wheel, speed in wheel_rim_speeds(run).items():
        name = book.add_signal(f"rim_speed_{wheel}", run.time, speed * KMH)
        series.append(Series(wheel.upper(), name, wheel))
    if run.has("ecu_reference_speed"):
        name = book.add_signal("ecu_reference_speed", run.time, run.array("ecu_reference_speed") * KMH)
        series.append(Series("reference speed of the ECU", name, "second", "thin", dashed=True))
    name = book.add_signal("speed", run.time, run.array("speed") * KMH)
    series.append(Series("car", name, "reference", "bold"))
    return LineChart(
        "speed", "Speed of the car and its wheels", "km/h", series, height=270, wide=True, step_names=True,
        explanation="Wheels: speed of the circumference. A wheel far below the car is about to lock.",
    )  # fmt: skip


def slip_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Magnitude of braking slip of each wheel, blank while the car stands."""
    if not run.has_wheels("slip_ratio"):
        return None
    moving = run.array("speed") > STANDING_M_S if run.has("speed") else np.ones(len(run.time), np.bool_)
    fast = run.array("speed") > FAST_M_S if run.has("speed") else moving
    if book.focus is not None:
        fast &= (run.time >= book.focus[0]) & (run.time <= book.focus[1])
    series, shown = [], []
    for wheel in WHEELS:
        percent = np.where(moving, run.array(f"slip_ratio_{wheel}") * -100.0, np.nan)
        series.append(Series(wheel.upper(), book.add_signal(f"slip_{wheel}", run.time, percent), wheel))
        shown.append(percent[fast & np.isfinite(percent)])
    values = np.concatenate([np.zeros(1), *shown])
    span = (min(1.05 * float(values.min()), -1.0), max(1.08 * float(values.max()), 20.0))
    return LineChart(
        "slip", "Brake slip", "%", series, height=230, wide=True, range=span,
        explanation="0 % rolls freely, 100 % is locked, negative values drive.",
    )  # fmt: skip


def deceleration_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Deceleration of the car, and the accelerometer as the bus carries it."""
    series = []
    if run.has("longitudinal_acceleration"):
        name = book.add_signal("measured_deceleration", run.time, -run.array("longitudinal_acceleration"))
        series.append(Series("sensor", name, "other", "thin"))
    if run.has("true_longitudinal_acceleration"):
        name = book.add_signal("deceleration", run.time, -run.array("true_longitudinal_acceleration"))
        series.append(Series("car", name, "reference"))
    return LineChart("deceleration", "Deceleration", "m/s²", series, smallest_span=1.0) if series else None


def yaw_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Yaw rate of the car and of the sensor, side-slip angle."""
    series = []
    if run.has("yaw_rate"):
        name = book.add_signal("measured_yaw_rate", run.time, run.array("yaw_rate") * DEGREES)
        series.append(Series("sensor", name, "other", "thin"))
    if run.has("true_yaw_rate"):
        name = book.add_signal("yaw_rate", run.time, run.array("true_yaw_rate") * DEGREES)
        series.append(Series("car", name, "reference"))
    return (
        LineChart("yaw", "Yaw rate", "°/s", series, smallest_span=4.0, explanation="Positive to the left.")
        if series
        else None
    )


def steering_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Steering-wheel angle of the driver."""
    if not run.has("driver_steering_wheel_angle"):
        return None
    name = book.add_signal("steering", run.time, run.array("driver_steering_wheel_angle") * DEGREES)
    return LineChart("steering", "Steering wheel", "°", [Series("driver", name, "reference")], smallest_span=10.0)


def lateral_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Place across the road."""
    if not run.has("position_y"):
        return None
    name = book.add_signal("position_y", run.time, run.array("position_y"))
    return LineChart(
        "lateral", "Place across the road", "m", [Series("centre of gravity", name, "reference")], smallest_span=0.4
    )


def deviation_area(
    book: ChartBook, run: RunData, estimate: str, deviation: str, running: NDArray[np.bool_], colour: str
) -> Area:
    """Ground of ± one standard deviation about an estimate while it runs."""
    value, spread = run.array(estimate), run.array(deviation)
    low, high = np.maximum(value - spread, 0.0), value + spread
    return Area(
        book.add_signal(f"{estimate}.low", run.time, np.where(running, low, np.nan)),
        book.add_signal(f"{estimate}.high", run.time, np.where(running, high, np.nan)),
        colour,
    )
