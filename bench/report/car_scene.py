"""The car as something to look at: MuJoCo's model with bodywork, wheels and road, and its pose at an instant.

The joints stand in the order of the plant's, so that its positions fit as they are.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from signals.wheels import WHEELS

if TYPE_CHECKING:
    from vehicle_model.vehicle_file import VehicleFile

_PAINT, _GLASS, _RUBBER, _RIM, _LIGHT, _REAR_LIGHT = (
    "0.05 0.30 0.62 1",
    "0.10 0.13 0.17 1",
    "0.06 0.06 0.07 1",
    "0.75 0.77 0.80 1",
    "1 0.97 0.85 1",
    "0.75 0.05 0.05 1",
)
_HULLS = {"body": _PAINT, "windows": _GLASS, "roof": _PAINT}
_NO_PHYSICS = 'contype="0" conaffinity="0" mass="1"'
_TYRE_WIDTH_M = 0.2
_SPOKES = 5


@dataclass(frozen=True)
class Pose:
    """Where the car stands and how; angles in rad, lengths in m, wheels in the usual order."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    travel: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    steer: tuple[float, float] = (0.0, 0.0)
    spin: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)

    def positions(self, height: float) -> list[float]:
        """MuJoCo's positions; ``height`` of the centre of gravity at rest [m]."""
        half = (0.5 * self.roll, 0.5 * self.pitch, 0.5 * self.yaw)
        (cr, cp, cy), (sr, sp, sy) = map(math.cos, half), map(math.sin, half)
        quaternion = [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
        values = [self.x, self.y, height, *quaternion]
        for number in range(4):
            values.append(self.travel[number])
            if number < 2:
                values.append(self.steer[number])
            values.append(self.spin[number])
        return values


def scene(vehicle: "VehicleFile") -> str:
    """MJCF text of the car on a level road, as large as its file says."""
    body = vehicle.body
    height = body.centre_of_gravity_height
    front, rear = body.centre_of_gravity_to_front_axle, body.centre_of_gravity_to_front_axle - body.wheelbase
    wheels = "".join(
        _wheel(name, front if name[0] == "f" else rear, (1 if name[1] == "l" else -1) * 0.5 * track, height, radius)
        for name, track, radius in (
            (w, getattr(vehicle.axles, "front" if w[0] == "f" else "rear").track, getattr(vehicle.wheels, w).radius)
            for w in WHEELS
        )
    )
    return (
        '<mujoco model="car"><compiler angle="radian" autolimits="false"/>'
        '<option gravity="0 0 0"/>'
        '<visual><global offwidth="1920" offheight="1080"/><headlight ambient=".35 .35 .35" diffuse=".45 .45 .45"/>'
        '<quality shadowsize="4096"/></visual>'
        '<asset><texture name="sky" type="skybox" builtin="gradient" rgb1=".75 .84 .93" rgb2=".97 .98 1" '
        'width="256" height="256"/><texture name="road" type="2d" builtin="checker" rgb1=".36 .37 .39" '
        'rgb2=".41 .42 .44" width="256" height="256"/><material name="road" texture="road" texrepeat="1 1" '
        f'texuniform="true"/>{_meshes(vehicle)}</asset><worldbody>'
        '<geom type="plane" size="0 0 1" material="road" contype="0" conaffinity="0"/>'
        '<body name="chassis"><freejoint name="chassis"/>'
        '<light mode="track" pos="-4 -6 12" dir=".3 .45 -1" diffuse=".6 .6 .6" directional="true"/>'
        f"{_bodywork(vehicle, height)}{wheels}</body>"
        "</worldbody></mujoco>"
    )


def _bodywork(vehicle: "VehicleFile", height: float) -> str:
    """A saloon inside the length, width and height of the file, with arches for its wheels."""
    body = vehicle.body
    width, total = body.width, body.height
    axle = body.centre_of_gravity_to_front_axle
    nose, tail = _ends(vehicle)
    radius = vehicle.wheels.fl.radius
    clearance, arch, waist = 0.16, 2.0 * radius + 0.02, 0.63 * total
    gap = radius + 0.06
    parts = [_box(tail + 0.05, nose - 0.05, width - 0.5, clearance, arch, height, _PAINT)]
    for back, front in (
        (tail, axle - body.wheelbase - gap),
        (axle - body.wheelbase + gap, axle - gap),
        (axle + gap, nose),
    ):
        parts.append(_box(back, front, width - 0.04, clearance, arch, height, _PAINT))
    parts += [f'<geom type="mesh" mesh="{name}" rgba="{colour}" {_NO_PHYSICS}/>' for name, colour in _HULLS.items()]
    for side in (1, -1):
        at = side * (0.5 * width - 0.24)
        parts.append(_lamp(nose - 0.03, at, 0.5 * (arch + waist) - 0.09 - height, _LIGHT))
        parts.append(_lamp(tail + 0.03, at, 0.5 * (arch + waist) - 0.05 - height, _REAR_LIGHT))
    return "".join(parts)


def _ends(vehicle: "VehicleFile") -> tuple[float, float]:
    """x of the front and the rear end: a little more than a third of the overhangs is in front."""
    body = vehicle.body
    nose = body.centre_of_gravity_to_front_axle + 0.42 * (body.length - body.wheelbase)
    return nose, nose - body.length


def _meshes(vehicle: "VehicleFile") -> str:
    """Bonnet and boot, windows, roof as convex hulls of their corners."""
    body = vehicle.body
    nose, tail = _ends(vehicle)
    axle, total = body.centre_of_gravity_to_front_axle, body.height
    low, waist = 2.0 * vehicle.wheels.fl.radius + 0.02, 0.63 * total
    full, shoulder, top = 0.5 * body.width - 0.02, 0.5 * body.width - 0.12, 0.5 * body.width - 0.3
    screen, back = axle - 0.18 * body.wheelbase, axle - 1.2 * body.wheelbase
    roof_front, roof_back = screen - 0.75, back + 0.5
    hulls = {
        "body": [
            *_rectangle(tail, nose, full, low),
            *_rectangle(tail + 0.03, nose - 0.04, full, waist - 0.22),
            *_rectangle(tail + 0.12, screen + 0.1, shoulder, waist),
            *_rectangle(screen, nose - 0.22, shoulder, waist - 0.12),
        ],
        "windows": [
            *_rectangle(back, screen, shoulder - 0.02, waist - 0.01),
            *_rectangle(roof_back, roof_front, top, total - 0.03),
        ],
        "roof": [
            *_rectangle(roof_back - 0.02, roof_front + 0.02, top + 0.01, total - 0.06),
            *_rectangle(roof_back + 0.12, roof_front - 0.12, top - 0.08, total),
        ],
    }
    height = body.centre_of_gravity_height
    return "".join(
        f'<mesh name="{name}" vertex="{" ".join(f"{x} {y} {z - height}" for x, y, z in corners)}"/>'
        for name, corners in hulls.items()
    )


def _rectangle(rear: float, front: float, half_width: float, z: float) -> list[tuple[float, float, float]]:
    return [(x, y, z) for x in (rear, front) for y in (-half_width, half_width)]


def _box(rear: float, front: float, width: float, low: float, high: float, origin: float, colour: str) -> str:
    place = f"{0.5 * (rear + front)} 0 {0.5 * (low + high) - origin}"
    size = f"{0.5 * (front - rear)} {0.5 * width} {0.5 * (high - low)}"
    return f'<geom type="box" pos="{place}" size="{size}" rgba="{colour}" {_NO_PHYSICS}/>'


def _lamp(x: float, y: float, z: float, colour: str) -> str:
    return f'<geom type="ellipsoid" pos="{x} {y} {z}" size=".05 .17 .06" rgba="{colour}" {_NO_PHYSICS}/>'


def _wheel(name: str, x: float, y: float, height: float, radius: float) -> str:
    steer = f'<joint name="steer_{name}" type="hinge" axis="0 0 1"/>' if name[0] == "f" else ""
    half = 0.5 * _TYRE_WIDTH_M
    outside = half if name[1] == "l" else -half
    spokes = "".join(
        f'<geom type="box" pos="{0.28 * radius * math.cos(a)} {1.02 * outside} {0.28 * radius * math.sin(a)}" '
        f'euler="0 {-a} 0" size="{0.3 * radius} .012 {0.06 * radius}" rgba="{_RIM}" {_NO_PHYSICS}/>'
        for a in (2.0 * math.pi * k / _SPOKES for k in range(_SPOKES))
    )
    return (
        f'<body name="wheel_{name}" pos="{x} {y} {radius - height}">'
        f'<joint name="travel_{name}" type="slide" axis="0 0 1"/>{steer}'
        f'<joint name="spin_{name}" type="hinge" axis="0 1 0"/>'
        f'<geom type="cylinder" size="{radius} {half}" euler="{0.5 * math.pi} 0 0" rgba="{_RUBBER}" {_NO_PHYSICS}/>'
        f'<geom type="cylinder" pos="0 {0.96 * outside} 0" size="{0.64 * radius} .012" euler="{0.5 * math.pi} 0 0" '
        f'rgba="0.3 0.31 0.33 1" {_NO_PHYSICS}/>{spokes}</body>'
    )
