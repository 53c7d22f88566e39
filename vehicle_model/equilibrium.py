"""Static equilibrium of the car on its springs and tyres, solved exactly."""

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import NDArray

from signals.errors import RunError
from vehicle_model.plant_record import POSITION_TRAVEL, VELOCITY_TRAVEL

_ROTATION, _HEIGHT = (3, 4), 2
_FREE = (_HEIGHT, *_ROTATION, *VELOCITY_TRAVEL)
"""Velocities whose accelerations must vanish: heave, roll, pitch, travel of the wheels."""

_TOLERANCE = 1e-11
_LARGEST_STEP = 0.05


def solve_equilibrium(
    model: mujoco.MjModel, data: mujoco.MjData, support: Callable[[], None], yaw_angle_rad: float
) -> None:
    """Bring the car to rest on its springs at the position and yaw angle of ``data``.

    Tyres give vertical forces only, so that a car on a grade is at rest relative to its own accelerated motion.
    Newton's method on heave, roll, pitch and the four travels with MuJoCo's accelerations as residual.

    Parameters
    ----------
    model, data
        The car; ``data.qpos`` holds the place and gets the solution, velocities become zero.
    support : callable
        Writes the generalised forces of springs and vertical tyre loads for the positions in ``data``.
    yaw_angle_rad : float
        Heading.

    Raises
    ------
    RunError
        If there is no equilibrium (a car that tips over).
    """
    place = data.qpos[:2].copy()
    steer = data.qpos.copy()
    unknown = np.zeros(len(_FREE))
    unknown[0] = data.qpos[_HEIGHT]

    def residual(x: NDArray[np.float64]) -> NDArray[np.float64]:
        data.qpos[:] = steer
        data.qpos[:2] = place
        data.qpos[_HEIGHT] = x[0]
        data.qpos[3:7] = _quaternion(yaw_angle_rad, x[2], x[1])
        data.qpos[list(POSITION_TRAVEL)] = x[3:]
        data.qvel[:] = 0.0
        support()
        mujoco.mj_forward(model, data)
        accelerations: NDArray[np.float64] = data.qacc[list(_FREE)].copy()
        return accelerations

    value = residual(unknown)
    for _ in range(50):
        if np.max(np.abs(value)) < _TOLERANCE:
            return
        jacobian = np.empty((len(_FREE), len(_FREE)))
        for column in range(len(_FREE)):
            moved = unknown.copy()
            moved[column] += 1e-6
            jacobian[:, column] = (residual(moved) - value) / 1e-6
        step = np.linalg.solve(jacobian, -value)
        unknown = unknown + np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
        previous, value = np.max(np.abs(value)), residual(unknown)
        # the last digits of the accelerations are rounding noise
        if np.max(np.abs(value)) >= previous < 1e-8:
            return
    raise RunError("the car finds no static equilibrium", mend="check masses, springs and the road's grade and bank")


def _quaternion(yaw: float, pitch: float, roll: float) -> NDArray[np.float64]:
    """Unit quaternion of yaw, then pitch, then roll."""
    result = np.array([np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)])
    for angle, axis in ((pitch, 2), (roll, 1)):
        turn = np.array([np.cos(angle / 2.0), 0.0, 0.0, 0.0])
        turn[axis] = np.sin(angle / 2.0)
        product = np.empty(4)
        mujoco.mju_mulQuat(product, result, turn)
        result = product
    return result
