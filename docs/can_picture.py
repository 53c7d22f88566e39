"""Draws docs/images/can_janus.png from a run of the bus in time: python docs/can_picture.py."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from can_fault_injector import Frame, Node, TimedBus, TimedNode
from can_fault_injector.janus import SPLIT, janus
from can_fault_injector.timed_bus import BitTiming

LATE, EARLY = Frame(0x2AA, b"\x4a\xbd"), Frame(0x2AA, b"\x5c\x8b")
BIT_US = 2.0
SHOWN = range(18, 34)


def main() -> None:
    """One waveform, the instants at which two receivers sample it, and what they read."""
    timings = {"late": BitTiming(7, 7, 5, 1), "early": BitTiming(3, 1, 15, 1)}
    bus = TimedBus([TimedNode(Node("sender"), timings["late"]), *(TimedNode(Node(n), t) for n, t in timings.items())])
    for disturbance in janus(LATE, EARLY, "sender"):
        bus.disturb(disturbance)
    bus.send("sender", LATE)
    bus.run(len(LATE.bits()) + 5)
    assert bus.nodes["late"].received == [LATE]
    assert bus.nodes["early"].received == [EARLY]

    halves = np.column_stack([EARLY.bits(), LATE.bits()])[SHOWN.start : SHOWN.stop].ravel()
    edges = np.array([[bit, bit + SPLIT] for bit in SHOWN]).ravel()
    times = np.append(edges, SHOWN.stop) * BIT_US
    figure, axes = plt.subplots(figsize=(9, 2.6), layout="constrained")
    axes.stairs(halves, times, color="black", linewidth=1.5, label="sender's line")
    for name, colour, height in (("early", "tab:blue", 1.25), ("late", "tab:red", -0.25)):
        samples = [s for s in bus.samples if s.node == name and times[0] <= s.time_ns * 1e-3 < times[-1]]
        at = [s.time_ns * 1e-3 for s in samples]
        axes.plot(at, [s.level for s in samples], "o", color=colour, markersize=5, label=f"samples of node {name}")
        for instant, sample in zip(at, samples, strict=True):
            axes.text(instant, height, str(sample.level), color=colour, ha="center", va="center")
    axes.set(
        xlabel="time, µs",
        yticks=[0, 1],
        yticklabels=["dominant", "recessive"],
        ylim=(-0.5, 1.5),
        xlim=(times[0], times[-1]),
    )
    axes.set_xticks(np.arange(SHOWN.start, SHOWN.stop + 1) * BIT_US)
    axes.grid(axis="x", alpha=0.4)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.28), ncols=3, frameon=False)
    figure.savefig(Path(__file__).parent / "images" / "can_janus.png", dpi=110)


if __name__ == "__main__":
    main()
