"""Errors that a user can mend: where, what was found, what is allowed, what to do.

Whoever raises one of these says everything the user needs; the command line prints the text and ends with the exit
code of the class. Anything else that reaches the top is a defect of the bench.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches

INTERRUPTED = 130
"""Exit code of a command that Ctrl-C ended."""


class BenchError(Exception):
    """An error that ends a command with one clear message.

    Parameters
    ----------
    message : str
        One line: where and what.
    found, allowed, nearest, mend : str, optional
        What was found, what is allowed, the nearest valid name, the command or change that helps.
    """

    exit_code = 4

    def __init__(self, message: str, *, found: str = "", allowed: str = "", nearest: str = "", mend: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.found = found
        self.allowed = allowed
        self.nearest = nearest
        self.mend = mend

    def __str__(self) -> str:
        parts = [
            f"found {self.found}" if self.found else "",
            f"did you mean {self.nearest}?" if self.nearest else "",
            f"allowed: {self.allowed}" if self.allowed else "",
        ]
        detail = "; ".join(part for part in parts if part)
        lines = [self.message]
        if detail:
            lines.append(f"  {detail}")
        lines += [f"  {line}" for line in self.mend.splitlines()]
        return "\n".join(lines)


class InputError(BenchError):
    """Bad usage or a bad input file."""

    exit_code = 2


class RunError(BenchError):
    """Something failed while running: ECU that never answers, disk full, a child that died."""

    exit_code = 4


class LinkError(RunError):
    """A link does not exist, is not permitted, or was lost."""


class FieldError(ValueError):
    """Raised by the validators of file schemas: one wrong field in or below the object that is validated.

    Parameters
    ----------
    problem : str
        What is wrong, a few words.
    at : sequence of str or int
        Path of the field below the object; empty for the object itself.
    found, allowed, nearest : str
        As in `BenchError`; without ``found`` the value in the file is shown.
    """

    def __init__(
        self, problem: str, *, at: Sequence[str | int] = (), found: str = "", allowed: str = "", nearest: str = ""
    ) -> None:
        self.problem = problem
        self.at = tuple(at)
        self.found = found
        self.allowed = allowed
        self.nearest = nearest
        super().__init__("; ".join(part for part in (problem, found, allowed, nearest) if part))


class FieldErrors(ValueError):
    """Several wrong fields, raised at once by one validator."""

    def __init__(self, errors: Sequence[FieldError]) -> None:
        self.errors = tuple(errors)
        super().__init__("; ".join(str(error) for error in errors))


@dataclass(frozen=True)
class Fault:
    """One fault of a file.

    Attributes
    ----------
    file, line, column
        Place, counted from 1; line 0 where the fault has no place in the file.
    field
        Dotted path of the field (``manoeuvre.steps[1].pedal_force``).
    problem, found, allowed, nearest
        What is wrong, the value found, what is allowed, the nearest valid name.
    """

    file: str
    line: int
    column: int
    field: str
    problem: str
    found: str = ""
    allowed: str = ""
    nearest: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        head = f"{place}  {self.field}: {self.problem}" if self.field else f"{place}  {self.problem}"
        parts = [
            f"found {self.found}" if self.found else "",
            f"did you mean {self.nearest}?" if self.nearest else "",
            f"allowed: {self.allowed}" if self.allowed else "",
        ]
        detail = "; ".join(part for part in parts if part)
        return f"{head}\n  {detail}" if detail else head


class FileFaults(InputError):
    """All faults of one input file; at most six lines are printed.

    Attributes
    ----------
    faults : tuple of Fault
        Every fault, in the order of the file.
    """

    printed_lines = 6

    def __init__(self, faults: Sequence[Fault], check: str = "") -> None:
        self.faults = tuple(faults)
        self.check = check
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __str__(self) -> str:
        whole = self.message.splitlines()
        if len(whole) <= self.printed_lines:
            return self.message
        lines: list[str] = []
        shown = 0
        for fault in self.faults:
            text = str(fault).splitlines()
            if len(lines) + len(text) > self.printed_lines - 1:
                break
            lines += text
            shown += 1
        rest = len(self.faults) - shown
        lines.append(f"  {rest} more error{'s' if rest > 1 else ''}; all: bench check {self.check}")
        return "\n".join(lines)


def nearest_name(name: str, candidates: Sequence[str]) -> str:
    """The valid name closest to a misspelt one, or an empty text if none is close."""
    close = get_close_matches(name, list(candidates), n=1, cutoff=0.6)
    return close[0] if close else ""


def unknown_name(what: str, name: str, candidates: Sequence[str], *, mend: str = "") -> InputError:
    """Error for a name that does not exist, with the nearest one and, if they are few, all of them."""
    few = ", ".join(candidates) if 0 < len(candidates) <= 12 else ""
    return InputError(f"unknown {what} {name!r}", allowed=few, nearest=nearest_name(name, candidates), mend=mend)
