"""The other tyre formulas inside the compiled plant: against their printed forms, their limits and their symmetry."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from vehicle_model.tyres.coefficients import SURFACE_FACTOR, SURFACE_SIZE, TYRE_SIZE, write_tyre
from vehicle_model.tyres.formula_tyre import tyre_of
from vehicle_model.tyres.kernel import (
    PEAK_FORCE_X,
    PEAK_SLIP_X,
    PREPARED_SIZE,
    STIFFNESS_X,
    STIFFNESS_Y,
    across,
    along,
    prepare,
)
from vehicle_model.tyres.tmeasy_file import TMeasyPoint
from vehicle_model.tyres.tyre_file import AnyTyre, FialaTyre, LuGreTyre, TMeasyTyre
from vehicle_model.vehicle_file import TYRES, load_tyres

LOAD, SPEED = 4000.0, 20.0
FORMULAS = ("pacejka_1987", "burckhardt_dry_asphalt", "tmeasy", "dugoff", "fiala", "lugre", "dahl")


class Rolling:
    """A tyre under a load at a speed, evaluated as in the plant."""

    def __init__(self, tyre: AnyTyre | str, load: float = LOAD, speed: float = SPEED, friction: float = 1.0) -> None:
        self.tyre = load_tyres(tyre).front if isinstance(tyre, str) else tyre
        self.row: NDArray[np.float64] = np.zeros(TYRE_SIZE)
        self.prepared: NDArray[np.float64] = np.zeros(PREPARED_SIZE)
        surface = np.zeros(SURFACE_SIZE)
        surface[SURFACE_FACTOR] = 1.0
        write_tyre(self.tyre, self.row, right=False)
        prepare(self.row, surface, friction, load, speed, 0.0, self.prepared)

    def at(self, slip_x: float, slip_y: float = 0.0) -> tuple[float, float, float, float]:
        """Longitudinal force, side force, slope, aligning moment."""
        force_x, slope = along(self.row, self.prepared, slip_x, slip_y)
        force_y, moment = across(self.row, self.prepared, slip_x, slip_y, force_x)
        return force_x, force_y, slope, moment


def braked(slip_3: float) -> float:
    """Slip S5 of a braked wheel from slip S3, both positive here."""
    return slip_3 / (1.0 + slip_3)


def tmeasy() -> TMeasyTyre:
    tyre = load_tyres("tmeasy").front
    assert isinstance(tyre, TMeasyTyre)
    return tyre


@pytest.mark.acceptance("F-1")
@pytest.mark.parametrize("direction", ["x", "y"])
@pytest.mark.parametrize("load", ["nominal", "double"])
def test_tmeasy_is_continuous_and_begins_with_its_slope(direction: str, load: str, record: Callable[..., None]) -> None:
    side = tmeasy().longitudinal if direction == "x" else tmeasy().lateral
    point: TMeasyPoint = getattr(side, load)
    rolling = Rolling("tmeasy", LOAD * (1.0 if load == "nominal" else 2.0))

    def force(slip_3: float) -> float:
        return -rolling.at(-braked(slip_3))[0] if direction == "x" else rolling.at(0.0, slip_3)[1]

    def slope(slip_3: float, side: float) -> float:
        step = side * 1e-7
        return (force(slip_3 + step) - force(slip_3)) / step

    assert force(point.peak_slip) == pytest.approx(point.peak_force, rel=1e-12)
    assert force(point.sliding_slip) == pytest.approx(point.sliding_force, rel=1e-12)
    for place in (point.peak_slip, point.sliding_slip):
        gap = force(place * (1.0 + 1e-12)) - force(place * (1.0 - 1e-12))
        record(f"TMeasy, jump of the force at {'s^M' if place == point.peak_slip else 's^G'}, N", abs(gap), "0")
        assert abs(gap) < 1e-6
        assert slope(place, 1.0) == pytest.approx(0.0, abs=2e-4 * point.slope)
        assert slope(place, -1.0) == pytest.approx(0.0, abs=2e-4 * point.slope)
    first = force(1e-9) / 1e-9
    record("TMeasy, F'(0) over dF0", first / point.slope, "1")
    assert first == pytest.approx(point.slope, rel=1e-6)
    assert force(3.0 * point.sliding_slip) == pytest.approx(point.sliding_force, rel=1e-12)


def test_tmeasy_between_the_directions_is_eqs_14_to_21() -> None:
    """By hand at nominal load: s_x = -0.06, s_y = 0.08 (S3), both forces from one resultant curve."""
    rolling = Rolling("tmeasy")
    along_3, across_3 = -0.06, 0.08
    share = 1.0 / (1.0 - along_3)  # R w / v of a braked wheel: S5 = S3 times it
    x, y, _, _ = rolling.at(along_3 * share, across_3 * share)
    hat_x, hat_y = 4400.0 / 120e3, 4200.0 / 55e3
    s = math.hypot(along_3 / hat_x, across_3 / hat_y)
    cosine, sine = along_3 / hat_x / s, across_3 / hat_y / s
    slope = math.hypot(120e3 * hat_x * cosine, 55e3 * hat_y * sine)
    at = math.hypot(0.11 / hat_x * cosine, 0.2 / hat_y * sine)
    peak = math.hypot(4400.0 * cosine, 4200.0 * sine)
    sliding_slip = math.hypot(0.5 / hat_x * cosine, 0.8 / hat_y * sine)
    sliding = math.hypot(4250.0 * cosine, 4150.0 * sine)
    sigma = s / at
    if s <= at:
        force = at * slope * sigma / (1.0 + sigma * (sigma + slope * at / peak - 2.0))
    else:
        q = (s - at) / (sliding_slip - at)
        force = peak - (peak - sliding) * q * q * (3.0 - 2.0 * q)
    assert (x, y) == pytest.approx((force * cosine, force * sine), rel=1e-9)


def test_tmeasy_trail_is_eq_22() -> None:
    rolling = Rolling("tmeasy")
    for slip, trail in (
        (0.1, 0.12 * 0.178 * 0.5),
        (0.2, 0.0),
        (0.3, -0.12 * 0.178 * (0.1 / 0.2) * (0.05 / 0.15) ** 2),
        (0.5, 0.0),
    ):
        _, force_y, _, moment = rolling.at(0.0, slip)
        assert moment == pytest.approx(-trail * force_y, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("slip", [-0.9, -0.4, -0.1, -0.02, 0.02, 0.1, 1.0, 5.0])
def test_dugoff_is_the_form_of_section_2_2_4(slip: float) -> None:
    """Pure longitudinal slip without the reduction; the slip of the formula refers to the travelling speed (S4)."""
    tyre = load_tyres("dugoff").front.model_copy(update={"friction_reduction": 0.0})
    stiffness, friction = 22.3 * LOAD, 1.2
    share = friction * LOAD * (1.0 + slip) / (2.0 * abs(stiffness * slip))
    expected = stiffness * slip / (1.0 + slip) * (share * (2.0 - share) if share < 1.0 else 1.0)
    slip_5 = slip if slip < 0.0 else slip / (1.0 + slip)
    assert Rolling(tyre).at(slip_5)[0] == pytest.approx(expected, rel=1e-12)


def test_dugoff_locks_at_its_friction() -> None:
    locked = -Rolling("dugoff").at(-1.0)[0] / LOAD
    assert locked == pytest.approx(1.2 * (1.0 - 0.012 * SPEED), rel=1e-2)


def test_load_dependent_coefficients_are_eq_6() -> None:
    """In the units of the paper: kN, per cent, degrees; at 5 kN D = -21.3 25 + 1144 5 = 5187.5 N."""
    rolling = Rolling("pacejka_1987", 5000.0)
    peak = -21.3 * 25.0 + 1144.0 * 5.0
    slope = (49.6 * 25.0 + 226.0 * 5.0) / math.exp(0.069 * 5.0)
    curvature = -0.006 * 25.0 + 0.056 * 5.0 + 0.486
    for percent in (1.0, 8.0, 30.0, 100.0):
        x = slope / (1.65 * peak) * percent
        expected = peak * math.sin(1.65 * math.atan(x - curvature * (x - math.atan(x))))
        assert -rolling.at(-percent / 100.0)[0] == pytest.approx(expected, rel=1e-9)
    assert rolling.prepared[PEAK_FORCE_X] == pytest.approx(5187.5, rel=1e-9)
    degrees = 4.0
    fitted = 1078.0 * math.sin(1.82 * math.atan(0.208 * 5.0))
    assert rolling.prepared[STIFFNESS_Y] / math.degrees(1.0) == pytest.approx(fitted, rel=0.05)
    assert rolling.at(0.0, math.radians(degrees))[1] > 0.9 * 0.5 * fitted * degrees


def test_fiala_has_the_textbook_brush_in_cornering() -> None:
    """With constant friction: full sliding at tan(alpha) = 3 U Fz / C, largest moment at a quarter of it, 27/256."""
    tyre = FialaTyre(
        formula="fiala",
        static_friction=1.0,
        sliding_friction=1.0,
        slip_stiffness=20.0,
        cornering_stiffness=15.0,
        width=0.2,
    )
    rolling = Rolling(tyre)
    full = 3.0 / 15.0
    assert rolling.at(0.0, full)[1] == pytest.approx(LOAD)
    assert rolling.at(0.0, 0.5 * full)[1] == pytest.approx(LOAD * (1.0 - 0.5**3))
    assert rolling.at(0.0, full)[3] == 0.0
    moments = [-rolling.at(0.0, share * full)[3] for share in np.linspace(0.0, 1.0, 101)]
    assert int(np.argmax(moments)) == 25
    assert max(moments) == pytest.approx(LOAD * 0.2 * 27.0 / 256.0)
    # along: s* = U Fz / (2 C), the parabola beyond it
    assert rolling.at(-0.025)[0] == pytest.approx(-0.5 * LOAD)
    assert rolling.at(-0.05)[0] == pytest.approx(-0.75 * LOAD)


def test_fiala_keeps_to_the_kamm_ellipse() -> None:
    rolling = Rolling("fiala")
    for slip_x in np.linspace(-1.0, 1.0, 21):
        for slip_y in np.linspace(-0.7, 0.7, 15):
            x, y, _, _ = rolling.at(float(slip_x), float(slip_y))
            friction = 1.25 - 0.4 * min(math.hypot(slip_x, slip_y), 1.0)
            assert math.hypot(x, y) <= friction * LOAD * (1.0 + 1e-9)
    assert rolling.at(-0.1, 0.1)[0] > rolling.at(-0.1, 0.0)[0]  # less friction at more slip


def lugre_settled(tyre: LuGreTyre, v_x: float, v_y: float, rim: float) -> tuple[float, float]:
    """Forces over load at the end of the transient of the two bristles, integrated from rest."""

    def friction(speed: float) -> float:
        fall = math.exp(-math.sqrt(speed / tyre.stribeck_speed))
        return tyre.coulomb_friction + (tyre.static_friction - tyre.coulomb_friction) * fall

    speed = math.hypot(v_x, v_y)
    stiffness = np.array([tyre.stiffness_longitudinal, tyre.stiffness_lateral])

    def rate(_: float, z: NDArray[np.float64]) -> NDArray[np.float64]:
        sliding = np.array([v_x, v_y])
        renewal = 7.0 / (6.0 * tyre.contact_length)
        return np.asarray(sliding - (stiffness * speed / friction(speed) + renewal * abs(rim)) * z)

    z = solve_ivp(rate, (0.0, 5.0), np.zeros(2), rtol=1e-10, atol=1e-14, method="LSODA").y[:, -1]
    forces = stiffness * z + tyre.viscous_friction * np.array([v_x, v_y])
    return float(forces[0]), float(forces[1])


@pytest.mark.parametrize(("slip", "side"), [(-0.02, 0.0), (-0.15, 0.05), (-1.0, 0.0), (-1.0, 0.3), (0.2, -0.1)])
def test_lugre_is_where_its_bristles_settle(slip: float, side: float) -> None:
    tyre = load_tyres("lugre").front
    assert isinstance(tyre, LuGreTyre)
    rim = SPEED * (1.0 + slip) if slip < 0.0 else SPEED / (1.0 - slip)
    faster = max(rim, SPEED)
    expected = lugre_settled(tyre, slip * faster, side * faster, rim)
    x, y, _, _ = Rolling(tyre).at(slip, side)
    assert (x / LOAD, y / LOAD) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_dahl_is_lugre_with_constant_friction() -> None:
    dahl = load_tyres("dahl").front
    same = LuGreTyre(
        formula="lugre",
        static_friction=1.0,
        coulomb_friction=1.0,
        stribeck_speed=5.0,
        stiffness_longitudinal=181.54,
        stiffness_lateral=120.0,
    )
    for slip in (-1.0, -0.3, -0.01, 0.1):
        assert Rolling(dahl).at(slip, 0.1)[:2] == pytest.approx(Rolling(same).at(slip, 0.1)[:2], rel=1e-12)
    forces = [-Rolling(dahl).at(-slip)[0] for slip in np.linspace(0.0, 1.0, 101)]
    assert np.all(np.diff(forces) > 0.0)
    assert forces[-1] == pytest.approx(LOAD)  # the document's mu of a locked wheel: Coulomb


@pytest.mark.parametrize("name", FORMULAS)
def test_slope_is_the_derivative(name: str) -> None:
    rolling = Rolling(name)
    for slip in (-0.9, -0.3, -0.06, -0.01):
        step = 1e-6
        ahead, behind = rolling.at(slip + step)[0], rolling.at(slip - step)[0]
        assert rolling.at(slip)[2] == pytest.approx((ahead - behind) / (2.0 * step), rel=1e-3, abs=5.0)
    assert rolling.prepared[STIFFNESS_X] == pytest.approx(rolling.at(-1e-8)[0] / -1e-8, rel=2e-3)
    assert rolling.prepared[STIFFNESS_Y] == pytest.approx(rolling.at(0.0, 1e-8)[1] / 1e-8, rel=2e-3)


@pytest.mark.parametrize("name", FORMULAS)
@pytest.mark.parametrize("friction", [1.0, 0.3])
def test_peak_that_the_plant_reports_is_the_peak(name: str, friction: float) -> None:
    rolling = Rolling(name, friction=friction)
    slips = np.linspace(0.0, 1.0, 5001)
    curve = np.array([-rolling.at(-slip)[0] for slip in slips])
    assert rolling.prepared[PEAK_FORCE_X] == pytest.approx(curve.max(), rel=2e-4)
    assert rolling.prepared[PEAK_SLIP_X] == pytest.approx(slips[curve.argmax()], abs=0.02)


@pytest.mark.parametrize("name", sorted(path.stem for path in TYRES.glob("*.yaml")))
def test_force_falls_after_its_peak_where_the_formula_says_so(name: str) -> None:
    rolling = Rolling(name)
    slips = np.linspace(0.0, 1.0, 1001)
    curve = np.array([-rolling.at(-slip)[0] for slip in slips])
    if name == "dahl":
        assert curve.argmax() == 1000
        return
    assert curve[-1] < 0.97 * curve.max()
    assert np.all(np.diff(curve[: curve.argmax()]) > 0.0)
    assert np.all(np.diff(curve[curve.argmax() :]) <= 1e-9)


@pytest.mark.parametrize("name", FORMULAS)
def test_no_friction_is_no_force(name: str) -> None:
    rolling = Rolling(name, friction=0.0)
    for slip_x, slip_y in ((0.0, 0.0), (-1.0, 0.0), (-0.1, 0.05), (0.5, -0.3)):
        assert np.abs(rolling.at(slip_x, slip_y)[:2]).max() <= 1e-5 * LOAD


def test_tmeasy_never_slides_with_more_than_its_peak() -> None:
    """At half the nominal load the parabolas of the example's two forces have crossed."""
    rolling = Rolling("tmeasy", 0.5 * LOAD)
    assert -rolling.at(-1.0)[0] <= rolling.prepared[PEAK_FORCE_X]


@pytest.mark.parametrize("name", FORMULAS)
def test_backwards_is_forwards_turned_round(name: str) -> None:
    forwards, backwards = Rolling(name, speed=SPEED), Rolling(name, speed=-SPEED)
    for slip_x in (-1.0, -0.2, 0.0, 0.05, 0.6):
        for slip_y in (0.0, 0.08, -0.3):
            x, y, slope, moment = forwards.at(slip_x, slip_y)
            turned = backwards.at(-slip_x, -slip_y)
            assert turned == pytest.approx((-x, -y, slope, moment), rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("name", FORMULAS)
def test_forces_never_help_the_sliding(name: str) -> None:
    rolling = Rolling(name)
    for slip_x in np.linspace(-1.0, 0.5, 23):
        for slip_y in np.linspace(-1.0, 1.0, 21):
            x, y, _, _ = rolling.at(float(slip_x), float(slip_y))
            assert x * slip_x >= 0.0
            assert y * slip_y >= 0.0
            assert math.hypot(x, y) < 1.6 * LOAD


@pytest.mark.parametrize("name", FORMULAS)
def test_one_interface_for_arrays(name: str) -> None:
    """Slip ratio S4 and slip angle outside, slip S5 inside; signs of ISO; a lifted tyre has no force."""
    tyre = tyre_of(load_tyres(name).front, name)
    forces = tyre.forces(np.array([-0.1, 0.25])[:, None], np.array([0.0, 0.05]), 0.0, [[LOAD], [LOAD]], speed=SPEED)
    assert forces.fx.shape == (2, 2)
    rolling = Rolling(name)
    tangent = math.tan(0.05)
    assert forces.fx[0, 1] == pytest.approx(rolling.at(-0.1, -tangent)[0])
    assert forces.fy[1, 1] == pytest.approx(rolling.at(0.2, -tangent / 1.25)[1])
    assert forces.fx[1, 0] > 0.0 > forces.fy[0, 1]
    assert tyre.forces(0.0, 0.02, 0.0, LOAD).mz > 0.0
    assert list(tyre.forces(-0.1, 0.1, 0.0, 0.0)) == [0.0] * 5
    assert tyre.forces(-0.1, 0.1, 0.3, LOAD, inflation_pressure=1e5) == tyre.forces(-0.1, 0.1, 0.0, LOAD)


def test_relaxation_lengths_default_to_stiffness_over_stiffness() -> None:
    tyre = load_tyres("dugoff").front
    assert tyre.relaxation_length_longitudinal == pytest.approx(22.3 * 3500.0 / 3e5)
    assert tyre.relaxation_length_lateral == pytest.approx(17.5 * 3500.0 / 2e5)
    lugre = load_tyres("lugre").front
    assert lugre.relaxation_length_longitudinal == pytest.approx(6.0 * 0.2 / 7.0)  # 1/kappa
