"""A speed that a slower receiver holds in a drive too short for many of its values."""

import numpy as np

HELD, SAMPLES = 50, 440
"""GNSS at 2 Hz in a log of 100 Hz, for 4.4 s."""


def _short(log, change):
    """The begin of a log whose speed ``change`` has gone through."""
    begun = {name: (time[:SAMPLES], values[:SAMPLES]) for name, (time, values) in log.items()}
    time, values = begun["speed"]
    return {**begun, "speed": (time, change(values))}


def _held(values):
    return values[(np.arange(len(values)) // HELD) * HELD]


def _coarse(values):
    """A step of the resolution each 50 samples or so, as a car that coasts has it."""
    return 20.0 - 0.1 * np.floor(np.arange(len(values)) / HELD)


def test_eight_held_values_are_known(recorded) -> None:
    """By an ABS stop's speeds that stand still for half a second a car would seem to slip by 5 m/s."""
    (manoeuvre,) = recorded(5, after=lambda log, _: _short(log, _held), kinds=("stop",), jitter_s=0.0, drop=0.0)
    (fault,) = (one for one in manoeuvre.reading_faults if one.channel == "speed")
    assert (fault.kind, fault.value) == ("gps_hold", HELD)
    assert np.all(np.diff(np.flatnonzero(manoeuvre.weights["speed"])) == HELD)


def test_eight_steps_of_a_coarse_resolution_are_no_hold(recorded) -> None:
    (manoeuvre,) = recorded(5, after=lambda log, _: _short(log, _coarse), kinds=("stop",), jitter_s=0.0, drop=0.0)
    assert not any(fault.kind == "gps_hold" for fault in manoeuvre.reading_faults)
