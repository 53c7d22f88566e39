"""Processor, kernel, rights, memory, disk."""

import os
import platform
import resource
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from bench.doctor.finding import Finding

_LIMITS = "/etc/security/limits.d/bench.conf"
_MEND_RIGHTS = rf"printf '%s - rtprio 80\n%s - memlock unlimited\n' $USER $USER | sudo tee {_LIMITS}; then log in again"
_ENOUGH_LOCKED_BYTES = 1 << 30
_CAP_IPC_LOCK = 14
_SPACE_BYTES = 2 << 30
_SLOW_MB_S = 10.0
_DEEP_SLEEP_US = 100


def findings() -> Iterator[Finding]:
    """Everything about the machine itself."""
    yield system()
    yield fifo()
    yield locked_memory()
    yield governor()
    yield sleep_states()
    yield isolated_cores()
    yield huge_pages()
    yield swap()
    yield disk(Path())


def read(path: str | Path) -> str:
    """Content of a small system file, empty if there is none."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def system() -> Finding:
    """Python, cores and kernel."""
    cores = len(os.sched_getaffinity(0))
    real_time = "PREEMPT_RT" in platform.version() or read("/sys/kernel/realtime") == "1"
    kernel = ".".join(platform.release().split(".")[:2])
    text = f"python {platform.python_version()}, {cores} core{'s' if cores > 1 else ''}, kernel {kernel} "
    text += "(PREEMPT_RT)" if real_time else "(no PREEMPT_RT)"
    if cores < 2:
        return Finding("system", "warn", f"{text}: loop and helpers share it", "give the machine a second core")
    return Finding("system", "ok", text)


def fifo() -> Finding:
    """The right to real-time scheduling; asked for and given back."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        return Finding("sched_fifo", "warn", "SCHED_FIFO not allowed", _MEND_RIGHTS)
    with suppress(OSError):
        os.sched_setscheduler(0, *before)
    return Finding("sched_fifo", "ok", "SCHED_FIFO allowed")


def locked_memory() -> Finding:
    """How much memory may be locked."""
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit == resource.RLIM_INFINITY or limit >= _ENOUGH_LOCKED_BYTES or _has_capability(_CAP_IPC_LOCK):
        return Finding("memlock", "ok", "memory may be locked")
    return Finding("memlock", "warn", f"only {limit >> 20} MB of memory may be locked", _MEND_RIGHTS)


def _has_capability(number: int) -> bool:
    """Whether this process has a capability of the kernel."""
    for entry in read("/proc/self/status").splitlines():
        if entry.startswith("CapEff:"):
            return bool(int(entry.split()[1], 16) >> number & 1)
    return False


def governor() -> Finding:
    """Frequency governor of the processor."""
    name = read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    if not name:
        return Finding("governor", "info", "no frequency governor (usual in virtual machines)")
    if name == "performance":
        return Finding("governor", "ok", "governor performance")
    return Finding("governor", "warn", f"governor {name}", "sudo cpupower frequency-set -g performance")


def sleep_states() -> Finding:
    """Deep sleep states of the processor."""
    deep = 0
    for state in Path("/sys/devices/system/cpu/cpu0/cpuidle").glob("state*"):
        latency = read(state / "latency")
        if latency.isdigit() and int(latency) > _DEEP_SLEEP_US and read(state / "disable") != "1":
            deep = max(deep, int(latency))
    if deep:
        text = f"processor sleeps that take {deep} us to leave"
        return Finding("c_states", "warn", text, f"sudo cpupower idle-set --disable-by-latency {_DEEP_SLEEP_US}")
    return Finding("c_states", "ok", "no deep sleep states")


def isolated_cores() -> Finding:
    """Cores that the kernel keeps free."""
    cores = read("/sys/devices/system/cpu/isolated")
    if cores:
        return Finding("isolcpus", "ok", f"isolated cores: {cores}")
    last = (os.cpu_count() or 1) - 1
    text = "no isolated core (only for the last microseconds)"
    return Finding("isolcpus", "info", text, f"kernel command line: isolcpus={last} nohz_full={last}" if last else "")


def huge_pages() -> Finding:
    """Transparent huge pages."""
    setting = read("/sys/kernel/mm/transparent_hugepage/enabled")
    if "[always]" in setting:
        mend = "echo madvise | sudo tee /sys/kernel/mm/transparent_hugepage/enabled"
        return Finding("huge_pages", "warn", "transparent huge pages: always", mend)
    return Finding("huge_pages", "ok", "transparent huge pages: not forced")


def swap() -> Finding:
    """Swap space, which stalls a process whose memory is not locked."""
    if len(read("/proc/swaps").splitlines()) > 1:
        return Finding("swap", "info", "swap is on", "sudo swapoff -a (or allow locked memory)")
    return Finding("swap", "ok", "no swap")


def disk(folder: Path) -> Finding:
    """Space and speed where runs are written."""
    free = shutil.disk_usage(folder).free
    try:
        speed = _write_speed_mb_s(folder)
    except OSError as error:
        return Finding(
            "disk", "warn", f"cannot write in {folder.absolute()}: {error.strerror}", "bench run … --out DIR"
        )
    text = f"disk {free / 1e9:.0f} GB free, {speed:.0f} MB/s"
    if free < _SPACE_BYTES or speed < _SLOW_MB_S:
        return Finding("disk", "warn", text, "write runs elsewhere: bench run … --out DIR")
    return Finding("disk", "ok", text)


def _write_speed_mb_s(folder: Path, megabytes: int = 8) -> float:
    block = os.urandom(1 << 20)
    with tempfile.TemporaryFile(dir=folder) as file:
        began = time.perf_counter()
        for _ in range(megabytes):
            file.write(block)
        file.flush()
        os.fsync(file.fileno())
        return megabytes / (time.perf_counter() - began)
