"""The car to look at: joints as in the plant, size as in the file, a picture with something in it, clear errors."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from bench.report.car_render import HINT, View, render_car
from bench.report.car_scene import Pose, scene
from bench.report.car_viewer import show
from signals.errors import RunError
from vehicle_model import Plant, load_vehicle
from vehicle_model.vehicle_file import vehicle_names


@pytest.mark.parametrize("name", vehicle_names())
def test_scene_has_the_joints_of_the_plant_and_the_size_of_the_file(name: str) -> None:
    vehicle = load_vehicle(name)
    model = mujoco.MjModel.from_xml_string(scene(vehicle))
    plant = Plant(load_vehicle("ekf_car"))._model
    assert [model.joint(k).name for k in range(model.njnt)] == [plant.joint(k).name for k in range(plant.njnt)]
    data = mujoco.MjData(model)
    data.qpos[:] = Pose().positions(vehicle.body.centre_of_gravity_height)
    mujoco.mj_forward(model, data)
    wheels = np.array([data.body(f"wheel_{w}").xpos for w in ("fl", "fr", "rl", "rr")])
    assert wheels[0, 0] - wheels[2, 0] == pytest.approx(vehicle.body.wheelbase)
    assert wheels[0, 1] - wheels[1, 1] == pytest.approx(vehicle.axles.front.track)
    assert wheels[:, 2] == pytest.approx([getattr(vehicle.wheels, w).radius for w in ("fl", "fr", "rl", "rr")])


def test_pose_turns_the_car_in_the_order_of_iso_8855() -> None:
    model = mujoco.MjModel.from_xml_string(scene(load_vehicle("ekf_car")))
    data = mujoco.MjData(model)
    data.qpos[:] = Pose(x=3.0, y=-2.0, yaw=0.5, pitch=0.2, roll=0.1).positions(0.5)
    mujoco.mj_forward(model, data)
    forward, left, _ = data.body("chassis").xmat.reshape(3, 3).T
    # yaw about z, then pitch nose down about y, then roll: x axis (cos ψ cos θ, sin ψ cos θ, -sin θ)
    assert forward == pytest.approx([np.cos(0.5) * np.cos(0.2), np.sin(0.5) * np.cos(0.2), -np.sin(0.2)])
    assert left[2] == pytest.approx(np.cos(0.2) * np.sin(0.1))


def test_picture_shows_a_blue_car_before_a_bright_sky(tmp_path: Path) -> None:
    from matplotlib.image import imread

    path = tmp_path / "car.png"
    try:
        render_car("ekf_car", [Pose()], [path], View(width=320, height=180))
    except RunError as error:
        pytest.skip(f"no off-screen graphics here: {HINT}; {error.found}")
    picture = imread(path)[:, :, :3]
    assert picture.shape == (180, 320, 3)
    blue = (picture[:, :, 2] > 1.6 * picture[:, :, 0]) & (picture[:, :, 2] > 0.2)
    assert 0.03 < blue.mean() < 0.5
    assert picture[:10].mean() > 0.7


def test_machine_without_graphics_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("bench.report.car_render.LIBRARIES", ("no_such_library",))
    with pytest.raises(RunError, match=r"apt-get install libegl1") as caught:
        render_car("ekf_car", [Pose()], [tmp_path / "car.png"])
    assert "no_such_library" in caught.value.found
    assert caught.value.exit_code == 4


def test_viewer_without_a_screen_points_to_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert "DISPLAY" not in os.environ
    with pytest.raises(RunError, match=r"bench vehicle show CAR --out"):
        show(load_vehicle("ekf_car"))


@pytest.mark.skipif(shutil.which("Xvfb") is None, reason="no virtual screen here: sudo apt-get install xvfb")
def test_viewer_opens_on_a_screen_with_the_whole_car_in_sight(tmp_path: Path) -> None:
    """On a screen in memory, whose file is an XWD dump: 24 bits of colour in 4 bytes, blue first, at its end."""
    width, height = 1024, 768
    reading, writing = os.pipe()
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", f"{width}x{height}x24", "-fbdir", str(tmp_path)]
    with subprocess.Popen(command, pass_fds=(writing,), stderr=subprocess.DEVNULL) as screen:
        os.close(writing)
        with os.fdopen(reading) as number:
            display = f":{number.readline().strip()}"
        program = [sys.executable, "-m", "bench.cli", "vehicle", "show", "ekf_car", "--viewer"]
        environment = {**os.environ, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}
        with subprocess.Popen(program, env=environment, stderr=subprocess.PIPE, text=True) as window:
            try:
                for _ in range(240):  # first the window, then the first frame, then the camera
                    time.sleep(0.5)
                    assert window.poll() is None, window.stderr and window.stderr.read()
                    pixels = (tmp_path / "Xvfb_screen0").read_bytes()[-4 * width * height :]
                    if shows_a_whole_car(np.frombuffer(pixels, np.uint8).reshape(height, width, 4)):
                        return
            finally:
                window.terminate()
                screen.terminate()
    raise AssertionError("the viewer never shows the whole car")


def shows_a_whole_car(screen: NDArray[np.uint8]) -> bool:
    """Something blue in the window, with room around it; the screen beside the window is black."""
    blue, red = screen[:, :, 0].astype(float), screen[:, :, 2].astype(float)
    car = (blue > 1.6 * red) & (blue > 50.0)
    rows, columns = car.any(axis=1), car.any(axis=0)
    window = screen[:, :, :3].any(axis=2)
    if not rows.any() or rows[:10].any() or columns[:10].any():
        return False
    return bool(0.03 < car.sum() / window.sum() < 0.5 and window[np.flatnonzero(rows)[-1] + 10 :].any())
