"""Figures of merit of a friction filter on a run of the twin (friction document 4.8)."""

from functools import cache

import friction_twin as twin
import numpy as np
from numpy.typing import NDArray

import estimators

HIGH, LOW = (1.12, 0.98), (0.70, 0.65)
_LAUNCH = {"start_speed": 1.0, "top_speed": 110 / 3.6}
_MANOEUVRES = {
    "E6": {"limits": HIGH},
    "E7": {"limits": LOW, "spin_torque": 1700.0},
    "E8": {"limits": HIGH, "abs_on": True},
    "E9": {"limits": LOW, "spin_torque": 1700.0, "abs_on": True},
    "E10": {
        "limits": HIGH,
        "abs_on": True,
        "after_jump": tuple(0.6 * limit for limit in HIGH),
        "jump_time": 1.5,
    },
}


@cache
def run(name: str) -> twin.Run:
    """A run of 4.2 with launch, roll and stop from 95 km/h."""
    return twin.simulate(**_LAUNCH, **_MANOEUVRES[name])


@cache
def stop(name: str, curve: tuple[float, float] = twin.SET_T, magic: bool = False) -> twin.Run:
    """The stop alone, from 95 km/h after half a second of rolling."""
    chosen = {key: value for key, value in _MANOEUVRES[name].items() if key != "spin_torque"}
    return twin.simulate(**chosen, start_speed=97 / 3.6, brake_speed=95 / 3.6, curve=curve, magic=magic)


class Estimate:
    """Outputs of a friction filter by name, and how far they are from the truth of a run."""

    def __init__(
        self,
        truth: twin.Run,
        *,
        path: str = "ideal",
        estimator: str = "friction_ekf",
        vehicle: dict[str, float] | None = None,
        seed: int = 0,
        noise: tuple[float, float] = (0.05, 0.05),
        actual_torque: bool = False,
        **settings: object,
    ) -> None:
        self.truth = truth
        columns = twin.measured(
            truth, seed=seed, acceleration_noise=noise[0], wheel_noise=noise[1], actual_torque=actual_torque
        )
        ages = None
        if path == "tone_ring":
            columns = twin.tone_ring(columns, truth)
        if path != "ideal":
            columns, ages = twin.held(columns)
        self.estimator = estimators.create(estimator, vehicle or twin.TABLE_8, settings)
        self.results = self.estimator.replay(columns, ages)
        self._index = {signal.name.split(".")[1]: i for i, signal in enumerate(self.estimator.outputs)}
        self.phase = truth.braking_phase()

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.results[:, self._index[name]]

    def rmse(self, name: str, truth: NDArray[np.float64]) -> float:
        return float(np.sqrt(np.mean((self[name][self.phase] - truth[self.phase]) ** 2)))

    def mean(self, name: str) -> float:
        return float(self[name][self.phase].mean())

    def mean_limit_ratio(self) -> float:
        """Mean of the load-weighted estimate over the mean of the load-weighted truth."""
        t, phase = self.truth, self.phase
        share = t.load_front / (t.load_front + t.load_rear)
        truth = share * t.limit_front + (1 - share) * t.limit_rear
        return self.mean("friction_limit_mean") / float(truth[phase].mean())

    def settling_time(self, name: str, truth: NDArray[np.float64], start: int, band: float) -> float:
        """Time from sample ``start`` until the estimate stays within ``band`` of the truth while v >= 5 m/s [s]."""
        stop_at = self.phase[-1]
        off = np.abs(self[name][start:stop_at] / truth[start:stop_at] - 1) > band
        return 0.001 * (int(np.flatnonzero(off)[-1]) + 1 if off.any() else 0)
