"""Links, pictures and commands of the pages that users read first."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGES = (
    "README.md",
    "docs/report.md",
    "docs/diagnosis.md",
    "docs/dashboard.md",
    "docs/event_sequence.md",
    "docs/design_decisions.md",
)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    targets = [target for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text) if "://" not in target]
    missing = [target for target in targets if not ((ROOT / page).parent / target).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES)
def test_commands_exist(page: str) -> None:
    from typer.main import get_command

    from bench.cli import app

    known = set(get_command(app).commands)  # type: ignore[attr-defined]
    text = (ROOT / page).read_text("utf-8")
    used = set(re.findall(r"^(?:\.venv/bin/)?bench ([a-z]+)", text, re.MULTILINE)) | set(
        re.findall(r"`bench ([a-z]+)", text)
    )
    assert used <= known


def test_pictures_are_small() -> None:
    pictures = list((ROOT / "docs" / "images").iterdir())
    assert pictures
    assert all(picture.stat().st_size < 300_000 for picture in pictures)
