"""A replay whose prediction is linear in the deviations (or bent on request): the truth of every evidence is known."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre

FloatArray = NDArray[np.float64]
SIGNALS = ("longitudinal_acceleration", "wheel_speed_fl", "yaw_rate")
NOISE_STD = 0.1


def effect(name: str, count: int = 1, nuisance: float = 0.03, width: float = 0.2, discrete: bool = False) -> Effect:
    """An effect with ``count`` deviations between -1 and 1."""
    parameters = tuple(
        EffectParameter(f"part_{number}", "1", -1.0, 1.0, nuisance, width, f"body.{name}") for number in range(count)
    )
    return Effect(name, Group.BODY, Application.PLANT, "y = S x", parameters, SIGNALS, "any", discrete=discrete)


class LinearCar:
    """Replay with fixed sensitivities: smooth random functions of time, one set per manoeuvre.

    ``bend`` adds a quadratic term; ``colour`` is the first coefficient of the noise's autoregression; ``same`` are
    pairs of columns with equal sensitivities up to a factor, ``alike`` pairs with a correlation below one.
    """

    def __init__(
        self,
        effects: Sequence[Effect],
        truth: FloatArray,
        seed: int,
        manoeuvres: int = 4,
        samples: int = 300,
        bend: float = 0.0,
        colour: float = 0.0,
        strength: float = 1.0,
        same: Sequence[tuple[int, int, float]] = (),
        alike: Sequence[tuple[int, int, float]] = (),
    ) -> None:
        rng = np.random.default_rng(seed)
        self.effects = tuple(effects)
        self.parameters = tuple(one for item in effects for one in item.parameters)
        self.columns = tuple(name for item in effects for name in item.columns)
        self.owner = np.array([index for index, item in enumerate(effects) for _ in item.parameters])
        self.bend = bend
        time = np.arange(samples) * SAMPLE_TIME_S
        self.matrices = []
        for _ in range(manoeuvres):
            rough = rng.standard_normal((samples, len(SIGNALS), len(self.columns)))
            smooth = strength * lfilter([0.1], [1.0, -0.9], rough, axis=0) / 0.23
            for first, second, factor in same:
                smooth[:, :, second] = factor * smooth[:, :, first]
            for first, second, correlation in alike:
                own = np.sqrt(1.0 - correlation**2) * smooth[:, :, second]
                smooth[:, :, second] = correlation * smooth[:, :, first] + own
            self.matrices.append(smooth)
        self.manoeuvres = []
        for number, predicted in enumerate(self._predicted(truth)):
            noise = lfilter([1.0], [1.0, -colour], NOISE_STD * rng.standard_normal(predicted.shape), axis=0)
            channels = {name: (predicted + noise)[:, column] for column, name in enumerate(SIGNALS)}
            weights = {name: np.ones(samples) for name in SIGNALS}
            self.manoeuvres.append(Manoeuvre(f"m{number}", time, channels, weights, "linear car"))

    def _predicted(self, theta: FloatArray) -> list[FloatArray]:
        return [matrix @ (theta + self.bend * theta**2) for matrix in self.matrices]

    def signals(self, manoeuvre: int) -> tuple[str, ...]:
        return SIGNALS

    def weights(self) -> list[FloatArray]:
        return [np.ones(matrix.shape[:2]) for matrix in self.matrices]

    def residuals(self, theta: FloatArray) -> list[FloatArray]:
        return [
            np.stack([manoeuvre.channels[name] for name in SIGNALS], axis=1) - predicted
            for manoeuvre, predicted in zip(self.manoeuvres, self._predicted(theta), strict=True)
        ]

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        chosen = np.arange(len(theta)) if columns is None else np.asarray(columns)
        own = theta[: len(self.columns)]
        return [(matrix * (1.0 + 2.0 * self.bend * own))[:, :, chosen] for matrix in self.matrices]

    def corrections(self, manoeuvre: int) -> FloatArray:
        """No observer."""
        return np.zeros((len(SIGNALS), 0))

    def sensor_std(self, signal: str) -> float:
        return NOISE_STD
