"""``bench list``: the scenarios that can be run by their id."""

import re
from pathlib import Path
from typing import Annotated

import typer

from bench.commands.options import JsonOption, print_json

_HEAD = re.compile(r"^(title|standard|time_limit|runs|hazards):[ \t]*(.*?)[ \t]*$", re.MULTILINE)


def list_scenarios(
    text: Annotated[str, typer.Argument(help="Only those whose id or title contains this.")] = "",
    as_json: JsonOption = False,
) -> None:
    """List the scenarios in ./scenarios and those that ship with the bench.

    Example: bench list stops
    """
    from bench.scenario.locate import scenario_files
    from signals.errors import InputError

    entries = [
        entry
        for name, path in scenario_files().items()
        if (entry := _entry(name, path)) and text.lower() in f"{entry['id']} {entry['title']}".lower()
    ]
    if text and not entries:
        raise InputError(f"no scenario contains {text!r}", mend="all of them: bench list")
    if as_json:
        print_json(entries)
        return
    width = max(len(entry["id"]) for entry in entries) if entries else 0
    for entry in entries:
        standard = f"  [{entry['standard']}]" if entry["standard"] else ""
        print(f"{entry['id']:<{width}}  {entry['title']}{standard}")


def _entry(name: str, path: Path) -> dict[str, str]:
    """Head of a file, read without a YAML parser: a listing of many files has to be quick."""
    head = {key: value.strip("\"'") for key, value in _HEAD.findall(path.read_text("utf-8", errors="replace"))}
    return {
        "id": name,
        "title": head.get("title", ""),
        "standard": head.get("standard", ""),
        "kind": "procedure" if "runs" in head else "campaign" if "hazards" in head else "scenario",
        "path": str(path),
    }
