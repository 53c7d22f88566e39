"""Columns that do what others do together: their slopes are sums of those, and no differences of their own."""

from collections.abc import Mapping, Sequence

import numpy as np

from model_diagnosis.effects.in_common import IN_COMMON

_REFLECTED = "wheel_inertia_reflected.inertia"
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
