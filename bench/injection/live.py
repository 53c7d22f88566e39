"""``bench inject --from … --to …``: open both sides, forward until the time is over or somebody ends it, tell."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.codec.codec import Codec
from bench.injection.gateway import Gateway
from bench.injection.sending import cyclic, replayed, send_timed
from bench.links.registry import OWN_KINDS, open_link
from bench.loop.ending import until_ended
from can_fault_injector.faults.fault_file import load_faults
from can_fault_injector.faults.running import FaultEvent

_LOGGED_AT_ONCE = 50


def link_text(name: str) -> str:
    """Text of a link; a bare name that is no kind of link is an interface of SocketCAN."""
    return name if ":" in name or name in OWN_KINDS else f"socketcan:{name}"


def forward(
    bench_side: str,
    ecu_side: str,
    faults: Path | None,
    *,
    dbc: Path | None = None,
    bit_rate: float | None = None,
    seed: int = 1,
    duration_s: float | None = None,
    ready: Callable[[], None] = lambda: None,
    tell: Callable[[FaultEvent], None] = lambda event: None,
) -> dict[str, Any]:
    """Be the injector between two buses.

    Parameters
    ----------
    bench_side, ecu_side : str
        Texts of links, or names of interfaces.
    faults : Path, optional
        Fault file; without it everything passes.
    bit_rate : float [bit/s]
        Of the modelled bus.
    duration_s : float, optional
        Ends after this time; without it on SIGINT or SIGTERM.
    ready : callable
        Called once frames are forwarded.
    tell : callable
        Called with every event of a fault.

    Returns
    -------
    dict
        `Gateway.summary`.

    Raises
    ------
    BenchError
        If a file is bad, or a link does not open or is lost.
    """
    listed = load_faults(faults) if faults is not None else None
    codec = Codec.load(dbc)
    with (
        # on each side it stands in for the one on the other side
        open_link(link_text(bench_side), role="ecu") as first,
        open_link(link_text(ecu_side), role="bench") as second,
        until_ended() as ended,
    ):
        gateway = Gateway(first, second, listed, codec, bit_rate=bit_rate, seed=seed)
        gateway.engine.warm_up()
        gateway.restart_clock()
        ready()
        _loop(gateway, ended, duration_s, tell)
        return gateway.summary()


def send(
    to: str, *, log: Path | None = None, frame: str | None = None, every_s: float = 0.01, count: int = 100
) -> dict[str, Any]:
    """Send a log as it was recorded, or one frame in a cycle, onto a bus.

    Returns
    -------
    dict
        `SendingReport.as_data`.

    Raises
    ------
    BenchError
        If the log or the frame is bad, or the link does not open or is lost.
    """
    timed = replayed(log) if log is not None else cyclic(frame or "", every_s, count)
    with open_link(link_text(to), role="bench") as link, until_ended() as ended:
        return send_timed(link, timed, lambda: not ended()).as_data()


def _loop(
    gateway: Gateway, ended: Callable[[], int], duration_s: float | None, tell: Callable[[FaultEvent], None]
) -> None:
    end = float("inf") if duration_s is None else time.monotonic() + duration_s
    log = gateway.engine.log
    told = 0
    while not ended() and time.monotonic() < end:
        if not gateway.step():
            # telling takes time: only where nothing waits
            for event in log[told : told + _LOGGED_AT_ONCE]:
                tell(event)
                told += 1
            gateway.wait()
    for event in log[told:]:
        tell(event)
