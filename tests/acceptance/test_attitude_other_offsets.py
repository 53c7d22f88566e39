"""Item 51 of the attitude document's list: the other offsets come back after the onset of one.

"After onset of one offset the estimates of the other offsets may swing but return to within 0.1 degree/s and 10 mG of
their truth within 60 s (form 2A; form 2C for gyro and b_x offsets)", with the numbers "of the set-up of 7.1, averaged
over at least six seeds"; that set-up averages from 60 s after the onset on. Here a mean has to stay within the limit by
two of its standard errors, and on the default cycle at the very instant of 60 s too.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from attitude_bound import left_by_the_pitch_gyroscope
from attitude_rides import ONSET_S, SEEDS, FloatArray, motorcycle, observe, offsets, ride, until

from vehicle_model.reference.two_wheeler import Ride, measure, random_ride

MANY = tuple(range(101, 121))
SEEDS_OF = {"2A": SEEDS, "2C": MANY}
"""Form 2A stays four standard errors off its limit on the six seeds of the other items."""
FURTHER = tuple(range(121, 161))
"""For the pitch gyroscope in form 2C, whose b_x comes nearest to the limit."""
CYCLES = ("middle", "document")
AFTER_S = 60.0
INSTANT_ENDS_S = ONSET_S + AFTER_S + 2.0
GYROS = ("roll_rate_offset", "pitch_rate_offset", "yaw_rate_offset")
ACCELEROMETERS = tuple(f"{axis}_acceleration_offset" for axis in ("longitudinal", "lateral", "vertical"))
NAMES = (*GYROS, *ACCELEROMETERS)
B_X = NAMES.index("longitudinal_acceleration_offset")
OWN = {
    "roll=1": "roll_rate_offset",
    "pitch=1": "pitch_rate_offset",
    "yaw=1": "yaw_rate_offset",
    "x=100": "longitudinal_acceleration_offset",
    "z=100": "vertical_acceleration_offset",
    "": "",
}
CASES = [("2A", wrong) for wrong in ("roll=1", "pitch=1", "yaw=1", "z=100")]
CASES += [("2C", wrong) for wrong in ("roll=1", "pitch=1", "yaw=1", "x=100")]


class Found(NamedTuple):
    """Offsets of ``NAMES`` [degree/s, mG] 58 to 62 s after the onset, and from 60 s after it to the end of the ride."""

    instant: FloatArray
    window: FloatArray


def _found(source: Ride, seed: int, form: str, wrong: str, cycle: str, end: float = INSTANT_ENDS_S) -> Found:
    key, _, value = wrong.partition("=")
    given = offsets(**{key: float(value)}) if key else {}
    part, columns = until(end, source, measure(source, seed, offsets=given, onset_s=ONSET_S))
    bank = observe(part, columns, {"form": form, "cycle": cycle})
    at = ONSET_S + AFTER_S
    return Found(
        np.array([bank.mean(name, at - 2.0, INSTANT_ENDS_S) for name in NAMES]),
        np.array([bank.mean(name, at) for name in NAMES]),
    )


@cache
def found(form: str, wrong: str, cycle: str, end: float = INSTANT_ENDS_S) -> Found:
    """Offsets of all seeds after one onset, shape (seeds, 6)."""
    rows = [_found(ride(seed, True), seed, form, wrong, cycle, end) for seed in SEEDS_OF[form]]
    return Found(*(np.array(of) for of in zip(*rows, strict=True)))


def bounds(values: FloatArray, wrong: str) -> dict[str, float]:
    """Largest mean of the other offsets plus two standard errors, by unit."""
    reach = np.abs(values.mean(axis=0)) + 2.0 * values.std(axis=0, ddof=1) / np.sqrt(len(values))
    others = {name: value for name, value in zip(NAMES, reach, strict=True) if name != OWN[wrong]}
    units = (("degree/s", GYROS), ("mG", ACCELEROMETERS))
    return {unit: max(others[name] for name in names if name in others) for unit, names in units}


LIMITS = {"degree/s": 0.1, "mG": 10.0}


@pytest.mark.acceptance("B-51")
@pytest.mark.parametrize(("form", "wrong"), [case for case in CASES if case != ("2C", "pitch=1")])
@pytest.mark.parametrize("cycle", ["middle", pytest.param("document", marks=pytest.mark.nightly)])
def test_other_offsets_return(form: str, wrong: str, cycle: str, record: Callable[..., None]) -> None:
    """Here the stricter reading holds on both cycles: at 60 s."""
    for unit, value in bounds(found(form, wrong, cycle).instant, wrong).items():
        label = f"largest other offset 60 s after the onset with two standard errors, {form}, cycle {cycle}, {unit}"
        record(label, value, f"< {LIMITS[unit]:g} {unit}")
        assert value < LIMITS[unit]


@pytest.mark.acceptance("B-51")
def test_other_offsets_after_the_pitch_gyroscopes(record: Callable[..., None]) -> None:
    """The cycle that is the default, on sixty seeds at the instant of 60 s."""
    further = [
        _found(random_ride(motorcycle(), seed, seconds=INSTANT_ENDS_S, sloped=True), seed, "2C", "pitch=1", "middle")
        for seed in FURTHER
    ]
    values = np.concatenate([found("2C", "pitch=1", "middle").instant, [of.instant for of in further]])
    record("b_x 60 s after 1 degree/s of the pitch gyroscope, 2C, cycle middle, mG", values[:, B_X].mean(), "< 10 mG")
    for unit, value in bounds(values, "pitch=1").items():
        record(f"largest other offset with two standard errors, {unit}", value, f"< {LIMITS[unit]:g} {unit}")
        assert value < LIMITS[unit]


@pytest.mark.nightly
@pytest.mark.acceptance("B-51")
def test_other_offsets_in_the_documents_cycle(record: Callable[..., None]) -> None:
    """As 7.1 averages, from 60 s after the onset on, they are back; at the instant of 60 s b_x is not.

    Half of b_x at that instant is there without any offset: inputs of the last step are half a step late, and a roll
    angle that lags by its rate looks like a pitch angle, since the heading integrates what the roll angle does.
    """
    whole = found("2C", "pitch=1", "document", np.inf)
    for unit, value in bounds(whole.window, "pitch=1").items():
        label = f"largest other offset from 60 s after the onset on with two standard errors, 2C, {unit}"
        record(label, value, f"< {LIMITS[unit]:g} {unit}")
        assert value < LIMITS[unit]
    late = {
        ("pitch=1", "middle"): found("2C", "pitch=1", "middle").instant[:, B_X],
        ("pitch=1", "document"): whole.instant[:, B_X],
        **{("", cycle): found("2C", "", cycle).instant[:, B_X] for cycle in CYCLES},
    }
    for (wrong, cycle), values in late.items():
        label = f"b_x at 60 s, {wrong or 'no offset'}, cycle {cycle}, mG"
        record(label, values.mean(), "reported; 10 mG would be the limit at this instant")
    # ride by ride: what the cycle adds is there with and without an offset
    added = {wrong: late[wrong, "document"] - late[wrong, "middle"] for wrong in ("pitch=1", "")}
    assert added[""].mean() == pytest.approx(added["pitch=1"].mean(), rel=0.1)
    assert np.all(added[""] > 0.0)


@pytest.mark.acceptance("B-51")
def test_what_the_rows_could_tell(record: Callable[..., None]) -> None:
    """The limit is within reach of the rows; half of it the gain of 3.5 leaves even on an exact model.

    The pitch gyroscope's offset walks 0.2 degree/s an hour in Q: until the filter has followed the step, the pitch
    angle drifts by 4 degrees, and takes b_x with it, since along the road G_x tells only their difference. What b_x
    got it forgets as slowly as its own random walk makes it.
    """
    rides = (random_ride(motorcycle(), seed, seconds=ONSET_S + AFTER_S + 1.0, sloped=True) for seed in SEEDS)
    found = [left_by_the_pitch_gyroscope(source, "2C", AFTER_S) for source in rides]
    deviation, mean = (float(np.mean([getattr(of, name) for of in found])) for name in ("deviation", "mean"))
    record("deviation of b_x, best estimate of these rows and noises, mG", deviation, "< 10 mG / 3, or it could not")
    record("b_x that an exact model with the gain of 3.5 leaves at 60 s, mG", mean, "reported, < 10 mG")
    assert deviation < 10.0 / 3.0
    assert deviation < mean < 10.0
    record("time in which that gain forgets an error of b_x, P/Q, s", np.mean([of.memory for of in found]), "reported")
