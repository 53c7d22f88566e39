"""Cases: the same seed gives the same case, families in their shares, sizes in scatters, values as they act."""

import itertools
import json
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from generate import main
from hidden_effects.case import Case
from hidden_effects.effects import EFFECTS, SMALLEST_UNITS
from hidden_effects.families import CONFOUNDED, SHARES, Draw, Hidden, LookAlike, draw, family_of, named
from hidden_effects.isolability import (
    EVIDENCE_NEEDED,
    RIVAL_SIZE,
    FloatArray,
    Point,
    detection_limit,
    effect_column,
    expected_evidence,
    nominal_point,
    scatter_columns,
    size_std,
    truth_of,
)
from hidden_effects.manoeuvres import HELD_OUT, SIX
from hidden_effects.sealing import seal_of
from hidden_effects.special_effects import UNEXCITED

_BELOW_THE_LIMIT = tuple(one.name for one in SIX if one.name != "abs_stop")
CSV_CASE = next(index for index in range(9) if Case(3, index, "clean", "first").format == "csv")


def test_families_come_in_their_shares_from_the_first_cases_on() -> None:
    counts = Counter(family_of(index, None) for index in range(200))
    assert counts == SHARES
    assert set(SHARES) == {family_of(index, None) for index in range(60)}
    assert {family_of(index, "clean") for index in range(5)} == {"clean"}


def test_sizes_lie_between_the_limit_and_the_largest_in_the_directions_that_make_sense() -> None:
    random = np.random.default_rng(3)
    seen: Counter[str] = Counter()
    for _ in range(600):
        (hidden,) = draw("single", random).effects
        effect = hidden.effect
        assert SMALLEST_UNITS <= effect.smallest <= hidden.units <= effect.largest * 1.0001
        assert np.sign(hidden.deviation) in effect.signs
        seen[effect.name] += 1
    assert len(seen) == len(EFFECTS)


def test_small_effects_stay_below_the_limit() -> None:
    random = np.random.default_rng(3)
    assert all(h.units <= h.effect.smallest for _ in range(50) for h in draw("detection", random).effects)


def test_no_channel_that_an_effect_needs_is_missing_and_a_fifth_of_the_cases_misses_one() -> None:
    random = np.random.default_rng(4)
    draws = [draw("single", random) for _ in range(800)]
    missing = [one for one in draws if one.missing]
    assert len(missing) / len(draws) == pytest.approx(0.2, abs=3.3 * np.sqrt(0.2 * 0.8 / 800))
    assert all(not set(one.missing) & {n for h in one.effects for n in h.effect.needs} for one in missing)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_every_effect_changes_car_or_chain_and_leaves_the_given_ones_alone(effect: object) -> None:
    case = Case(1, 0, "clean", "first")
    car, chain = dict(case.car), dict(case.chain)
    before = {name: value.copy() for name, value in (case.car | case.chain).items()}
    effect.change(car, chain, effect.signs[-1] * 4.0 * effect.scatter, 0)  # type: ignore[attr-defined]
    changed = [n for n, value in (car | chain).items() if not np.array_equal(value, before[n])]
    assert changed
    assert all(np.array_equal(value, before[name]) for name, value in (case.car | case.chain).items())


def test_the_same_seed_writes_the_same_logs_under_another_salt(tmp_path: Path) -> None:
    texts = []
    for name in ("one", "other"):
        out, sealed = tmp_path / name, tmp_path / f"{name}_sealed"
        words = ["cases", "--seed", "3", "--n", "9", "--only", str(CSV_CASE), "--family", "clean"]
        assert main([*words, "--out", str(out), "--sealed", str(sealed)]) == 0
        label = json.loads((sealed / f"case_{CSV_CASE:04d}.json").read_text())
        assert (
            seal_of(label["salt"], label["label"]) == (out / f"case_{CSV_CASE:04d}" / "seal.sha256").read_text().strip()
        )
        logs = sorted((out / f"case_{CSV_CASE:04d}").rglob("*.csv"))
        texts.append((label["label"], [path.read_bytes() for path in logs], label["salt"]))
        assert len(logs) == len(SIX) + len(HELD_OUT)
    assert texts[0][:2] == texts[1][:2]
    assert texts[0][2] != texts[1][2]


@pytest.mark.parametrize("family", ["single", "clean", "data_fault"])
def test_a_family_has_the_cases_of_the_mixture_under_their_numbers(family: str) -> None:
    """Why a table counts such a case once."""
    mixture = next(c for k in range(40) if (c := Case(3, k, None, "first")).family == family)
    alone = Case(3, mixture.index, family, "first")
    assert alone.deviations == mixture.deviations
    assert (alone.draw, alone.format, alone.loggers) == (mixture.draw, mixture.format, mixture.loggers)


def test_labels_stay_out_of_the_case_folders(tmp_path: Path) -> None:
    words = ["cases", "--seed", "3", "--n", "1", "--out", str(tmp_path / "a"), "--sealed", str(tmp_path / "b")]
    assert main(words) == 0
    name = json.loads((tmp_path / "b" / "case_0000.json").read_text())["label"]["effects"][0]["name"]
    files = [path for path in (tmp_path / "a").rglob("*") if path.is_file() and path.suffix in (".yaml", ".json")]
    assert files
    assert all(name not in path.read_text() for path in files)


def test_the_size_of_an_effect_counts_from_the_data_sheet() -> None:
    """At least four scatters off it, whatever the number scatters by; every other number keeps its own draw."""
    seen = set()
    for index in range(400):
        case = Case(21, index, "single", "first")
        hidden = case.draw.effects[0]
        name = hidden.effect.name
        if name in seen or name not in _VALUES:
            continue
        seen.add(name)
        assert hidden.units >= 4.0
        assert case.label()["effects"][0]["value"] == pytest.approx(_VALUES[name](hidden.deviation))
        car, chain = case.car_in(SIX[0])
        changed = {key for key in case.car if not np.array_equal(car[key], case.car[key])}
        changed |= {key for key in case.chain if not np.array_equal(chain[key], case.chain[key])}
        assert changed == _CHANGED[name]
    assert seen == set(_VALUES)


_VALUES = {
    "mass_change": lambda deviation: 1.0 + deviation,
    "tyre_friction": lambda deviation: 1.0 + deviation,
    "tyre_relaxation_length": lambda deviation: 0.2 + deviation,
    "brake_pad_pressure": lambda deviation: 1.0 + deviation,
    "gyro_offset": lambda deviation: deviation,
}
_CHANGED = {
    "mass_change": {"mass"},
    "tyre_friction": {"peak_x", "peak_y", "wheel_friction"},
    "tyre_relaxation_length": {"relaxation_x", "relaxation_y"},
    "brake_pad_pressure": {"pad_pressure_exponent"},
    "gyro_offset": {"gyro_offset"},
}


def test_expected_evidence_of_a_shift_within_the_scatter_is_bounded_by_its_prior() -> None:
    """A change along a nuisance column of one scatter: 4 scatters give at most 4^2 / 2 however good the data."""
    column = np.array([[30.0], [40.0]])
    assert expected_evidence(4.0 * column[:, 0], column) == pytest.approx(8.0 * 2500.0 / 2501.0)
    assert expected_evidence(np.array([40.0, -30.0]), column) == pytest.approx(1250.0)


def test_theory_finds_what_scatter_alone_limits_and_what_no_manoeuvre_excites() -> None:
    """A sensor error that nothing else looks like is limited by its scatter: sqrt(2 * 8); cold brakes cannot fade."""
    point = nominal_point(scripts=(SIX[1],))
    nuisance = scatter_columns(point)
    ring = next(one for one in EFFECTS if one.name == "tone_ring_error")
    assert detection_limit(ring, point, nuisance) == pytest.approx(4.0, abs=0.1)
    fade = next(one for one in UNEXCITED if one.name == "brake_pad_fade")
    assert detection_limit(fade, point, nuisance) > 1e3


def test_of_a_pair_each_effect_shows_beside_the_other() -> None:
    """Pads that press less the harder they are pressed keep the front wheels from locking: their valves never move."""
    case = Case(41, 0, "pair", "first")
    pads = Hidden(named("brake_pad_pressure"), -0.25, 0)
    for wheel, least, most in ((1, 0.0, 1e-9), (3, 1e3, np.inf)):
        valve = Hidden(named("inlet_valve_delay"), 0.018, wheel)
        assert least <= case.shown(Draw("pair", (pads, valve)), valve) <= most
        assert case.shown(Draw("pair", (valve,)), valve) > 1e3
    assert all(case.shown(case.draw, hidden) > EVIDENCE_NEEDED for hidden in case.draw.effects)


@cache
def _nominal(missing: tuple[str, ...], manoeuvres: tuple[str, ...]) -> tuple[Point, FloatArray]:
    """The nominal car in some manoeuvres, and what its scatter changes."""
    point = nominal_point(missing, tuple(one for one in SIX if one.name in manoeuvres))
    return point, scatter_columns(point)


@pytest.mark.parametrize("pair", CONFOUNDED, ids=lambda pair: f"{pair.effect}-{pair.twin}")
def test_what_is_meant_to_look_alike_does_so_by_theory(pair: LookAlike) -> None:
    """Beside the twin a tenth of the evidence is left at most, and data with a limit of their own show the effect.

    Pads and mass in gentle stops, where the pitch tells them apart, would keep two thirds.
    """
    # at the limit of adhesion a replay is not smooth, and equal effects look different
    point, nuisance = _nominal(pair.missing, pair.manoeuvres or _BELOW_THE_LIMIT)
    effect, twin = named(pair.effect), named(pair.twin)
    own = effect_column(effect, 0, point)
    rival = RIVAL_SIZE * twin.largest * effect_column(twin, 0, point, own)
    assert expected_evidence(own, np.column_stack([nuisance, rival])) < 0.1 * expected_evidence(own, nuisance)
    if pair.smallest:
        assert pair.smallest == pytest.approx(detection_limit(effect, point, nuisance), rel=0.1)


@pytest.mark.parametrize(
    ("name", "units", "scatters"), [("mass_change", 5.0, 1), ("brake_balance", 6.0, 1), ("inlet_valve_delay", 9.6, 0)]
)
def test_the_best_precision_is_that_of_least_squares_with_the_others_scatter(
    name: str, units: float, scatters: int
) -> None:
    """Covariance of a Bayesian fit of all numbers at once: the inverse of its information; the size comes first."""
    point = nominal_point(scripts=SIX[2:3])
    effect = named(name)
    truth = truth_of((effect, units * effect.scatter, 0), point.car, point.chain, SIX[2:3], ())
    others = scatter_columns(truth.point, effect.numbers_at(0))
    assert others.shape[1] == scatter_columns(truth.point).shape[1] - scatters
    columns = np.column_stack([truth.secant, others])
    information = columns.T @ columns + np.diag([0.0, *np.ones(others.shape[1])])
    assert size_std(truth) == pytest.approx(np.sqrt(np.linalg.inv(information)[0, 0]), rel=1e-6)
    assert size_std(truth) < 0.2  # of an ABS stop alone


@pytest.mark.nightly
def test_the_best_precision_is_told_over_the_physical_value() -> None:
    """A leak of some 1e-14 m^3/s/Pa is drawn in cm^3/s at 100 bar; a healthy brake has none."""
    case = next(one for one in _singles(7) if one.draw.effects[0].effect.name == "hydraulic_leak")
    (std,) = case.value_stds()
    hidden = case.draw.effects[0]
    truth = truth_of(
        (hidden.effect, hidden.deviation, hidden.place), case.car, case.chain, case.scripts()[0], case.draw.missing
    )
    assert std == pytest.approx(size_std(truth))
    assert 0.01 < std < 0.5


def _singles(seed: int) -> Iterator[Case]:
    return (Case(seed, index, "single", "first") for index in itertools.count())
