"""What this machine can do for the bench, line by line, and the command that mends what it cannot.

Everything here is quick and imports nothing but the standard library; the benchmark is the exception.
"""

from collections.abc import Iterator

from bench.doctor.finding import Finding, line

__all__ = ["Finding", "findings", "line"]


def findings(*, benchmark: bool = False) -> Iterator[Finding]:
    """Every finding as soon as it is known.

    Parameters
    ----------
    benchmark : bool
        Also run the bench itself and measure its speed.
    """
    from bench.doctor import can_bus, machine, software, timer

    yield from machine.findings()
    yield from can_bus.findings()
    yield from software.findings()
    yield from timer.findings()
    if benchmark:
        from bench.doctor import benchmark as speed

        yield from speed.findings()
