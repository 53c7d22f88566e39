"""What every tyre offers: forces and moments at slip, camber, load and pressure, with arrays that broadcast."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from signals.errors import InputError

_UNITS = {
    "slip_ratio": "",
    "slip_angle": "rad",
    "camber": "rad",
    "vertical_load": "N",
    "inflation_pressure": "Pa",
}
LIMITED = tuple(_UNITS)
"""Inputs that have a range for which a tyre was measured, in the order of ``Tyre.forces``."""


class TyreForces(NamedTuple):
    """Forces [N] and moments [N m] on the wheel in TYDEX-W axes (ISO): x forward, y left, z up, at the contact."""

    fx: Any
    fy: Any
    mx: Any
    my: Any
    mz: Any


class TyreSlopes(NamedTuple):
    """Derivatives of the forces by slip ratio [N] and by slip angle [N/rad]."""

    fx_by_slip_ratio: Any
    fx_by_slip_angle: Any
    fy_by_slip_ratio: Any
    fy_by_slip_angle: Any


@dataclass(frozen=True)
class Limits:
    """Range of each input for which a tyre was measured; infinite where a file gives none.

    Attributes
    ----------
    ranges : dict
        Name of the input → (low, high) in SI units.
    """

    ranges: Mapping[str, tuple[float, float]]
    places: Mapping[str, str] = field(default_factory=dict)
    """Name of the input → where its range stands."""

    def check(self, tyre: str, inputs: Mapping[str, NDArray[np.float64]]) -> None:
        """Raise InputError for the first input that is not finite or leaves its range."""
        for name, values in inputs.items():
            low, high = self.ranges.get(name, (-np.inf, np.inf))
            wrong = ~np.isfinite(values) | (values < low) | (values > high)
            if name == "vertical_load":  # a lifted tyre is no error
                wrong &= ~(values <= 0.0)
            if wrong.any():
                worst = values[wrong].ravel()[0]
                unit = _UNITS[name]
                place = f" ({self.places[name]})" if name in self.places else ""
                raise InputError(
                    f"{tyre}: {name} outside the range for which the tyre was measured{place}",
                    found=f"{worst:g} {unit}".rstrip(),
                    allowed=f"{low:g}…{high:g} {unit}".rstrip(),
                    mend="check=False evaluates the formula all the same",
                )


class Tyre(ABC):
    """A tyre in steady state.

    Signs are those of ISO (TYDEX-W): driving slip is positive and gives positive ``fx``; a positive slip angle gives a
    negative ``fy``; the rolling-resistance moment ``my`` is negative when rolling forwards.
    """

    name: str
    limits: Limits

    @property
    @abstractmethod
    def reference(self) -> tuple[float, float]:
        """Inflation pressure [Pa] and speed [m/s] that stand for what a caller leaves out."""

    @abstractmethod
    def evaluate(
        self, inputs: NDArray[np.float64], friction: float, mirrored: bool, forces: NDArray[np.float64]
    ) -> None:
        """Write (Fx, Fy, Mx, My, Mz) into ``forces``, shape (n, 5).

        Parameters
        ----------
        inputs : shape (n, 6)
            Rows of slip ratio, slip angle, camber, load, pressure, speed.
        friction, mirrored
            As in ``forces``.
        """

    def forces(
        self,
        slip_ratio: ArrayLike,
        slip_angle: ArrayLike,
        camber: ArrayLike,
        vertical_load: ArrayLike,
        inflation_pressure: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        *,
        friction: float = 1.0,
        mirrored: bool = False,
        check: bool = True,
    ) -> TyreForces:
        """Forces and moments; arrays broadcast, plain numbers give plain numbers.

        Parameters
        ----------
        slip_ratio
            (R w - v) / |v|, driving positive, locked -1.
        slip_angle, camber : rad
            arctan(v_y/v_x); inclination. Only tyres from ``.tir`` files know camber and pressure.
        vertical_load : N
            Positive; a lifted tyre has no forces.
        inflation_pressure : Pa, optional
            The nominal one if left out.
        speed : m/s, optional
            Speed of the wheel centre, the reference speed if left out.
        friction : float
            Factor of the road on the friction coefficients.
        mirrored : bool
            True for the tyre mounted on the other side of the car than it was measured on.
        check : bool
            Refuse inputs outside the tyre's limits.

        Raises
        ------
        InputError
            If an input is outside the limits.
        """
        pressure, reference_speed = self.reference
        given = (
            slip_ratio,
            slip_angle,
            camber,
            vertical_load,
            pressure if inflation_pressure is None else inflation_pressure,
            reference_speed if speed is None else speed,
        )
        columns = np.broadcast_arrays(*(np.asarray(value, np.float64) for value in given))
        if check:
            self.limits.check(self.name, dict(zip(LIMITED, columns[:5], strict=True)))
        shape = columns[0].shape
        inputs = np.stack([column.ravel() for column in columns], axis=1)
        result = np.empty((inputs.shape[0], 5))
        self.evaluate(inputs, friction, mirrored, result)
        return TyreForces(*(result[:, k].reshape(shape)[()] for k in range(5)))

    def slopes(
        self,
        slip_ratio: ArrayLike,
        slip_angle: ArrayLike,
        camber: ArrayLike,
        vertical_load: ArrayLike,
        inflation_pressure: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        *,
        friction: float = 1.0,
    ) -> TyreSlopes:
        """Derivatives of the forces by both slips (central differences)."""
        kappa, alpha = np.asarray(slip_ratio, np.float64), np.asarray(slip_angle, np.float64)
        rest = (camber, vertical_load, inflation_pressure, speed)

        def at(more_kappa: float, more_alpha: float) -> TyreForces:
            return self.forces(kappa + more_kappa, alpha + more_alpha, *rest, friction=friction, check=False)

        step = 1e-6
        by_kappa = [at(step, 0.0), at(-step, 0.0)]
        by_alpha = [at(0.0, step), at(0.0, -step)]
        return TyreSlopes(
            (by_kappa[0].fx - by_kappa[1].fx) / (2.0 * step),
            (by_alpha[0].fx - by_alpha[1].fx) / (2.0 * step),
            (by_kappa[0].fy - by_kappa[1].fy) / (2.0 * step),
            (by_alpha[0].fy - by_alpha[1].fy) / (2.0 * step),
        )
