"""The doctor on machines that lack this or that."""

import errno
import json
import os
import socket
from pathlib import Path
from typing import Any

import pytest

from bench.cli import main
from bench.doctor import can_bus, findings, line, machine, software, timer
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


def test_strict_and_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import bench.doctor

    found = [Finding("a", "ok", "good"), Finding("b", "warn", "bad", "mend it")]
    monkeypatch.setattr(bench.doctor, "findings", lambda *, benchmark: iter(found))
    assert main(["doctor"]) == 0
    assert main(["doctor", "--strict"]) == 1
    capsys.readouterr()
    assert main(["doctor", "--json", "--strict"]) == 1
    assert [entry["state"] for entry in json.loads(capsys.readouterr().out)] == ["ok", "warn"]
