"""The whole search on a car whose truth is known: what is hidden is named, what is not is not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from linear_car import LinearCar, effect
from numpy.typing import NDArray
from scipy.stats import binom

from model_diagnosis.effects import catalogue
from model_diagnosis.evidence import lookalikes
from model_diagnosis.evidence.answer import causes
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.fitting import Fit
from model_diagnosis.evidence.hypotheses import hypotheses_of
from model_diagnosis.evidence.lookalikes import InPlace, look_alikes
from model_diagnosis.evidence.naming import named
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selection, Selector
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.evidence.threshold import OUTSIDE, bootstrap_maxima, threshold
from model_diagnosis.evidence.wrong_vehicle import are_of_the_car, compare

EFFECTS = [
    *(effect(f"e{number}") for number in range(10)),
    effect("wheels", 4),
    effect("failed", nuisance=0.0, discrete=True),
]
COLUMNS = 15
NUISANCE = 0.03


def _search(car: LinearCar) -> tuple[Search, Selection]:
    base = fit_base(car, Priors.of(car.parameters))
    hypotheses = hypotheses_of(car)
    maxima = bootstrap_maxima(
        base.at_nothing.information,
        ratios(base.problem, ()),
        [one.columns for one in hypotheses],
        np.random.default_rng(0),
    )
    search = Search(base.problem, hypotheses)
    selection = Selector(search, threshold(maxima, COLUMNS, 6)).run(base.nothing, base.at_nothing, base.at_saturated)
    return search, selection


def _truth(seed: int, **hidden: float) -> NDArray[np.float64]:
    truth = np.random.default_rng(seed).normal(0.0, NUISANCE, COLUMNS)
    truth[14] = 0.0
    for name, value in hidden.items():
        truth[int(name.removeprefix("c"))] = value
    return truth


def _factor(_column: int, deviation: float) -> tuple[float, str, float]:
    return 1.0 + deviation, "1", 1.0


def _names(car: LinearCar, selection: Selection) -> set[str]:
    return {car.effects[one.hypothesis.effect].name for one in selection.accepted}


@pytest.mark.parametrize("seed", range(8))
def test_a_healthy_car_has_no_effect(seed: int) -> None:
    car = LinearCar(EFFECTS, _truth(seed), seed, bend=0.4, colour=0.5)
    assert _names(car, _search(car)[1]) == set()


@pytest.mark.parametrize(("seed", "column", "size"), [(1, 2, 0.3), (2, 7, -0.22), (3, 0, 0.2), (4, 9, -0.35)])
def test_one_hidden_effect_is_named_with_its_size(seed: int, column: int, size: float) -> None:
    truth = _truth(seed, **{f"c{column}": size})
    car = LinearCar(EFFECTS, truth, seed, bend=0.4, colour=0.5)
    _, selection = _search(car)
    assert _names(car, selection) == {f"e{column}"}
    assert selection.fit.theta[column] == pytest.approx(size, abs=0.01)


def test_one_wheel_of_four_is_named_as_that_wheel() -> None:
    car = LinearCar(EFFECTS, _truth(5, c12=0.3), 5, colour=0.5)
    _, selection = _search(car)
    assert [one.hypothesis.columns for one in selection.accepted] == [(12,)]


def test_what_an_effects_law_gets_wrong_is_not_given_to_its_other_deviations() -> None:
    """Responses of 0.9 of one wheel and of a tenth of it, as a law is right to, of another: less than 1 % of the
    evidence goes with the latter, beyond its scatter of 0.03 though it is."""
    car = LinearCar(EFFECTS, _truth(6, c12=0.9, c11=0.1), 6, colour=0.5)
    _, selection = _search(car)
    assert [one.hypothesis.columns for one in selection.accepted] == [(12,)]
    assert selection.fit.theta[12] == pytest.approx(0.9, abs=0.01)


def test_a_discrete_effect_takes_its_own_value() -> None:
    truth = _truth(6)
    truth[14] = 1.0
    car = LinearCar(EFFECTS, truth, 6, colour=0.5, strength=0.1)
    _, selection = _search(car)
    assert [(one.hypothesis.columns, one.hypothesis.value) for one in selection.accepted] == [((14,), 1.0)]
    assert selection.fit.theta[14] == 1.0


def test_two_hidden_effects_are_both_named() -> None:
    car = LinearCar(EFFECTS, _truth(7, c1=0.25, c6=-0.3), 7, bend=0.4, colour=0.5)
    assert _names(car, _search(car)[1]) == {"e1", "e6"}


def test_what_a_check_has_refused_does_not_come_back_by_a_swap() -> None:
    """A swap weighs plain evidence only; what was refused for its heat or by a left-out manoeuvre would win by it."""
    car = LinearCar(EFFECTS, _truth(1, c2=0.3), 1)
    search, selection = _search(car)
    selector = Selector(search, 5.0)
    offered = [one.hypothesis for one in selector._rejected([], selection.stages)]
    assert offered
    selector.refused.add(offered[0])
    assert offered[0] not in [one.hypothesis for one in selector._rejected([], selection.stages)]


def test_exact_look_alikes_are_one_group_and_share_the_probability() -> None:
    car = LinearCar(EFFECTS, _truth(8, c3=0.25), 8, colour=0.5, same=[(3, 4, 0.8)])
    search, selection = _search(car)
    alike = [look_alikes(search, selection, one) for one in selection.accepted]
    assert len(alike) == 1
    assert set(alike[0].group) == {3, 4}
    (correlation,) = alike[0].correlations.values()
    assert correlation == pytest.approx(1.0, abs=1e-6)
    assert 0.95 * (1.0 - OUTSIDE) < alike[0].probability[[3, 4]].sum() < 1.0 - OUTSIDE + 1e-9
    assert alike[0].probability[[3, 4]].min() > 0.1


def test_look_alikes_whose_form_is_wrong_share_the_probability_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no size tells two laws apart, what one of them fits better is the form's error and no evidence."""
    car = LinearCar(EFFECTS, _truth(8, c3=0.25), 8, colour=0.5, same=[(3, 4, 0.8)])
    search, selection = _search(car)
    (accepted,) = selection.accepted
    fitted = search.fit_set

    def worse_by_its_form(*given: Any, **named: Any) -> Fit:
        fit = fitted(*given, **named)
        return replace(fit, cost=fit.cost + 40.0)

    right = look_alikes(search, selection, accepted, forced=(4,))
    monkeypatch.setattr(search, "fit_set", worse_by_its_form)
    wrong = look_alikes(search, selection, accepted, forced=(4,))
    assert wrong.evidence[4] == pytest.approx(right.evidence[4], abs=wrong.separations[4] + 1e-6)
    assert wrong.probability[[3, 4]].min() > 0.1


def test_look_alikes_whose_sizes_are_not_as_likely_do_not_share_it_alike() -> None:
    """A change of 0.8 or one of 1.0 beside a width of 0.2: sizes alone tell the two apart."""
    car = LinearCar(EFFECTS, _truth(8, c3=0.8), 8, colour=0.5, same=[(3, 4, 0.8)])
    search, selection = _search(car)
    (alike,) = [look_alikes(search, selection, one, forced=(4,)) for one in selection.accepted]
    assert alike.group == (3, 4)
    assert 1.0 < alike.evidence[3] - alike.evidence[4] < 0.5 * (1.0**2 - 0.8**2) / 0.2**2


def test_the_most_probable_of_a_group_stands_for_it() -> None:
    """The same change by 0.8 of one or 1.0 of the other: whichever was accepted, the likelier size is named."""
    car = LinearCar(EFFECTS, _truth(8, c3=0.8), 8, colour=0.5, same=[(3, 4, 0.8)])
    search, selection = _search(car)
    selector = Selector(search, 5.0)
    (accepted,) = selection.accepted
    other = next(one for one in search.hypotheses if one.columns == (4,))
    swapped = selector.led_by(selection, accepted, other, selection.fit.theta)
    assert [one.hypothesis.columns for one in swapped.accepted] == [(4,)]
    assert swapped.fit.theta[4] == pytest.approx(1.0, abs=0.1)
    for begun in (selection, swapped):
        left, (found,) = named(search, selector, begun, lambda one: [7 - one.hypothesis.effect], _factor)
        assert (found.cause.effect, set(found.cause.group)) == ("e3", {"e3", "e4"})
        assert left.fit.theta[3] == pytest.approx(0.8, abs=0.1)
        assert found.cause.probability == max(found.cause.group_probabilities.values())
    assert any(one.startswith("e3 stands for e4") for one in left.decisions), left.decisions


def test_a_rejected_effect_far_from_the_winner_is_not_in_its_group() -> None:
    car = LinearCar(EFFECTS, _truth(9, c3=0.25), 9, colour=0.5)
    search, selection = _search(car)
    assert look_alikes(search, selection, selection.accepted[0]).group == (3,)


@pytest.mark.parametrize(
    ("apart", "group", "improbable"),
    [(1.0, (7, 4), False), (4.0, (7,), False), (-1.0, (7, 4), False), (-6.0, (7,), True)],
)
def test_what_says_as_much_is_in_the_group_whatever_was_to_be_expected(
    monkeypatch: pytest.MonkeyPatch, apart: float, group: tuple[int, ...], improbable: bool
) -> None:
    """An effect that should be told apart, and is less than 3 of log evidence away; from 3 above on it is the likelier
    one (e^6 = 400 to 1), and what was accepted is no cause."""
    car = LinearCar(EFFECTS, _truth(2, c7=-0.22), 2, bend=0.4, colour=0.5)
    search, selection = _search(car)
    (accepted,) = selection.accepted
    said = np.full(len(car.effects), -50.0)
    said[4] = accepted.evidence - apart
    monkeypatch.setattr(lookalikes, "_evidence_in_place", lambda *_: said.copy())
    rival = next(one for one in search.hypotheses if one.effect == 4)
    refit = InPlace(rival, float(said[4]), 0.0, selection.fit.theta)
    monkeypatch.setattr(lookalikes, "_refitted", lambda *_: refit)
    alike = look_alikes(search, selection, accepted)
    assert alike.separations[4] > 10.0
    assert alike.group == group
    (found,) = causes(search, selection, [alike], _factor)
    assert found.is_improbable == improbable
    told = [remark for remark in found.cause.remarks if remark.startswith("e4 explains this data as well")]
    assert len(told) == (len(group) > 1)


def test_an_improbable_effect_leaves_the_others_as_if_it_had_not_been_accepted() -> None:
    car = LinearCar(EFFECTS, _truth(7, c1=0.25, c6=-0.3), 7, bend=0.4, colour=0.5)
    search, selection = _search(car)
    improbable = [one for one in selection.accepted if one.hypothesis.columns == (6,)]
    left = Selector(search, 5.0).without(selection, improbable)
    assert [one.hypothesis.columns for one in left.accepted] == [(1,)]
    assert left.fit.theta[1] == pytest.approx(0.25, abs=0.05)
    assert left.fit.widths[6] == pytest.approx(NUISANCE)  # a number of an ordinary car again
    assert "dropped e6: what was refused says more in its place" in left.decisions


def test_a_value_that_the_hypothesis_states_has_no_width() -> None:
    truth = _truth(6)
    truth[14] = 1.0
    search, selection = _search(LinearCar(EFFECTS, truth, 6, colour=0.5, strength=0.1))
    (found,) = causes(search, selection, [look_alikes(search, selection, selection.accepted[0])], _factor)
    (estimate,) = found.cause.parameters.values()
    assert (estimate.low, estimate.value, estimate.high) == (2.0, 2.0, 2.0)


def test_a_cause_at_the_end_of_its_range_says_so() -> None:
    """Hidden is 1.3; the effect ends at 1."""
    search, selection = _search(LinearCar(EFFECTS, _truth(6, c3=1.3), 6, colour=0.5))
    alike = [look_alikes(search, selection, one) for one in selection.accepted]
    found = causes(search, selection, alike, _factor)
    own = next(one for one in found if one.accepted.hypothesis.columns == (3,))
    assert own.cause.remarks[0] == "part_0 is at the end of its range: the cause is larger, or another"


def test_what_the_axles_share_may_lie_on_top_of_a_range_and_in_the_interval() -> None:
    """Hidden are 1 on the front axle, where its range ends, and 0.1 on both."""
    front, both = effect("front"), effect("both", nuisance=0.1)
    (own,), (common,) = front.parameters, both.parameters
    front = replace(front, parameters=(replace(own, vehicle_path="tyres.front.friction"),))
    both = replace(both, parameters=(replace(common, common_path="tyres.*.friction"),))
    car = LinearCar([front, both], np.array([1.0, 0.1]), 6, colour=0.5)
    base = fit_base(car, Priors.of(car.parameters))
    search = Search(base.problem, hypotheses_of(car))
    selection = Selector(search, 5.0).run(base.nothing, base.at_nothing, base.at_saturated)
    alike = [look_alikes(search, selection, one) for one in selection.accepted]
    found = next(one for one in causes(search, selection, alike, _factor) if one.cause.effect == "front")
    (estimate,) = found.cause.parameters.values()
    assert estimate.value == pytest.approx(2.0 + 2.0 * 0.1, abs=0.1)
    assert estimate.low <= estimate.value <= estimate.high


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    hits = named = 0
    for seed in range(40):
        truth = _truth(100 + seed, c2=0.3)
        car = LinearCar(EFFECTS, truth, 100 + seed, colour=0.5, strength=0.1, manoeuvres=3, samples=200)
        search, selection = _search(car)
        if _names(car, selection) != {"e2"}:
            continue
        named += 1
        alike = [look_alikes(search, selection, one) for one in selection.accepted]
        found = causes(search, selection, alike, _factor)
        (estimate,) = found[0].cause.parameters.values()
        hits += estimate.low <= 1.0 + truth[2] <= estimate.high
    assert named >= 30
    # lower end of what a 90 % interval gives in 99 of 100 sets of cars (binomial)
    assert hits >= binom.ppf(0.01, named, 0.9)


def test_several_parameters_far_off_are_another_car() -> None:
    truth = _truth(10)
    truth[:8] = [0.3, -0.25, 0.28, -0.3, 0.26, 0.3, -0.27, 0.25]
    car = LinearCar(EFFECTS, truth, 10, colour=0.5)
    search, selection = _search(car)
    wrong = compare(search.problem, selection.nothing, [selection.linearisation], [selection.fit.theta])
    assert wrong.beats(sum(one.evidence for one in selection.accepted), selection.fit.cost)
    assert len(wrong.far_off) >= 6


@pytest.mark.parametrize(("far_off", "more"), [(5, True), (1, False)])
def test_causes_beyond_what_an_answer_holds_are_left(far_off: int, more: bool) -> None:
    truth = _truth(12)
    truth[:far_off] = [0.3, -0.25, 0.28, -0.3, 0.26][:far_off]
    _, selection = _search(LinearCar(EFFECTS, truth, 12, colour=0.5))
    assert len(selection.accepted) == min(far_off, 3)
    assert (selection.left > 5.0) is more


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("yaw_inertia", "mass_change", "tyre_peak_shape"), True),
        (("yaw_inertia", "mass_change", "gyro_offset"), True),
        (("road_grade", "gyro_offset", "accelerometer_scale"), False),
        (("mass_change", "gyro_offset"), False),
        ((), False),
    ],
)
def test_roads_and_sensors_make_no_other_car(names: tuple[str, ...], told: bool) -> None:
    assert are_of_the_car([catalogue.effect(name) for name in names]) is told


def test_one_effect_is_not_another_car() -> None:
    car = LinearCar(EFFECTS, _truth(11, c2=0.3), 11, colour=0.5)
    search, selection = _search(car)
    wrong = compare(search.problem, selection.nothing, [selection.linearisation], [selection.fit.theta])
    assert not wrong.beats(sum(one.evidence for one in selection.accepted), selection.fit.cost)


@pytest.mark.parametrize("seed", range(6))
def test_no_refit_is_worse_than_nothing_more_with_the_same_freedom(seed: int) -> None:
    """A hypothesis allows all that "nothing more" allows: its cost at that solution is a bound, in any minimum."""
    car = LinearCar(EFFECTS, _truth(seed, c2=0.5, c7=-0.4), seed, bend=3.0, colour=0.5)
    search, selection = _search(car)
    priors, first = search.problem.priors, selection.stages[0]
    nothing = first.nothing_more
    for refit in first.refits:
        if refit.hypothesis.value is None:
            bound = nothing.misfit + np.sum(((nothing.theta - priors.centre) / refit.fit.widths) ** 2)
            assert refit.fit.cost <= bound + 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_nothing_has_converged_before_effects_are_weighed_against_it(seed: int) -> None:
    """On a strongly bent car with an effect: sensitivities taken anew at "nothing" lower its cost by no unit more."""
    car = LinearCar(EFFECTS, _truth(seed, c2=0.8, c7=-0.8), seed, bend=3.0, colour=0.5)
    base = fit_base(car, Priors.of(car.parameters))
    nothing = base.nothing
    again = base.problem.fit(base.problem.linearise(nothing.theta), nothing.widths, nothing.theta)
    assert nothing.cost - again.cost < 1.0


@pytest.mark.parametrize("seed", range(4))
def test_the_temperature_is_that_of_the_noise_where_the_catalogue_holds_the_effects(seed: int) -> None:
    """White innovations have temperature 1, and blocks scatter. Fits of another whitening gave 42."""
    car = LinearCar(EFFECTS, _truth(seed, c2=0.8, c7=-0.8), seed, bend=6.0, colour=0.5)
    assert 1.0 <= fit_base(car, Priors.of(car.parameters)).problem.whitener.temperature < 1.6
