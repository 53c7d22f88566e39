"""``bench ecu``: the emulated ABS ECU as a process of its own, in real time or in lock-step with a bench.

Exit codes: 0 the bench ended the run or SIGTERM came, 2 bad usage or a bad file, 4 the link or the barrier failed,
130 interrupted. The process ends with its parent.
"""

import argparse
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, get_args

from bench.codec.mapping_file import Protection
from bench.ecu.calibration import CALIBRATIONS
from bench.ecu.records import TASK_OFFSET_TICKS
from bench.loop.ending import until_ended
from bench.loop.scheduling import CorePlan, die_with_parent, real_time_process
from signals.errors import INTERRUPTED, BenchError, InputError

if TYPE_CHECKING:
    from bench.ecu.node import EcuNode
    from bench.links.barrier import BarrierClient
    from bench.links.interface import Link

TICK_S = 1e-3
MOST_FRAMES = 4096
MOST_ANSWERS = 64
MOST_TICKS_WITHOUT_REST = 5
"""On a machine too slow for the ECU, the bench on the same core gets its turn after these."""
LEAST_REST_S = 0.5e-3
OK = 0


class Stopped(BaseException):
    """SIGTERM came; none of a library's ``except Exception`` takes it for an error of its own."""


class _Stop:
    """Handler of SIGTERM.

    Its exception can be lost in a callback of what compiles or loads. A process that went on then would have nothing to
    end it, not even its parent's death, so it asks once more before it serves.
    """

    def __init__(self) -> None:
        self._came = False

    def __call__(self, number: int, frame: FrameType | None) -> NoReturn:
        _let_nothing_disturb_the_end()  # a second one would come while the first is handled
        self._came = True
        raise Stopped

    def if_it_came(self) -> None:
        if self._came:
            raise Stopped


def _let_nothing_disturb_the_end() -> None:
    """From here on the exit code stands: an interpreter that is leaving catches no exception of a handler."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bench ecu", description="The emulated ABS ECU alone, on any link.")
    parser.add_argument("--link", help="virtual, udp, socketcan:vcan0, slcan:/dev/ttyUSB0@500000, IFACE:CHANNEL")
    parser.add_argument("--calibration", default="sensitive", help=f"{', '.join(CALIBRATIONS)}, or a file")
    parser.add_argument("--dbc", help="CAN database (default: the shipped one)")
    parser.add_argument("--mapping", help="mapping file of a database with other names")
    parser.add_argument("--barrier", help="socket of a bench in lock-step")
    parser.add_argument("--core", type=int, help="processor core to stay on")
    parser.add_argument("--protection", choices=get_args(Protection), default="full", help="what is checked of frames")
    parser.add_argument("--silent", action="store_true", help="listen but answer nothing")
    return parser


def run_in_lockstep(node: "EcuNode", link: "Link", barrier: "BarrierClient") -> None:
    """Run the ticks that the bench begins until it ends the run."""
    from bench.links.frame import new_frames

    received, answers = new_frames(MOST_FRAMES), new_frames(MOST_ANSWERS)
    while (begun := barrier.begin(link, received)) is not None:
        tick, count = begun
        sent = node.tick(tick, received, count, answers)
        link.send(answers, sent)
        barrier.finish(answers, sent)


def run_in_real_time(node: "EcuNode", link: "Link", ended: Callable[[], int]) -> None:
    """Own clock, a tick each millisecond; a frame that arrives earlier is taken in at the next tick."""
    from bench.links.frame import new_frames

    received, answers = new_frames(MOST_FRAMES), new_frames(MOST_ANSWERS)
    start, tick, without_rest = time.perf_counter(), 0, 0
    while not ended():
        elapsed = time.perf_counter() - start
        if without_rest >= MOST_TICKS_WITHOUT_REST:
            tick = max(tick, math.ceil((elapsed + LEAST_REST_S) / TICK_S))
        ahead = tick * TICK_S - elapsed
        without_rest = 0 if ahead > 0 else without_rest + 1
        if ahead > 0:
            time.sleep(ahead)
        # after a stall time goes on from now: an ECU does not make up for tasks that it missed, and frames that waited
        # meanwhile are as new as the tick that takes them in
        tick = max(tick, int((time.perf_counter() - start) / TICK_S))
        count = link.receive(received)
        sent = node.tick(tick, received, count, answers)
        if sent:
            link.send(answers, sent)
        tick += 1


def serve(
    link: str | None = None,
    calibration: str = "sensitive",
    *,
    dbc: str | None = None,
    mapping: str | None = None,
    barrier: str | None = None,
    core: int | None = None,
    silent: bool = False,
    protection: Protection = "full",
    at_started: Callable[[], None] = lambda: None,
    at_end: Callable[[dict[str, Any]], None] | None = None,
) -> int:
    """Be the ECU on a link until the bench or a signal ends it; returns the exit code.

    Parameters
    ----------
    link
        Text of the link, the machine's default without one.
    calibration
        Name or file.
    dbc, mapping
        Database and mapping file of the bus.
    barrier
        Socket of a bench in lock-step; without it the ECU runs in real time.
    core
        Processor core to stay on.
    silent
        Listen but answer nothing.
    protection
        What is checked of protected frames.
    at_started
        Called when all is compiled and loaded, before the link opens.
    at_end
        Told, however it ends, what the ECU did: link, its own counts and the link's.

    Raises
    ------
    BenchError
        If a file is bad, the link cannot be opened, or link or barrier are lost.
    """
    from bench.codec.codec import Codec
    from bench.ecu.node import EcuNode
    from bench.links.frame import new_frames
    from bench.links.registry import default_link_text, open_link

    cores = _pin(core)
    codec = Codec.load(dbc, mapping)
    node = EcuNode(calibration, codec, silent=silent, protection=protection)
    # a node of its own compiles, or loads from disk, what a tick calls, before time counts
    EcuNode(calibration, codec).tick(TASK_OFFSET_TICKS, new_frames(1), 0, new_frames(MOST_ANSWERS))
    text = link or default_link_text()
    if text == "virtual":
        raise InputError("link virtual does not leave its process", mend="use --link udp, or bench run --ecu inprocess")
    at_started()
    with open_link(text, role="ecu") as opened:
        try:
            return _run(node, opened, barrier, cores)
        finally:
            if at_end is not None:
                at_end({"link": opened.text, "ecu": node.statistics(), "bus": opened.statistics()})


def _run(node: "EcuNode", link: "Link", barrier: str | None, cores: frozenset[int]) -> int:
    from bench.links.barrier import BarrierClient

    if barrier is None:
        with until_ended() as ended:
            # on the only core it would keep the bench from its own ticks
            with real_time_process(CorePlan(cores, cores), fifo=(os.cpu_count() or 1) > 1):
                run_in_real_time(node, link, ended)
            return INTERRUPTED if ended() == signal.SIGINT else OK
    client = BarrierClient(barrier)
    try:
        run_in_lockstep(node, link, client)
    finally:
        client.close()
    return OK


def _pin(core: int | None) -> frozenset[int]:
    """Stay on a core; returns the cores that the process may use."""
    allowed = os.sched_getaffinity(0)
    if core is None:
        return frozenset(allowed)
    if core not in allowed:
        raise InputError(f"--core {core}: no such core", allowed=", ".join(str(number) for number in sorted(allowed)))
    os.sched_setaffinity(0, {core})
    return frozenset({core})


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point of ``bench ecu``; returns the exit code."""
    arguments = _parser().parse_args(argv)
    die_with_parent(signal.SIGTERM)
    try:
        try:
            stop = _Stop()
            signal.signal(signal.SIGTERM, stop)
            return serve(**vars(arguments), at_started=stop.if_it_came)
        finally:  # inside the outer try: what comes until this is done is still caught
            _let_nothing_disturb_the_end()
    except BenchError as error:
        print(f"bench ecu: {error}", file=sys.stderr)
        return error.exit_code
    except Stopped:
        return OK
    except KeyboardInterrupt:
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
