"""Longitudinal fits of the vehicle-state document (3.4, AC-35) on its planar car, over seeds of the sensors' noise."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from state_runs import ALL_NOISE, LAUNCH_NOISE, SEEDS, TUNING_SEEDS, Replay, drive, fits_of, forget_drives


@pytest.fixture(scope="module", autouse=True)
def _runs_are_dropped() -> Iterator[None]:
    yield
    forget_drives()


STIFFNESS = {"ice": 58.0, "icy_snow": 38.0}
"""B of the document for its two launches (2.4 [E])."""


def longitudinal_fits(surface: str, settings: dict[str, Any], noise: dict[str, float]) -> list[dict[str, Any]]:
    """Longitudinal fits of all seeds, beside the truth."""
    run = drive(f"state/launch_{surface}")
    replays = (Replay(run, "magic_formula_fit", settings, seed=seed, noise=noise) for seed in SEEDS)
    return [event for found in replays for event in fits_of(run, found) if event["direction"] == "longitudinal"]


def within(fits: list[dict[str, Any]]) -> float:
    """Part of the fits at 71 to 80 % of the true peak."""
    return float(np.mean([0.71 <= event["true_share"] <= 0.80 for event in fits]))


@pytest.mark.acceptance("V-35", "V-33", "V-55")
@pytest.mark.parametrize("surface", STIFFNESS)
def test_longitudinal_fits_at_the_threshold_of_the_surface(surface: str, record: Callable[..., None]) -> None:
    """Thresholds set by hand for each surface, as in the document, at 0.63/B (3.4): every fit, with all our noise."""
    settings = {"fit.threshold": "fixed", "fit.threshold_longitudinal": 0.63 / STIFFNESS[surface]}
    fits = longitudinal_fits(surface, settings, ALL_NOISE)
    shares, quality = ([event[key] for event in fits] for key in ("true_share", "r_squared"))
    record(f"{surface}: threshold by hand, share of the true peak, smallest", min(shares), ">= 0.71", id="V-35")
    record(f"{surface}: threshold by hand, share of the true peak, largest", max(shares), "<= 0.80", id="V-35")
    record(f"{surface}: threshold by hand, R^2, smallest", min(quality), ">= 0.90", id="V-35")
    record(f"{surface}: threshold by hand, part of the fits within", within(fits), "1", id="V-35")
    assert len(fits) == 2 * len(SEEDS)  # both driven wheels, once each
    assert min(quality) >= 0.90
    assert within(fits) == 1.0


@pytest.mark.acceptance("V-35", "V-55")
@pytest.mark.parametrize("surface", STIFFNESS)
def test_longitudinal_fits(surface: str, record: Callable[..., None]) -> None:
    """Automatic threshold: single fits with the noise of the document's own launch (C.1), medians also with ours.

    The rule asks the fit's own B, and noise moves B more than it moves the crossing of a slip: five times the noise
    power and a gyroscope's spread B by a tenth (C.3 has D as uncertain at these shares), which is what leaves 71-80 %.
    """
    for name, noise in (("", ALL_NOISE), ("noise of C.1, ", LAUNCH_NOISE)):
        fits = longitudinal_fits(surface, {}, noise)
        shares, quality = (np.array([event[key] for event in fits]) for key in ("true_share", "r_squared"))
        errors = np.abs([event["error"] for event in fits])
        judged = noise is LAUNCH_NOISE
        record(f"{surface}: {name}share of the true peak, median", float(np.median(shares)), "0.71 ... 0.80")
        record(f"{surface}: {name}R^2, smallest", float(quality.min()), ">= 0.90")
        record(f"{surface}: {name}median error of D %", 100.0 * float(np.median(errors)), "reported")
        limit = ">= 0.95" if judged else "reported: five times the noise power of C.1"
        record(f"{surface}: {name}part of the fits within it", within(fits), limit)
        spread = 100.0 * float(np.std([event["stiffness"] for event in fits])) / STIFFNESS[surface]
        record(f"{surface}: {name}spread of B %", spread, "reported")
        assert len(fits) == 2 * len(SEEDS)  # both driven wheels, once each
        assert quality.min() >= 0.90
        assert np.median(errors) < 0.10
        assert 0.71 <= np.median(shares) <= 0.80
        assert not judged or within(fits) >= 0.95


@pytest.mark.acceptance("V-35")
@pytest.mark.parametrize("change", [{"longitudinal.towing_slip": False}, {"longitudinal.pair_slip": "model"}], ids=str)
def test_what_hides_the_bend_of_the_curve(change: dict[str, Any], record: Callable[..., None]) -> None:
    """Slip of the towed wheels left out, or slip that lags behind the friction: the limit is then found too high.

    Both move the pairs to larger slips where the friction in use is small, which straightens the curve.
    """
    run = drive("state/launch_ice")
    errors: dict[bool, list[float]] = {True: [], False: []}
    for seed in TUNING_SEEDS[:5]:
        for changed, settings in ((False, {}), (True, change)):
            found = Replay(run, "magic_formula_fit", settings, seed=seed, noise=ALL_NOISE)
            errors[changed] += [
                e["limit"] / run[f"friction_limit_{e['wheel']}"][1000] - 1.0
                for e in found.estimator.events()
                if e["direction"] == "longitudinal"
            ]
    record(f"{next(iter(change))} changed: mean error of D %", 100.0 * float(np.mean(errors[True])), "reported")
    assert np.mean(np.abs(errors[True])) > np.mean(np.abs(errors[False]))
