"""One line of the doctor."""

from dataclasses import dataclass
from typing import Literal

State = Literal["ok", "warn", "info"]
_SHOWN = {"ok": "ok  ", "warn": "warn", "info": "--  "}


@dataclass(frozen=True)
class Finding:
    """What was found.

    Attributes
    ----------
    name : str
        What was looked at, for machines.
    state : {"ok", "warn", "info"}
        Good, worth mending, or neither (what only some uses need).
    text : str
        One line for people.
    mend : str
        Command or change that helps.
    """

    name: str
    state: State
    text: str
    mend: str = ""


def line(finding: Finding) -> str:
    """The finding as the doctor prints it."""
    mend = f"\n       mend: {finding.mend}" if finding.mend and finding.state != "ok" else ""
    return f" {_SHOWN[finding.state]}  {finding.text}{mend}"
