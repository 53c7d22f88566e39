"""Swapped wheels: the order of the four wheel-speed channels that fits turning and braking best."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from model_diagnosis.data.faults import joined
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import GRAVITY, Motion, members, reached
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from signals.wheels import WHEELS

_MARGIN = 20.0
_BLOCK_S = 0.5
_MODEL_ERROR = 0.003
"""Relative error of the expected wheel speeds, root mean square: slip angles, radii under load."""
_NAMES = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_SLIP_PER_M_S2 = 0.01
"""Usual slip of an axle per acceleration that its force makes, 1/(m/s²), with half of the weight on it: 2/(K g), K = 20
the slip stiffness over load."""
_SLIP_FACTORS = (0.4, 1.0, 2.0)
_LINEAR_M_S2 = 5.0
"""Acceleration up to which slip goes with force over load: near the limit an axle slips as its control lets it."""
_STRAIGHT, _GENTLE_M_S2 = 0.002, 2.0
"""Relative difference of wheel speeds by turning beyond which it may be no more than that acceleration: the lighter
inner wheel of a driven axle slips by as much more as the whole axle does (tuning seeds 407 and 607)."""
_LEAST_SHARE = 0.2
"""Share of the weight that an axle keeps at any rate."""


def check_swapped_wheels(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name and undo a permutation of the wheel speeds where it fits better by more than 20 in log likelihood."""
    blocks = [rows for m in manoeuvres if (rows := _blocks(m, geometry)) is not None]
    if not blocks:
        return [], list(manoeuvres)
    measured = np.concatenate([b[0] for b in blocks])
    turning = np.concatenate([b[1] for b in blocks])
    slipping = np.concatenate([b[2] for b in blocks])
    costs = {order: _cost(measured[:, order], turning, slipping) for order in permutations(range(4))}
    identity = (0, 1, 2, 3)
    best = min(costs, key=lambda order: costs[order])
    margin = costs[identity] - costs[best]
    second = min(cost for order, cost in costs.items() if order != best)
    if best == identity or margin < _MARGIN or second - costs[best] < 0.25 * _MARGIN:
        return [], list(manoeuvres)
    return [_fault(best, margin)], [_reordered(m, best) for m in manoeuvres]


def _blocks(manoeuvre: Manoeuvre, geometry: Geometry) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Means over half seconds: wheel speeds over their mean, expected from turning, and axles' slip (b, 4) each."""
    motion = Motion(manoeuvre, geometry)
    rims = motion.rim_speeds()
    yaw_rate = manoeuvre.channels.get("yaw_rate")
    if rims is None:
        return None
    mean = np.mean(rims, axis=1)
    if yaw_rate is None and "lateral_acceleration" in manoeuvre.channels:
        yaw_rate = manoeuvre.channels["lateral_acceleration"] / np.maximum(mean, 2.0)
    if yaw_rate is None:
        yaw_rate = np.zeros(manoeuvre.samples)
    rolling = mean > 4.0
    for name in _NAMES:
        rolling &= reached(manoeuvre, name)
    turning = _turning(motion, geometry, mean, yaw_rate)
    slipping, commanded = _slipping(motion)
    relative = rims / np.maximum(mean, 1.0)[:, None] - 1.0
    rolling &= np.max(np.abs(relative), axis=1) < 0.15
    straight = np.max(np.abs(turning), axis=1) < _STRAIGHT
    rolling &= np.abs(commanded) < np.where(straight, _LINEAR_M_S2, _GENTLE_M_S2)
    size = round(_BLOCK_S / SAMPLE_TIME_S)
    rows = [
        (relative[k : k + size].mean(0), turning[k : k + size].mean(0), slipping[k : k + size].mean(0))
        for k in range(0, manoeuvre.samples - size + 1, size)
        if rolling[k : k + size].all()
    ]
    if not rows:
        return None
    return np.array([r[0] for r in rows]), np.array([r[1] for r in rows]), np.array([r[2] for r in rows])


def _turning(motion: Motion, geometry: Geometry, speed: FloatArray, yaw_rate: FloatArray) -> FloatArray:
    """Relative differences of the wheel speeds in a turn without slip, (n, 4)."""
    angle = _road_wheel_angle(motion, geometry, speed, yaw_rate)
    pace = np.maximum(speed, 1.0)
    columns = []
    for wheel in WHEELS:
        side = -1.0 if wheel[1] == "l" else 1.0
        track = geometry.track_front if wheel[0] == "f" else geometry.track_rear
        along = side * 0.5 * track * yaw_rate / pace
        if wheel[0] == "f":
            along = along + angle * geometry.wheelbase * yaw_rate / pace - 0.5 * angle**2
        columns.append(along)
    relative: FloatArray = np.stack(columns, axis=1)
    return relative - relative.mean(axis=1, keepdims=True)


def _road_wheel_angle(motion: Motion, geometry: Geometry, speed: FloatArray, yaw_rate: FloatArray) -> FloatArray:
    names = members("steering", list(motion.channels))
    if not names:
        return geometry.wheelbase * yaw_rate / np.maximum(speed, 2.0)
    return motion.channels[names[0]] / (geometry.steering_ratio if names[0] == "steering_wheel_angle" else 1.0)


def _slipping(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Slips that pressures and drive torques ask for, (n, 4) with mean 0, and the acceleration (n,) that they make."""
    samples, geometry = motion.manoeuvre.samples, motion.geometry
    gains, channels = geometry.brake_gains, motion.channels
    per_axle = {"f": np.zeros(samples), "r": np.zeros(samples)}
    for wheel in WHEELS:
        name = f"brake_pressure_{wheel}" if f"brake_pressure_{wheel}" in channels else "master_pressure"
        if name in channels:
            force = gains[wheel] * channels[name] / motion.geometry.radii[wheel]
            per_axle[wheel[0]] -= force / motion.geometry.mass
    for axle in ("f", "r"):
        if f"drive_torque_{axle}" in channels:
            force = channels[f"drive_torque_{axle}"] / motion.geometry.radii[f"{axle}l"]
            per_axle[axle] += force / motion.geometry.mass
    commanded = per_axle["f"] + per_axle["r"]
    moved = commanded * geometry.height / (GRAVITY * geometry.wheelbase)
    on_front = np.clip(1.0 - geometry.to_front / geometry.wheelbase - moved, _LEAST_SHARE, 1.0 - _LEAST_SHARE)
    share = {"f": on_front, "r": 1.0 - on_front}
    slips: FloatArray = _SLIP_PER_M_S2 * np.stack([0.5 * per_axle[w[0]] / share[w[0]] for w in WHEELS], axis=1)
    return slips - slips.mean(axis=1, keepdims=True), commanded


def _cost(measured: FloatArray, turning: FloatArray, slipping: FloatArray) -> float:
    """Half the squared misfit over its variance; radii are free within 1 %, the slip per force within a factor."""
    costs = []
    for factor in _SLIP_FACTORS:
        misfit = measured - turning - factor * slipping
        radius = misfit.mean(axis=0) * len(misfit) / (len(misfit) + (_MODEL_ERROR / 0.01) ** 2)
        spread = np.hypot(_MODEL_ERROR, 0.3 * np.abs(factor * slipping))
        costs.append(
            float(
                np.sum(np.minimum(((misfit - radius) / spread) ** 2, 25.0)) / 2.0 + np.sum((radius / 0.01) ** 2) / 2.0
            )
        )
    return min(costs)


def _fault(order: Sequence[int], margin: float) -> DataFault:
    moved = [_NAMES[k] for k in range(4) if order[k] != k]
    pairs = ", ".join(f"{WHEELS[k]} holds {WHEELS[order.index(k)]}" for k in range(4) if order[k] != k)
    return DataFault(
        kind="channel_swap",
        channel=joined(moved),
        value=float(len(moved)),
        unit="1",
        evidence=margin,
        repaired=True,
        message=f"wheel speeds are swapped: {pairs}; put right",
    )


def _reordered(manoeuvre: Manoeuvre, order: Sequence[int]) -> Manoeuvre:
    channels, weights, origins = dict(manoeuvre.channels), dict(manoeuvre.weights), dict(manoeuvre.origins)
    for k, name in enumerate(_NAMES):
        source = _NAMES[order[k]]
        if source in manoeuvre.channels:
            channels[name], weights[name] = manoeuvre.channels[source], manoeuvre.weight(source)
            origins[name] = manoeuvre.origins.get(source, "")
    return replace(manoeuvre, channels=channels, weights=weights, origins=origins)
