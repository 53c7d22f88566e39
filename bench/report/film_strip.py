"""A strip of pictures of the car through a run: drawn from above, or rendered where asked for and possible."""

import base64
import math
import tempfile
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path

import numpy as np
from markupsafe import Markup

from bench.report.car_scene import Pose
from bench.report.run_data import FloatArray, RunData
from signals.errors import BenchError, InputError
from signals.wheels import WHEELS

FRAMES = 6
RENDERED_SIZE = (480, 300)
_NEEDED = ("speed", "position_x", "position_y", "yaw_angle")
_FAST_M_S = 0.5
_LOCKED, _BRAKING = -0.8, -0.05
_DEFAULT_CAR = (4.3, 1.7, 2.6)  # length, width, wheelbase: where the vehicle file is not at hand
_JPEG_QUALITY = 82
_NO_BREAK_SPACE = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class Frame:
    """The car at an instant.

    Attributes
    ----------
    offset_m
        To the left of where the strip begins, across the road.
    slip
        Of the four wheels; 0 where the car stands.
    picture
        Rendered picture as the source of an image, or empty.
    """

    time_s: float
    speed_m_s: float
    deceleration_m_s2: float
    offset_m: float
    pose: Pose
    slip: tuple[float, ...]
    picture: str = ""


def frames_of(run: RunData, count: int = FRAMES) -> list[Frame]:
    """Instants spread over the stop (or the run); none where the run has no motion to show."""
    if not run.has(*_NEEDED) or len(run.time) < 2:
        return []
    low, high = run.focus() or (float(run.time[0]), float(run.time[-1]))
    rows = np.unique(np.searchsorted(run.time, np.linspace(low, high, count)).clip(0, len(run.time) - 1))
    spin = _spin_angles(run)
    return [_frame(run, int(row), int(rows[0]), spin) for row in rows]


def _frame(run: RunData, row: int, first: int, spin: dict[str, FloatArray]) -> Frame:
    def value(name: str) -> float:
        return float(run.array(name)[row]) if run.has(name) else 0.0

    speed = value("speed")
    pose = Pose(
        x=value("position_x"),
        y=value("position_y"),
        yaw=value("yaw_angle"),
        roll=value("roll_angle"),
        pitch=value("pitch_angle"),
        travel=tuple(value(f"suspension_travel_{w}") for w in WHEELS),
        steer=(value("true_road_wheel_angle_fl"), value("true_road_wheel_angle_fr")),
        spin=tuple(float(spin[w][row]) if w in spin else 0.0 for w in WHEELS),
    )
    moving = abs(speed) > _FAST_M_S
    return Frame(
        time_s=float(run.time[row]),
        speed_m_s=speed,
        deceleration_m_s2=-value("true_longitudinal_acceleration") if moving else 0.0,
        offset_m=pose.y - float(run.array("position_y")[first]),
        pose=pose,
        slip=tuple(value(f"slip_ratio_{w}") if moving else 0.0 for w in WHEELS),
    )


def _spin_angles(run: RunData) -> dict[str, FloatArray]:
    steps = np.diff(run.time, prepend=run.time[0])
    return {
        w: np.cumsum(run.array(f"true_wheel_speed_{w}") * steps) % (2.0 * math.pi)
        for w in WHEELS
        if run.has(f"true_wheel_speed_{w}")
    }


def rendered(run: RunData, frames: list[Frame]) -> list[Frame]:
    """The frames with rendered pictures.

    Raises
    ------
    RunError
        If no graphics library of this machine can draw without a screen.
    """
    from PIL import Image

    from bench.report.car_render import View, render_car

    width, height = RENDERED_SIZE
    view = View(width=width, height=height, azimuth_deg=125.0, elevation_deg=-18.0, distance=1.45)
    with tempfile.TemporaryDirectory(prefix="bench-frames-") as folder:
        paths = [Path(folder) / f"{number}.png" for number in range(len(frames))]
        render_car(str(run.scenario.get("vehicle", "ekf_car")), [frame.pose for frame in frames], paths, view)
        result = []
        for frame, path in zip(frames, paths, strict=True):
            stream = BytesIO()
            with Image.open(path) as image:
                image.convert("RGB").save(stream, "JPEG", quality=_JPEG_QUALITY)
            text = base64.b64encode(stream.getvalue()).decode("ascii")
            result.append(replace(frame, picture=f"data:image/jpeg;base64,{text}"))
    return result


def strip_of(run: RunData, *, render: bool = False) -> list[tuple[Markup, str]]:
    """Pictures of the strip with their captions; with ``render`` from MuJoCo's renderer, else drawn from above.

    A machine that cannot render gets the drawing, and the run's remarks say so.
    """
    frames = frames_of(run)
    if render and frames:
        try:
            frames = rendered(run, frames)
        except BenchError as error:
            run.remarks.append(f"The car is drawn, not rendered: {error.message}")
    size = _car_size(run)
    return [(_picture(frame, size), caption(frame)) for frame in frames]


def caption(frame: Frame) -> str:
    """Time, speed, deceleration; a line ends between them, never between a number and its unit."""
    quantities = [f"{frame.time_s:.2f} s", f"{abs(3.6 * frame.speed_m_s):.0f} km/h"]
    if frame.deceleration_m_s2 > 0.5:
        quantities.append(f"{frame.deceleration_m_s2:.1f} m/s²")
    return " · ".join(quantity.replace(" ", _NO_BREAK_SPACE) for quantity in quantities)


def _picture(frame: Frame, size: tuple[float, float, float]) -> Markup:
    if frame.picture:
        width, height = RENDERED_SIZE
        return Markup('<img src="{}" width="{}" height="{}" alt="{}">').format(
            frame.picture, width, height, f"the car at {frame.time_s:.2f} s"
        )
    return Markup(drawing(frame, size))  # numbers only, made below


def _car_size(run: RunData) -> tuple[float, float, float]:
    from vehicle_model.vehicle_file import load_vehicle

    name = run.scenario.get("vehicle")
    try:
        vehicle = load_vehicle(str(name)) if name else None
    except InputError:
        vehicle = None
    if vehicle is None:
        return _DEFAULT_CAR
    return vehicle.body.length, vehicle.body.width, vehicle.body.wheelbase


def drawing(frame: Frame, size: tuple[float, float, float]) -> str:
    """The car from above as SVG: heading, steering and place across the road; wheels coloured by their slip."""
    length, width, wheelbase = size
    offset = max(-2.0, min(frame.offset_m, 2.0))
    turn = math.degrees(frame.pose.yaw)
    tyres = []
    for number, slip in enumerate(frame.slip):
        x = 0.5 * wheelbase if number < 2 else -0.5 * wheelbase
        y = 0.5 * width if number % 2 == 0 else -0.5 * width
        steer = math.degrees(frame.pose.steer[number]) if number < 2 else 0.0
        state = "locked" if slip < _LOCKED else "braking" if slip < _BRAKING else "rolling"
        tyres.append(
            f'<rect class="tyre {state}" x="-0.32" y="-0.11" width="0.64" height="0.22" rx="0.06" '
            f'transform="translate({x:.3f} {y:.3f}) rotate({steer:.2f})"/>'
        )
    arrow = min(0.12 * frame.deceleration_m_s2, 1.4)
    force = (
        f'<path class="force" d="M{-0.5 * length:.3f} 0 h{-arrow:.3f} m0.18 0.16 l-0.18 -0.16 l0.18 -0.16"/>'
        if arrow > 0.06
        else ""
    )
    label = f"car from above at {frame.time_s:.2f} s, {abs(3.6 * frame.speed_m_s):.0f} km/h"
    return (
        f'<svg viewBox="-4.2 -2.6 7.4 5.2" role="img" aria-label="{label}">'
        '<path class="lane" d="M-4.2 -1.75 h7.4 M-4.2 1.75 h7.4"/><path class="middle" d="M-4.2 0 h7.4"/>'
        f'<g transform="scale(1 -1) translate(0 {offset:.3f}) rotate({turn:.2f})">'
        f'<rect class="body" x="{-0.5 * length:.3f}" y="{-0.5 * width:.3f}" width="{length:.3f}" '
        f'height="{width:.3f}" rx="0.45"/>'
        f'<path class="glass" d="M{0.17 * length:.3f} {-0.38 * width:.3f} L{0.06 * length:.3f} {-0.33 * width:.3f} '
        f'V{0.33 * width:.3f} L{0.17 * length:.3f} {0.38 * width:.3f} Z"/>{"".join(tyres)}{force}</g></svg>'
    )
