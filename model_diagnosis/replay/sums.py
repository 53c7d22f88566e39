"""Columns that do what others do together: their slopes are sums of those, and no differences of their own."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.in_common import IN_COMMON
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

_REFLECTED = "wheel_inertia_reflected.inertia"
_PADS, _BALANCE = "brake_pad_friction.factor", "brake_balance.shift"
_OWN_GAINS = tuple(f"wheel_brake_weak.{wheel}" for wheel in WHEELS)
_WHEEL_INERTIA = (("form_wheel_inertia.front", slice(0, 2)), ("form_wheel_inertia.rear", slice(2, 4)))


def sums_of(columns: Sequence[str], car: np.void) -> dict[int, dict[int, float]]:
    """Place of such a column -> places of those it adds up from, and how much each one's deviation moves by 1 of its.

    ``car`` is the record without any deviation.
    """
    place = {name: index for index, name in enumerate(columns)}
    stated: dict[str, Mapping[str, float]] = {common: dict.fromkeys(axles, 1.0) for common, axles in IN_COMMON.items()}
    stated[_REFLECTED] = _wheel_inertias(car)
    return {
        place[name]: {place[part]: share for part, share in parts.items()}
        for name, parts in stated.items()
        if parts and name in place and all(part in place for part in parts)
    }


class BrakeGains:
    """Factors on the brakes of all wheels or axles in terms of each wheel's own: all of them multiply its gain.

    Places of columns are those of ``columns``; ``car`` is the record without any deviation.
    """

    def __init__(self, columns: Sequence[str], car: np.void) -> None:
        place = {name: index for index, name in enumerate(columns)}
        torque = car["torque_per_pressure"]
        self._ratio = float(torque[0] / torque[2]) if torque[2] > 0.0 else 0.0
        self._wheels = [place[name] for name in _OWN_GAINS if name in place]
        is_whole = len(self._wheels) == len(_OWN_GAINS)
        self.columns = {place[name]: name for name in (_PADS, _BALANCE) if is_whole and name in place}

    def shares(self, column: int, theta: FloatArray) -> dict[int, float]:
        """How much each wheel's own deviation moves by 1 of this column's, at theta (p,)."""
        at = float(theta[column])
        if self.columns[column] == _PADS:
            relative = [1.0 / (1.0 + at)] * len(self._wheels)
        else:
            left = 1.0 - at * self._ratio
            rear = -self._ratio / left if left > 0.0 else 0.0
            relative = [1.0 / (1.0 + at)] * 2 + [rear] * 2
        return {own: float(1.0 + theta[own]) * share for own, share in zip(self._wheels, relative, strict=True)}


def _wheel_inertias(car: np.void) -> dict[str, float]:
    """What 1 kg m^2 at every driven wheel is of its axles' inertia; nothing where an axle's wheels differ."""
    shares = {}
    for name, wheels in _WHEEL_INERTIA:
        driven, inertia = car["drive_share"][wheels] > 0.0, car["spin_inertia"][wheels]
        if driven.any():
            if not driven.all() or inertia[0] != inertia[1]:
                return {}
            shares[name] = float(1.0 / inertia[0])
    return shares
