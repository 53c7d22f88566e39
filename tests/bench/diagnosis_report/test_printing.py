"""What the terminal says of a diagnosis, and its exit code by verdict."""

import io
from dataclasses import replace
from pathlib import Path

import made_up_findings
import pytest
from rich.console import Console

from bench.diagnosis.diagnosing import Found, Written, write
from bench.diagnosis.extending import deviation_of
from bench.diagnosis.printing import print_diagnosis
from model_diagnosis.effects.catalogue import effect
from model_diagnosis.findings import Findings
from model_diagnosis.result import OverallGain, ParameterEstimate
from vehicle_model.vehicle_file import load_vehicle


def printed(findings: Findings, folder: Path = Path("result")) -> str:
    console = Console(file=io.StringIO(), width=160, highlight=False)
    print_diagnosis(Written(findings, folder), console)
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_the_terminal_says_cause_value_and_next_step(findings: Findings) -> None:
    text = printed(findings)
    for words in (
        "EFFECT FOUND",
        "brake pad friction −20.5 %",
        "83 %",
        "0.314 … 0.322",
        "cannot be told from",
        "pressure sensor scale",
        "channel sign, repaired: lateral_acceleration",
        "error left on held-out manoeuvres: 12 % [9, 16]",
        "hold at standstill",
        "result/extended_vehicle.yaml",
    ):
        assert words in text


def test_a_cause_that_stands_alone_has_no_column_of_look_alikes(findings: Findings) -> None:
    alone = findings.diagnosis.causes[0].model_copy(update={"group": [findings.diagnosis.causes[0].effect]})
    answer = findings.diagnosis.model_copy(update={"causes": [alone]})
    text = printed(replace(findings, diagnosis=answer))
    assert "0.314 … 0.322" in text
    assert "cannot be told from" not in text


def test_a_discovered_term_is_printed(findings: Findings) -> None:
    answer = findings.diagnosis.model_copy(update={"discovered_terms": [made_up_findings.discovered()]})
    assert "a · T_b · v²" in printed(replace(findings, diagnosis=answer))


@pytest.mark.parametrize(
    ("verdict", "code"), [("effect_found", 0), ("nothing_found", 0), ("wrong_vehicle", 0), ("insufficient_data", 3)]
)
def test_exit_codes(verdict: str, code: int, findings: Findings) -> None:
    answer = findings.diagnosis.model_copy(update={"verdict": verdict})
    assert Written(replace(findings, diagnosis=answer), Path()).exit_code == code


def test_the_extended_car_has_what_was_found_and_loads(findings: Findings, tmp_path: Path) -> None:
    written = write(Found(findings, load_vehicle("ekf_car"), "ekf_car"), tmp_path, stops=False)
    assert written.diagnosis.extension_file == "extended_vehicle.yaml"
    extended = load_vehicle(tmp_path / "extended_vehicle.yaml")
    assert extended.brakes.front.pad_friction == pytest.approx(0.318)
    assert extended.extensions[0].intervals["brakes.rear.pad_friction"] == pytest.approx([0.314, 0.322])


def test_a_slope_of_one_manoeuvre_is_told_in_the_extended_car_and_not_applied(
    findings: Findings, tmp_path: Path
) -> None:
    slope = ParameterEstimate(value=-0.025, low=-0.03, high=-0.02, unit="1", nominal=0.0)
    of_drive = findings.diagnosis.causes[0].model_copy(
        update={"effect": "road_grade", "parameters": {"grade_in_manoeuvre_1": slope}, "group": ["road_grade"]}
    )
    answer = findings.diagnosis.model_copy(update={"causes": [*findings.diagnosis.causes, of_drive]})
    written = write(
        Found(replace(findings, diagnosis=answer), load_vehicle("ekf_car"), "ekf_car"), tmp_path, stops=False
    )
    assert written.diagnosis.extension_file == "extended_vehicle.yaml"
    told = next(
        one for one in load_vehicle(tmp_path / "extended_vehicle.yaml").extensions if one.effect == "road_grade"
    )
    assert dict(told.conditions) == {"road_grade.grade_in_manoeuvre_1": "-0.025"}
    assert not told.parameters


def test_without_a_proven_gain_there_is_no_extended_car(findings: Findings, tmp_path: Path) -> None:
    gain = findings.diagnosis.gain
    assert gain is not None
    unproven = gain.model_copy(update={"overall": OverallGain(ratio=0.9, low=0.7, high=1.1)})
    answer = findings.diagnosis.model_copy(update={"gain": unproven, "extension_file": None})
    (tmp_path / "extended_vehicle.yaml").write_text("of an earlier diagnosis")
    written = write(Found(replace(findings, diagnosis=answer), load_vehicle("ekf_car"), "ekf_car"), tmp_path)
    assert not (tmp_path / "extended_vehicle.yaml").exists()
    assert "no extended vehicle file: no gain on data that took no part" in written.diagnosis.remarks


def test_where_a_refit_of_the_cars_own_numbers_does_better_there_is_no_extended_car(
    findings: Findings, tmp_path: Path
) -> None:
    gain = findings.diagnosis.gain
    assert gain is not None
    beaten = gain.model_copy(update={"against_refit": OverallGain(ratio=1.06, low=1.04, high=1.11)})
    answer = findings.diagnosis.model_copy(update={"gain": beaten, "extension_file": None})
    written = write(Found(replace(findings, diagnosis=answer), load_vehicle("ekf_car"), "ekf_car"), tmp_path)
    assert not (tmp_path / "extended_vehicle.yaml").exists()
    assert any("refit of the vehicle file's own numbers does better" in one for one in written.diagnosis.remarks)


def test_deviations_are_those_behind_the_physical_values() -> None:
    (factor,) = effect("brake_pad_friction").parameters
    estimate = made_up_findings.cause().parameters["factor"]
    assert deviation_of(estimate, factor, estimate.value) == pytest.approx(0.318 / 0.4 - 1.0)
