"""Priors of numbers that the axles of one car share, and of those that the replay's form is not sure of."""

import numpy as np
import pytest

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.effects.form import REPLAYED
from model_diagnosis.effects.in_common import common_columns
from model_diagnosis.evidence.priors import COMMON_SHARE, Priors, with_commons

PARAMETERS = [parameter for effect in REPLAYED for parameter in effect.parameters]
COLUMNS = [column for effect in REPLAYED for column in effect.columns]
STATED = 0.03


def _springs() -> list[EffectParameter]:
    return [
        EffectParameter("front", "1", -0.5, 1.0, STATED, 0.2, "suspension.front.spring_rate"),
        EffectParameter("rear", "1", -0.5, 1.0, STATED, 0.2, "suspension.rear.spring_rate"),
        EffectParameter("spring_rate", "1", -0.3, 0.3, STATED, STATED, common_path="suspension.*.spring_rate"),
    ]


def test_each_axle_scatters_as_stated_and_half_of_it_with_the_other_one() -> None:
    """The marginal variance is the vehicle file's; the correlation is the common share."""
    own_front, own_rear, common = Priors.of(_springs()).nuisance
    assert own_front**2 + common**2 == pytest.approx(STATED**2, rel=1e-12)
    assert own_rear**2 + common**2 == pytest.approx(STATED**2, rel=1e-12)
    assert common**2 / STATED**2 == pytest.approx(COMMON_SHARE, rel=1e-12)


@pytest.mark.parametrize("off", [(0.08, 0.08), (0.08, 0.0), (0.05, -0.05)])
def test_the_cheapest_split_costs_what_the_bivariate_normal_does(off: tuple[float, float]) -> None:
    """Oracle: x' S^-1 x of two correlated normals (numpy)."""
    own, _, common = Priors.of(_springs()).nuisance
    together = np.linspace(-0.1, 0.1, 200_001)
    split = (together / common) ** 2 + sum(((axle - together) / own) ** 2 for axle in off)
    covariance = STATED**2 * np.array([[1.0, COMMON_SHARE], [COMMON_SHARE, 1.0]])
    assert float(np.min(split)) == pytest.approx(float(np.array(off) @ np.linalg.solve(covariance, off)), rel=1e-6)


def test_a_calibration_takes_each_axle_for_itself() -> None:
    front, rear, common = Priors.of(_springs(), in_common=False).nuisance
    assert front == rear == STATED
    assert common < 1e-3 * STATED * 1.01


def test_the_catalogue_knows_what_the_axles_share() -> None:
    found = {COLUMNS[own]: COLUMNS[common] for own, common in common_columns(PARAMETERS).items()}
    assert {column.partition(".")[0] for column in found} == {
        "spring_rate",
        "damper_rate",
        "anti_roll_bar",
        "roll_centre_height",
        "anti_dive_anti_lift",
        "tyre_friction",
    }
    assert len(found) == 2 * len(set(found.values()))


def test_what_is_common_counts_to_each_axle() -> None:
    assert with_commons(np.array([0.10, -0.05, 0.02]), _springs()) == pytest.approx([0.12, -0.03, 0.0])


def test_a_form_that_is_not_sure_adds_to_the_scatter() -> None:
    scale = COLUMNS.index("pressure_sensor_scale.wheels")
    assert Priors.of(PARAMETERS).nuisance[scale] == pytest.approx(np.hypot(0.005, 0.005), rel=1e-12)
