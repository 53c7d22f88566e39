"""Candidate terms: their dimensions, their offers and their values, against the compiled stack of the plant."""

import numpy as np
import pytest

from model_diagnosis.discovery.build import interval_of, term_of_answer, term_of_the_car
from model_diagnosis.discovery.candidates import Candidate, Shape
from model_diagnosis.discovery.dimension import coefficient_exponents, is_physical, unit_text
from model_diagnosis.discovery.offers import first_offers, further_offers, neighbours
from model_diagnosis.discovery.term import DiscoveredTerm
from model_diagnosis.discovery.variables import Variable
from model_diagnosis.replay.terms import TERM_TARGETS
from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import load_vehicle

TIMES = np.linspace(0.0, 1.0, 400)
VARIABLES = {
    "speed": Variable("speed", "m/s", (5.0 + 25.0 * TIMES,)),
    "lateral_acceleration": Variable("lateral_acceleration", "m/s^2", (6.0 * np.sin(6.0 * TIMES),)),
    "longitudinal_acceleration": Variable("longitudinal_acceleration", "m/s^2", (-8.0 * TIMES,)),
    "brake_pressure": Variable("brake_pressure", "Pa", (1e7 * np.stack([TIMES] * 4, axis=1),)),
    "brake_disc_temperature": Variable("brake_disc_temperature", "degC", (20.0 + 300.0 * np.stack([TIMES] * 4, 1),)),
}


def _term(
    candidate: Candidate, coefficients: list[float], reach: float, target: str = "brake_torque"
) -> DiscoveredTerm:
    values = np.array(coefficients)
    return DiscoveredTerm(
        target=target,
        is_factor=target == "brake_torque",
        candidate=candidate,
        coefficients=values,
        low=values - reach,
        high=values + reach,
        unit="1",
        inclusion=0.97,
        explained=0.5,
    )


def test_terms_that_need_made_up_constants_are_no_candidates() -> None:
    """N = c v² needs kg/m; a factor c v a_x needs s³/m², two units; N = c v a_x T needs four."""
    drag = Candidate((Shape("speed", exponent=2.0, symmetry="even"),))
    force, factor = "body_longitudinal_force", "brake_torque_factor"
    assert unit_text(coefficient_exponents(drag, force, VARIABLES)) == "kg/m"
    assert is_physical(drag, force, VARIABLES)
    pair = Candidate((Shape("speed"), Shape("longitudinal_acceleration")))
    assert unit_text(coefficient_exponents(pair, factor, VARIABLES)) == "s^3/m^2"
    assert is_physical(pair, factor, VARIABLES)
    trio = Candidate((*pair.shapes, Shape("brake_disc_temperature")))
    assert not is_physical(trio, force, VARIABLES)
    assert not is_physical(trio, factor, VARIABLES)


def test_no_target_is_offered_the_acceleration_that_it_causes() -> None:
    """The noise of a measured acceleration stands on both sides of its own balance and would explain itself."""
    own = {
        "body_longitudinal_force": "longitudinal_acceleration",
        "brake_torque_factor": "longitudinal_acceleration",
        "tyre_friction_factor": "longitudinal_acceleration",
        "body_lateral_force": "lateral_acceleration",
        "yaw_moment": "yaw_rate",
    }
    assert set(own) == set(TERM_TARGETS)
    for target, name in own.items():
        offers = [*first_offers(target, VARIABLES), *further_offers(target, VARIABLES)]
        assert len(offers) > 40
        assert len(set(offers)) == len(offers)
        assert not any(name in offer.variables for offer in offers)


@pytest.mark.parametrize("reach", [1.0, 0.35, 0.12])
def test_refined_numbers_stay_where_the_data_are(reach: float) -> None:
    """Thresholds within the span that was driven, at least one whole period of a periodic term."""
    low, high = VARIABLES["speed"].span
    for function in ("above", "below", "step", "excess_share"):
        for at in (low + 1.0, 15.0, high - 1.0):
            near = neighbours(Candidate((Shape("speed", function, at=at),)), VARIABLES, reach)
            assert near
            assert all(low < one.shapes[0].at < high for one in near)
    once = 2.0 * np.pi / (high - low)
    waves = neighbours(Candidate((Shape("speed", "sine", wave_number=once),)), VARIABLES, reach)
    assert waves
    assert min(one.shapes[0].wave_number for one in waves) > once


def test_an_excess_share_makes_a_factor_a_threshold_of_what_it_multiplies() -> None:
    """k p (1 - a max(1 - p0/p, 0)) = k p - a k max(p - p0, 0), by algebra."""
    pressure = np.linspace(-1e5, 1e7, 500)
    share = Shape("brake_pressure", "excess_share", at=3e6).of(pressure)
    assert pressure * share == pytest.approx(np.maximum(pressure - 3e6, 0.0))


def test_a_periodic_terms_interval_is_that_of_its_amplitude() -> None:
    """Sine 0.3 and cosine 0.4, each ± 0.05: amplitude 0.5 ± 0.05, whatever the phase."""
    term = _term(Candidate((Shape("speed", "sine", wave_number=2.0),)), [0.3, 0.4], 0.05)
    interval = interval_of(term)
    assert (interval.value, interval.low, interval.high) == pytest.approx((0.5, 0.45, 0.55))
    assert term.formula == "brake_torque += ±0.5 · brake_torque · sin(2 speed)"
    answer = term_of_answer(term)
    assert (answer.formula, answer.target, answer.inclusion) == (term.formula, "brake_torque", 0.97)
    factor = term_of_the_car("brake_torque_factor", term).terms[0].factors[0]
    assert factor.phase == pytest.approx(np.arctan2(0.4, 0.3))  # type: ignore[union-attr]


STEER = np.concatenate([np.linspace(0.0, 1.0, 300), np.linspace(1.0, -0.8, 500), np.linspace(-0.8, 0.3, 200)])


@pytest.mark.parametrize(
    "shape",
    [
        Shape("steering_wheel_angle", exponent=1.5),
        Shape("steering_wheel_angle", exponent=2.0, symmetry="even"),
        Shape("steering_wheel_angle", "above", "even", at=0.4),
        Shape("steering_wheel_angle", "above", "odd", at=0.4, exponent=2.0),
        Shape("steering_wheel_angle", "below", at=0.2),
        Shape("steering_wheel_angle", "step", at=0.1),
        Shape("steering_wheel_angle", "excess_share", at=0.2),
        Shape("steering_wheel_angle", "excess_share", "odd", at=0.2),
        Shape("steering_wheel_angle", "limited", at=0.1, width=0.3),
        Shape("steering_wheel_angle", "direction", width=0.2),
    ],
)
def test_a_term_on_data_is_the_plants_term(shape: Shape) -> None:
    """The candidate's values are those of the compiled stack for the same course of the variable."""
    vehicle = load_vehicle("ekf_car")
    vehicle.terms.stack.extend(
        term_of_the_car("yaw_moment", _term(Candidate((shape,)), [7.0], 1.0, "yaw moment")).terms
    )
    car = Plant(vehicle)
    car.reset(speed_m_s=20.0)
    added = []
    for tick, angle in enumerate(STEER):
        car.tick(np.zeros(4), np.zeros(4), float(angle), tick * 1e-3)
        added.append(car._state["added"][0, 9, 0])
    assert np.array(added) == pytest.approx(7.0 * shape.of(STEER), abs=1e-12)
