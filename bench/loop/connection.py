"""The bus side of a run: which ECU, on which link, started by whom."""

import math
import os
import signal
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from bench.codec.codec import AGE_NAMES, Codec, Receiver
from bench.codec.mapping_file import BUS_NAMES
from bench.links.interface import Link
from bench.loop.children import Child, on_helper_cores, start_module
from bench.loop.ecu_sides import BarrierEcu, LinkedEcu, NoEcu
from bench.loop.scheduling import CorePlan
from bench.loop.tick import TICK_S, EcuSide
from bench.scenario.schema import Ecu, ScenarioFile
from signals.errors import InputError, RunError

BARRIER_NAME = "barrier"
START_TIMEOUT_S = 60.0
"""Time for the emulated ECU's process to start, its code compiled or loaded."""


def check_combination(scenario: ScenarioFile) -> None:
    """Refuse what cannot work, before anything is started.

    Raises
    ------
    InputError
        Naming the combination and what to change.
    """
    kind, link, lockstep = scenario.ecu.kind, scenario.ecu.link, scenario.pacing == "lockstep"
    if kind == "external" and lockstep:
        raise InputError(
            "lock-step with an external ECU: it has its own clock and cannot follow virtual time",
            mend="use --realtime, or --ecu emulated",
        )
    if scenario.sensor_cluster.kind == "external" and lockstep:
        raise InputError(
            "lock-step with an external sensor cluster: it has its own clock and cannot follow virtual time",
            mend="use --realtime, or --set sensor_cluster.kind=simulated",
        )
    if lockstep and (link or "").partition(":")[0] == "slcan":
        raise _own_time(f"link {link}")
    if link == "virtual" and kind in ("emulated", "external"):
        raise InputError(
            f"link virtual with --ecu {kind}: a virtual link does not leave this process",
            mend="use --ecu inprocess or none, or a link such as --link udp",
        )
    if link not in (None, "virtual") and kind == "inprocess":
        raise InputError(
            f"link {link} with --ecu inprocess: a controller in this process needs no link",
            mend="leave --link out, or use --ecu emulated",
        )


def _own_time(link: str) -> InputError:
    return InputError(f"lock-step on {link}: a real bus keeps its own time", mend="use --realtime")


@dataclass
class Connection:
    """An open bus side and the processes behind it.

    Attributes
    ----------
    link_text : str
        Text of the link for people, "virtual" without one.
    longest_silence_s : float
        An ECU wanted alive from which no good frame came for longer has fallen silent.
    """

    side: EcuSide
    link_text: str
    statistics: Callable[[], dict[str, Any]]
    ecu: Child | None = None
    expect: str = "alive"
    longest_silence_s: float = math.inf
    barrier_folder: "tempfile.TemporaryDirectory[str] | None" = None

    def watch(self, silent_ticks: int) -> None:
        """Raise RunError if the scenario wants the ECU alive and it has ended or fallen silent.

        Parameters
        ----------
        silent_ticks : int
            Ticks since its last good frame.
        """
        if self.expect != "alive":
            return
        if self.ecu is not None and self.ecu.exit_code is not None:
            raise RunError(
                f"the emulated ECU ended during the run (exit code {self.ecu.exit_code})", mend="see log.txt"
            )
        silence_s = silent_ticks * TICK_S
        if silence_s > self.longest_silence_s:
            raise RunError(
                f"the ECU on {self.link_text} fell silent: no good frame for {silence_s:.1f} s",
                mend="check its supply and the link, allow more by ecu.longest_silence, or declare ecu.expect: lost in "
                "the scenario",
            )

    def kill_ecu(self) -> None:
        """End the emulated ECU at once, as a loss of its supply would."""
        if self.ecu is not None and self.ecu.exit_code is None:
            os.kill(self.ecu.process.pid, signal.SIGKILL)
            self.ecu.process.wait()
        silence = getattr(self.side, "silence", None)
        if silence is not None:
            silence()

    def close(self) -> int | None:
        """Close the link, end and reap the ECU; its exit code, None without one."""
        with suppress(Exception):
            self.side.close()  # type: ignore[attr-defined]
        code = self.ecu.stop() if self.ecu is not None else None
        if self.barrier_folder is not None:
            self.barrier_folder.cleanup()
        return code


def probe_link(scenario: ScenarioFile) -> None:
    """Open and close the link that a scenario names, so that one that is not there ends the run before it begins.

    Raises
    ------
    InputError
        If the text is no link, or lock-step does not go with it.
    LinkError
        If it does not exist or is not permitted.
    """
    if scenario.ecu.kind != "inprocess" and scenario.ecu.link not in (None, "virtual"):
        _open_link(scenario).close()


def with_link(scenario: ScenarioFile) -> ScenarioFile:
    """The scenario with the link that it will use: the one it names, else the best that the machine has."""
    from bench.links.registry import default_link_text

    ecu = scenario.ecu
    if ecu.link is not None:
        return scenario
    link = "virtual" if ecu.kind in ("inprocess", "none") else default_link_text()
    return scenario.model_copy(update={"ecu": ecu.model_copy(update={"link": link})})


def _open_link(scenario: ScenarioFile) -> Link:
    from bench.links.registry import open_link

    link = open_link(with_link(scenario).ecu.link or "", role="bench")
    if scenario.pacing == "lockstep" and not link.supports_lockstep:
        link.close()
        raise _own_time(f"link {link.text}")
    return link


def connect(scenario: ScenarioFile, codec: Codec, cores: CorePlan, log: IO[bytes] | None = None) -> Connection:
    """Open the bus side that a scenario asks for.

    Raises
    ------
    LinkError
        If the link does not exist or is not permitted.
    InputError
        If the ECU's calibration has faults.
    """
    ecu = scenario.ecu
    if ecu.kind == "inprocess":
        from bench.ecu.node import EcuNode
        from bench.loop.in_process_ecu import InProcessEcu

        node = EcuNode(ecu.calibration, codec, silent=_starts_silent(ecu), protection=ecu.protection)
        return Connection(
            InProcessEcu(node),
            "virtual",
            lambda: {"kind": "virtual", "ecu": node.statistics()},
            expect=ecu.expect,
            longest_silence_s=ecu.longest_silence,
        )
    if ecu.kind == "none" and ecu.link in (None, "virtual"):
        return Connection(NoEcu(), "virtual", lambda: {"kind": "virtual"}, expect="silent")
    return _connect_link(scenario, codec, cores, log)


def _connect_link(scenario: ScenarioFile, codec: Codec, cores: CorePlan, log: IO[bytes] | None) -> Connection:
    ecu = scenario.ecu
    link = _open_link(scenario)
    if ecu.kind == "emulated":
        if scenario.pacing == "lockstep":
            return _in_lockstep(ecu, link, cores, log)
        return _in_real_time(ecu, link, _ecu_frames(codec, ecu), cores, log)
    side = LinkedEcu(link, ecu.first_answer)
    expect = ecu.expect if ecu.kind == "external" else "silent"
    connection = Connection(side, link.text, link.statistics, expect=expect, longest_silence_s=ecu.longest_silence)
    if expect != "silent":
        _or_close(connection, lambda: side.wait_until_heard(_ecu_frames(codec, ecu)))
    return connection


def _ecu_frames(codec: Codec, ecu: Ecu) -> Receiver:
    """A receiver of the ECU's messages that only listens for them."""
    return codec.receiver("bench", np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES)), protection=ecu.protection)


def _starts_silent(ecu: Ecu) -> bool:
    """The emulated ECU listens but answers nothing; one that is killed later speaks until then."""
    return ecu.expect == "silent" and ecu.kill is None


def _start_ecu(ecu: Ecu, link: Link, cores: CorePlan, log: IO[bytes] | None, more: Sequence[str] = ()) -> Child:
    arguments = ["--link", link.text, "--calibration", ecu.calibration, "--protection", ecu.protection, *more]
    for option, value in (("--dbc", ecu.dbc), ("--mapping", ecu.mapping)):
        arguments += [option, value] if value else []
    if _starts_silent(ecu):
        arguments.append("--silent")
    with on_helper_cores(cores):
        return start_module("ecu", "bench.ecu.process", arguments, log=log)


def _in_real_time(ecu: Ecu, link: Link, ecu_frames: Receiver, cores: CorePlan, log: IO[bytes] | None) -> Connection:
    child = _start_ecu(ecu, link, cores, log)
    # its first start compiles: that is the bench's time, not the ECU's
    side = LinkedEcu(link, max(ecu.first_answer, START_TIMEOUT_S))
    connection = Connection(side, link.text, link.statistics, child, ecu.expect, ecu.longest_silence)
    if ecu.expect != "silent":
        _or_close(connection, lambda: side.wait_until_heard(ecu_frames, lambda: child.exit_code is None))
    return connection


def _in_lockstep(ecu: Ecu, link: Link, cores: CorePlan, log: IO[bytes] | None) -> Connection:
    from bench.links.barrier import BarrierServer

    folder = tempfile.TemporaryDirectory(prefix="bench-")
    path = str(Path(folder.name) / BARRIER_NAME)
    server = BarrierServer(path)
    child = _start_ecu(ecu, link, cores, log, ("--barrier", path))
    side = BarrierEcu(link, server, may_be_lost=ecu.expect != "alive")
    connection = Connection(side, link.text, link.statistics, child, ecu.expect, ecu.longest_silence, folder)
    _or_close(connection, lambda: server.wait_for_peer(START_TIMEOUT_S, lambda: child.exit_code is None))
    return connection


def _or_close(connection: Connection, wait: Callable[[], None]) -> None:
    try:
        wait()
    except BaseException:
        connection.close()
        raise
