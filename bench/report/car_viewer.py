"""The car in MuJoCo's own window, to turn and to look at from all sides."""

import math
import os
import time

from bench.report.car_render import View
from bench.report.car_scene import Pose, scene
from signals.errors import RunError
from vehicle_model.vehicle_file import VehicleFile

_FRAME_S = 1.0 / 60.0


def show(vehicle: VehicleFile) -> None:
    """Open the window and return when it is closed; the wheels turn and steer slowly.

    Raises
    ------
    RunError
        If there is no screen.
    """
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RunError(
            "no screen for the viewer: neither DISPLAY nor WAYLAND_DISPLAY is set",
            mend="draw into a file instead: bench vehicle show CAR --out car.png",
        )
    import mujoco
    import mujoco.viewer

    model = mujoco.MjModel.from_xml_string(scene(vehicle))
    data = mujoco.MjData(model)
    height, view = vehicle.body.centre_of_gravity_height, View()
    with mujoco.viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False) as window:
        with window.lock():  # MuJoCo's own choice stands inside the car
            window.cam.lookat[:] = 0.0, 0.0, height
            window.cam.distance = view.distance * vehicle.body.length
            window.cam.azimuth, window.cam.elevation = view.azimuth_deg, view.elevation_deg
        began = time.monotonic()
        while window.is_running():
            elapsed = time.monotonic() - began
            steer = 0.4 * math.sin(0.6 * elapsed)
            data.qpos[:] = Pose(steer=(steer, steer), spin=(elapsed,) * 4).positions(height)
            mujoco.mj_forward(model, data)
            window.sync()
            time.sleep(_FRAME_S)
