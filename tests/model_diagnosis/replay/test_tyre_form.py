"""The replay's short form of the vehicle's tyre."""

import numpy as np
import pytest

from model_diagnosis.extension.tyre_shape import curve
from model_diagnosis.extension.tyre_shape import reshaped as reshaped_curve
from model_diagnosis.replay.tyre_shape import reshaped
from model_diagnosis.replay.tyre_table import TyreForm, fit_tyre, short_forces
from vehicle_model.tyres.tyre_file import MagicFormulaCurve
from vehicle_model.vehicle_file import load_tyres, load_vehicle


# curves with similarity are the plant's tyre up to the table; the others differ in the combination of slips or in a
# load dependence that is not linear, in shares of the load over a grid that reaches lock and 9 degrees together
@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("reduced_unit_peak", 0.001),
        ("reduced_set_t", 0.001),
        ("burckhardt_dry_asphalt", 0.01),
        ("tmeasy", 0.1),
        ("dugoff", 0.15),
        ("commonroad", 0.2),
    ],
)
def test_short_form_against_the_tyre_itself(name: str, most: float) -> None:
    pair = load_vehicle("commonroad_bmw_320i").tyre_pair if name == "commonroad" else load_tyres(name)
    assert fit_tyre(pair.front, 4500.0).error < most


def test_short_form_keeps_stiffness_peak_and_odd_symmetry() -> None:
    tyre = load_tyres("reduced_set_t").front
    form = fit_tyre(tyre, 4500.0)
    curve_x = tyre.longitudinal
    small = short_forces(form, -1e-5, 0.0, 4500.0)[0]
    stiffness = curve_x.peak_friction * curve_x.shape * curve_x.stiffness
    assert small / (-1e-5 * 4500.0) == pytest.approx(stiffness, rel=1e-3)
    assert form.longitudinal.peak == pytest.approx(curve_x.peak_friction, rel=1e-6)
    assert short_forces(form, 0.05, -0.02, 4500.0) == pytest.approx(
        tuple(-force for force in short_forces(form, -0.05, 0.02, 4500.0))
    )


def test_loss_of_friction_by_load_is_the_files() -> None:
    tyre = load_tyres("reduced_set_t").front.model_copy(update={"load_sensitivity": 0.15, "nominal_load": 4500.0})
    form = fit_tyre(tyre, 4500.0)
    assert form.longitudinal.load_loss == pytest.approx(0.15, rel=1e-6)
    assert form.longitudinal.stiffness_loss == pytest.approx(0.15, rel=1e-3)


@pytest.mark.parametrize(("loss", "shift"), [(0.05, 0.0), (0.0, 0.15), (-0.04, -0.1)])
def test_reshaped_table_is_a_magic_formula_of_that_form(loss: float, shift: float) -> None:
    """Against the extension's Magic Formula, found by another way: same stiffness, peak elsewhere, less sliding."""
    tyre = load_tyres("reduced_unit_peak").front
    form: TyreForm = fit_tyre(tyre, 4500.0)
    assert isinstance(tyre.longitudinal, MagicFormulaCurve)
    wanted = reshaped_curve(tyre.longitudinal, loss, shift)
    table = reshaped(form.longitudinal.table, form.longitudinal.peak_slip, loss, shift)
    cells = np.arange(1, len(table) - 1)
    relative = cells / (len(table) - 1 - cells)
    slips = relative * form.longitudinal.peak_slip * (1.0 + shift)
    reached = slips < 1.0
    expected = curve(slips[reached], wanted.shape, wanted.stiffness, wanted.curvature)
    assert np.allclose(table[cells][reached, 0], expected / expected.max(), atol=4e-3)
