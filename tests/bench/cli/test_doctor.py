"""The doctor on machines that lack this or that."""

import errno
import json
import os
import socket
from pathlib import Path
from typing import Any

import pytest

from bench.cli import main
from bench.doctor import benchmark, can_bus, findings, line, machine, software, timer
from bench.doctor.finding import Finding


def test_every_subject_is_looked_at() -> None:
    names = [finding.name for finding in findings()]
    assert names[0] == "system"
    for name in ("sched_fifo", "memlock", "af_can", "can_utils", "multicast", "serial", "timer", "disk", "governor"):
        assert name in names
    for name in ("c_states", "isolcpus", "huge_pages", "swap", "chromium", "packages", "optional"):
        assert name in names


def test_a_warning_tells_what_mends_it() -> None:
    for finding in findings():
        assert finding.state != "warn" or finding.mend, finding.name
    assert "mend: do this" in line(Finding("x", "warn", "bad", "do this"))
    assert "mend" not in line(Finding("x", "ok", "good", "do this"))


def test_scheduling_is_given_back() -> None:
    machine.fifo()
    assert os.sched_getscheduler(0) == os.SCHED_OTHER


def test_no_right_to_schedule(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: Any) -> None:
        raise PermissionError(errno.EPERM, "not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    finding = machine.fifo()
    assert finding.state == "warn"
    assert "/etc/security/limits.d/bench.conf" in finding.mend


def test_a_kernel_without_can(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: Any) -> None:
        raise OSError(errno.EAFNOSUPPORT, "Address family not supported by protocol")

    monkeypatch.setattr(socket, "socket", refuse)
    finding = can_bus.kernel_can()
    assert finding.state == "warn"
    assert "ci/can_kernel" in finding.mend


def test_transparent_huge_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "read", lambda path: "[always] madvise never")
    assert machine.huge_pages().state == "warn"
    monkeypatch.setattr(machine, "read", lambda path: "always [madvise] never")
    assert machine.huge_pages().state == "ok"


def test_a_folder_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(folder: Path, megabytes: int = 8) -> float:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(machine, "_write_speed_mb_s", refuse)
    assert machine.disk(tmp_path).state == "warn"


def test_packages_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(software, "find_spec", lambda name: None if name == "mujoco" else object())
    assert "mujoco" in software.packages().text
    assert software.packages().state == "warn"


def test_lateness_is_counted_from_absolute_deadlines() -> None:
    late = timer.lateness_us(20)
    assert len(late) == 20
    assert late == sorted(late)
    assert late[0] >= 0


TIMING: dict[str, Any] = {
    "scheduler": "fifo 60",
    "ticks": 9000,
    "lateness_us": {"p50": 0.1, "p99": 19.0, "p999": 60.0, "max": 900.0},
    "tick_cpu_us": {"p50": 85.0, "p99": 233.0},
    "late_ticks": 2,
    "late_ticks_ours": 0,
    "late_ticks_machine": 2,
}
"""Of a run that meets the goals, a late machine or not."""


@pytest.mark.parametrize(
    ("change", "state"),
    [
        ({}, "ok"),
        ({"late_ticks_ours": 1}, "warn"),
        ({"lateness_us": {**TIMING["lateness_us"], "p99": 21.0}}, "warn"),
        ({"lateness_us": {**TIMING["lateness_us"], "p99": 199.0}, "scheduler": "other"}, "ok"),
        ({"lateness_us": {**TIMING["lateness_us"], "p99": 201.0}, "scheduler": "other"}, "warn"),
        ({"tick_cpu_us": {"p50": 151.0, "p99": 233.0}}, "warn"),
        ({"tick_cpu_us": {"p50": 85.0, "p99": 351.0}}, "warn"),
    ],
)
def test_the_real_time_loop_is_held_against_each_goal(change: dict[str, Any], state: str) -> None:
    finding = benchmark.judge_timing(TIMING | change)
    assert finding.state == state
    for word in ("p50 0.1", "p99.9 60.0", "max 900", "late ticks 2 of 9000", "the machine's 2", "tick p50"):
        assert word in finding.text or change


def test_strict_and_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import bench.doctor

    found = [Finding("a", "ok", "good"), Finding("b", "warn", "bad", "mend it")]
    monkeypatch.setattr(bench.doctor, "findings", lambda *, benchmark: iter(found))
    assert main(["doctor"]) == 0
    assert main(["doctor", "--strict"]) == 1
    capsys.readouterr()
    assert main(["doctor", "--json", "--strict"]) == 1
    assert [entry["state"] for entry in json.loads(capsys.readouterr().out)] == ["ok", "warn"]
