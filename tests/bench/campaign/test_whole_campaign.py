"""A whole campaign with real runs: outcomes, figures, report, the single run again, and what a kill leaves."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
import pyarrow.parquet as pq
import pytest

from bench.campaign.engine import CampaignRun, Progress, read_campaign
from bench.campaign.folders import campaign_of
from bench.campaign.report_page import build
from bench.campaign.showing import repeat
from bench.campaign.store import Store, read_about, read_rows
from bench.campaign.summary import summarise
from bench.cli import main
from signals.errors import InputError, RunError

SMALL = Path(__file__).parent / "small.yaml"


@dataclass(frozen=True)
class Done:
    """A campaign that has been run: folder, rows by text of their faults, progress."""

    folder: Path
    rows: dict[str, dict[str, Any]]
    progress: Progress


def text_of(row: dict[str, Any]) -> str:
    times = ["" if time is None else f" {time:g}" for time in row["times_s"]]
    return "+".join(f"{fault}{time}" for fault, time in zip(row["faults"], times, strict=True))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Done:
    folder = tmp_path_factory.mktemp("campaign") / "small"
    progress = CampaignRun(read_campaign(SMALL), SMALL, folder).run(workers=2)
    return Done(folder, {text_of(row): row for row in read_rows(folder)}, progress)


def test_outcomes_are_those_of_the_car(small: Done) -> None:
    outcomes = {text: row["outcome"] for text, row in small.rows.items()}
    # two missing frames are no fault for an ECU that waits five periods (calibration: timeout_periods), and the next
    # frame brings the count of all edges since (docs/ecu.md: a missing frame is not a missing pulse)
    assert outcomes["dropped[duration=10 ms] 0.4"] in ("no_effect", "silent_harmless")
    assert outcomes["dropped[duration=0.5 s] 0.4"] == "degraded_safely"
    # an outlet valve that is open for 0.8 s of a stop of 2.2 s costs one of two front brakes
    assert outcomes["valve[target=valve_outlet_fl] 0.4"] == "hazardous"
    assert outcomes["pads"] == "hazardous"
    assert len(outcomes) == 2 * 2 + 2 * 2 + 1 + 1


def test_detection_has_a_latency_of_the_time_out(small: Done) -> None:
    row = small.rows["dropped[duration=0.5 s] 0.4"]
    assert row["noticed"] == "monitor"
    assert 3 in row["fault_codes"]  # wheel_edges_fl_missing, bench/ecu/faults.py
    # more than five periods of 5 ms after the last good frame, seen in the frame of 20 ms that carries the code
    assert 0.02 <= row["latency_s"] <= 0.06


def test_rows_say_where_and_of_which_class_the_fault_was(small: Done) -> None:
    row = small.rows["dropped[duration=0.5 s] 0.4"]
    assert (row["messages"], row["disturbances"], row["e2e"], row["levels"]) == (
        ["0x122"],
        ["drop"],
        ["loss"],
        ["frame_gateway"],
    )
    assert row["phase"] == "brake"
    assert small.rows["pads"]["times_s"] == [None]


def test_each_run_is_made_once(small: Done) -> None:
    assert small.progress.made == len(small.rows) == 10


def test_figures_and_limits(small: Done) -> None:
    summary = summarise(campaign_of(small.folder), list(read_rows(small.folder)))
    assert summary.whole.runs == 9
    assert sum(share.count for share in summary.whole.outcomes.values()) == 9
    assert summary.exit_code == 0
    assert summary.covered["faults"] == (5, 5)
    assert summary.covered["times"] == (2, 2)
    assert [line.name for line in summary.by_entry] == ["dropped", "valve", "pads"]
    assert summary.pareto[0].hazardous.count == max(line.hazardous.count for line in summary.by_entry)


def test_the_store_is_read_by_any_parquet_reader(small: Done) -> None:
    table = pq.read_table(small.folder / "runs")
    assert table.num_rows == 10
    assert len(set(table["key"].to_pylist())) == 10
    assert sorted(path.name for path in (small.folder / "runs").iterdir()) == ["all.parquet"]


def test_a_single_run_comes_out_the_same_bit_for_bit(small: Done, tmp_path: Path) -> None:
    key = small.rows["valve[target=valve_outlet_fl] 0.4"]["key"]
    again = repeat(key, str(small.folder), tmp_path / "again")
    assert again.same
    for name in ("verdict.json", "report.html", "signals.mf4", "frames.blf", "scenario.yaml"):
        assert (tmp_path / "again" / name).exists()


def test_the_report_holds_every_run_with_its_command(small: Done) -> None:
    page = build(small.folder).read_text()
    for row in small.rows.values():
        if not row["fault_free"]:
            assert f"bench campaign show {row['key']} --campaign {small.folder}" in page
    assert "Time of injection × stopping distance" in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_the_same_command_again_makes_no_run(small: Done) -> None:
    progress = CampaignRun(read_campaign(SMALL), SMALL, small.folder).run(workers=1)
    assert (progress.made, progress.known) == (0, 10)


def test_a_folder_of_another_campaign_is_refused(small: Done) -> None:
    other = read_campaign(SMALL).model_copy(update={"same_within": 0.5})
    with pytest.raises(InputError, match="another campaign"):
        CampaignRun(other, SMALL, small.folder).run(workers=1)


def test_two_processes_do_not_write_one_campaign(small: Done) -> None:
    about = read_about(small.folder)
    with Store(small.folder, about), pytest.raises(RunError, match="another process"):
        Store(small.folder, about)


def test_limits_that_the_fault_free_run_breaks_are_refused(tmp_path: Path) -> None:
    text = SMALL.read_text().replace("at_most: 10 deg", "at_least: 10 deg")
    path = tmp_path / "narrow.yaml"
    path.write_text(text.replace("../whole_runs", str(SMALL.parents[1] / "whole_runs")))
    with pytest.raises(InputError, match=r"fault-free run .* breaks the limit of hazard 'yaw'"):
        CampaignRun(read_campaign(path), path, tmp_path / "narrow").run(workers=1)


def test_a_broken_limit_is_exit_code_1(small: Done, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "strict"
    shutil.copytree(small.folder, folder)
    about = json.loads((folder / "campaign.json").read_text())
    about["campaign"]["limits"] = [{"quantity": "hazardous_runs", "at_most": 0}]
    (folder / "campaign.json").write_text(json.dumps(about))
    assert main(["campaign", "report", str(folder), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["limits"][0]["broken"]
    assert told["exit_code"] == 1


def start(folder: Path) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", "bench.cli", "campaign", "run", str(SMALL), "--out", str(folder), "--workers", "2"]
    return subprocess.Popen([*command, "--plain"], stdout=subprocess.DEVNULL)


def stored(folder: Path) -> int:
    return sum(pq.read_metadata(path).num_rows for path in (folder / "runs").glob("*.parquet"))


def wait_for_rows(folder: Path, process: "subprocess.Popen[bytes]") -> None:
    deadline = time.monotonic() + 120
    while process.poll() is None and time.monotonic() < deadline:
        if (folder / "runs").exists() and stored(folder) >= 1:
            return
        time.sleep(0.02)


def test_a_campaign_goes_on_after_a_kill_of_any_of_its_processes(small: Done, tmp_path: Path) -> None:
    """First the main process, then a worker: no run is lost or there twice, all are those of the whole campaign."""
    folder = tmp_path / "killed"
    first = start(folder)
    wait_for_rows(folder, first)
    first.send_signal(signal.SIGKILL)
    assert first.wait() == -signal.SIGKILL
    assert stored(folder) >= 1
    (folder / "runs" / ".part-000009.parquet.partial").write_bytes(b"half a part")

    second = start(folder)
    workers: list[psutil.Process] = []
    deadline = time.monotonic() + 120
    while not workers and second.poll() is None and time.monotonic() < deadline:
        children = psutil.Process(second.pid).children()
        workers = [child for child in children if "spawn_main" in " ".join(child.cmdline())]
        time.sleep(0.02)
    if workers:
        os.kill(workers[0].pid, signal.SIGKILL)
    assert second.wait(timeout=300) == 0
    rows = {row["key"]: row for row in read_rows(folder)}
    assert stored(folder) == len(rows) == 10
    expected = {row["key"]: (row["motion"], row["outcome"]) for row in small.rows.values()}
    assert {key: (row["motion"], row["outcome"]) for key, row in rows.items()} == expected


def test_the_bare_form_runs_a_campaign_and_json_stands_alone(small: Done, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", str(SMALL), "--out", str(small.folder), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["progress"]["known"] == 10
    assert told["progress"]["made"] == 0
    assert told["whole"]["runs"] == 9


def test_the_table_for_documents_has_a_line_per_entry(small: Done, capsys: pytest.CaptureFixture[str]) -> None:
    """Without variants by entry of the file, with them by class of fault and variant."""
    assert main(["campaign", "report", str(small.folder), "--markdown"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("| fault | runs |")
    assert [line.split(" | ")[0] for line in lines[2:]] == ["| dropped", "| valve", "| pads"]


def test_help_of_the_group_and_its_commands_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["campaign", "--help"], *(["campaign", name, "--help"] for name in ("run", "report", "show"))):
        assert main(arguments) == 0
        assert "bench campaign" in capsys.readouterr().out
