"""Vehicle-state observers on logs of real cars: a section of docs/estimators_measured.md, its picture, its refusals."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

OBSERVERS = ("vehicle_state_ukf", "wheel_sliding_mode", "magic_formula_fit", "road_grade", "observer_cascade")
WHEELS = ("fl", "fr", "rl", "rr")
DEGREE = 0.017453292519943295

# what a RAV4 of 2017 sends, as in opendbc's toyota_rav4_2017_pt; accelerations count the other way
DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ 36 KINEMATICS: 8 X
 SG_ YAW_RATE : 1|10@0+ (0.244,-125) [0|0] "deg/s" X
 SG_ ACCEL_X : 17|10@0+ (0.03589,-18.375) [0|0] "m/s2" X
 SG_ ACCEL_Y : 33|10@0+ (0.03589,-18.375) [0|0] "m/s2" X
BO_ 37 STEER_ANGLE_SENSOR: 8 X
 SG_ STEER_ANGLE : 3|12@0- (1.5,0) [0|0] "deg" X
 SG_ STEER_FRACTION : 39|4@0- (0.1,0) [0|0] "deg" X
BO_ 170 WHEEL_SPEEDS: 8 X
 SG_ FR : 7|16@0+ (0.01,-67.67) [0|0] "km/h" X
 SG_ FL : 23|16@0+ (0.01,-67.67) [0|0] "km/h" X
 SG_ RR : 39|16@0+ (0.01,-67.67) [0|0] "km/h" X
 SG_ RL : 55|16@0+ (0.01,-67.67) [0|0] "km/h" X
BO_ 548 BRAKE_MODULE: 8 X
 SG_ BRAKE_PRESSED : 5|1@0+ (1,0) [0|0] "" X
"""
_FRAMES = (0x24, 0x25, 0xAA, 0x224)
COLUMNS = ("time", "ax", "ay", "yaw", "steer", *(f"wheel_{wheel}" for wheel in WHEELS), "brake")
RAV4_MAP = """clock: {column: time}
channels:
  longitudinal_acceleration: {source: ax, unit: m/s^2, sign: -1}
  lateral_acceleration: {source: ay, unit: m/s^2, sign: -1}
  yaw_rate: {source: yaw, unit: deg/s}
  steering_wheel_angle: {source: steer, unit: deg}
  brake_switch: {source: brake}
  wheel_speed_fl: {source: wheel_fl, unit: km/h}
  wheel_speed_fr: {source: wheel_fr, unit: km/h}
  wheel_speed_rl: {source: wheel_rl, unit: km/h}
  wheel_speed_rr: {source: wheel_rr, unit: km/h}
"""
# steering ratio and track: usual figures of this car; yaw inertia: mass times both distances to the axles
RAV4 = """format: 1
name: rav4_steered
extends: rav4.yaml
body: {yaw_inertia: 2950 kg m^2}
axles: {front: {track: 1.57 m}, rear: {track: 1.57 m}}
steering:
  ratio: 16.9
  map:
    steering_wheel_angle: [-338 deg, 0, 338 deg]
    left: [-20 deg, 0, 20 deg]
    right: [-20 deg, 0, 20 deg]
"""
# every channel that the log has a signal for; angles at the wheels times the ratio of the file above
AV21_MAP = """clock: {column: time(s)}
channels:
  steering_wheel_angle: {source: delta(rad), unit: rad, scale: 16.9}
  brake_pressure_fl: {source: brake_ped_cmd(kPa), unit: kPa}
  brake_pressure_fr: {source: brake_ped_cmd(kPa), unit: kPa}
  brake_pressure_rl: {source: brake_ped_cmd(kPa), unit: kPa}
  brake_pressure_rr: {source: brake_ped_cmd(kPa), unit: kPa}
  longitudinal_acceleration: {source: ax(m/s^2)}
  yaw_rate: {source: omega(rad/s)}
  wheel_speed_fl: {source: wheel_fl(kmph), unit: km/h}
  wheel_speed_fr: {source: wheel_fr(kmph), unit: km/h}
  wheel_speed_rl: {source: wheel_rl(kmph), unit: km/h}
  wheel_speed_rr: {source: wheel_rr(kmph), unit: km/h}
"""
FERRARI_MAP = """clock: {column: t}
channels:
  steering_wheel_angle: {source: delta, unit: rad, scale: 16.9}
  longitudinal_acceleration: {source: axCG, unit: m/s^2}
  lateral_acceleration: {source: ayCG, unit: m/s^2}
  yaw_rate: {source: yawRate, unit: rad/s}
"""


@dataclass(frozen=True)
class References:
    """What the log knows of the car from other instruments, at the source's rows; NaN where nothing."""

    speed: Any
    yaw_rate: Any
    side_slip: Any

    @property
    def lateral_acceleration(self) -> Any:
        """Of a car whose side slip hardly changes."""
        return self.speed * self.yaw_rate


def section(data: Path, folder: Path, images: Path) -> str:
    """Text of the vehicle-state part; pictures are written on the way. ``folder`` has the car ``rav4.yaml``."""
    from bench.estimation.offline import Request, run_offline
    from bench.estimation.source import open_source
    from vehicle_model.vehicle_file import load_vehicle

    log = data / "comma2k19-rav4" / "segment40.npz"
    origin = _write_rav4(log, folder)
    car = folder / "rav4_steered.yaml"
    source = open_source(folder / "rav4_state.csv", folder / "rav4_state_map.yaml", car)
    numbers = load_vehicle(car).numbers()
    requests = [Request(OBSERVERS[0], OBSERVERS[0], {})]
    estimate = run_offline(source, numbers, requests)[0]
    references = _references(log, origin, source.data.time)
    _draw(images / "rav4_state.png", source, estimate, references)
    offset = float(np.mean((source.data.array("yaw_rate") - references.yaw_rate)[_judged(source, estimate)]))
    corrected = run_offline(_with_yaw_offset(source, -offset), numbers, requests)[0]
    parts = [
        HEAD,
        _table(source, estimate, references),
        f"![{TITLE}](images/measured/rav4_state.png)",
        f"{CAUSE.format(offset=offset / DEGREE)} {_slip_text(source, corrected, references)}",
        CORNERING,
        _cornering_table(source, numbers, references, -offset),
        REFUSED,
        _lacking(data, folder, source),
    ]
    return "\n\n".join(parts) + "\n"


def _with_yaw_offset(source: Any, offset: float) -> Any:
    """The log with a number added to its yaw rate."""
    return _with(source, "yaw_rate", source.data.array("yaw_rate") + offset)


def _with(source: Any, signal: str, values: Any) -> Any:
    """The log with other values of a signal."""
    from dataclasses import replace

    from bench.recording.arrays import RunArrays

    data = source.data
    columns = {name: data.array(name) for name in data.names}
    columns[signal] = values
    return replace(source, data=RunArrays(data.time, columns, data.units))


def _judged(source: Any, estimate: Any) -> Any:
    """Rows that count: the first and the last second are left out, where the smoothed references end."""
    time = source.data.time
    return estimate.running() & (time > 1.0) & (time < time[-1] - 1.0)


def _slip(estimate: Any) -> Any:
    """Side-slip angle at the centre of gravity [deg]."""
    return estimate.output("lateral_speed") / np.maximum(estimate.output("speed"), 1.0) / DEGREE


def _slip_text(source: Any, estimate: Any, references: References) -> str:
    rows = _judged(source, estimate)
    error = _slip(estimate) - references.side_slip / DEGREE
    spread = np.std(error[rows])
    return f"off by {spread:.3f} degrees and ranges over {np.ptp(_slip(estimate)[rows]):.2f}."


def _write_rav4(log: Path, folder: Path) -> float:
    """CSV, channel map and car of the RAV4's frames; returns the time of its first row."""
    import cantools

    database = cantools.database.load_string(DBC, "dbc")
    held: dict[str, float] = {}
    rows = []
    with np.load(log) as data:
        frames = [
            (float(t), int(number), bytes(raw))
            for t, number, raw in zip(data["can_t"], data["can_id"], data["can_data"], strict=True)
            if int(number) in _FRAMES
        ]
    for t, number, raw in sorted(frames):
        held |= database.decode_message(number, raw, decode_choices=False)
        # the yaw-rate sensor's frame comes as often as those of wheels and steering: one row for each
        if number == _FRAMES[0] and len(held) == 10:
            rows.append([t, *_row(held)])
    table = np.array(rows)
    origin = float(table[0, 0])
    table[:, 0] -= origin
    np.savetxt(folder / "rav4_state.csv", table, "%.6f", ",", header=",".join(COLUMNS), comments="")
    (folder / "rav4_state_map.yaml").write_text(RAV4_MAP, encoding="utf-8")
    (folder / "rav4_steered.yaml").write_text(RAV4, encoding="utf-8")
    return origin


def _row(held: Mapping[str, float]) -> list[float]:
    wheels = [held[wheel.upper()] for wheel in WHEELS]
    steering = held["STEER_ANGLE"] + held["STEER_FRACTION"]
    return [held["ACCEL_X"], held["ACCEL_Y"], held["YAW_RATE"], steering, *wheels, held["BRAKE_PRESSED"]]


def _references(log: Path, origin: float, time: Any) -> References:
    """Satellite receiver, the phone's own gyroscope, and the phone's pose: camera and satellites, published with it."""
    with np.load(log) as data:
        speed = np.interp(time, data["live_gnss_ublox_t"] - origin, data["live_gnss_ublox_value"][:, 2])
        # the phone's axes: forward, right, down
        gyroscope = -_smooth(data["gyro_value"][:, 2], 21)
        yaw_rate = np.interp(time, data["gyro_t"] - origin, gyroscope)
        along = _in_device_axes(data["pose_frame_orientations"], data["pose_frame_velocities"])
        side_slip = -np.arctan2(along[:, 1], along[:, 0])
        side_slip = np.interp(time, data["pose_frame_times"] - origin, _smooth(side_slip, 11))
    return References(speed, yaw_rate, side_slip)


def _in_device_axes(quaternions: Any, vectors: Any) -> Any:
    """Vectors of the earth-fixed frame in the axes of the device, whose attitude the quaternions (w, x, y, z) are."""
    w, v = quaternions[:, :1], quaternions[:, 1:]
    twice = 2.0 * np.cross(-v, vectors)
    return vectors + w * twice + np.cross(-v, twice)


def _smooth(values: Any, window: int) -> Any:
    return np.convolve(np.pad(values, window // 2, mode="edge"), np.ones(window) / window, "valid")


def _table(source: Any, estimate: Any, references: References) -> str:
    data = source.data
    wheels = np.mean([data.array(f"wheel_speed_{wheel}") for wheel in WHEELS], axis=0) * 0.345
    speed, slip = estimate.output("speed"), _slip(estimate)
    running = _judged(source, estimate)
    slip_there = references.side_slip / DEGREE
    rows = [
        ("speed in m/s", references.speed, speed, wheels, "mean of the wheels"),
        ("yaw rate in deg/s", references.yaw_rate / DEGREE, estimate.output("yaw_rate") / DEGREE,
         data.array("yaw_rate") / DEGREE, "the car's gyroscope"),
        ("lateral acceleration in m/s²", references.lateral_acceleration, estimate.output("lateral_acceleration"),
         data.array("lateral_acceleration"), "the car's accelerometer"),
        ("side-slip angle in degrees, both less their mean", slip_there - np.mean(slip_there[running]),
         slip - np.mean(slip[running]), np.zeros_like(slip), "always 0"),
    ]  # fmt: skip
    lines = [
        "| Quantity | Spread of the reference | Observer: RMSE, mean error | Beside it: RMSE, mean error |",
        "|---|---:|---:|---:|",
    ]
    for title, truth, value, plain, name in rows:
        figures = (_figures(value - truth, running), f"{name}: {_figures(plain - truth, running)}")
        lines.append(f"| {title} | {np.std(truth[running]):.3f} | {figures[0]} | {figures[1]} |")
    limits = ", ".join(f"{int(estimate.output(f'fits_lateral_{wheel}')[-1])}" for wheel in WHEELS)
    largest = np.max(np.abs(estimate.output("slip_angle_fl")[running])) / DEGREE
    return "\n".join(lines) + (
        f"\n\nLateral fits (fl, fr, rl, rr): {limits}. Largest slip angle in front: {largest:.2f} degrees. "
        f"Processor time of a step: {estimate.step_time_us:.1f} us."
    )


def _figures(error: Any, rows: Any) -> str:
    return f"{np.sqrt(np.mean(error[rows] ** 2)):.3f}, {np.mean(error[rows]):+.3f}"


def _cornering_table(source: Any, numbers: Mapping[str, float], references: References, correction: float) -> str:
    """The cornering-stiffness method as it is, and with signals that the reference mends, one after the other."""
    from bench.estimation.offline import Request, run_offline

    rows = [
        "| Signals | Side-slip angle less its mean, RMSE in degrees | Side friction in front less that of the "
        "reference, RMSE | Slope told (window spans 1 degree), front, rear | Alarms, front, rear |",
        "|---|---:|---:|---:|---:|",
    ]
    request = Request(CORNERING_NAME, CORNERING_NAME, {})
    without_offset = _with_yaw_offset(source, correction)
    for title, log in (
        ("as they are", source),
        ("mean error of the gyroscope taken out", without_offset),
        ("and the reference for the accelerometer",
         _with(without_offset, "lateral_acceleration", references.lateral_acceleration)),
    ):  # fmt: skip
        estimate = run_offline(log, numbers, [request])[0]
        judged = _judged(log, estimate)
        slip = (estimate.output("side_slip_angle") - references.side_slip)[judged] / DEGREE
        used = (estimate.output("friction_used_front") - references.lateral_acceleration / 9.80665)[judged]
        told, alarms = (
            ", ".join(f"{100 * np.mean(estimate.output(name.format(axle))[judged] > 0):.1f} %" for axle in AXLES)
            for name in ("slope_{}_confidence", "limit_reached_{}")
        )
        rows.append(f"| {title} | {np.std(slip):.3f} | {np.sqrt(np.mean(used**2)):.3f} | {told} | {alarms} |")
    spread = np.std(references.side_slip[judged]) / DEGREE
    still = np.sqrt(np.mean((references.lateral_acceleration[judged] / 9.80665) ** 2))
    rows.append(f"| beside it: always 0 | {spread:.3f} | {still:.3f} | – | – |")
    return "\n".join(rows)


def _lacking(data: Path, folder: Path, rav4: Any) -> str:
    """For every estimator of both documents and every real log: run above, or the signals that it lacks."""
    from bench.estimation.source import open_source
    from estimators import describe

    logs = {"RAV4": rav4}
    for name, path, text in (
        ("Dallara AV-21", data / "iac-av21" / "LVMS_23_01_04_B.csv.gz", AV21_MAP),
        ("Ferrari 250 LM", data / "revs-250lm-2014" / "250lm_20140222_01_t150-425.csv.gz", FERRARI_MAP),
    ):
        (folder / "lacking.yaml").write_text(text, encoding="utf-8")
        logs[name] = open_source(path, folder / "lacking.yaml", folder / "rav4_steered.yaml")
    rows = [f"| Estimator | {' | '.join(logs)} |", "|---" * (1 + len(logs)) + "|"]
    for name, settings in EVERY.items():
        description = describe(name)
        inputs = description.inputs(description.settings(**settings))
        cells = [", ".join(f"`{signal}`" for signal in log.missing(inputs)) or "run" for log in logs.values()]
        rows.append(f"| `{name}` | {' | '.join(cells)} |")
    return "\n".join(rows)


def _draw(path: Path, source: Any, estimate: Any, references: References) -> None:
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    from bench.report.plot_style import INK, plot_style

    time, speed, slip = source.data.time, estimate.output("speed"), _slip(estimate)
    panels = (
        ("speed in m/s", references.speed, speed),
        ("yaw rate in deg/s", references.yaw_rate / DEGREE, estimate.output("yaw_rate") / DEGREE),
        ("lateral acceleration in m/s²", references.lateral_acceleration, estimate.output("lateral_acceleration")),
        ("side-slip angle in degrees", references.side_slip / DEGREE, slip),
    )
    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(2, 2, figsize=(10.0, 5.0), layout="constrained", sharex=True)
        for axis, (title, truth, value) in zip(axes.flat, panels, strict=True):
            axis.plot(time, truth, color=INK, linewidth=0.9, label="reference")
            axis.plot(time, value, color="#0b62c4", linewidth=0.9, label="vehicle_state_ukf")
            axis.set_title(title, loc="left", fontsize=9)
        for axis in axes[1]:
            axis.set_xlabel("time in s")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), ncols=2, loc="outside lower center")
        figure.savefig(path, dpi=90)
        pyplot.close(figure)


TITLE = "vehicle-state filter on the RAV4"
HEAD = """## Vehicle-state observers: Toyota RAV4 (comma2k19)

The same 60 s. Of the logs at hand only this one has what the lateral filter asks for: four wheel speeds, both
accelerometers, yaw rate, steering wheel, brake switch, all from the car's CAN frames, through a channel map; shipped
settings. Steering ratio, track and yaw inertia are assumed. References come from other instruments than the filter's:
GNSS speed; the gyroscope of a phone in the windscreen; both multiplied for the lateral acceleration; the side-slip
angle from velocity and attitude of that phone (camera and GNSS, published with the data). Its mounting angle is not
known, so that means are taken out. "Beside it" is what one has without an observer.

What it shows: this motorway hardly turns (the lateral acceleration spreads by 0.07 m/s²), and the filter is no use on
it. Speed is the wheels', yaw rate the gyroscope's, with their errors: radius 0.8 % too small, 0.44 degrees per second
of offset, which a car learns that stands, and this one never does. The lateral acceleration is smoother than the
sensor's but has speed times that offset in it. The side-slip angle drifts by 1.8 degrees, where the car's stays within
0.1: to say always 0 would be better. Slip angles do not reach the threshold of a fit, so that no friction limit is
told, and none should be. Peaks of the speed (up to 2 m/s for some milliseconds) are jolts of single wheels,
extrapolated to the next frame."""
CAUSE = """\
The drift is the gyroscope's offset: with its mean error against the phone ({offset:+.2f} degrees per second) taken out,
which is no result, as it takes the reference to know it, the side-slip angle is"""
CORNERING_NAME = "cornering_stiffness_rls"
AXLES = ("front", "rear")
EVERY: dict[str, dict[str, Any]] = {
    "friction_ekf": {"torque_mode": "z2"},
    "friction_ukf": {"torque_mode": "z2"},
    "force_ekf": {},
    "slip_slope_rls": {},
    "simple_braking": {},
    CORNERING_NAME: {},
    **{name: {} for name in OBSERVERS},
}
"""The estimators of the friction and the vehicle-state document, with the settings that ask for fewest signals."""
CORNERING = """### Cornering-stiffness method

The same log, shipped settings. On this motorway no window spans a degree of slip angle, so that the method has nothing
to say of slopes, and says so (`slope_..._confidence` 0, no alarm). Its side-slip angle is off by more than the car has:
that is the lateral accelerometer, which feels lean and bank of the road (0.18 m/s² off the reference), while the offset
of the gyroscope is forgotten with the 2 s of `side_slip_time_constant`. Two rows take the reference to mend the
signals, and are no result but the proof."""
REFUSED = """### What the logs lack

All real logs of a car at hand, and every estimator of the friction and the vehicle-state document: run above, or the
signals that the log has not. `bench estimate` names them before it runs. No log tells the torques of its axles, so that
`force_ekf` was run on none: the Dallara's brake pressure is a command and its engine's torque is not there, the RAV4
sends neither. The CarMaker runs are simulated, and have no wheel speeds."""
