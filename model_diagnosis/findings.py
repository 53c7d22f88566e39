"""What a diagnosis found, with the arrays behind it: what the report draws and a notebook looks at."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.extension.extended_vehicle import FoundEffect, FoundTerm
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.result import Diagnosis

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ManoeuvreFindings:
    """One manoeuvre, measured and replayed; n samples, c compared signals, catalogue units.

    Attributes
    ----------
    manoeuvre : repaired data, its time base and the weights of its channels
    signals : names of the compared signals, the columns of the arrays
    measured, before, after : (n, c) measured, replayed by the vehicle as given, replayed with what was found (observer
        replay, the one behind all statistics; ``after`` equals ``before`` where nothing was found)
    free_before, free_after : (n, c) free runs from the first sample, for the pictures; None where not made
    restarted_before, restarted_after : (n, c) free runs that restart each second at the measured speeds and yaw rate
    weights : (n, c), 0 where a sample counts for nothing
    states : catalogue name -> (n,) of the replay at the answer, to show residuals over them: ``speed``,
        ``slip_ratio_fl``, ``slip_angle_fl``, ``brake_disc_temperature_fl``, …; whatever is missing is not drawn
    held_out : True where the manoeuvre took no part in the search
    """

    manoeuvre: Manoeuvre
    signals: tuple[str, ...]
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    weights: FloatArray
    free_before: FloatArray | None = None
    free_after: FloatArray | None = None
    restarted_before: FloatArray | None = None
    restarted_after: FloatArray | None = None
    states: Mapping[str, FloatArray] = field(default_factory=dict)
    held_out: bool = False


@dataclass(frozen=True)
class Findings:
    """A diagnosis and what it rests on.

    Attributes
    ----------
    diagnosis : the answer as it stands in diagnosis.json
    vehicle : name of the vehicle file's car
    manoeuvres : in the order of the logs, held-out ones included
    sensor_std : signal -> the sensor's own noise in the signal's unit
    evidence : effect -> log Bayes factor against "nothing" from the sensitivities, for every effect that was tested
    logs : files as given
    terms : discovered terms as the extended vehicle takes them
    numbers : of a wrong vehicle, or of this one within its scatter, what the data say, as the extended vehicle takes it
    """

    diagnosis: Diagnosis
    vehicle: str
    manoeuvres: Sequence[ManoeuvreFindings]
    sensor_std: Mapping[str, float]
    evidence: Mapping[str, float] = field(default_factory=dict)
    logs: Sequence[str] = ()
    terms: Sequence[FoundTerm] = ()
    numbers: Sequence[FoundEffect] = ()
