"""Checks of a channel's level over all manoeuvres: constant, wrapped away from the wheels, negative loads."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.rig import is_on_rig
from model_diagnosis.data.sample_values import is_motion
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twins import Motion
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.result import DataFault

_LATERAL = ("lateral_acceleration", "yaw_rate", "lateral_speed", "side_slip_angle")
_STEERED_RAD = 0.005
_BRAKING_M_S2 = 2.5


def check_constant(manoeuvres: Sequence[Manoeuvre]) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name channels that never change although the car moves; they are left out."""
    set_on_rig = ("speed",) if is_on_rig(manoeuvres) else ()
    dead = [name for name in _all_channels(manoeuvres) if name not in set_on_rig and _is_dead(manoeuvres, name)]
    faults = []
    for name in dead:
        value = next(float(m.channels[name][0]) for m in manoeuvres if name in m.channels)
        message = f"{name} is constant ({value:.4g}) in every manoeuvre; the channel is not used"
        faults.append(DataFault(kind="constant_channel", channel=name, value=value, message=message))
    return faults, [without(m, dead) for m in manoeuvres]


def without(manoeuvre: Manoeuvre, names: Sequence[str]) -> Manoeuvre:
    """The manoeuvre without some channels."""
    if not names:
        return manoeuvre
    return replace(
        manoeuvre,
        channels={n: v for n, v in manoeuvre.channels.items() if n not in names},
        weights={n: w for n, w in manoeuvre.weights.items() if n not in names},
    )


def _all_channels(manoeuvres: Sequence[Manoeuvre]) -> list[str]:
    return list(dict.fromkeys(name for m in manoeuvres for name in m.channels))


def _series(manoeuvres: Sequence[Manoeuvre], name: str) -> FloatArray:
    parts = [m.channels[name][m.weight(name) > 0.0] for m in manoeuvres if name in m.channels]
    return np.concatenate(parts) if parts else np.zeros(0)


def _is_dead(manoeuvres: Sequence[Manoeuvre], name: str) -> bool:
    values = _series(manoeuvres, name)
    if len(values) < 2 or np.ptp(values) > 0.0:
        return False
    if name in _LATERAL:
        return any(_turns(m, name) for m in manoeuvres)
    if name.startswith("brake_pressure_"):
        others = [n for n in _all_channels(manoeuvres) if n.startswith("brake_pressure_")]
        return all(np.ptp(_series(manoeuvres, n)) == 0.0 for n in others) and any(_brakes(m) for m in manoeuvres)
    return is_motion(name)


def _turns(manoeuvre: Manoeuvre, but: str) -> bool:
    """True where steering or another lateral channel changes."""
    for name, least in (("steering_wheel_angle", 10.0 * _STEERED_RAD), ("road_wheel_angle", _STEERED_RAD)):
        if name in manoeuvre.channels and np.ptp(manoeuvre.channels[name]) > least:
            return True
    return any(n != but and n in manoeuvre.channels and np.ptp(manoeuvre.channels[n]) > 0.05 for n in _LATERAL)


def _brakes(manoeuvre: Manoeuvre) -> bool:
    acceleration = manoeuvre.channels.get("longitudinal_acceleration")
    return acceleration is not None and float(np.percentile(acceleration, 5)) < -_BRAKING_M_S2


def restore_wraps(manoeuvres: Sequence[Manoeuvre], faults: Sequence[DataFault], geometry: Geometry) -> list[Manoeuvre]:
    """Bring an unwrapped speed back to the wheels' level: whole multiples of the wrap, per manoeuvre."""
    wraps = {f.channel: f.value for f in faults if f.kind == "counter_wrap" and f.value}
    wrap = wraps.get("speed")
    if wrap is None:
        return list(manoeuvres)
    restored = []
    for manoeuvre in manoeuvres:
        wheels = Motion(manoeuvre, geometry).wheels_speed()
        speed = manoeuvre.channels.get("speed")
        if wheels is None or speed is None:
            restored.append(manoeuvre)
            continue
        turns = round(float(np.median(wheels - speed)) / wrap)
        restored.append(replace(manoeuvre, channels=dict(manoeuvre.channels) | {"speed": speed + turns * wrap}))
    return restored


def check_load_sign(manoeuvres: Sequence[Manoeuvre]) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Vertical loads press on the road: logs with the other sign are turned round."""
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for name in _all_channels(manoeuvres):
        values = _series(manoeuvres, name)
        if not name.startswith("vertical_load_") or not len(values) or np.median(values) >= 0.0:
            continue
        message = f"{name} is negative (median {np.median(values):.4g} N): counted upwards in the log; turned round"
        faults.append(
            DataFault(kind="channel_sign", channel=name, value=-1.0, unit="1", repaired=True, message=message)
        )
        repaired = [
            replace(m, channels=dict(m.channels) | {name: -m.channels[name]}) if name in m.channels else m
            for m in repaired
        ]
    return faults, repaired
