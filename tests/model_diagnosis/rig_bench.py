"""A wheel on a rig, made without the replay: a Magic Formula along and across, first-order relaxation, noise."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from model_diagnosis.manoeuvre import Manoeuvre
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

FloatArray = NDArray[np.float64]

SPEED_M_S, RELAXATION_M = 15.0, 0.3
FINE_S, EVERY = 0.0005, 20
NOISE = {
    "slip_ratio_fl": 2e-4,
    "slip_angle_fl": 2e-4,
    "vertical_load_fl": 10.0,
    "longitudinal_force_fl": 20.0,
    "lateral_force_fl": 20.0,
}
"""White, of each sensor; a tyre's forces also stray by ``STRAY_N``, forgotten by a tenth each sample."""
STRAY_N, KEPT = 30.0, 0.9
PEAK, SHAPE, STIFFNESS = (1.12, 1.0), (1.316, 1.4), (14.34, 13.0)
"""Of the Magic Formula, along and across."""


def rig_car(folder: Path) -> VehicleFile:
    """``ekf_car`` on the tyres below."""
    file = folder / "rig_car.yaml"
    curves = ", ".join(
        f"{direction}: {{peak_friction: {PEAK[k]}, shape: {SHAPE[k]}, stiffness: {STIFFNESS[k]}}}, "
        f"relaxation_length_{direction}: {RELAXATION_M} m"
        for k, direction in enumerate(("longitudinal", "lateral"))
    )
    file.write_text(f"format: 1\nname: rig_car\nextends: ekf_car\ntyres: {{front: &tyre {{{curves}}}, rear: *tyre}}\n")
    return load_vehicle(file)


def relaxed(slip: FloatArray, speed: FloatArray, length: float) -> FloatArray:
    """Slip that the tyre follows, sigma ds/dt + v_x s = v_x slip, exact for a slip that is level within a fine step."""
    kept, level, out = np.exp(-speed * FINE_S / length), 0.5 * (slip[1:] + slip[:-1]), slip.copy()
    for k, now in enumerate(level):
        out[k + 1] = now + kept[k] * (out[k] - now)
    return out


def sweep(
    seed: int,
    load: float,
    *,
    friction: float = 1.0,
    cornering: float = 1.0,
    slip: float = 1.0,
    relaxation: float = RELAXATION_M,
    braking: bool = False,
) -> Manoeuvre:
    """Eight seconds of slip angle to 8 degrees, or of braking slip to 12 %, at a load that swings.

    ``friction``, ``cornering`` and ``slip`` are factors of the force and of its slopes over slip angle and slip.
    """
    time = FINE_S * np.arange(800 * EVERY)
    random = np.random.default_rng(seed)
    loads = load * (1.0 + 0.15 * np.sin(1.3 * time + seed))
    course = np.sin(2.0 * np.pi * 0.4 * time) * np.minimum(time / 4.0, 1.0)
    ratio, angle = (-0.12 * np.abs(course), 0.0 * time) if braking else (0.0 * time, np.radians(8.0) * course)
    along_plane = SPEED_M_S * np.cos(angle)
    slips = relaxed(ratio, along_plane, relaxation), relaxed(-np.tan(angle), along_plane, relaxation)
    factors = slip, cornering
    along, across = (
        friction * PEAK[k] * loads * np.sin(SHAPE[k] * np.arctan(factors[k] * STIFFNESS[k] * slips[k]))
        for k in range(2)
    )
    true = {
        "speed": np.full_like(time, SPEED_M_S),
        "slip_ratio_fl": ratio,
        "slip_angle_fl": angle,
        "vertical_load_fl": loads,
        "longitudinal_force_fl": along,
        "lateral_force_fl": across,
    }
    measured = {
        key: values[::EVERY] + NOISE.get(key, 0.0) * random.standard_normal(800) for key, values in true.items()
    }
    for key in ("longitudinal_force_fl", "lateral_force_fl"):
        stray = STRAY_N * np.sqrt(1.0 - KEPT**2) * random.standard_normal(800)
        measured[key] += lfilter([1.0], [1.0, -KEPT], stray)
    name = f"{'brake' if braking else 'corner'} {load:.0f} N"
    return Manoeuvre(name, time[::EVERY], measured, {key: np.ones(800) for key in measured}, "made by numpy")


def programme(seed: int = 0, **changes: float) -> list[Manoeuvre]:
    """Both kinds of sweep at a light and a heavy load; ``changes`` as in ``sweep``."""
    return [
        sweep(seed + k, load, braking=braking, **changes)
        for k, (braking, load) in enumerate((b, load) for b in (False, True) for load in (2000.0, 4500.0))
    ]
