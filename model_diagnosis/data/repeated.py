"""The same measurement given twice: it would count as evidence twice, or tell the gain on what was searched."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from model_diagnosis.manoeuvre import Manoeuvre
from signals.errors import InputError

_ENDS_S = 0.02
"""Lengths that differ by less are one: exports of a drive in several formats end a sample apart."""
_SAME_SHARE = 1e-4
"""Share of its standard deviation by which a channel differs between two exports: stamps of another resolution, 1 µs
of seconds. Noise of the sensors makes two drives differ by more however alike they are driven."""


def refuse_repeats(manoeuvres: Sequence[Manoeuvre]) -> None:
    """Refuse manoeuvres of which two are the same measurement, whatever their files are called.

    Raises
    ------
    InputError
        Where two are, with the stretches of both logs.
    """
    for first, second in combinations(manoeuvres, 2):
        one_after_the_other = first.drive == second.drive and first.start_s != second.start_s
        as_long = abs(first.duration_s - second.duration_s) <= _ENDS_S
        if as_long and not one_after_the_other and _are_same(first, second):
            raise InputError(
                f"{second.source}: the same measurement as {first.source}",
                mend="give each drive once; what is held out must not be diagnosed",
            )


def _are_same(first: Manoeuvre, second: Manoeuvre) -> bool:
    samples = min(first.samples, second.samples)
    compared = 0
    for name in first.channels.keys() & second.channels.keys():
        one, other = first.channels[name][:samples], second.channels[name][:samples]
        spread = float(np.std(one))
        if np.median(np.abs(one - other)) > _SAME_SHARE * spread:
            return False
        compared += spread > 0.0
    return compared > 0
