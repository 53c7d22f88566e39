"""Figures that tell a tyre: peaks, locked wheel, stiffnesses, trail, at one load."""

from dataclasses import asdict, dataclass

import numpy as np

from bench.tyre_bench.sources import Source

_SLIPS = np.linspace(-1.0, 0.0, 1001)
_ANGLES = np.linspace(0.0, 0.6, 601)


@dataclass(frozen=True)
class Characteristics:
    """At a load: forces over the load, slips at their peaks, slopes at zero slip over the load, trail [m]."""

    load_n: float
    peak_braking: float
    slip_at_peak: float
    locked: float
    peak_cornering: float
    angle_at_peak_deg: float
    slip_stiffness: float
    cornering_stiffness_per_rad: float
    pneumatic_trail_m: float

    def as_dict(self) -> dict[str, float]:
        """For JSON."""
        return asdict(self)


def characteristics(source: Source, load: float | None = None) -> Characteristics:
    """Figures of a tyre at a load [N], the nominal one if left out; the formula itself, beyond its limits too."""
    load = load or source.nominal_load
    tyre = source.tyre
    braking = -tyre.forces(_SLIPS, 0.0, 0.0, load, check=False).fx / load
    cornering = -tyre.forces(0.0, _ANGLES, 0.0, load, check=False).fy / load
    slopes = tyre.slopes(1e-6, 1e-6, 0.0, load)
    little = tyre.forces(0.0, np.array([-0.01, 0.01]), 0.0, load, check=False)
    side = little.fy[0] - little.fy[1]
    return Characteristics(
        load_n=load,
        peak_braking=float(braking.max()),
        slip_at_peak=float(-_SLIPS[braking.argmax()]),
        locked=float(braking[0]),
        peak_cornering=float(cornering.max()),
        angle_at_peak_deg=float(np.degrees(_ANGLES[cornering.argmax()])),
        slip_stiffness=float(slopes.fx_by_slip_ratio / load),
        cornering_stiffness_per_rad=float(-slopes.fy_by_slip_angle / load),
        pneumatic_trail_m=float((little.mz[1] - little.mz[0]) / side) if side else 0.0,
    )
