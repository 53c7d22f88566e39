"""Tyre forces inside the compiled plant: the tables of the friction document, combined slip, options."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from vehicle_model.road import RoadTables
from vehicle_model.road_file import RoadFile, load_surfaces
from vehicle_model.tyres.coefficients import TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PEAK_FORCE_X, PEAK_SLIP_X, PREPARED_SIZE, STIFFNESS_X, across, along, prepare
from vehicle_model.tyres.tyre_file import CurveTyre
from vehicle_model.vehicle_file import load_tyres

LOAD = 3000.0


def prepared(
    tyre: CurveTyre | None = None,
    surface: str = "own_curve",
    friction: float = 1.0,
    load: float = LOAD,
    speed: float = 20.0,
) -> NDArray[np.float64]:
    row, result = np.zeros(TYRE_SIZE), np.zeros(PREPARED_SIZE)
    write_tyre(tyre or load_tyres("reduced_set_t").front, row, right=False)
    prepare(row, RoadTables(RoadFile(surface=surface)).surfaces[0], friction, load, speed, 0.0, result)
    return result


def evaluate(row: NDArray[np.float64], slip_x: float, slip_y: float) -> tuple[float, float, float, float]:
    """Longitudinal force, side force, slope, aligning moment of a curve tyre, whose own row is not needed."""
    none = np.zeros(TYRE_SIZE)
    force_x, slope = along(none, row, slip_x, slip_y)
    force_y, moment_z = across(none, row, slip_x, slip_y, force_x)
    return force_x, force_y, slope, moment_z


def tyre_with(**changes: object) -> CurveTyre:
    return load_tyres("reduced_set_t").front.model_copy(update=changes)


@pytest.mark.acceptance("F-1")
@pytest.mark.parametrize(
    ("surface", "peak", "at", "locked"),
    [
        ("dry_asphalt", 1.000, 0.180, 0.914),
        ("wet_asphalt", 0.820, 0.088, 0.637),
        ("snow", 0.300, 0.312, 0.286),
        ("ice", 0.100, 0.389, 0.096),
        ("burckhardt_dry_asphalt", 1.170, 0.170, 0.760),
        ("burckhardt_wet_asphalt", 0.801, 0.131, 0.510),
        ("burckhardt_dry_concrete", 1.090, 0.160, 0.662),
        ("burckhardt_snow", 0.190, 0.060, 0.130),
        ("burckhardt_ice", 0.050, None, 0.050),
    ],
)
def test_peaks_of_tables_2_and_3(surface: str, peak: float, at: float | None, locked: float) -> None:
    row = prepared(surface=surface)
    slips = np.linspace(0.0, 1.0, 20001)
    curve = np.array([evaluate(row, -slip, 0.0)[0] for slip in slips]) / -LOAD
    assert curve.max() == pytest.approx(peak, abs=1e-3)
    assert row[PEAK_FORCE_X] / LOAD == pytest.approx(curve.max(), rel=1e-6)
    if at is not None:
        assert slips[curve.argmax()] == pytest.approx(at, abs=1e-3)
        assert row[PEAK_SLIP_X] == pytest.approx(slips[curve.argmax()], abs=2e-4)
    assert curve[-1] == pytest.approx(locked, abs=1e-3)


@pytest.mark.parametrize(("name", "at", "locked"), [("reduced_set_t", 0.176, 0.919), ("reduced_set_a", 0.123, 0.942)])
def test_sets_of_the_reduced_curve(name: str, at: float, locked: float) -> None:
    """Section 2.2.5 prints 0.911 for the locked wheel of set T; its own k1 and k2 give sin(k1 arctan k2) = 0.919."""
    tyre = load_tyres(name).front
    row = prepared(tyre)
    assert row[PEAK_SLIP_X] == pytest.approx(at, abs=1e-3)
    assert row[PEAK_FORCE_X] == pytest.approx(1.12 * LOAD)
    assert -evaluate(row, -1.0, 0.0)[0] / (1.12 * LOAD) == pytest.approx(locked, abs=1e-3)
    assert row[STIFFNESS_X] == pytest.approx(evaluate(row, 1e-7, 0.0)[0] / 1e-7, rel=1e-6)


def test_polished_ice_rewards_slip_control() -> None:
    row = prepared(surface="polished_ice")
    assert row[PEAK_SLIP_X] < 0.12
    assert evaluate(row, -1.0, 0.0)[0] / -row[PEAK_FORCE_X] <= 0.85
    assert "960652" in load_surfaces()["polished_ice"].source


def test_a_road_factor_scales_peak_and_slope() -> None:
    whole, half = prepared(), prepared(friction=0.5)
    for slip in (-1.0, -0.1, -0.01, 0.05):
        assert evaluate(half, slip, 0.02)[:2] == pytest.approx([0.5 * f for f in evaluate(whole, slip, 0.02)[:2]])


@pytest.mark.parametrize("surface", ["own_curve", "wet_asphalt", "burckhardt_snow"])
@pytest.mark.parametrize("combined", ["similarity", "kamm"])
def test_slope_is_the_derivative(surface: str, combined: str) -> None:
    row = prepared(tyre_with(combined_slip=combined), surface)
    for slip_x in (-0.9, -0.2, -0.05, 0.01, 0.3):
        for slip_y in (0.0, 0.03, -0.2):
            step = 1e-6
            ahead, behind = (evaluate(row, slip_x + sign * step, slip_y)[0] for sign in (1.0, -1.0))
            slope = evaluate(row, slip_x, slip_y)[2]
            assert slope == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-4, abs=1.0)


def test_combined_slip_shares_one_friction() -> None:
    row = prepared()
    for angle in np.linspace(0.0, 2.0 * math.pi, 37):
        for slip in (0.02, 0.1, 0.5, 1.0):
            x, y, _, _ = evaluate(row, slip * math.cos(angle), slip * math.sin(angle))
            assert (x / (1.12 * LOAD)) ** 2 + (y / (1.0 * LOAD)) ** 2 <= 1.0 + 1e-9
            # the force points along the slip vector, never against it
            assert x * math.cos(angle) >= -1e-9
            assert y * math.sin(angle) >= -1e-9
    pure_x, pure_y = evaluate(row, -0.1, 0.0)[0], evaluate(row, 0.0, 0.1)[1]
    x, y, _, _ = evaluate(row, -0.1, 0.1)
    assert abs(x) < abs(pure_x)
    assert abs(y) < abs(pure_y)


def test_a_locked_wheel_slides_against_its_motion() -> None:
    """On a curve for the resultant slip the force of a locked wheel is exactly opposite to its velocity."""
    row = prepared(surface="burckhardt_dry_asphalt")
    for drift in (0.1, 0.5, 1.0):
        x, y, _, _ = evaluate(row, -1.0, -drift)
        assert y / x == pytest.approx(drift)


def test_kamm_keeps_the_longitudinal_force() -> None:
    row = prepared(tyre_with(combined_slip="kamm"))
    x, y, _, _ = evaluate(row, -0.1, 0.05)
    assert x == evaluate(row, -0.1, 0.0)[0]
    used = x / (1.12 * LOAD)
    assert y == pytest.approx(evaluate(row, 0.0, 0.05)[1] * math.sqrt(1.0 - used**2))


def test_load_sensitivity_lowers_friction_with_load() -> None:
    tyre = tyre_with(load_sensitivity=0.2, nominal_load=3000.0)
    assert prepared(tyre, load=3000.0)[PEAK_FORCE_X] == pytest.approx(1.12 * 3000.0)
    assert prepared(tyre, load=6000.0)[PEAK_FORCE_X] == pytest.approx(0.8 * 1.12 * 6000.0)


def test_full_burckhardt_falls_with_speed_and_load() -> None:
    row = np.zeros(PREPARED_SIZE)
    tyre = np.zeros(TYRE_SIZE)
    write_tyre(load_tyres("reduced_set_t").front, tyre, right=False)
    from vehicle_model.road_file import Surface
    from vehicle_model.tyres.tyre_file import BurckhardtCurve

    curve = BurckhardtCurve(c1=1.2801, c2=23.99, c3=0.52, c4=0.003, c5=1.5e-10)
    road = RoadTables(RoadFile(surface="fast", surfaces={"fast": Surface(curve=curve)}))
    prepare(tyre, road.surfaces[0], 1.0, 4000.0, 30.0, 0.0, row)
    force = -evaluate(row, -0.5, 0.0)[0] / 4000.0
    base = 1.2801 * (1.0 - math.exp(-23.99 * 0.5)) - 0.52 * 0.5
    assert force == pytest.approx(base * math.exp(-0.003 * 0.5 * 30.0) * (1.0 - 1.5e-10 * 4000.0**2))  # eq. 10


def test_aligning_moment_turns_the_wheel_back() -> None:
    row = prepared()
    force_y, moment = evaluate(row, 0.0, 0.01)[1], evaluate(row, 0.0, 0.01)[3]
    assert moment == pytest.approx(-0.03 * force_y, rel=0.1)
    assert evaluate(row, 0.0, 0.5)[3] == 0.0
