"""Memory of the attitude filters: one named tuple of arrays, so that a tick allocates nothing."""

from typing import NamedTuple

import numpy as np

from estimators.attitude_forms import ENTRIES, ROWS
from estimators.attitude_settings import ATTITUDE_OUTPUTS
from estimators.attitude_two_wheeler import INPUTS, LOADS, MECHANICS
from estimators.attitude_weights import BANK_ROWS
from estimators.kalman.covariance import FloatArray, IntArray

CHANNELS = 7
"""Low-passed channels: three rates, three accelerations, speed."""

(
    ACTIVE,
    RESETS,
    VERDICT,
    TICKS,
    STEPS,
    HELD,
    SUSPECT,
    CENTRE,
    INNOVATION,
    FILTERING,
    ABS,
    LOG_VOLUME,
) = range(12)
STATUS = 12

(
    SAMPLE_TIME,
    PERIOD,
    PERIOD_TICKS,
    CAR,
    EXTERNAL,
    LOOP,
    MINIMUM_SPEED,
    LARGEST_ROLL,
    DELAY,
    SMOOTHING,
    ACCUMULATED,
    SAMPLES,
    STUDENT,
    BEST,
    RECENTRING,
    RECENTRING_START,
    LARGEST_CENTRE,
    FRICTION_SHARE,
    SUSPICIOUS_WEIGHT,
    SUSPICIOUS_STEPS,
    ELEVATION_POLE,
    VIRTUAL,
    STALE_AGE,
    TARGET,
    GRAVITY,
    REPORTED,
    SETTLING_TICKS,
    DOCUMENT_CYCLE,
    LEVEL_PITCH,
) = range(29)
TUNING = 29


class Memory(NamedTuple):
    """Arrays of a bank of n filters with k states and m measurements.

    Attributes
    ----------
    status, tuning
        Places as named above.
    state, covariance : shapes (n, 10), (n, k, k)
        Full states and covariances of the filters, each its own.
    bank : shape (5, n)
        Likelihoods, weights, virtual offsets (:mod:`estimators.attitude_weights`).
    combined, variance : shape (10,)
        Weighted state (29) and its variances.
    entries, rows : shapes (k,), (m,)
        Entries of the full vector that are states; rows of the measurement that are used.
    inputs : shape (3, 11)
        Inputs of this step, of the last one, and those of the prediction from there to here.
    filtered : shape (7, 4)
        Low-passes: two memories, the value and that of the sample before, for each channel.
    coefficients : shape (2, 5)
        Low-pass of the sensors and of the speed: b0, b1, b2, a1, a2.
    matrices : shape (2, 3, 3)
        Axes of gyroscopes and accelerometers.
    """

    status: FloatArray
    tuning: FloatArray
    state: FloatArray
    covariance: FloatArray
    bank: FloatArray
    combined: FloatArray
    variance: FloatArray
    loads: FloatArray
    entries: IntArray
    rows: IntArray
    inputs: FloatArray
    filtered: FloatArray
    coefficients: FloatArray
    matrices: FloatArray
    sources: IntArray
    radii: FloatArray
    initial: FloatArray
    process: FloatArray
    noise: FloatArray
    correction: FloatArray
    measured: FloatArray
    steps: FloatArray
    mechanics: FloatArray
    rates: FloatArray
    outputs: FloatArray
    slopes_f: FloatArray
    slopes_h: FloatArray
    transition: FloatArray
    design: FloatArray
    columns: IntArray
    report: FloatArray
    work: FloatArray
    wide: FloatArray


def memory(filters: int, entries: IntArray, rows: IntArray, wheels: int) -> Memory:
    """Empty memory of a bank."""
    n, k, m = filters, len(entries), len(rows)
    return Memory(
        status=np.zeros(STATUS),
        tuning=np.zeros(TUNING),
        state=np.zeros((n, ENTRIES)),
        covariance=np.zeros((n, k, k)),
        bank=np.zeros((BANK_ROWS, n)),
        combined=np.zeros(ENTRIES),
        variance=np.zeros(ENTRIES),
        loads=np.zeros(LOADS),
        entries=entries,
        rows=rows,
        inputs=np.zeros((3, INPUTS)),
        filtered=np.zeros((CHANNELS, 4)),
        coefficients=np.zeros((2, 5)),
        matrices=np.zeros((2, 3, 3)),
        sources=np.zeros(CHANNELS + 2, dtype=np.int64),
        radii=np.zeros(wheels),
        initial=np.zeros(k),
        process=np.zeros((k, k)),
        noise=np.zeros(m),
        correction=np.zeros(k),
        measured=np.zeros(ROWS),
        steps=np.zeros(ENTRIES),
        mechanics=np.zeros(MECHANICS),
        rates=np.zeros((3, 4)),
        outputs=np.zeros((3, ROWS)),
        slopes_f=np.zeros((k, 4)),
        slopes_h=np.zeros((k, ROWS)),
        transition=np.zeros((k, k)),
        design=np.zeros((m, k)),
        columns=np.arange(k),
        report=np.zeros(len(ATTITUDE_OUTPUTS)),
        work=np.zeros((k, k)),
        wide=np.zeros((3, k)),
    )
