"""Which code answered: scores of runs can be put together where it is the same."""

import hashlib
from functools import cache
from pathlib import Path

from signals.compile_cache import hash_sources

ROOT = Path(__file__).resolve().parents[2]
DIAGNOSIS = ("model_diagnosis", "vehicle_model", "hydraulics", "signals")
"""Packages that an answer depends on."""

DIGITS = 16


@cache
def code_digest() -> str:
    """First digits of the SHA-256 of all that answers depend on: scores with the same one are of the same code."""
    digest = hashlib.sha256()
    hash_sources(digest, ROOT, DIAGNOSIS)
    return digest.hexdigest()[:DIGITS]
