"""Nightly: how often a receiver accepts a frame with two flipped bits with other content, and that one flip never does.

``python -m benchmarks.can_escapes [--frames N] [--json]`` takes about ten minutes for 120 000 frames of each length. It
ends with 1 if a rate differs by more than four standard deviations from the measurement that it repeats (random
standard data frames, all pairs of flipped bits at one receiver), if a CAN FD frame or a single flip escapes, or a known
escape does not. Intervals are Wilson's at 95 %.
"""

import argparse
import json
import math
import random
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from bench.campaign.statistics import share
from can_fault_injector import Frame
from can_fault_injector.sweep import ESCAPED, flip_pair_escapes, single_bit_outcomes

FRAMES = 120_000
REFERENCE = {1: (2, 171.9e6), 2: (5, 228.8e6), 4: (32, 363.8e6), 8: (166, 736.6e6)}
"""Payload bytes: escapes and pairs that were counted with a receiver written in C."""
DEVIATIONS = 4.0
FD_SHARE = 8
"""CAN FD frames are fewer: none may escape at all."""
KNOWN = (
    (0x207, "0d", (25, 43), 0x207, "03"),
    (0x22D, "be80", (23, 48), 0x22D, "ae40"),
    (0x2BF, "a728a75dcee783f3", (32, 72), 0x2BF, "a7204ebb9dcf17f3"),
    (0x5CC, "8608f493299174a8", (10, 45), 0x5CE, "8608f493299174a8"),
    (0x39E, "2b99c7f603a8b816", (71, 93), 0x39E, "2b99c7f603a8f82c"),
)
"""Identifier, data and flipped bits of frames that are accepted, and as what."""


@dataclass(frozen=True)
class Row:
    """Escapes among the pairs of flipped bits of one kind of frame."""

    kind: str
    frames: int
    pairs: int
    escapes: int
    rate: float
    low: float
    high: float
    ok: bool


def random_frames(length: int, count: int, fd: bool, iso: bool) -> Iterator[Frame]:
    """Random standard data frames of one length."""
    generator = random.Random(length + 100 * fd + 1000 * iso)
    for _ in range(count):
        yield Frame(generator.randrange(0x800), generator.randbytes(length), fd=fd, iso=iso)


def deviations(escapes: int, pairs: float, other_escapes: int, other_pairs: float) -> float:
    """Difference of two rates in standard deviations, if both were the same."""
    rate = (escapes + other_escapes) / (pairs + other_pairs)
    spread = math.sqrt(max(rate, 1 / (pairs + other_pairs)) * (1 / pairs + 1 / other_pairs))
    return (escapes / pairs - other_escapes / other_pairs) / spread


def measure(length: int, count: int, *, fd: bool = False, iso: bool = True) -> Row:
    """All pairs of flips of ``count`` frames."""
    pairs = escapes = 0
    for frame in random_frames(length, count, fd, iso):
        tried, found = flip_pair_escapes(frame)
        pairs += tried
        escapes += len(found)
    interval = share(escapes, pairs)
    ok = escapes == 0 if fd else abs(deviations(escapes, pairs, *REFERENCE[length])) < DEVIATIONS
    kind = f"{length} bytes" + ((" CAN FD ISO" if iso else " CAN FD non-ISO") if fd else "")
    return Row(kind, count, pairs, escapes, interval.value, interval.low, interval.high, ok)


def single_flips(count: int) -> int:
    """Single flips of random frames that are accepted with other content."""
    return sum(
        int(np.sum(single_bit_outcomes(frame) == ESCAPED))
        for length in (1, 2, 4, 8)
        for frame in random_frames(length, count, fd=False, iso=True)
    )


def known_escapes_missing() -> list[str]:
    """Known escapes that a receiver of the model does not accept as it should."""
    missing = []
    for identifier, data, flips, seen, seen_data in KNOWN:
        bits = Frame(identifier, bytes.fromhex(data)).bits()
        bits[list(flips)] ^= 1
        received = Frame.from_bits(bits)
        if received.identifier != seen or (received.data.hex() != seen_data and identifier == seen):
            missing.append(f"{identifier:X}#{data} {flips}")
    return missing


def main() -> None:
    """Print the table; exit code 1 if a figure is out of its range."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    start = time.perf_counter()
    rows = [measure(length, arguments.frames) for length in REFERENCE]
    rows += [measure(8, max(arguments.frames // FD_SHARE, 1), fd=True, iso=iso) for iso in (False, True)]
    singles, missing = single_flips(max(arguments.frames // 10, 1)), known_escapes_missing()
    ok = all(row.ok for row in rows) and singles == 0 and not missing
    if arguments.json:
        result = {"rows": [asdict(row) for row in rows], "single_flip_escapes": singles, "missing": missing, "ok": ok}
        print(json.dumps(result))
    else:
        for row in rows:
            rate = f"{row.escapes:5} of {row.pairs:.4g} pairs  {row.rate:.2e} [{row.low:.1e}, {row.high:.1e}]"
            print(f"{row.kind:22} {row.frames:7} frames  {rate}  {'as measured before' if row.ok else 'OUT OF RANGE'}")
        print(f"single flips that escape: {singles}; known escapes that are missing: {', '.join(missing) or 'none'}")
        print(f"{time.perf_counter() - start:.0f} s")
    sys.exit(not ok)


if __name__ == "__main__":
    main()
