"""Exit codes, help, JSON, and what happens to errors that nobody expected."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer

from bench import cli
from bench.cli import app, main
from bench.commands.options import Interrupted
from signals.errors import LinkError

COMMANDS = sorted(info.name or "" for info in app.registered_commands)


def test_every_command_of_the_design_is_there() -> None:
    wanted = {
        "run",
        "ecu",
        "list",
        "check",
        "doctor",
        "report",
        "replay",
        "recover",
        "judge",
        "runs",
        "compare",
        "compare-surfaces",
        "estimate",
        "schema",
    }
    assert wanted <= set(COMMANDS)
    assert {"estimators", "vehicle"} <= {group.name for group in app.registered_groups}


@pytest.mark.parametrize("command", [*COMMANDS, "estimators list", "estimators compare", "vehicle list"])
def test_every_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.split(), "--help"]) == 0
    text = capsys.readouterr().out
    assert "Example" in text
    assert f"bench {command}" in " ".join(text.split())


def test_the_help_ends_with_the_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    end = " ".join(capsys.readouterr().out.split())[-400:]
    for code in (
        "0 pass",
        "1 ran, verdict fail",
        "2 bad usage",
        "3 verdict inconclusive",
        "4 error",
        "130 interrupted",
    ):
        assert code in end


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (
            LinkError("vcan0: no such interface", mend="make it: ip link add"),
            4,
            "error: vcan0: no such interface\n  make",
        ),
        (Interrupted("runs/x"), 130, "interrupted; the recording is in runs/x"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (typer.Abort(), 130, "interrupted"),
        (
            ZeroDivisionError("division by zero"),
            4,
            "error: ZeroDivisionError: division by zero\n  a defect of the bench",
        ),
    ],
)
def test_errors_become_messages_and_exit_codes(
    error: BaseException,
    code: int,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    def fail(**options: Any) -> None:
        raise error

    monkeypatch.setenv("BENCH_LOG", str(tmp_path / "bench.log"))
    monkeypatch.setattr(cli, "app", fail)
    assert main(["run", "x"]) == code
    assert capsys.readouterr().err.startswith(message)
    if isinstance(error, ZeroDivisionError):
        assert "Traceback" in (tmp_path / "bench.log").read_text()


def test_json_of_an_error_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "nothing", "--json"]) == 2
    printed = json.loads(capsys.readouterr().out)
    assert printed["exit_code"] == 2
    assert "no scenario 'nothing'" in printed["error"]


def test_list_names_scenarios_and_procedures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "stops", "--json"]) == 0
    entries = {entry["id"]: entry for entry in json.loads(capsys.readouterr().out)}
    assert entries["stops/dry"]["kind"] == "scenario"
    assert entries["stops/abs_against_locked"]["kind"] == "procedure"
    assert all(entry["title"] for entry in entries.values())
    assert main(["list", "friction/e8"]) == 0
    assert capsys.readouterr().out.startswith("friction/e8_abs_high_grip")


@pytest.mark.parametrize(
    ("file", "kind"),
    [
        ("stops/dry", "scenario"),
        ("stops/dry_ten_runs", "procedure"),
        ("vehicle_model/vehicles/ekf_car.yaml", "vehicle"),
        ("vehicle_model/tyre_files/reduced_set_t.yaml", "tyre"),
        ("vehicle_model/roads/wet.yaml", "road"),
        ("vehicle_model/roads/dry.yaml", "road"),
        ("vehicle_model/roads/surfaces.yaml", "surfaces"),
        ("bench/ecu/calibrations/coarse.yaml", "calibration"),
        ("scenarios/common/abs_stop.yaml", "scenario"),
        ("dbc/brake_bus.dbc", "CAN database"),
    ],
)
def test_check_knows_every_kind_of_file(
    file: str, kind: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(__file__).resolve().parents[3])
    assert main(["check", file, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["kind"] == kind


def test_check_reports_every_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.yaml").write_text("vehicle: ekf_cra\nmanoeuvre: {steps: [{name: a, release: true}]}\nseed: -1\n")
    (tmp_path / "b.yaml").write_text("manoeuvre: {steps: [{name: a, release: true}]}\n")
    assert main(["check", str(tmp_path / "a.yaml"), str(tmp_path / "b.yaml"), "--json"]) == 2
    first, second = json.loads(capsys.readouterr().out)
    assert [(fault["line"], fault["field"]) for fault in first["faults"]] == [(1, "vehicle"), (3, "seed")]
    assert second["ok"]


def test_check_prints_more_than_six_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    steps = "manoeuvre: {steps: [{name: a, release: true}]}\n"
    (tmp_path / "a.yaml").write_text(steps + "".join(f"field{n}: 1\n" for n in range(9)))
    assert main(["check", str(tmp_path / "a.yaml")]) == 2
    assert capsys.readouterr().err.count("unknown field") == 9


def test_schemas_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "--out", str(tmp_path)]) == 0
    written = {path.name for path in tmp_path.iterdir()}
    assert {"scenario.schema.json", "procedure.schema.json", "vehicle.schema.json", "road.schema.json"} <= written


def test_vehicle_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["vehicle", "list", "ekf_car", "--filter", "booster_gain", "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)
    assert entry["path"] == "brakes.booster_gain"
    assert (entry["unit"], entry["value"]) == ("Pa/N", 3e4)


def test_output_to_a_closed_pipe_is_no_error() -> None:
    root = Path(__file__).resolve().parents[3]
    command = f"{sys.executable} -m bench.cli schema | head -1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, cwd=root)
    assert done.returncode == 0
    assert done.stderr == ""
