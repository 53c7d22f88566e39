"""Pictures of the car from MuJoCo's renderer, without a screen.

The drawing happens in a process of its own: MuJoCo chooses its graphics library when it is imported, a driver that
fails takes its process with it, and the process of a run has imported MuJoCo long before.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.report.car_scene import Pose
from signals.errors import RunError

LIBRARIES = ("egl", "osmesa")
TIMEOUT_S = 120.0
HINT = "sudo apt-get install libegl1 libgl1-mesa-dri   (or libosmesa6), then again; with a screen: --viewer"


@dataclass(frozen=True)
class View:
    """Camera and size of a picture.

    Attributes
    ----------
    azimuth_deg, elevation_deg
        Direction of view; 0 looks along the road, 90 to the left.
    distance
        From the car's middle, in lengths of the car.
    """

    width: int = 1280
    height: int = 720
    azimuth_deg: float = 140.0
    elevation_deg: float = -16.0
    distance: float = 1.35


def render_car(vehicle: str, poses: Sequence[Pose], paths: Sequence[Path], view: View | None = None) -> None:
    """Draw the car in each pose into a PNG file.

    Parameters
    ----------
    vehicle : str
        Name or path of a vehicle file.
    poses, paths
        As many of one as of the other.

    Raises
    ------
    RunError
        If no graphics library of this machine can draw without a screen.
    """
    request = {
        "vehicle": vehicle,
        "poses": [asdict(pose) for pose in poses],
        "paths": [str(path) for path in paths],
        "view": asdict(view or View()),
    }
    failures = []
    for library in LIBRARIES:
        try:
            done = subprocess.run(
                [sys.executable, "-m", "bench.report.car_render"],
                input=json.dumps(request),
                capture_output=True,
                text=True,
                timeout=TIMEOUT_S,
                env={**os.environ, "MUJOCO_GL": library, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
        except subprocess.TimeoutExpired:
            failures.append(f"{library}: no answer within {TIMEOUT_S:g} s")
            continue
        if done.returncode == 0:
            return
        last = (done.stderr.strip().splitlines() or [f"ended with {done.returncode}"])[-1]
        failures.append(f"{library}: {last[:150]}")
    raise RunError("the car cannot be drawn: no graphics library works here", found="; ".join(failures), mend=HINT)


def draw(request: dict[str, object]) -> None:
    """Draw the pictures of a request in this process."""
    import mujoco
    from matplotlib.image import imsave

    from bench.report.car_scene import scene
    from vehicle_model.vehicle_file import load_vehicle

    vehicle = load_vehicle(str(request["vehicle"]))
    view = View(**request["view"])  # type: ignore[arg-type]
    model = mujoco.MjModel.from_xml_string(scene(vehicle))
    data = mujoco.MjData(model)
    camera = mujoco.MjvCamera()
    camera.azimuth, camera.elevation = view.azimuth_deg, view.elevation_deg
    camera.distance = view.distance * vehicle.body.length
    middle = vehicle.body.centre_of_gravity_to_front_axle - 0.5 * vehicle.body.wheelbase
    with mujoco.Renderer(model, view.height, view.width) as renderer:
        for values, path in zip(request["poses"], request["paths"], strict=True):  # type: ignore[call-overload]
            pose = Pose(**values)
            data.qpos[:] = pose.positions(vehicle.body.centre_of_gravity_height)
            mujoco.mj_forward(model, data)
            camera.lookat[:] = data.body("chassis").xpos + middle * data.body("chassis").xmat.reshape(3, 3)[:, 0]
            renderer.update_scene(data, camera)
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            imsave(path, renderer.render())


if __name__ == "__main__":
    draw(json.load(sys.stdin))
