"""Write docs/estimators_measured.md: estimators on logs of real cars that nobody here made.

``python docs/generate_measured_estimates.py`` needs the data of BENCH_SHARED_DATA (by default ../shared/data beside the
repository). Each log goes through ``bench estimate``'s own path: its format, a channel map, a vehicle file.
"""

import os
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "docs"))

PAGE = ROOT / "docs" / "estimators_measured.md"
IMAGES = ROOT / "docs" / "images" / "measured"
DATA = Path(os.environ.get("BENCH_SHARED_DATA", ROOT.parent / "shared" / "data"))

ESTIMATORS = {
    "friction_ekf": {"torque_mode": "z2"},
    "friction_ukf": {"torque_mode": "z2"},
    "slip_slope_rls": {},
    "simple_braking": {},
}
WHEELS = ("fl", "fr", "rl", "rr")

# facts of the data's own README; what it does not say is assumed
RAV4 = """format: 1
name: rav4
extends: ekf_car
body: {mass: 1700 kg, wheelbase: 2.66 m, centre_of_gravity_to_front_axle: 1.15 m, centre_of_gravity_height: 0.62 m}
wheels: {fl: &wheel {radius: 0.345 m, unloaded_radius: 0.36 m, inertia: 1.2 kg m^2}, fr: *wheel, rl: *wheel, rr: *wheel}
aerodynamics: {drag_coefficient: 0.33, frontal_area: 2.7 m^2}
"""
AV21 = """format: 1
name: av21
extends: ekf_car
body: {mass: 800 kg, wheelbase: 2.97 m, centre_of_gravity_to_front_axle: 1.724 m, centre_of_gravity_height: 0.3 m}
wheels: {fl: &wheel {radius: 0.3 m, unloaded_radius: 0.31 m, inertia: 1.0 kg m^2}, fr: *wheel, rl: *wheel, rr: *wheel}
aerodynamics: {drag_coefficient: 0.9, frontal_area: 1.0 m^2}
"""

HEAD = """# Estimators on logs of real cars

Made by `python docs/generate_measured_estimates.py`. Logs that nobody of this project made, read through channel maps
as a user would (`bench estimate LOG --channels MAP --vehicle FILE`), shipped settings, nothing tuned to a log. Masses
and wheelbases are those of the data's descriptions, other numbers of the cars assumed. The friction estimators first,
with unknown torques (`torque_mode: z2`); the vehicle-state observers stand at the end.

None of the logs contains a braking near the limit: what can be checked is the speed against a reference and that
friction in use is about the acceleration over g (resistance, slope and the smoothing of the reference's derivative are
in the difference).

What they show: the simple evaluation and the slip slope take the speed from rolling wheels and stay within 0.5 m/s. The
friction filters without torques are made for a stop of some seconds. In a minute of gentle driving nothing ties their
speed: the accelerometer's offset and the road's slope are integrated by row 8, the slip absorbs the difference to the
wheels, and with hardly any force the limits fall until that slip fits (the document's "small weak point", 3.6.11).
Their confidence then asks for a share of a limit that is too low and is wrong too. They should be started before a
braking.

Which estimator lacks what in which log stands in a table [at the end](#what-the-logs-lack).
"""


@dataclass(frozen=True)
class Log:
    """A log with what is needed to read it, and the true speed over time where there is one."""

    name: str
    title: str
    text: str
    path: Path
    channels: Path
    vehicle: Path
    time: Any
    speed: Any
    reference: str


def rav4(folder: Path) -> Log:
    """Frames 0x24 and 0xAA of the Toyota's CAN bus as a candump log; reference: the GNSS receiver's speed."""
    from measured_state_logs import DBC

    data = np.load(DATA / "comma2k19-rav4" / "segment40.npz")
    origin = float(data["can_t"][0])
    lines = [
        f"({t - origin + 1.0:.6f}) can0 {int(i):03X}#{bytes(raw).hex().upper()}"
        for t, i, raw in zip(data["can_t"], data["can_id"], data["can_data"], strict=True)
        if int(i) in (0x24, 0xAA)
    ]
    (folder / "rav4.log").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "rav4.dbc").write_text(DBC, encoding="utf-8")
    (folder / "rav4.yaml").write_text(RAV4, encoding="utf-8")
    wheels = "".join(f"  wheel_speed_{w}: {{source: WHEEL_SPEEDS.{w.upper()}, unit: km/h}}\n" for w in WHEELS)
    (folder / "rav4_map.yaml").write_text(
        "dbc: rav4.dbc\nchannels:\n  longitudinal_acceleration: {source: KINEMATICS.ACCEL_X, sign: -1}\n" + wheels,
        encoding="utf-8",
    )
    first = min(float(line[1 : line.index(")")]) for line in lines) - 1.0 + origin
    gnss = data["live_gnss_ublox_value"][:, 2]
    return Log(
        "rav4", "Toyota RAV4 on a motorway (comma2k19)",
        "60 s, 8 to 20 m/s, at most 2.4 m/s² of deceleration; wheel speeds and accelerometer from raw CAN frames. "
        "The car counts its acceleration the other way (against the derivative of its speed): `sign: -1` in the map.",
        folder / "rav4.log", folder / "rav4_map.yaml", folder / "rav4.yaml",
        data["live_gnss_ublox_t"] - first, gnss, "GNSS speed",
    )  # fmt: skip


def av21(folder: Path) -> Log:
    """The Dallara's CSV at 25 Hz; reference: the localisation's speed."""
    path = DATA / "iac-av21" / "LVMS_23_01_04_B.csv.gz"
    (folder / "av21.yaml").write_text(AV21, encoding="utf-8")
    wheels = "".join(f"  wheel_speed_{w}: {{source: wheel_{w}(kmph), unit: km/h}}\n" for w in WHEELS)
    (folder / "av21_map.yaml").write_text(
        "clock: {column: time(s)}\nchannels:\n  longitudinal_acceleration: {source: ax(m/s^2)}\n"
        "  speed: {source: vx(m/s)}\n" + wheels,
        encoding="utf-8",
    )
    from signals.measured import load_channel_map, read_log

    log = read_log(path, load_channel_map(folder / "av21_map.yaml"), wheel_radius_m=0.3)
    speed = log.channels["speed"]
    return Log(
        "av21", "Dallara AV-21 on an oval (Indy Autonomous Challenge)",
        "672 s at 25 Hz, up to 20.8 m/s, one braking of 2.4 s. The logged `ax` lags by about 2 s (the data's own "
        "description); it is used as it is, and shows what a wrong accelerometer does.",
        path, folder / "av21_map.yaml", folder / "av21.yaml", speed.time, speed.values, "speed of the localisation",
    )  # fmt: skip


def section(log: Log, folder: Path) -> str:
    """Text on one log; pictures are written on the way."""
    from bench.estimation.offline import Request, run_offline
    from bench.estimation.output_files import draw
    from bench.estimation.source import open_source
    from vehicle_model.vehicle_file import load_vehicle

    source = open_source(log.path, log.channels, log.vehicle)
    requests = [Request(name, name, settings) for name, settings in ESTIMATORS.items()]
    estimates = run_offline(source, load_vehicle(log.vehicle).numbers(), requests)
    reference = np.interp(source.data.time, log.time, log.speed, left=np.nan, right=np.nan)
    slope = np.gradient(np.convolve(np.nan_to_num(reference), np.ones(500) / 500, "same"), 1e-3)
    rows = [
        "| Estimator | Speed, RMSE and mean error in m/s | Friction in use less (a + resistance)/g, RMSE | Confident | "
        "us per step |",
        "|---|---:|---:|---:|---:|",
    ]
    for estimate in estimates:
        rows.append(_row(estimate, reference, slope))
    IMAGES.mkdir(parents=True, exist_ok=True)
    draw(IMAGES / f"{log.name}.png", estimates[0], _comparisons(estimates[0], reference))
    picture = f"![friction EKF on {log.title}](images/measured/{log.name}.png)"
    return f"## {log.title}\n\n{log.text} Reference: {log.reference}.\n\n" + "\n".join(rows) + f"\n\n{picture}\n"


def _comparisons(estimate: Any, reference: Any) -> Mapping[str, Any]:
    from bench.estimation.offline import Comparison

    return {"speed": Comparison(reference, ("speed",), 0.0, 0.0)}


def _row(estimate: Any, reference: Any, slope: Any) -> str:
    names = [signal.name.partition(".")[2] for signal in estimate.outputs]
    running = estimate.running() & np.isfinite(reference)
    error = (estimate.output("speed") - reference)[running]
    used = estimate.output("friction_used_mean" if "friction_used_mean" in names else "friction_used")
    moving = (
        running & (np.abs(slope) < 6.0) & (np.arange(len(slope)) > 1000) & (np.arange(len(slope)) < len(slope) - 1000)
    )
    force = np.sqrt(np.mean((used - slope / 9.81)[moving] ** 2))
    label = next((n for n in ("friction_limit_mean_confidence", "friction_limit_confidence") if n in names), "")
    confident = f"{100 * np.mean(estimate.output(label)[running] > 0.5):.1f} %" if label else "-"
    speed = f"{np.sqrt(np.mean(error**2)):.3f}, {np.mean(error):+.3f}"
    return f"| `{estimate.name}` | {speed} | {force:.3f} | {confident} | {estimate.step_time_us:.1f} |"


def main() -> int:
    """Write the page."""
    import measured_state_logs

    if not DATA.is_dir():
        print(f"{DATA}: no such folder; set BENCH_SHARED_DATA")
        return 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        parts = [HEAD, *(section(make(folder), folder) for make in (rav4, av21))]
        parts.append(measured_state_logs.section(DATA, folder, IMAGES))
    PAGE.write_text("\n".join(parts), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
