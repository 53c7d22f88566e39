"""What drives the replay: noise is taken out of it, flanks are not."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from scipy.stats import norm

from model_diagnosis.replay.broken_lines import broken_lines
from model_diagnosis.replay.smoothing import noise_of, pressure_without_noise, without_noise
from model_diagnosis.replay.turns import turning_points, without_small_turns

NOISE = 3e4
"""A series pressure sensor's, Pa."""


def followed(master: np.ndarray, step_s: float = 0.01) -> np.ndarray:
    """Wheel pressure behind a valve that fills it slowly and empties it fast (50 ms, 10 ms; friction document 2.6)."""
    wheel = np.empty_like(master)
    wheel[0] = master[0]
    for k in range(1, len(master)):
        time_constant = 0.05 if master[k] > wheel[k - 1] else 0.01
        wheel[k] = wheel[k - 1] + (1.0 - np.exp(-step_s / time_constant)) * (master[k] - wheel[k - 1])
    return wheel


def test_noise_is_estimated_on_a_ramp() -> None:
    rng = np.random.default_rng(1)
    values = 1e5 * np.arange(4000) + NOISE * rng.standard_normal(4000)
    # the lowest tenth of the variances in 4000 overlapping windows of 15 samples; one window's scatters by a half
    assert noise_of(values) == pytest.approx(NOISE, rel=0.06)


def test_a_held_pressure_keeps_its_mean_behind_a_one_way_valve() -> None:
    rng = np.random.default_rng(2)
    held = 1.8e6 + NOISE * rng.standard_normal(2000)
    raw, quiet = followed(held)[100:], followed(without_noise(held))[100:]
    assert raw.mean() < 1.8e6 - 0.4 * NOISE  # the valve follows the lowest values
    assert abs(quiet.mean() - 1.8e6) < 0.1 * NOISE


@pytest.mark.parametrize("seed", range(4))
def test_courses_of_lines_are_weighed_as_by_trying_all_of_them(seed: int) -> None:
    """Every way to cut nine samples, each line's level and slope integrated out on its own (a Gaussian integral)."""
    rng = np.random.default_rng(seed)
    values = np.where(np.arange(9) < 5, 0.0, 4.0) + rng.standard_normal(9)
    levels = np.ptp(values)
    slopes = max(1.0, 2.0 * np.max(np.abs(values[4:] - values[:-4])) / 4.0)
    weights, courses = [], []
    for cuts in (cuts for count in range(8) for cuts in combinations(range(1, 9), count)):
        pieces = np.split(values, cuts)
        if min(map(len, pieces)) < 2:
            continue
        weight, course = 1.0, []
        for piece in pieces:
            design = np.stack([np.ones(len(piece)), np.arange(len(piece))], axis=1)
            line = design @ np.linalg.lstsq(design, piece)[0]
            likely = np.prod(norm.pdf(piece - line)) * 2.0 * np.pi / np.sqrt(np.linalg.det(design.T @ design))
            weight *= likely / (levels * slopes) * 0.95 ** (len(piece) - 1) * 0.05
            course.extend(line)
        weights.append(weight)
        courses.append(course)
    found = np.empty(9)
    broken_lines(values, 1.0, found)
    np.testing.assert_allclose(found, np.average(courses, axis=0, weights=weights), atol=1e-9)


def test_a_ramp_keeps_its_corners() -> None:
    """Nearly as well as by a line of its own for each piece, had one known where the pieces end."""
    rng = np.random.default_rng(3)
    samples, corners = np.arange(400), (100, 130, 270, 300)
    ramp = np.interp(samples, corners, (0.0, 3e6, 3e6, 0.0))
    near = np.min(np.abs(samples[:, None] - np.array(corners)), axis=1) < 16
    found, known = [], []
    for _ in range(100):
        noisy = ramp + NOISE * rng.standard_normal(400)
        found.append(without_noise(noisy)[near] - ramp[near])
        pieces = zip(np.split(samples, corners), np.split(noisy, corners), strict=True)
        lines = np.concatenate([np.polyval(np.polyfit(*piece, 1), piece[0]) for piece in pieces])
        known.append(lines[near] - ramp[near])
    assert np.std(found) < 1.5 * np.std(known)
    assert np.max(np.abs(np.mean(found, axis=0))) < 0.3 * NOISE  # windows of 33 samples round them by 1.0


def test_flanks_of_an_abs_cycle_stay_as_they_are() -> None:
    rng = np.random.default_rng(4)
    saw = 4e6 + 2e6 * np.abs(np.mod(np.arange(600) / 12.0, 2.0) - 1.0)
    noisy = saw + NOISE * rng.standard_normal(600)
    error = without_noise(noisy) - saw
    assert float(np.std(error)) < 1.3 * NOISE
    assert abs(float(error.mean())) < 0.2 * NOISE


def test_samples_without_noise_and_short_stretches_are_handed_through() -> None:
    ramp = np.linspace(0.0, 5e6, 200)
    np.testing.assert_allclose(without_noise(ramp), ramp, atol=1e-6)
    few = np.array([1.0, 2.0, 4.0])
    assert np.array_equal(without_noise(few), few)


def test_released_brakes_are_not_pressed_by_noise() -> None:
    noise = NOISE * np.random.default_rng(6).standard_normal(4000)
    noise[3000:] += 2e6
    raw, quiet = np.maximum(noise[:2950], 0.0), np.maximum(pressure_without_noise(noise)[:2950], 0.0)
    assert raw.mean() == pytest.approx(NOISE / np.sqrt(2.0 * np.pi), rel=0.05)  # mean of the positive half of a normal
    assert quiet.mean() < 0.03 * NOISE
    assert pressure_without_noise(noise)[3100:3900].mean() == pytest.approx(2e6, rel=0.002)


@pytest.mark.parametrize("seed", range(5))
def test_single_peaks_of_the_noise_are_no_pressure(seed: int) -> None:
    """At rest nothing drives the brakes, and a slow application loses no more than its first peak of the noise."""
    rng = np.random.default_rng(seed)
    rest = NOISE * rng.standard_normal(2000)
    assert not pressure_without_noise(rest).any()
    ramp = np.maximum(1e6 * (np.arange(600) - 300) * 0.01, 0.0)
    begun = pressure_without_noise(ramp + NOISE * rng.standard_normal(600))
    assert np.all(begun[ramp > 5.0 * NOISE + 3.0 * NOISE] > 0.0)
    assert abs(float(np.mean(begun[350:] - ramp[350:]))) < 0.2 * NOISE


def held_back(pressure: np.ndarray, width: float) -> np.ndarray:
    """Pressure that acts on the pads of a brake with hysteresis: it falls only beyond the width."""
    acting = pressure.copy()
    for k in range(1, len(acting)):
        acting[k] = max(min(acting[k - 1], pressure[k] + width), pressure[k])
    return acting


def strokes(seed: int) -> np.ndarray:
    """A pedal pressed, held, pressed harder and let go, each stroke in 0.3 to 0.9 s: as an s, without corners."""
    rng = np.random.default_rng(seed)
    levels, course = [0.0, 2e6, 4e6, 1.5e6, 5e6, 0.0], [np.zeros(50)]
    for before, after in pairwise(levels):
        rise = np.linspace(0.0, 1.0, int(rng.integers(30, 90)))
        course += [
            before + (after - before) * (3.0 * rise**2 - 2.0 * rise**3),
            np.full(int(rng.integers(40, 120)), after),
        ]
    return np.concatenate(course)


@pytest.mark.parametrize("seed", range(4))
def test_noise_of_a_pressure_is_no_width_of_a_hysteresis(seed: int) -> None:
    """Of 0.6 bar; what windows and lines leave of the noise on flanks adds 0.05 to 0.09 bar. 0.02 are allowed."""
    true, width = strokes(seed), 6e4
    measured = true + NOISE * np.random.default_rng(seed + 100).standard_normal(len(true))
    wanted = held_back(true, width) - true
    widths = np.linspace(0.0, 2e5, 201)

    def seen(pressure: np.ndarray) -> float:
        """Width with which this pressure holds a brake back as the true one does."""
        errors = [np.sum((held_back(pressure, one) - pressure - wanted) ** 2) for one in widths]
        return float(widths[int(np.argmin(errors))])

    assert seen(pressure_without_noise(measured)) == pytest.approx(width, abs=2e3)


def test_a_course_turns_where_it_goes_back_by_more_than_its_noise() -> None:
    values = np.array([0.0, 2.0, 1.5, 4.0, 3.9, 8.0, 7.0, 3.0, 3.5, 1.0, 5.0])
    assert list(turning_points(values, 2.0)) == [0, 5, 9, 10]
    # means of what goes back in between: 2 and 1.5, 4 and 3.9, 3 and 3.5
    pooled = without_small_turns(values, 2.0 / 3.0)
    assert pooled == pytest.approx([0.0, 1.75, 1.75, 3.95, 3.95, 8.0, 7.0, 3.25, 3.25, 1.0, 5.0])


def test_cycles_of_an_abs_stop_keep_their_peaks() -> None:
    """Turns of bars, from sample to sample, are no noise."""
    cycles = 4e6 + 1e6 * np.abs((np.arange(300) % 20) - 10) / 10.0
    assert without_small_turns(cycles, NOISE) == pytest.approx(cycles, abs=1.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_hold_ends_at_its_own_pressure(seed: int) -> None:
    """And not at the highest of its samples, 2.4 standard deviations above it: of the mean 0.1 is left."""
    rng = np.random.default_rng(seed)
    true = np.concatenate([np.linspace(0.0, 3e6, 60), np.full(100, 3e6), np.linspace(3e6, 0.0, 60)])
    course = without_small_turns(true + 5e3 * rng.standard_normal(len(true)), NOISE)
    assert course.max() - 3e6 < 0.5 * 5e3
