"""The multibody car as a MuJoCo model: free chassis, four suspension slides, two steer hinges, four wheel hinges.

Every force comes from our own compiled step, so contacts and constraints are off, and nothing in the model has
stiffness or damping. Each wheel is one body with its joints in the order travel, steer, spin.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from signals.wheels import WHEELS
from vehicle_model.plant_record import POSITIONS, VELOCITIES
from vehicle_model.rigid_bodies import RigidBodies

_OFF = (
    "constraint equality frictionloss limit contact spring damper actuation sensor warmstart midphase autoreset island"
)


def _numbers(values: "np.typing.ArrayLike") -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def _wheel(bodies: RigidBodies, index: int) -> str:
    name = WHEELS[index]
    steer = f'<joint name="steer_{name}" type="hinge" axis="0 0 1"/>' if index < 2 else ""
    transverse, spin = bodies.transverse_inertia[index], bodies.spin_inertia[index]
    return (
        f'<body name="wheel_{name}" pos="{_numbers(bodies.wheel_positions[index])}">'
        f'<inertial pos="0 0 0" mass="{float(bodies.unsprung_mass[index])!r}" '
        f'diaginertia="{_numbers([transverse, spin, transverse])}"/>'
        f'<joint name="travel_{name}" type="slide" axis="0 0 1"/>{steer}'
        f'<joint name="spin_{name}" type="hinge" axis="0 1 0"/></body>'
    )


def mjcf(bodies: RigidBodies, time_step_s: float) -> str:
    """Model of the car as MJCF text; its only world is the road's plane with z normal to it."""
    inertia = bodies.sprung_inertia
    full = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    flags = " ".join(f'{name}="disable"' for name in _OFF.split())
    return (
        '<mujoco model="car"><compiler angle="radian" autolimits="false" balanceinertia="true"/>'
        f'<option timestep="{time_step_s!r}" integrator="Euler" gravity="0 0 -9.81"><flag {flags}/></option>'
        f'<worldbody><body name="chassis"><freejoint name="chassis"/><inertial pos="{_numbers(bodies.sprung_centre)}" '
        f'mass="{bodies.sprung_mass!r}" fullinertia="{_numbers(full)}"/>'
        f"{''.join(_wheel(bodies, index) for index in range(4))}</body></worldbody></mujoco>"
    )


def build_model(bodies: RigidBodies, time_step_s: float) -> mujoco.MjModel:
    """Compile the model of the car."""
    model = mujoco.MjModel.from_xml_string(mjcf(bodies, time_step_s))
    if (model.nq, model.nv) != (POSITIONS, VELOCITIES):
        raise ValueError(
            f"the model has {model.nq} positions and {model.nv} velocities, expected {POSITIONS, VELOCITIES}"
        )
    return model


def write_slides(model: mujoco.MjModel, slides: NDArray[np.float64]) -> None:
    """Change the lines along which the wheels travel (shape ``(4, 3)``, movement per travel) of a model in use."""
    for wheel, slide in zip(WHEELS, slides, strict=True):
        model.joint(f"travel_{wheel}").axis[:] = slide


def write_bodies(model: mujoco.MjModel, scratch: mujoco.MjData, bodies: RigidBodies) -> None:
    """Change masses, inertias and wheel places of a model in use; ``scratch`` is data of it that nobody else uses."""
    principal, axes = np.linalg.eigh(bodies.sprung_inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, axes.ravel())
    model.body_mass[1] = bodies.sprung_mass
    model.body_inertia[1] = principal
    model.body_ipos[1] = bodies.sprung_centre
    model.body_iquat[1] = quaternion
    for index in range(4):
        transverse, spin = bodies.transverse_inertia[index], bodies.spin_inertia[index]
        model.body_pos[2 + index] = bodies.wheel_positions[index]
        model.body_mass[2 + index] = bodies.unsprung_mass[index]
        model.body_inertia[2 + index] = (transverse, spin, transverse)
    # recomputes the masses of subtrees, in the rest position of the data that it is given
    mujoco.mj_setConst(model, scratch)
