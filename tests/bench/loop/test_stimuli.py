"""Stimuli: what they change, when, and what they refuse to change."""

from collections.abc import Callable

import numpy as np
import pytest

from bench.loop import waveforms
from bench.loop.stimuli import Stimuli, Stimulus
from signals.catalogue import block_slice
from signals.errors import InputError
from signals.vector import SignalVector


class Owner:
    """A part with one parameter."""

    def __init__(self) -> None:
        self.value = 0.4
        self.history: list[float] = []

    def get(self) -> float:
        return self.value

    def set(self, value: float) -> None:
        self.value = value
        self.history.append(value)


def sensed() -> np.ndarray:
    bus = block_slice("bus")
    return np.zeros(bus.stop - bus.start)


def at(vector: SignalVector, time_s: float) -> Callable[[float], bool]:
    return lambda armed_s: vector["time"] >= time_s


def run(stimuli: Stimuli, vector: SignalVector, ticks: int, each: Callable[[int], None] = lambda n: None) -> None:
    for n in range(ticks):
        vector.values[vector.index("time")] = n * 1e-3
        stimuli.tick(n * 1e-3)
        each(n)


@pytest.mark.acceptance("F-38")
def test_a_parameter_changes_for_its_duration_and_gets_its_value_back() -> None:
    vector, owner = SignalVector(), Owner()
    stimulus = Stimulus("fade", "brakes.front.pad_friction", at(vector, 0.010), lambda b: waveforms.step(0.2), 0.005)
    stimuli = Stimuli(vector, sensed(), [stimulus], {"brakes.front.pad_friction": (owner.get, owner.set)})
    values: list[float] = []
    run(stimuli, vector, 20, lambda n: values.append(owner.value))
    assert values == [0.4] * 10 + [0.2] * 5 + [0.4] * 5
    assert [event for _, _, event in stimuli.log] == ["begins", "ends"]


def test_a_relative_ramp_starts_from_the_value_before() -> None:
    vector, owner = SignalVector(), Owner()
    stimulus = Stimulus("p", "p", at(vector, 0.0), lambda b: waveforms.ramp(0.0, 0.1, 0.010), relative=True)
    run(Stimuli(vector, sensed(), [stimulus], {"p": (owner.get, owner.set)}), vector, 11)
    assert owner.history[0] == pytest.approx(0.4)
    assert owner.history[5] == pytest.approx(0.45)
    assert owner.history[10] == pytest.approx(0.5)


def test_constant_stimulus_sets_its_parameter_once() -> None:
    """Filling a part's tables anew takes a good part of a tick, so nothing is set that is set already."""
    vector, owner = SignalVector(), Owner()
    stimulus = Stimulus("p", "p", at(vector, 0.0), lambda b: waveforms.step(0.2), 0.050)
    run(Stimuli(vector, sensed(), [stimulus], {"p": (owner.get, owner.set)}), vector, 100)
    assert owner.history == [0.2, 0.4]


def test_of_two_stimuli_on_one_parameter_the_later_wins_and_the_earlier_goes_on() -> None:
    vector, owner = SignalVector(), Owner()
    first = Stimulus("a", "p", at(vector, 0.0), lambda b: waveforms.step(0.2))
    second = Stimulus("b", "p", at(vector, 0.010), lambda b: waveforms.step(0.3), 0.005)
    stimuli = Stimuli(vector, sensed(), [first, second], {"p": (owner.get, owner.set)})
    values: list[float] = []
    run(stimuli, vector, 20, lambda n: values.append(owner.value))
    assert values == [0.2] * 10 + [0.3] * 5 + [0.2] * 5


def test_each_signal_is_overridden_at_the_stage_of_its_block() -> None:
    vector, on_the_bus = SignalVector(), sensed()
    targets = ("driver_pedal_force", "true_brake_pressure_fl", "wheel_speed_fl", "valve_inlet_fl")
    entries = [Stimulus(t, t, at(vector, 0.0), lambda b: waveforms.step(7.0)) for t in targets]
    stimuli = Stimuli(vector, on_the_bus, entries, {})
    stimuli.tick(0.0)
    stimuli.override_commands()
    assert (vector["driver_pedal_force"], vector["valve_inlet_fl"]) == (7.0, 7.0)
    assert vector["true_brake_pressure_fl"] == 0.0
    stimuli.override_actuation()
    assert vector["true_brake_pressure_fl"] == 7.0
    assert not on_the_bus.any()
    stimuli.override_sensed()
    assert on_the_bus[vector.index("wheel_speed_fl") - block_slice("bus").start] == 7.0
    # what the ECU sees is changed in the frames, not in the decoded block
    assert vector["wheel_speed_fl"] == 0.0


def test_of_two_stimuli_on_one_signal_the_later_wins() -> None:
    vector = SignalVector()
    entries = [
        Stimulus(str(v), "driver_pedal_force", at(vector, 0.0), lambda b, v=v: waveforms.step(v)) for v in (1.0, 2.0)
    ]
    stimuli = Stimuli(vector, sensed(), entries, {})
    stimuli.tick(0.0)
    stimuli.override_commands()
    assert vector["driver_pedal_force"] == 2.0
    assert stimuli.active_count == 2


@pytest.mark.parametrize("target", ["speed", "bus_load", "no_such_signal"])
def test_what_cannot_be_overridden_is_refused(target: str) -> None:
    vector = SignalVector()
    with pytest.raises(InputError, match=target):
        Stimuli(vector, sensed(), [Stimulus("x", target, at(vector, 0.0), lambda b: waveforms.step(0.0))], {})
