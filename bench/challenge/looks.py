"""Log of every look at seeds that are kept for the published table; none of them is scored twice."""

import json
import os
from datetime import UTC, datetime
from pathlib import Path

from signals.errors import InputError

FIRST_TABLE_SEED = 1_000_000
"""Seeds below are for tuning (0 to 9 999) and CI (10 000 to 10 019)."""


def looks_file() -> Path:
    """``docs/challenge_looks.jsonl`` of a checkout, else a file in the user's data folder."""
    docs = Path(__file__).resolve().parents[2] / "docs"
    if docs.is_dir():
        return docs / "challenge_looks.jsonl"
    base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(base) / "brake-control-bench" / "challenge_looks.jsonl"


def refuse_second_look(
    seed: int, family: str | None, generator: str, answers: str | None, file: Path | None = None
) -> None:
    """Raise InputError where this table seed was scored before.

    ``answers`` is the hash of the recorded answers that are to be scored, None before there are any. Scoring the same
    ones again, after a run that was broken off while it scored, is no second look.
    """
    if seed < FIRST_TABLE_SEED:
        return
    for look in _looks_at(seed, family, generator, file):
        if answers is None or look.get("answers") != answers:
            raise InputError(
                f"seed {seed}: scored before, on {look['time']}",
                allowed="each seed from 1 000 000 on counts once for the published table",
                mend="take another seed",
            )


def record_look(
    seed: int, count: int, family: str | None, generator: str, answers: str, file: Path | None = None
) -> None:
    """Append a look at answers of this hash; it counts from before the seals are opened, so that a run broken off
    counts too. Scored again, they are no second one."""
    if seed < FIRST_TABLE_SEED or _looks_at(seed, family, generator, file):
        return
    path = file or looks_file()
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn_with = {"seed": seed, "n": count, "family": family, "generator": generator}
    look = drawn_with | {"answers": answers, "time": datetime.now(UTC).isoformat(timespec="seconds")}
    with path.open("a", encoding="utf-8") as out:
        out.write(json.dumps(look) + "\n")


def _looks_at(seed: int, family: str | None, generator: str, file: Path | None) -> list[dict[str, object]]:
    wanted = seed, family, generator
    return [look for look in looks(file) if (look["seed"], look["family"], look["generator"]) == wanted]


def looks(file: Path | None = None) -> list[dict[str, object]]:
    """All looks so far."""
    path = file or looks_file()
    if not path.is_file():
        return []
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
