import base64

import numpy as np
import pytest

from bench.report.thinning import MAX_POINTS, presence, segments, thin, thin_about


def test_short_signal_is_kept_whole() -> None:
    time = np.arange(1500) * 1e-3
    values = np.sin(time)
    thinned = thin(time, values)
    assert thinned.offsets is None
    np.testing.assert_array_equal(thinned.values, values.astype(np.float32))
    np.testing.assert_allclose(thinned.times(), time, atol=1e-12)


def test_spike_of_one_sample_survives_with_its_time() -> None:
    time = np.arange(60_000) * 1e-3
    values = np.zeros(60_000)
    values[41_234], values[12_345] = 7.0, -3.0
    thinned = thin(time, values)
    assert len(thinned.values) <= MAX_POINTS
    # a byte for the place in a stretch of 60 samples: its rounding is below half a sample
    stretch = 60e-3
    assert thinned.times()[np.argmax(thinned.values)] == pytest.approx(41.234, abs=stretch / 255)
    assert thinned.times()[np.argmin(thinned.values)] == pytest.approx(12.345, abs=stretch / 255)


@pytest.mark.parametrize("count", [2001, 2999, 10_000, 10_001, 123_457])
def test_extremes_of_every_stretch_are_kept(count: int) -> None:
    random = np.random.default_rng(count)
    time, values = np.arange(count) * 1e-3, random.standard_normal(count)
    thinned = thin(time, values)
    length = round(2 * thinned.step / 1e-3)
    assert len(thinned.values) <= MAX_POINTS
    assert np.all(np.diff(thinned.times()) >= 0)
    for stretch in range(0, count // length, 97):
        part = values[stretch * length : (stretch + 1) * length]
        kept = thinned.values[2 * stretch : 2 * stretch + 2]
        assert kept.min() == pytest.approx(part.min(), rel=1e-6)
        assert kept.max() == pytest.approx(part.max(), rel=1e-6)


def test_missing_samples_stay_missing() -> None:
    values = np.ones(10_000)
    values[4000:6000] = np.nan
    thinned = thin(np.arange(10_000) * 1e-3, values)
    missing = np.isnan(thinned.values)
    assert missing.mean() == pytest.approx(0.2, abs=0.01)
    assert np.all(thinned.values[~missing] == 1.0)


def test_inline_form_decodes_to_the_same_numbers() -> None:
    thinned = thin(np.arange(5000) * 1e-3, np.arange(5000.0))
    content = thinned.inline()
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(str(content["data"])), "<f4"), thinned.values)
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(str(content["offsets"])), np.uint8), thinned.offsets)


def test_states_become_segments_that_touch() -> None:
    time = np.arange(10) * 0.1
    states = np.array([0, 0, 1, 1, 1, 2, 0, 0, 0, 0.0])
    assert segments(time, states) == [(0.0, 0.2, 0), (0.2, 0.5, 1), (0.5, 0.6, 2), (0.6, 0.9, 0)]


def test_chatter_is_bounded() -> None:
    time = np.arange(100_000) * 1e-3
    found = segments(time, np.arange(100_000) % 2.0, max_segments=500)
    assert 0 < len(found) <= 500
    assert found[0][0] == 0.0
    assert found[-1][1] == pytest.approx(99.999, abs=0.3)


def test_presence_breaks_where_frames_are_missing() -> None:
    times = np.concatenate((np.arange(0.0, 1.0, 0.005), np.arange(1.2, 2.0, 0.005)))
    assert presence(times, 0.0125) == [(0.0, 0.995), (1.2, 1.995)]
    assert presence(np.zeros(0), 0.01) == []


def test_the_focus_gets_most_points_and_the_pieces_touch() -> None:
    time = np.arange(60_001) * 1e-3
    values = np.sin(time)
    pieces = thin_about(time, values, (20.0, 24.0))
    points = [len(piece.values) for piece in pieces]
    assert len(pieces) == 3
    assert sum(points) <= MAX_POINTS
    assert points[1] > 1000
    times = np.concatenate([piece.times() for piece in pieces])
    assert np.all(np.diff(times) >= 0.0)
    assert times[0] == pytest.approx(0.0, abs=1.0)
    assert times[-1] == pytest.approx(60.0, abs=1.0)
    inside = pieces[1].times()
    assert 20.0 <= inside[0] < 20.01
    assert 23.99 < inside[-1] <= 24.0


def test_without_focus_there_is_one_piece() -> None:
    time = np.arange(60_001) * 1e-3
    assert [len(piece.values) for piece in thin_about(time, np.sin(time), None)] == [1968]
    assert len(thin_about(time[:100], time[:100], (0.02, 0.05))) == 1
