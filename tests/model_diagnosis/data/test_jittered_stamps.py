"""Frames of a cyclic sender whose stamps jitter: no command is lost or doubled, no value moves in time."""

import numpy as np
import pytest

from model_diagnosis.data.grid import on_grid, own_samples, steady_stamps
from model_diagnosis.data.samples import Samples

PERIOD_S = 0.01
JITTER_S = 3e-4
DRIFT = 5e-5


def jittered(count: int, seed: int) -> np.ndarray:
    """Stamps of a sender whose clock is 50 ppm fast, as a logger sets them."""
    random = np.random.default_rng(seed)
    stamps = PERIOD_S * (1.0 + DRIFT) * np.arange(count)
    return stamps + np.clip(JITTER_S * random.standard_normal(count), -1e-3, 1e-3) + 1e-3


def channel(name: str, stamps: np.ndarray, values: np.ndarray) -> Samples:
    return Samples(name, "1", stamps, values, np.isfinite(values), name, "log.blf")


@pytest.mark.parametrize("seed", range(5))
def test_no_valve_pulse_is_lost_or_doubled(seed: int) -> None:
    """A build-up pulse of one cycle every three: each is on the time base once, where it was sent."""
    stamps = jittered(900, seed)
    pulses = (np.arange(900) % 3 == 1).astype(float)
    speed = channel("speed", stamps, np.linspace(30.0, 10.0, 900))
    time, values, _ = on_grid({"valve_inlet_fl": channel("valve_inlet_fl", stamps, pulses), "speed": speed})
    held = values["valve_inlet_fl"]
    assert np.all(np.diff(np.flatnonzero(held > 0.5)) == 3)
    sent = PERIOD_S * (1.0 + DRIFT) * np.flatnonzero(pulses) + 1e-3
    seen = time[held > 0.5]
    # half a step at most, and the jitter of the stamp with which the time base begins
    assert np.abs(seen - sent[: len(seen)]).max() < 0.5 * PERIOD_S + 1e-3


@pytest.mark.parametrize("seed", range(5))
def test_steady_stamps_follow_the_drift_and_drop_the_jitter(seed: int) -> None:
    """The running median over 51 stamps has 1.25/sqrt(51) of the jitter: 0.053 ms; four of that are allowed."""
    error = steady_stamps(jittered(2000, seed)) - (PERIOD_S * (1.0 + DRIFT) * np.arange(2000) + 1e-3)
    assert float(np.std(error)) < 1.5 * 1.2533 / np.sqrt(51.0) * JITTER_S
    assert np.abs(error[25:-25]).max() < 5.0 * 1.2533 / np.sqrt(51.0) * JITTER_S


def test_a_lost_frame_leaves_the_others_in_place() -> None:
    stamps = jittered(900, 7)
    kept = np.ones(900, dtype=bool)
    kept[[100, 101, 400]] = False
    whole, with_losses = steady_stamps(stamps), steady_stamps(stamps[kept])
    assert with_losses == pytest.approx(whole[kept], abs=2e-4)


def test_stamps_of_no_cyclic_sender_stay() -> None:
    """Frames sent on events, and a table whose stamps have no jitter."""
    events = np.cumsum(np.random.default_rng(3).exponential(0.01, 500))
    table = PERIOD_S * np.arange(500)
    assert steady_stamps(events) is events
    assert steady_stamps(table) == pytest.approx(table, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("phase_s", [-5e-3, -4.95e-3, 2e-3, 4.95e-3, 5e-3])
def test_samples_stay_as_they_were_taken_whatever_their_phase(phase_s: float, seed: int) -> None:
    """Half a step off the time base too, where a jitter of 0.05 ms rounds one stamp down and the next one up.

    White noise in, the same noise out: laid on straight lines half way between its samples it would lose half of its
    variance, and a smoothing that knows its size from the differences would keep the rest.
    """
    random = np.random.default_rng(seed)
    time = PERIOD_S * np.arange(900)
    noise = random.standard_normal(900)
    stamps = time + phase_s + JITTER_S * random.standard_normal(900)
    kept = own_samples({"brake_pressure_fl": channel("brake_pressure_fl", stamps, noise)}, time)["brake_pressure_fl"]
    phase = kept.phase(0, 900)
    assert phase is not None
    assert abs(phase) == pytest.approx(abs(phase_s), abs=3e-5)  # half a step before is half a step behind
    taken = kept.values[kept.weights > 0.0]
    assert len(taken) >= 899  # one may lie off the ends
    assert np.isin(taken, noise).all()
