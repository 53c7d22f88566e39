"""NEES and NIS of the attitude filters on rides of the document's two-wheeler: reported, since its R is chosen.

Form 2A as shipped, 60 random rides over slopes, one value per ride, from its last step. Truth goes through the low-pass
of the sensors (7.2), but for the speed, which has none.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from attitude_rides import STEP as SAMPLES_PER_STEP
from attitude_rides import FloatArray, built, delayed, motorcycle, noise, offsets

from estimators.attitude_bank import AttitudeFilter
from estimators.attitude_forms import B_X, ENTRIES, PHI, SPEED, THETA
from estimators.attitude_weights import WEIGHT
from estimators.kalman.consistency import Consistency, chi_square_band, normalised_estimation_error
from vehicle_model.reference.two_wheeler import SAMPLE_S, Noise, Ride, measure, random_ride

FORM = "2A"
RUNS, FIRST_SEED, SECONDS = 60, 1001, 20.0
SAMPLES = round(SECONDS / SAMPLE_S)
"""Of a ride; the last one is a step of the filters."""
COLOUR_RUNS, COLOUR_FROM_S = 6, 12.0
"""Rides whose innovations are followed from step to step, and from when on."""
ROWS = ("G_y", "G_z", "speed", "roll balance")


@dataclass(frozen=True)
class Case:
    """A filter, the offset of the accelerometer x that it is not told [mG], its settings and the sensors' noise."""

    name: str
    offset_mg: float = 0.0
    settings: Mapping[str, Any] = field(default_factory=dict)
    noise: Noise = field(default_factory=Noise)


MEASURED_NOISE = {
    "measurement_lateral_acceleration": 0.05,
    "measurement_vertical_acceleration": 0.05,
    "measurement_speed": 0.03,
    "measurement_roll_balance": 0.03,
}
"""What white noise of the sensors leaves behind their low-pass, in place of the form's 0.1."""
OF_THE_BANK = noise(0.1, 0.1, 0.1, 0.1)
"""R of form 2A; the filter with the extra state has that of 2B as shipped."""
FILTERS = {f"`{name}`": Case(name) for name in ("attitude_bank", "attitude_single", "attitude_augmented")}
CASES = {
    **FILTERS,
    **{f"{label}, 100 mG on x": Case(case.name, 100.0) for label, case in FILTERS.items()},
    "`attitude_augmented`, R of the bank": Case("attitude_augmented", settings=OF_THE_BANK),
    "`attitude_augmented`, R of the bank, 100 mG on x": Case("attitude_augmented", 100.0, OF_THE_BANK),
    "`attitude_single`, sensors without noise": Case("attitude_single", noise=Noise(0.0, 0.0, 0.0)),
    "`attitude_single`, R of the sensors": Case("attitude_single", settings=MEASURED_NOISE),
}


@dataclass(frozen=True)
class Statistics:
    """Statistics of a case over the rides; errors and told deviations of its states, shape (60, k)."""

    roll: Consistency
    nees: Consistency
    nis: Consistency
    errors: FloatArray
    deviations: FloatArray


def _replayed(case: Case, source: Ride, seed: int) -> tuple[AttitudeFilter, FloatArray]:
    """The filter after a ride, and its last outputs."""
    filter_ = built({"form": FORM, **case.settings}, case.name)
    columns = measure(source, seed, offsets=offsets(x=case.offset_mg), onset_s=0.0, noise=case.noise)
    columns["abs_active"] = np.zeros(len(source.time))
    return filter_, filter_.replay({name: columns[name][:SAMPLES] for name in filter_.inputs})[-1]


def _estimate(filter_: AttitudeFilter) -> tuple[FloatArray, FloatArray]:
    """State and covariance of the mixture of a bank's filters, of which the outputs tell the diagonal alone."""
    states, weights = filter_.filter_states[:, filter_.memory.entries], filter_.bank[WEIGHT]
    mean = weights @ states
    apart = states - mean
    spread = np.einsum("i,ij,ik->jk", weights, apart, apart)
    return mean, np.einsum("i,ijk->jk", weights, filter_.filter_covariances) + spread


def _truth(case: Case, source: Ride) -> FloatArray:
    """Full vector of the last step; offsets that nobody put on are zero."""
    values = np.zeros(ENTRIES)
    for entry, angle in ((THETA, source.pitch_angle), (PHI, source.roll_angle)):
        values[entry] = delayed(angle)[SAMPLES - 1]
    values[SPEED] = source.speed[SAMPLES - 1]
    values[B_X] = offsets(x=case.offset_mg)["longitudinal_acceleration"]
    return values


def attitude_filters(cases: Collection[str] = tuple(CASES)) -> dict[str, Statistics]:
    """Statistics of cases by their names; every ride is made once for all of them."""
    roll: dict[str, list[float]] = {name: [] for name in cases}
    nees: dict[str, list[float]] = {name: [] for name in cases}
    nis: dict[str, list[float]] = {name: [] for name in cases}
    errors: dict[str, list[FloatArray]] = {name: [] for name in cases}
    deviations: dict[str, list[FloatArray]] = {name: [] for name in cases}
    for seed in range(FIRST_SEED, FIRST_SEED + RUNS):
        source = random_ride(motorcycle(), seed, seconds=SECONDS, sloped=True)
        for name in cases:
            filter_, out = _replayed(CASES[name], source, seed)
            state, covariance = _estimate(filter_)
            error = _truth(CASES[name], source)[filter_.memory.entries] - state
            place = list(filter_.memory.entries).index(PHI)
            names = [signal.name.partition(".")[2] for signal in filter_.outputs]
            assert np.isclose(out[names.index("roll_angle_std")] ** 2, covariance[place, place])
            roll[name].append(error[place] ** 2 / covariance[place, place])
            nees[name].append(float(normalised_estimation_error(error, covariance)))
            nis[name].append(out[names.index("innovation")])
            errors[name].append(error)
            deviations[name].append(np.sqrt(np.diag(covariance)))
    return {
        name: Statistics(
            chi_square_band(roll[name], 1),
            chi_square_band(nees[name], len(errors[name][0])),
            chi_square_band(nis[name], len(ROWS)),
            np.array(errors[name]),
            np.array(deviations[name]),
        )
        for name in cases
    }


def innovations() -> FloatArray:
    """Innovations of ``attitude_single`` from step to step, shape (rides, steps, rows of the measurement)."""
    rides = []
    for seed in range(FIRST_SEED, FIRST_SEED + COLOUR_RUNS):
        source = random_ride(motorcycle(), seed, seconds=SECONDS, sloped=True)
        filter_ = built({"form": FORM}, "attitude_single")
        columns = measure(source, seed) | {"abs_active": np.zeros(len(source.time))}
        first = round(COLOUR_FROM_S / SAMPLE_S)
        filter_.replay({name: columns[name][:first] for name in filter_.inputs})
        memory, found = filter_.memory, []
        for at in range(first, SAMPLES, SAMPLES_PER_STEP):
            filter_.replay({name: columns[name][at : at + SAMPLES_PER_STEP] for name in filter_.inputs})
            found.append((memory.measured - memory.outputs[0])[memory.rows])
        rides.append(found)
    return np.array(rides)


def correlation(values: FloatArray, lag: int = 1) -> FloatArray:
    """Of innovations with those some steps before, over all rides, by row of the measurement; zero for white noise."""
    late, early = values[:, lag:], values[:, :-lag]
    result: FloatArray = np.einsum("rsm,rsm->m", late, early) / np.einsum("rsm,rsm->m", late, late)
    return result
