"""What every plant offers: the MuJoCo car and the single-track cars of the source documents stand behind it."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from signals.catalogue import block_slice, catalogue

TIME_STEP_S = 0.001

PLANT_OUTPUTS: tuple[str, ...] = tuple(signal.name for signal in catalogue()[block_slice("plant")])


class Plant(Protocol):
    """A car on a road, advanced by 1 ms ticks.

    Axes are ISO 8855. The road's axes are the inertial ones: x along the road, y to the left, z normal to it; grade and
    bank turn gravity. ``speed``, ``lateral_speed`` and the accelerations are components along the car's heading in the
    road's plane (intermediate axes), without gravity; angular rates are those of a gyroscope fixed to the body.
    """

    time_step_s: float
    outputs: NDArray[np.float64]
    """Block "plant" of the catalogue (names in ``PLANT_OUTPUTS``), written by every tick."""

    def bind(self, view: NDArray[np.float64]) -> None:
        """Write the outputs into ``view`` (shape of ``outputs``) from now on."""

    def reset(
        self,
        *,
        speed_m_s: float,
        position_x_m: float = 0.0,
        position_y_m: float = 0.0,
        yaw_angle_rad: float = 0.0,
        time_s: float = 0.0,
    ) -> None:
        """Static equilibrium, moving at ``speed_m_s`` with freely rolling wheels; energies and distance are zero."""

    def tick(
        self, brake_torque: NDArray[np.float64], drive_torque: NDArray[np.float64], steer: float, time_s: float
    ) -> None:
        """Advance by 1 ms.

        Parameters
        ----------
        brake_torque : shape (4,), N m
            Torque that each brake can transmit, not negative; a wheel stands while less than that turns it.
        drive_torque : shape (4,), N m
            Drive torque at each wheel, positive forwards.
        steer : float, rad
            Steering-wheel angle, positive to the left.
        time_s : float
            Time of the run at the start of the tick; roads that change with time use it.
        """

    def step(self, n: int, *, brake_torque: ArrayLike = 0.0, drive_torque: ArrayLike = 0.0, steer: float = 0.0) -> None:
        """Advance by ``n`` ticks with constant inputs (scalars or one value per wheel)."""

    def names(self) -> Sequence[str]:
        """Dotted paths of every parameter, the road's as ``road.…``."""

    def get(self, path: str) -> float:
        """Value of a parameter in SI units; InputError if there is none of that path."""

    def set(self, path: str, value: float) -> None:
        """Change a parameter from the next tick on; InputError if there is none or the value is refused."""

    def state(self) -> dict[str, float]:
        """Outputs of the last tick by name."""
