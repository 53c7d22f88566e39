"""Road grade of the state document (V-48 to V-53) on the shipped hills, from signals with the document's noise."""

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from state_runs import ALL_NOISE, SEEDS, WHEELS, Drive, Replay, drive, forget_drives


@pytest.fixture(scope="module", autouse=True)
def _drives_are_dropped() -> Iterator[None]:
    yield
    forget_drives()


def section(run: Drive, found: Replay) -> tuple[float, float]:
    """Mean grade over the hill, and the hill's length by the estimate: between the half of its mean, 1 s averages."""
    grade, clock = found["road_grade"], run["time"]
    smooth = np.convolve(grade, np.full(1000, 1e-3), mode="same")
    on = np.abs(run["road_grade"]) >= 0.999 * np.abs(run["road_grade"]).max()
    mean = float(grade[on].mean())
    above = np.abs(smooth) > 0.5 * abs(mean)
    above[clock < 2.0] = False
    first, last = np.flatnonzero(above)[[0, -1]]
    return mean, float(np.sum(found["speed"][first : last + 1]) * 1e-3)


HILLS = [(grade, length, way) for grade, length in ((4, 750), (6, 507), (8, 501), (10, 400)) for way in ("up", "down")]


@pytest.mark.acceptance("V-50", "V-51", "V-55")
@pytest.mark.parametrize(("grade", "length", "way"), HILLS)
def test_hills(grade: int, length: int, way: str, record: Callable[..., None]) -> None:
    run = drive(f"state/hill_{grade}_{way}")
    true = grade / 100.0 if way == "up" else -grade / 100.0
    results = [section(run, Replay(run, "road_grade", {}, seed=s, noise=ALL_NOISE)) for s in SEEDS]
    error = 100.0 * abs(np.mean([mean for mean, _ in results]) / true - 1.0)
    worst = max(abs(found - length) for _, found in results)
    record(f"{grade} % {way}: error of the mean %", float(error), "<= 6.2", id="V-50")
    record(f"{grade} % {way}: error of the length m", float(worst), "<= 10", id="V-51")
    assert error <= 6.2
    assert worst <= 10.0


@pytest.mark.acceptance("V-48")
def test_grade_changes_only_with_its_blocks() -> None:
    found = Replay(drive("state/hill_10_up"), "road_grade", {"grade.block_time": 0.05}, seed=0, noise=ALL_NOISE)
    changed = np.flatnonzero(np.diff(found["road_grade"][200:5000]))
    assert len(changed) > 50
    assert np.all(np.diff(changed) % 50 == 0)


@pytest.mark.acceptance("V-49")
def test_inertial_reading_runs_away(record: Callable[..., None]) -> None:
    """A minute on 10 %: bounded; with eq. 3.1's acceleration the grade is counted twice (3.6 [E])."""
    forget_drives()  # this one alone takes as much as two others
    hill = [(90, 0.0), (110, 0.1), (1330, 0.1), (1350, 0.0)]
    run = drive(
        "state/hill_10_up",
        road__profile=[{"position": f"{place} m", "grade": grade} for place, grade in hill],
        manoeuvre__steps__hill__until={"distance": "1330 m"},
        manoeuvre__steps__leave__until={"distance": "1331 m"},
    )
    on = run["road_grade"] > 0.0999
    assert np.count_nonzero(on) >= 60_000
    good = Replay(run, "road_grade", {}, seed=0, noise=ALL_NOISE)["road_grade"]
    bad = Replay(run, "road_grade", {"grade.model_acceleration": "inertial"}, seed=0, noise=ALL_NOISE)["road_grade"]
    record("largest estimate in 60 s on 10 %", float(np.abs(good[2000:]).max()), "bounded, < 0.2")
    record("estimate after 60 s on 10 %", float(good[on][-1000:].mean()), "0.1 +- 0.01")
    assert np.abs(good[2000:]).max() < 0.2
    assert good[on][-1000:].mean() == pytest.approx(0.1, abs=0.01)
    assert bad[on][-1] > 0.3


@pytest.mark.acceptance("V-52")
def test_pitch_compensation(record: Callable[..., None]) -> None:
    """Off, the grade shifts by about 1.2 % per m/s^2; on, a hard acceleration on a flat road reads below 0.5 %."""
    run = drive("state/launch_dry_asphalt")
    part = (run["time"] > 5.5) & (run["time"] < 7.5)
    acceleration = float(run["true_longitudinal_acceleration"][part].mean())
    on, off = (
        Replay(run, "road_grade", {"grade.pitch_compensation": state}, seed=0, noise=ALL_NOISE)["road_grade"][part]
        for state in (True, False)
    )
    shift = 100.0 * float(off.mean() - on.mean()) / acceleration
    record("shift % per m/s^2", shift, "about 1.2")
    record("flat road, mean grade %", 100.0 * float(on.mean()), "< 0.5")
    assert acceleration > 1.5
    assert shift == pytest.approx(1.2, abs=0.15)
    assert abs(100.0 * on.mean()) < 0.5


@pytest.mark.acceptance("V-53")
def test_standstill_gives_the_first_grade() -> None:
    run = drive("state/hill_10_up")

    def standing(columns: dict[str, np.ndarray]) -> None:
        for wheel in WHEELS:
            columns[f"wheel_speed_{wheel}"][:] = 0.0
        columns["longitudinal_acceleration"][:] = 9.80665 * math.sin(math.atan(0.08))

    found = Replay(run, "road_grade", {}, seed=None, change=standing)
    assert found["road_grade"][2000] == pytest.approx(0.08, abs=1e-6)
    assert found["road_grade_confidence"][2000] == 1.0
