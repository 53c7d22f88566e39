"""A discovered term: its formula, coefficients with intervals, and how sure it is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.candidates import Candidate

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class DiscoveredTerm:
    """A term that the data show and no effect explains.

    Attributes
    ----------
    target : what it changes, as a formula has it
    is_factor : True where the target itself is multiplied
    coefficients, low, high : with the ends of the 90 % intervals; of a periodic term those of sine and cosine
    unit : of the coefficients
    inclusion : share of half-samples in which its variables were chosen
    explained : share of the data's squared misfit that it takes away
    """

    target: str
    is_factor: bool
    candidate: Candidate
    coefficients: FloatArray
    low: FloatArray
    high: FloatArray
    unit: str
    inclusion: float
    explained: float

    @property
    def amplitude(self) -> float:
        """The coefficient; of a periodic term its amplitude."""
        return float(self.coefficients[0] if len(self.coefficients) == 1 else np.hypot(*self.coefficients))

    @property
    def formula(self) -> str:
        """``brake_torque += -2.1e-04 s^2/m^2 · brake_torque · |speed|^2``."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        sign = "±" if self.candidate.kind == "periodic" else ""
        multiplied = f" · {self.target}" if self.is_factor else ""
        return f"{self.target} += {sign}{self.amplitude:.4g}{unit}{multiplied} · {self.candidate.text}"
