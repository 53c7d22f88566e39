"""Stimuli of a scenario file as the tick runs them."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bench.loop import waveforms
from bench.loop.parameters import Accessors
from bench.loop.stimuli import Stimuli, Stimulus
from bench.loop.waveforms import Waveform
from bench.scenario.stimulus_file import Noise, Ramp, Sine, StimulusEntry, Sweep, Table, Value
from signals.quantities import to_si
from signals.vector import SignalVector

NOISE_PURPOSE = 7001
"""Second word of the noise generators' seeds, so that no other purpose draws the same numbers."""


def build_stimuli(
    entries: Sequence[StimulusEntry],
    vector: SignalVector,
    sensed: NDArray[np.float64],
    parameters: Mapping[str, Accessors],
    units: Mapping[str, str],
    phase_names: Sequence[str],
    seed: int,
) -> Stimuli:
    """Connect the stimuli of a scenario to a run.

    Parameters
    ----------
    units : mapping
        Unit of each parameter; a signal's unit is the catalogue's.
    seed : int
        Of the scenario; each noise stimulus has a generator of its own.
    """
    all_units = {**{signal.name: signal.unit for signal in vector.signals}, **units}
    stimuli = []
    for number, entry in enumerate(entries):
        generator = np.random.default_rng([seed, NOISE_PURPOSE, number])
        unit = all_units.get(entry.target, "1")
        stimuli.append(
            Stimulus(
                name=entry.name or entry.target,
                target=entry.target,
                begins=entry.when.compile(vector, phase_names),
                make_waveform=_waveform_maker(entry, unit, generator),
                duration_s=float("inf") if entry.duration is None else entry.duration,
                restore=entry.restore,
                relative=entry.relative,
            )
        )
    return Stimuli(vector, sensed, stimuli, parameters)


def _waveform_maker(entry: StimulusEntry, unit: str, generator: np.random.Generator) -> Callable[[float], Waveform]:
    """Waveform as a function of the value that the target has when the stimulus begins."""

    def number(value: Value | None, otherwise: float) -> float:
        return otherwise if value is None else to_si(value, unit)

    def make(before: float) -> Waveform:
        neutral = 0.0 if entry.relative else before
        shape = getattr(entry, entry.shape)
        if isinstance(shape, Ramp):
            return waveforms.ramp(number(shape.start, neutral), number(shape.to, 0.0), shape.over)
        if isinstance(shape, Sine):
            offset = number(shape.offset, neutral)
            return waveforms.sine(offset, number(shape.amplitude, 0.0), shape.frequency, shape.phase)
        if isinstance(shape, Sweep):
            offset = number(shape.offset, neutral)
            return waveforms.sweep(offset, number(shape.amplitude, 0.0), shape.start, shape.to, shape.over)
        if isinstance(shape, Noise):
            return waveforms.noise(number(shape.offset, neutral), number(shape.standard_deviation, 0.0), generator)
        if isinstance(shape, Table):
            return waveforms.table(shape.times, [number(value, 0.0) for value in shape.values])
        return waveforms.step(number(shape, 0.0))

    return make
