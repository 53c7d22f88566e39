"""Seals of the labels: opened only when all answers are in and their hash is recorded."""

import hashlib
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from signals.errors import InputError

ANSWERS_RECORD = "answers.sha256"


def hash_of_answers(answers: Sequence[Path]) -> str:
    """SHA-256 over names and contents of all answers, in order of their names."""
    digest = hashlib.sha256()
    for path in sorted(answers):
        digest.update(path.name.encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def record_answers(folder: Path, answers: Sequence[Path]) -> str:
    """Write the hash of all answers and the time; from then on the seals may be opened.

    Raises
    ------
    InputError
        If other answers were recorded in this folder before.
    """
    value = hash_of_answers(answers)
    if recorded_answers(folder) not in (None, value):
        raise _changed(folder)
    record = {"sha256": value, "answers": len(answers), "recorded": datetime.now(UTC).isoformat()}
    (folder / ANSWERS_RECORD).write_text(json.dumps(record) + "\n", encoding="utf-8")
    return value


def _changed(folder: Path) -> InputError:
    return InputError(
        f"{folder}: the answers are not those that were recorded", mend="start again with a new seed in a new folder"
    )


def recorded_answers(folder: Path) -> str | None:
    """Hash that was recorded of the answers in a folder; None before."""
    record = folder / ANSWERS_RECORD
    return str(json.loads(record.read_text(encoding="utf-8"))["sha256"]) if record.is_file() else None


def open_seal(folder: Path, answers: Sequence[Path], case: Path, sealed: Path) -> dict[str, Any]:
    """Label of a case.

    Raises
    ------
    InputError
        If the answers are not recorded, were changed since, or salt and label do not belong to the seal.
    """
    record = folder / ANSWERS_RECORD
    if not record.is_file():
        raise InputError(f"{folder}: the answers are not recorded yet", mend="diagnose all cases first")
    known = json.loads(record.read_text(encoding="utf-8"))
    if known["answers"] != len(answers) or known["sha256"] != hash_of_answers(answers):
        raise _changed(folder)
    content = json.loads(sealed.read_text(encoding="utf-8"))
    label: dict[str, Any] = content["label"]
    text = json.dumps(label, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    found = hashlib.sha256((content["salt"] + text).encode()).hexdigest()
    expected = (case / "seal.sha256").read_text(encoding="ascii").strip()
    if found != expected:
        raise InputError(
            f"{sealed}: salt and label do not belong to the seal of {case.name}",
            found=found[:16],
            allowed=expected[:16],
            mend="the label was changed after the seal was made; generate the cases again",
        )
    return label
