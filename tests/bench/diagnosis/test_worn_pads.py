"""From a run of the bench to the named cause, its value, the extended car and the fitted car."""

import json
from pathlib import Path

import pytest

import bench
from bench.diagnosis.vehicle_fitting import fit
from model_diagnosis.replay.disturbances import ALIKE
from model_diagnosis.result import Diagnosis
from vehicle_model.vehicle_file import load_vehicle

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def folder(worn_drive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files of the diagnosis of the worn car's drive, made from Python."""
    out = tmp_path_factory.mktemp("result")
    answer = bench.diagnose(worn_drive, "ekf_car", out=out)
    written = Diagnosis.model_validate(json.loads((out / "diagnosis.json").read_text("utf-8")))
    assert written.verdict == answer.verdict
    return out


def test_worn_pads_are_named_with_their_friction(folder: Path) -> None:
    """The pads have 0.30 where the vehicle file says 0.40; a scale of the pressure sensors looks the same."""
    answer = Diagnosis.model_validate(json.loads((folder / "diagnosis.json").read_text("utf-8")))
    assert answer.verdict in ("effect_found", "indistinguishable")
    assert "brake_pad_friction" in answer.causes[0].group
    cause = next(cause for cause in answer.causes if cause.effect == "brake_pad_friction")
    assert cause.parameters["factor"].value == pytest.approx(0.30, rel=0.05)
    assert answer.ratings
    assert next(iter(answer.guilty_by_innovations)) == ALIKE  # no stop with ABS: most violated, not enough to be lit


def test_the_page_is_beside_the_answer(folder: Path) -> None:
    page = (folder / "diagnosis.html").read_text("utf-8")
    assert "brake pad friction" in page
    assert "house of equations" in page


def test_a_healthy_drive_names_no_cause(healthy_drive: Path, tmp_path: Path) -> None:
    """The plant that drove is the vehicle file's; its hydraulic unit rests up to 1 bar off its supply, as no fault."""
    answer = bench.diagnose(healthy_drive, "ekf_car", out=tmp_path)
    assert answer.causes == []
    assert answer.data_faults == []
    assert answer.discovered_terms == []
    assert answer.verdict != "wrong_vehicle"


def test_a_car_fitted_to_a_healthy_drive_is_that_car(healthy_drive: Path, tmp_path: Path) -> None:
    """The plant that drove is the vehicle file's: nothing is further off than the three scatters that are warned of.

    The largest are the inlet valves' (1.2 scatters, 10 ms samples of a rising pressure) and the pads' and the mass'
    (0.9 each), whose quotient alone a stop shows.
    """
    result = fit([str(healthy_drive)], "ekf_car", out=tmp_path / "car.yaml")
    assert result.fit.calibrated
    assert result.fit.far_off == []
    assert "circuit_failure" not in {one.effect for one in result.fit.calibrated}
    fitted, nominal = load_vehicle(result.file), load_vehicle("ekf_car")
    pads = fitted.brakes.front.pad_friction
    assert pads == pytest.approx(nominal.brakes.front.pad_friction, rel=0.03)
    assert fitted.scatter["brakes.front.pad_friction"].std < 0.03
    after = [after for _, after in result.fit.misfit.values()]
    before = [before for before, _ in result.fit.misfit.values()]
    assert sum(after) <= sum(before)
