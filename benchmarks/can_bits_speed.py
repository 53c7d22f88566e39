"""Speed of the CAN bit model: sweeps of disturbed bits, random frames to bits and back, bus bits per second.

``python -m benchmarks.can_bits_speed [--json] [--frames N]``; the figures are medians of repeated runs on one core.
"""

import argparse
import json
import random
import statistics
import time
from collections.abc import Callable

import numpy as np
from numba import njit

from can_fault_injector import Bus, Frame, Node, TimedBus, TimedNode
from can_fault_injector import fields as f
from can_fault_injector.bits import LENGTHS, encode
from can_fault_injector.decoding import (
    RESULT_DLC,
    RESULT_EXTENDED,
    RESULT_FD,
    RESULT_IDENTIFIER,
    RESULT_LENGTH,
    RESULT_REMOTE,
    RESULT_SIZE,
    decode,
)
from can_fault_injector.sweep import flip_pair_escapes, single_bit_outcomes, sweep_receivers

_REPEATS = 5
GOALS_S = {
    "single_bit_sweep_decoding_s": 0.05,
    "single_bit_sweep_nodes_s": 1.0,
    "all_pairs_s": 0.1,
    "round_trip_of_a_million_s": 60.0,
}
_BUS_BITS = 100_000
_TIMED_BITS = 5_000


def seconds(action: Callable[[], object], repeats: int = _REPEATS) -> float:
    """Median time of a call, after one that compiles."""
    action()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


@njit(cache=True)
def round_trips(count: int, generator: np.random.Generator) -> int:
    """Random frames of every kind to bits and back; returns how many came back different."""
    bits, codes = np.empty(f.MAX_BITS, np.uint8), np.empty(f.MAX_BITS, np.uint8)
    numbers, result = np.empty(f.MAX_BITS, np.int16), np.zeros(RESULT_SIZE, np.int64)
    data, back = np.zeros(64, np.uint8), np.zeros(64, np.uint8)
    different = 0
    for _ in range(count):
        kind = generator.integers(0, 6)
        extended, remote, fd = kind % 2 == 1, kind in (2, 3), kind >= 4
        identifier = generator.integers(0, 1 << (29 if extended else 11))
        dlc = generator.integers(0, 16)
        length = LENGTHS[dlc] if fd else (0 if remote else min(dlc, 8))
        mask = generator.integers(0, 3)  # half of the payload bytes are all ones or all zeros: stuff bits
        for i in range(length):
            data[i] = generator.integers(0, 256) if mask == 0 else (255 if mask == 1 else 0)
        brs, esi, iso = generator.integers(0, 2) == 1, generator.integers(0, 2) == 1, generator.integers(0, 2) == 1
        size = encode(
            identifier,
            extended,
            remote,
            fd,
            fd and brs,
            fd and esi,
            dlc,
            data,
            length,
            iso,
            True,
            bits,
            codes,
            numbers,
        )
        wrong = decode(bits[:size], iso, back, result) != 0
        wrong = wrong or result[RESULT_IDENTIFIER] != identifier or result[RESULT_EXTENDED] != extended
        wrong = wrong or result[RESULT_REMOTE] != remote or result[RESULT_FD] != fd or result[RESULT_DLC] != dlc
        wrong = wrong or result[RESULT_LENGTH] != length or np.any(back[:length] != data[:length])
        different += wrong
    return different


def bus_bits_per_second() -> float:
    """Busy bus of one sender and three receivers, without a trace."""

    def run() -> None:
        bus = Bus(["sender", "a", "b", "c"], trace=False)
        for i in range(1000):
            bus.send("sender", frames[i])
        bus.run(_BUS_BITS)

    generator = random.Random(1)
    frames = [Frame(generator.randrange(0x800), generator.randbytes(8)) for _ in range(1000)]
    return _BUS_BITS / seconds(run, 3)


def timed_bus_bits_per_second() -> float:
    """The same nodes with 20 time quanta in a bit, each with its own clock and delay."""

    def run() -> None:
        nodes = [TimedNode(Node(name), delay_ns=50.0 * i, clock_ppm=50.0 * i) for i, name in enumerate("sabc")]
        bus = TimedBus(nodes)
        for i in range(1000):
            bus.send("s", frames[i])
        bus.run(_TIMED_BITS)

    generator = random.Random(1)
    frames = [Frame(generator.randrange(0x800), generator.randbytes(8)) for _ in range(1000)]
    return _TIMED_BITS / seconds(run, 3)


def figures(frames: int) -> dict[str, float]:
    """All figures by name, times in seconds."""
    frame = Frame(0x123, bytes(range(8)))
    result = {
        "single_bit_sweep_decoding_s": seconds(lambda: [single_bit_outcomes(frame) for _ in range(3)]),
        "single_bit_sweep_nodes_s": seconds(lambda: sweep_receivers(frame)),
        "all_pairs_s": seconds(lambda: flip_pair_escapes(frame)),
    }
    round_trips(1, np.random.default_rng(0))
    start = time.perf_counter()
    differences = round_trips(frames, np.random.default_rng(1))
    result["round_trip_of_a_million_s"] = (time.perf_counter() - start) * 1_000_000 / frames
    result["round_trip_frames"] = frames
    result["round_trip_differences"] = differences
    result["bus_bits_per_s"] = bus_bits_per_second()
    result["timed_bus_bits_per_s"] = timed_bus_bits_per_second()
    return result


def show(frames: int) -> None:
    """Print all figures, with their goals where there are some."""
    for name, value in figures(frames).items():
        goal = f"  (goal: below {GOALS_S[name]:g} s)" if name in GOALS_S else ""
        print(f"CAN {name:32} {value:12.6g}{goal}")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--frames", type=int, default=1_000_000)
    arguments = parser.parse_args()
    if arguments.json:
        print(json.dumps(figures(arguments.frames)))
    else:
        show(arguments.frames)


if __name__ == "__main__":
    main()
