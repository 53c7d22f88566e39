"""Sealing of labels: a salted hash goes out before the logs, salt and label stay apart until all answers are in."""

import hashlib
import json
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

SALT_BYTES = 32


def canonical(label: Mapping[str, Any]) -> str:
    """The one text of a label that is hashed."""
    return json.dumps(label, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


def seal_of(salt: str, label: Mapping[str, Any]) -> str:
    """SHA-256 over salt and label."""
    return hashlib.sha256((salt + canonical(label)).encode()).hexdigest()


def seal(label: Mapping[str, Any], public: Path, private: Path) -> None:
    """Write a seal (``public``) and, apart from it, salt and label (``private``)."""
    salt = secrets.token_hex(SALT_BYTES)
    public.parent.mkdir(parents=True, exist_ok=True)
    private.parent.mkdir(parents=True, exist_ok=True)
    public.write_text(seal_of(salt, label) + "\n", encoding="ascii")
    private.write_text(json.dumps({"salt": salt, "label": label}, indent=1), encoding="utf-8")
