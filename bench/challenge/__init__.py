"""Blind challenge of the diagnosis: cases of a generator that shares no code with us, answers, seals, score.

    from bench.challenge import run_challenge
    result = run_challenge(seed=1, count=20)

Order of events: the generator writes cases and, apart from them, sealed labels; every case is diagnosed; the answers'
hash is recorded; only then are the seals opened and checked, and the answers scored.
"""

from typing import Any

__all__ = ["run_challenge"]


def __getattr__(name: str) -> Any:
    if name == "run_challenge":
        from bench.challenge.running import run_challenge

        return run_challenge
    raise AttributeError(f"module 'bench.challenge' has no attribute {name!r}")
