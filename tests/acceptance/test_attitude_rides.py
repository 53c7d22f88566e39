"""Acceptance list of the attitude document (its section 8), items 42 to 50, 52 to 54 and 57: rides with fresh seeds.

The set-up is that of its 7.1, the cycle that of its 3.6. Settings are the document's; nothing was tuned on these seeds.
Every comparison states three references: one filter with the bank's noise, one with its own best noise (chosen on
seeds 1 and 2), one with the virtual offset as one more state.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from attitude_rides import (
    DEGREE,
    DOCUMENT,
    JUDGED_S,
    MILLI_G,
    ONSET_S,
    SEEDS,
    Estimate,
    grid,
    noise,
    numbers,
    observe,
    offsets,
    ride,
)

from vehicle_model.reference.two_wheeler import measure

BANK, ONE, EXTRA = "attitude_bank", "attitude_single", "attitude_augmented"
LENGTH_S = 150.0

WIDE = {"virtual_offsets": grid(-300, 0, 300)}
STIFF = {"process_gyro_offset": 6e-6, "process_acceleration_offset": 4e-4}
NINE = {"virtual_offsets": grid(*range(-160, 161, 40))}
FINE_2B = noise(0.2, 0.2, 0.1, 0.2)

GYROS = ("roll_rate_offset", "pitch_rate_offset", "yaw_rate_offset")
ACCELEROMETERS = tuple(f"{axis}_acceleration_offset" for axis in ("longitudinal", "lateral", "vertical"))


@pytest.fixture(scope="module", autouse=True)
def _rides_are_dropped() -> Iterator[None]:
    yield
    ride.cache_clear()
    _judged.cache_clear()


@dataclass(frozen=True)
class Verdict:
    """Errors [degrees] and mean offsets [degree/s, mG] of a run, from 90 s on."""

    roll: float
    pitch: float
    virtual: float
    slope: float
    elevation: float
    offsets: Mapping[str, float]


def _verdict(found: Estimate) -> Verdict:
    names = (*GYROS, *ACCELEROMETERS)
    return Verdict(
        found.error("roll_angle"),
        found.error("pitch_angle"),
        found.mean("virtual_offset"),
        found.error("road_slope"),
        found.error("elevation_angle"),
        {name: found.mean(name) for name in names},
    )


@cache
def _judged(name: str, form: str, wrong: str, settings: str, seed: int, changed: str) -> Verdict:
    source = ride(seed, form.startswith("2") or form == "comparison", LENGTH_S)
    columns = measure(source, seed, offsets=offsets(**pairs(wrong)), onset_s=ONSET_S)
    keys = {"form": form, **DOCUMENT, **_SETTINGS[settings]}
    car = {**numbers(), **{f"two_wheeler.{path}": value for path, value in pairs(changed).items()}}
    return _verdict(observe(source, columns, keys, name, car))


_SETTINGS: dict[str, dict[str, Any]] = {}


def pairs(text: str) -> dict[str, float]:
    """``x=100 yaw=1`` as a mapping."""
    return {key: float(value) for key, _, value in (pair.partition("=") for pair in text.split())}


def judged(form: str, wrong: str = "", name: str = BANK, changed: str = "", **settings: Any) -> list[Verdict]:
    """Verdicts over all seeds; runs are made once."""
    if name != BANK:
        settings = {key: value for key, value in settings.items() if key != "virtual_offsets"}
    label = repr(sorted(settings.items()))
    _SETTINGS[label] = settings
    return [_judged(name, form, wrong, label, seed, changed) for seed in SEEDS]


def mean(verdicts: list[Verdict], name: str) -> float:
    """Mean over the seeds."""
    return float(np.mean([getattr(verdict, name) for verdict in verdicts]))


def mean_offset(verdicts: list[Verdict], name: str) -> float:
    """Mean over the seeds of an offset."""
    return float(np.mean([verdict.offsets[name] for verdict in verdicts]))


@pytest.mark.acceptance("B-42")
@pytest.mark.parametrize("form", ["1A", "2A"])
def test_one_filter_without_offset(form: str, record: Callable[..., None]) -> None:
    value = mean(judged(form, name=ONE), "roll")
    record(f"RMSE of roll, one filter, form {form}", value, "< 0.3 degrees")
    assert value < 0.3


@pytest.mark.acceptance("B-43")
def test_figure_9a(record: Callable[..., None]) -> None:
    bank, one = judged("1A", "y=250", **WIDE, **STIFF), judged("1A", "y=250", ONE, **STIFF)
    ratio, found = mean(bank, "roll") / mean(one, "roll"), mean(bank, "virtual")
    record("RMSE of roll over that of one filter", ratio, "< 0.3")
    record("b_y for 250 mG", found, "180 ... 300 mG")
    assert ratio < 0.3
    assert 180.0 < found < 300.0


@pytest.mark.acceptance("B-44")
@pytest.mark.parametrize(
    ("wrong", "name", "true"),
    [
        ("roll=1", "roll_rate_offset", 1.0),
        ("yaw=1", "yaw_rate_offset", 1.0),
        ("z=250", "vertical_acceleration_offset", 250.0),
    ],
)
def test_figures_9c_9d_9e(wrong: str, name: str, true: float, record: Callable[..., None]) -> None:
    found = mean_offset(judged("1A", wrong, **WIDE), name)
    record(f"{name} over its truth", found / true, "0.9 ... 1.1")
    assert found == pytest.approx(true, rel=0.1)


@pytest.mark.acceptance("B-45")
def test_figure_9g(record: Callable[..., None]) -> None:
    found = mean(judged("1C", "x=100"), "virtual")
    record("b_x for 100 mG", found, "60 ... 110 mG")
    assert 60.0 < found < 110.0


@pytest.mark.acceptance("B-46")
def test_figure_18a(record: Callable[..., None]) -> None:
    bank, one = judged("2A", "x=100"), judged("2A", "x=100", ONE)
    record("b_x for 100 mG", mean(bank, "virtual"), "100 +- 20 mG")
    assert mean(bank, "virtual") == pytest.approx(100.0, abs=20.0)
    for angle in ("roll", "pitch"):
        ratio = mean(bank, angle) / mean(one, angle)
        record(f"RMSE of {angle} over that of one filter", ratio, "< 0.4")
        assert ratio < 0.4


@pytest.mark.acceptance("B-47")
@pytest.mark.parametrize(
    ("wrong", "limits"),
    [
        ("roll=1", {"roll_rate_offset": 1.0}),
        ("pitch=1", {"pitch_rate_offset": 1.0}),
        ("yaw=1", {"yaw_rate_offset": 1.0}),
        ("z=100", {"vertical_acceleration_offset": 100.0}),
        ("roll=1 pitch=1 yaw=1 x=100 z=100", {**dict.fromkeys(GYROS, 1.0), "vertical_acceleration_offset": 100.0}),
    ],
)
def test_figures_18c_to_18g(wrong: str, limits: dict[str, float], record: Callable[..., None]) -> None:
    bank = judged("2A", wrong)
    for name, true in limits.items():
        found = mean_offset(bank, name) / true
        record(f"{name} over its truth", found, "0.95 ... 1.05")
        assert found == pytest.approx(1.0, abs=0.05), name


@pytest.mark.acceptance("B-48")
def test_figure_19a(record: Callable[..., None]) -> None:
    bank, one = judged("2B", "z=100", **NINE, **FINE_2B), judged("2B", "z=100", ONE, **FINE_2B)
    ratio, found = mean(bank, "pitch") / mean(one, "pitch"), mean(bank, "virtual")
    record("b_z for 100 mG, nine filters", found, "100 +- 10 mG")
    record("RMSE of pitch over that of one filter with the same noise", ratio, "< 0.3")
    assert found == pytest.approx(100.0, abs=10.0)
    assert ratio < 0.3


@pytest.mark.acceptance("B-49")
def test_figure_20a(record: Callable[..., None]) -> None:
    bank, one = judged("2C", "y=100"), judged("2C", "y=100", ONE)
    ratio, found = mean(bank, "roll") / mean(one, "roll"), mean(bank, "virtual")
    record("b_y for 100 mG", found, "100 +- 10 mG")
    record("RMSE of roll over that of one filter", ratio, "< 0.5")
    assert found == pytest.approx(100.0, abs=10.0)
    assert ratio < 0.5
    without = mean(judged("2C", "y=100", characteristic_equation=False), "virtual")
    record("b_y without the characteristic equation", without, "< 50 mG")
    assert without < 50.0


@pytest.mark.acceptance("B-50")
def test_example_4(record: Callable[..., None]) -> None:
    wrong = "roll=1 pitch=1 yaw=1 x=100 z=100"
    errors = {}
    for label, form, name in (("comparison device", "comparison", ONE), ("1C", "1C", BANK), ("2A", "2A", BANK)):
        # all three ride on the slopes, which is what the first embodiment leaves out
        values = []
        for seed in SEEDS:
            source = ride(seed, True, LENGTH_S)
            columns = measure(source, seed, offsets=offsets(**pairs(wrong)), onset_s=ONSET_S)
            values.append(observe(source, columns, {"form": form, **DOCUMENT}, name).error("roll_angle"))
        errors[label] = float(np.mean(values))
        record(f"RMSE of roll, {label}", errors[label], "comparison >= first (5 %) > second; 0.90, 0.90, 0.11 degrees")
    assert errors["comparison device"] >= 0.95 * errors["1C"]
    assert errors["1C"] > errors["2A"]


@pytest.mark.acceptance("B-52")
def test_slope(record: Callable[..., None]) -> None:
    closed = mean(judged("2A"), "slope")
    without = mean(judged("2A-light"), "slope")
    record("RMSE of the slope, closed loop", closed, "< 0.5 degrees; 0.24 in the document")
    record("with zeta = 0 over closed loop", without / closed, ">= 1.5")
    record("RMSE of zeta", mean(judged("2A"), "elevation"), "reported, 0.02 degrees in the document")
    assert closed < 0.5
    assert without >= 1.5 * closed


@pytest.mark.acceptance("B-53")
@pytest.mark.parametrize("form", ["1A", "2A"])
def test_straight_on(form: str, record: Callable[..., None]) -> None:
    """60 s after 10 s in which the filters start; the extra state drifts, the bank cannot."""
    errors, peaks, found, extra = [], [], [], []
    for seed in SEEDS:
        source = ride(seed, form == "2A", 70.0, 0.0)
        columns = measure(source, seed)
        bank, one = (observe(source, columns, {"form": form, **DOCUMENT}, name) for name in (BANK, EXTRA))
        rows = bank.after(10.0)
        errors.append(bank.error("roll_angle", 10.0))
        peaks.append(np.abs(bank["roll_angle"][rows] - bank.truth["roll_angle"][rows]).max() / DEGREE)
        found.append(np.abs(bank["virtual_offset"][rows]).max() / MILLI_G)
        extra.append(np.abs(one["virtual_offset"][rows]).max() / MILLI_G)
    record(f"RMSE of roll, form {form}, worst seed", max(errors), "< 0.5 degrees")
    record(f"largest error of roll, form {form}, mean over the seeds", float(np.mean(peaks)), "reported, degrees")
    record(f"largest estimate of the offset, form {form}, mean over the seeds", float(np.mean(found)), "< 10 mG")
    record(f"the same of the extra state, form {form}", float(np.mean(extra)), "reported; -59 mG in the document")
    assert max(errors) < 0.5
    assert np.mean(found) < 10.0


WRONG_PARAMETERS = {
    "mass centre 5 cm higher": "mass_z=-0.05",
    "mass centre 5 cm forward": "mass_x=0.10",
    "R_cr +10 %": "crown_radius=0.099",
    "I_xx +30 %": "roll_inertia=28.6",
    "h +3 cm": "sensor_height=0.78",
}
MIDDLE = {"cycle": "middle"}


@pytest.mark.acceptance("B-54")
@pytest.mark.parametrize(
    ("form", "wrong", "label"),
    [("2A", "x=100", label) for label in WRONG_PARAMETERS]
    # 2C hardly feels them: one is enough for every run
    + [
        pytest.param("2C", "y=100", label, marks=[] if label == "mass centre 5 cm higher" else [pytest.mark.nightly])
        for label in WRONG_PARAMETERS
    ],
)
def test_wrong_parameters(form: str, wrong: str, label: str, record: Callable[..., None]) -> None:
    nominal = mean(judged(form, wrong), "roll")
    value = mean(judged(form, wrong, changed=WRONG_PARAMETERS[label]), "roll")
    record(f"RMSE of roll over nominal, form {form}", value / nominal, "< 2")
    assert value < 2.0 * nominal


@pytest.mark.acceptance("B-54")
def test_a_wrong_mass_centre_with_inputs_of_the_middle(record: Callable[..., None]) -> None:
    """The cycle of the bench has a smaller error with the wrong car too; its nominal one has fallen further."""
    wrong = {"changed": WRONG_PARAMETERS["mass centre 5 cm higher"]}
    errors = {
        (cycle, label): mean(judged("2A", "x=100", **keys, **changes), "roll")
        for cycle, keys in (("document", {}), ("middle", MIDDLE))
        for label, changes in (("nominal", {}), ("mass centre 5 cm higher", wrong))
    }
    for (cycle, label), value in errors.items():
        record(f"RMSE of roll, cycle {cycle}, {label}", value, "reported, degrees; 0.11 and 0.18 in the document")
    for label in ("nominal", "mass centre 5 cm higher"):
        assert errors["middle", label] < errors["document", label]


@pytest.mark.nightly
@pytest.mark.acceptance("B-57")
@pytest.mark.parametrize(
    ("form", "wrong", "settings", "own"),
    [
        ("1A", "y=250", {**WIDE, **STIFF}, noise(5.0, 5.0, 0.05)),
        ("1C", "x=100", {}, noise(0.3, 0.3, 0.1)),
        ("2A", "x=100", {}, noise(0.03, 0.03, 0.1, 0.03)),
        ("2B", "z=100", {**NINE, **FINE_2B}, noise(2.0, 2.0, 0.2, 2.0)),
        ("2C", "y=100", {}, noise(5.0, 5.0, 0.2, 5.0)),
    ],
)
def test_three_references(
    form: str, wrong: str, settings: dict[str, Any], own: dict[str, float], record: Callable[..., None]
) -> None:
    for label, on in (("no offset", ""), (wrong, wrong)):
        rows = {
            "bank": judged(form, on, **settings),
            "one filter, bank's R": judged(form, on, ONE, **settings),
            "one filter, own R": judged(form, on, ONE, **{**settings, **own}),
            "extra state": judged(form, on, EXTRA, **settings),
        }
        if form == "2A":
            # as shipped it takes the noise of 2B, which has the same states
            rows["extra state, bank's R"] = judged(form, on, EXTRA, **noise(0.1, 0.1, 0.1, 0.1))
        for name, verdicts in rows.items():
            record(f"{form}, {label}, {name}: RMSE of roll", mean(verdicts, "roll"), "reported, degrees")
            if form.startswith("2"):
                record(f"{form}, {label}, {name}: RMSE of pitch", mean(verdicts, "pitch"), "reported, degrees")
            if name == "bank" or name.startswith("extra"):
                record(f"{form}, {label}, {name}: offset", mean(verdicts, "virtual"), "reported, mG")
        assert all(np.isfinite(mean(verdicts, "roll")) for verdicts in rows.values())
    assert not set(SEEDS) & {1, 2, 3, 4}, "seeds of the settings"
    assert len(SEEDS) >= 6
    assert JUDGED_S - ONSET_S >= 60.0
